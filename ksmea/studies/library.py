"""The library of a diagnosis: which of the registered effects are tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ksmea import registry
from ksmea.contracts import AnyEffect
from ksmea.errors import SettingError, unknown

NO_EFFECT = "none"  # in place of names: an empty library


def library(names: Sequence[str], without: Sequence[str]) -> tuple[dict[str, AnyEffect], Mapping[str, str]]:
    """The effects that are asked for, by name – all that are registered if none is named, but for those on request, and none
    if `NO_EFFECT` is – but for those in `without`; and why others are left out, which none is that is asked for by name.

    Raises `SettingError` for a name that is not registered."""
    known = list(registry.registered("effect"))
    if NO_EFFECT in names:
        if len(names) > 1:
            raise SettingError(f"effects: expected {NO_EFFECT} alone or names of effects, got {', '.join(names)}")
        return {}, {}
    for name in (*names, *without):
        if name not in known:
            raise unknown("effect", name, [*known, NO_EFFECT])
    if names:
        return {name: registry.create("effect", name, {}) for name in names if name not in without}, {}
    made, left_out = registry.create_all("effect", [name for name in known if name not in without])
    return {name: effect for name, effect in made.items() if not effect.on_request}, left_out

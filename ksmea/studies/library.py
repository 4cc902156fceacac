"""The library of a diagnosis: which of the registered effects are tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ksmea.errors import SettingError, unknown
from ksmea.measurement.measurement import Measurement
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect

NO_EFFECT = "none"  # in place of names: an empty library


def library(
    names: Sequence[str], without: Sequence[str], measurement: Measurement | None = None
) -> tuple[dict[str, AnyEffect], Mapping[str, str]]:
    """The effects that are asked for, by name – all that are registered if none is named, but for those that
    nothing in the measurement speaks for, where one is given, and none if `NO_EFFECT` is – but for those in `without`; and why others are left out,
    which none is that is asked for by name.

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
        asked = {name: registry.create("effect", name, {}) for name in names if name not in without}
        return {name: _seen_in(effect, measurement) or effect for name, effect in asked.items()}, {}
    made, left_out = registry.create_all("effect", [name for name in known if name not in without])
    seen = {name: _seen_in(effect, measurement) for name, effect in made.items()}
    return {name: effect for name, effect in seen.items() if effect is not None}, left_out


def _seen_in(effect: AnyEffect, measurement: Measurement | None) -> AnyEffect | None:
    return effect if measurement is None else effect.seen_in(measurement)

"""The library of a diagnosis: which of the registered effects are tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ksmea.errors import SettingError, unknown
from ksmea.measurement.measurement import Measurement
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.problem import Problem

NO_EFFECT = "none"  # in place of names: an empty library


def library(
    names: Sequence[str],
    without: Sequence[str],
    measurement: Measurement | None = None,
    problem: Problem | None = None,
) -> tuple[dict[str, AnyEffect], Mapping[str, str]]:
    """Effects by name, without the ones in `without`; and the reasons why others are left out.

    With `names`, exactly these effects; no effect if `NO_EFFECT` is named. Without names, all registered effects except the ones
    that nothing in a given measurement suggests, and the ones that a given problem does not offer. Only then may others be left out.

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
    found = {name: effect for name, effect in seen.items() if effect is not None}
    if problem is not None:
        found = {name: effect for name, effect in found.items() if _is_offered(effect, problem)}
    return found, left_out


def _is_offered(effect: AnyEffect, problem: Problem) -> bool:
    """Whether the problem calls for it.

    One for other problems may fail here, and is left out with its reason later.
    """
    try:
        return effect.is_offered(problem.machine)
    except Exception:
        return True


def _seen_in(effect: AnyEffect, measurement: Measurement | None) -> AnyEffect | None:
    return effect if measurement is None else effect.seen_in(measurement)

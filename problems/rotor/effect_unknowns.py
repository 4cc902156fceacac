"""Names of the unknowns of a rotor's effects, each once: an effect that is there already at another place keeps them apart by
its place.

The first runout of a model has `runout_x`; a second one at 0.5 m has `runout_x_at_0_5_m`. What is there keeps its names,
whatever is added. A name is one word, so that settings can be given by it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ksmea.errors import SettingError
from ksmea.parameters import Parameter, name_at
from problems.rotor.hooks import RotorHooks
from problems.rotor.problem import RotorProblem


def effect_unknowns(problem: RotorProblem, effects: Sequence[RotorHooks]) -> tuple[tuple[Parameter, ...], ...]:
    """The unknowns of each effect on a problem; `SettingError` where an unknown of the problem has the name of one, or two
    effects are the same at the same place."""
    found: list[tuple[Parameter, ...]] = []
    own = set(problem.parameters.names)
    taken, there = set(own), set[tuple[type, str]]()
    for effect in effects:
        items, at = effect.parameters(problem), (type(effect), str(effect))
        for item in items:
            if item.name in own or at in there:
                raise SettingError(
                    f"effects: expected each unknown once, got {item.name} again; take one of the two effects, or another"
                    " place for one"
                )
        if any(item.name in taken for item in items):
            items = tuple(dataclasses.replace(item, name=name_at(item.name, str(effect))) for item in items)
        taken.update(item.name for item in items)
        there.add(at)
        found.append(items)
    return tuple(found)

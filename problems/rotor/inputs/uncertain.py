"""Numbers of a rotor that are known to a tolerance, as unknowns that have a prior.

A search of the unknowns takes them as stated; what follows it, a joint fit with its intervals, takes them as unknowns too
(`ksmea/problem/problem.py`, `joint`). Coefficients of bearings and unbalance join the rotor's own unknowns, which cost no more; all
others are `RotorNumbers`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from problems.rotor.finite_elements.segments import Material
from problems.rotor.inputs.numbers import ProbeNumber, RotorNumber, RotorNumbers
from problems.rotor.inputs.places import Place
from problems.rotor.inputs.probe_places import ProbePlace
from problems.rotor.inputs.tolerances import NONE, Tolerances, probe_numbers, rotor_numbers
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import Unknown


@dataclass(frozen=True)
class UncertainNumbers:
    """Numbers with a tolerance of their own, `tolerances` of all others, and exact places of the rotor."""

    unknowns: tuple[Unknown, ...] = ()  # of bearings, supports and unbalance
    numbers: tuple[RotorNumber, ...] = ()
    probes: tuple[ProbeNumber, ...] = ()
    tolerances: Tolerances = NONE
    exact: frozenset[Place] = frozenset()
    exact_probes: tuple[ProbePlace, ...] = ()
    materials: Mapping[str, Material] = field(default_factory=dict)

    @property
    def are_there(self) -> bool:
        return bool(self.unknowns or self.numbers or self.probes) or self.tolerances != NONE

    def joint(self, problem: RotorProblem) -> RotorProblem:
        """A problem with all these numbers as unknowns, after its own.

        The problem itself if no number is uncertain.
        """
        plain = problem.plain
        searched = [each for effect in problem.effects if isinstance(effect, RotorNumbers) for each in effect.numbers]
        known = {place.path for number in (*self.numbers, *searched) for place in number.places}
        known |= {each.path for each in self.exact}
        numbers = [*self.numbers]
        for number in rotor_numbers(plain.rotor, self.tolerances, self._materials(plain)):
            places = tuple(place for place in number.places if place.path not in known)
            if places:
                numbers.append(dataclasses.replace(number, places=places))
        seen = [probe for probe in self.probes if any(map(probe.place.reads, plain.channels))]
        seen_before = [each for effect in problem.effects if isinstance(effect, RotorNumbers) for each in effect.probes]
        stated = {*(probe.place for probe in (*self.probes, *seen_before)), *self.exact_probes}
        seen += [probe for probe in probe_numbers(plain.channels, self.tolerances) if probe.place not in stated]
        unknowns = _without_known(self.unknowns, plain.unknowns)
        if not (unknowns or numbers or seen):
            return dataclasses.replace(plain, uncertain=None).with_effects(problem.effects, problem.near)
        made = dataclasses.replace(plain, unknowns=(*plain.unknowns, *unknowns), uncertain=None)
        own = (RotorNumbers(tuple(numbers), tuple(seen), "numbers known to a tolerance"),) if numbers or seen else ()
        return made.with_effects((*own, *problem.effects), problem.near)

    def _materials(self, problem: RotorProblem) -> Mapping[str, Material]:
        """Materials by name; without names in the order in which the shaft has them."""
        if self.materials:
            return self.materials
        found: dict[Material, None] = {}
        for segment in problem.rotor.segments:
            layers = [layer.material for layer in segment.layers]
            own = [getattr(segment, "material", None), *layers]
            found |= dict.fromkeys(material for material in own if material is not None)
        return {f"material_{number}": material for number, material in enumerate(found, start=1)}


def _without_known(unknowns: Sequence[Unknown], own: Sequence[Unknown]) -> list[Unknown]:
    """Unknowns except those with a target that the rotor's own unknowns set already."""
    taken = {target for item in own for target in item.targets}
    return [item for item in unknowns if not taken.intersection(item.targets)]

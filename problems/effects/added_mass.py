"""Mass that the model lacks at one place of the shaft, or has too much of.

Examples are a coupling, a sleeve, a nut, a heavier disk.

As a point it resists acceleration along x and y, f = Ω² m q. A part with a radius of gyration r about the shaft also resists tilting,
with I_p = m r² and I_d in the proportion of the disk there, or half of I_p (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010,
chapter 5, for the matrices of a disk). r is assumed, as the one of the disk there or of a sleeve twice as thick as the shaft, or else the inertia
is an unknown in parts of m r². Unlike `mass` it moves each critical speed by how much its place moves there, and not at all where that
is a node of the mode.

Places that are tried are those where things are mounted: disks, the ends of the shaft, and the middle of long spans; of a rotor that was
drawn, of a file, with an assumed radius too, and if a mass explains the data, with its inertia as an unknown.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, Indices, Mask
from ksmea.nonlinear.laws import LAWS
from ksmea.settings.settings import setting
from ksmea.units import MILLIMETRE
from problems.rotor.extension.effect import SeatedEffect, distinct, is_near, places_of, rotor_mass
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import diameter_at
from problems.rotor.finite_elements.segments import Disk, MassChange
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.1  # of the rotor's mass: more is a part that no drawing forgets
MISSING = 0.5  # of the mass and moments of the disks at the place: the rest still resists acceleration
NOTICED = (0.001, 0.05)  # of the rotor's mass, of either sign, are drawn
LARGEST_INERTIA = 4.0  # of m r²: twice the radius that is assumed
NOTICED_INERTIA = (0.3, 2.0)  # of m r², are drawn
LONG_SPAN = 0.25  # of the shaft's length, between disks, bearings and ends
SLEEVE = np.sqrt(
    (1**2 + 0.5**2) / 2
)  # radius of gyration of a sleeve twice as thick as the shaft, of the shaft's diameter
THIN = 0.5  # I_d of I_p
POINT, ASSUMED, FREE = "none", "assumed", "free"


@dataclass(frozen=True)
class AddedMass(SeatedEffect):
    """A place of the shaft carries more mass, or less."""

    position: float | None = setting(None, "position of the mass; null: the first disk or end", unit="m", at_least=0)
    inertia: str = setting(
        POINT, "its moments of inertia: none, assumed by the radius, or free", choices=(POINT, ASSUMED, FREE)
    )
    radius: float | None = setting(
        None,
        "radius of gyration about the shaft; null: from the disk there, or a sleeve twice as thick as the shaft",
        unit="m",
        above=0,
    )

    says = "The rotor carries {added_mass:more|less} {place} than in the model"
    check_next = "Weigh the parts on the shaft there: one that the rotor file lacks, or has twice, confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "mass": "both lower natural frequencies; several critical speeds, whose modes move that place differently",
        "disk_mass": "a disk has moments of inertia too; modes that tilt it, or weigh the disk",
        "disk_position": "both change what the disk does to each mode; measure its distance from a bearing, or weigh it",
        "spring_mass": "both lower natural frequencies; a speed near its own frequency: the shaft stands still there",
        "bearing_mass": "at one bearing both are alike; look at each bearing",
    }

    what, default_place = "mass", "the first disk or end"

    @property
    def sizes(self) -> Sequence[Size]:
        mass = Size("added_mass", "kg", LARGEST, drawn=NOTICED, of=rotor_mass, lowest=self._lowest)
        inertia = Size("added_inertia", "%", (0.0, LARGEST_INERTIA), drawn=NOTICED_INERTIA)
        return (mass, inertia) if self.inertia == FREE else (mass,)

    def __str__(self) -> str:
        if self.inertia == POINT or self.radius is None:
            return super().__str__()
        word = "an inertia in parts of m r², r =" if self.inertia == FREE else "a radius of gyration of"
        return f"{super().__str__()} with {word} {self.radius / MILLIMETRE:.3g} mm"

    def _lowest(self, problem: RotorProblem) -> float:
        """The most that may be missing, kg, below 0; a bare shaft has no mass to lose."""
        parts = (*problem.rotor.disks, *problem.rotor.masses)
        place = self.placed_on(problem).place
        there = sum(max(part.mass, 0.0) for part in parts if is_near(part.position, place))
        missing = MISSING / LARGEST_INERTIA if self.inertia == FREE else MISSING
        return -min(missing * there, LARGEST * rotor_mass(problem))

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return mounting_places(problem.rotor)

    def locations(self, problem: RotorProblem) -> Sequence[Self]:
        points = super().locations(problem)
        return [*points, *(self._with(ASSUMED, each, problem) for each in points if problem.is_as_drawn)]

    def kin(self, problem: RotorProblem) -> Sequence[Self]:
        return [self._with(FREE, self, problem)] if problem.is_as_drawn and self.inertia != FREE else []

    def _with(self, inertia: str, at: Self, problem: RotorProblem) -> Self:
        return dataclasses.replace(at, inertia=inertia).placed_on(problem)

    def placed_on(self, problem: RotorProblem) -> Self:
        placed = super().placed_on(problem)
        if self.inertia == POINT or placed.radius is not None:
            return placed
        return dataclasses.replace(placed, radius=radius_at(problem.rotor, placed.place))

    def site_law(self) -> SiteLaw | None:
        return SiteLaw(self.place, LAWS["mass"]) if self.inertia == POINT else None

    def costly(self, n_unknown: int) -> Indices:
        return np.arange(0 if self.inertia == POINT else n_unknown)

    def linear(self, n_unknown: int) -> Mask:
        return np.full(n_unknown, self.inertia == ASSUMED)

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        """Rotor with a part of this mass and inertia, with its offset from the nearest node."""
        radius = self.radius or radius_at(rotor, self.place)
        polar = theta[0] * radius**2 * (theta[1] if self.inertia == FREE else 1.0)
        [*_, shape] = [each.diametral_inertia / each.polar_inertia for each in _disks_at(rotor, self.place)] or [THIN]
        node = float(rotor.node_positions[np.argmin(np.abs(rotor.node_positions - self.place))])
        offset = 0.0 if is_near(node, self.place) else self.place - node
        part = MassChange(node, float(theta[0]), float(polar), float(shape * polar), is_lumped=True, offset=offset)
        return dataclasses.replace(rotor, masses=(*rotor.masses, part))


def radius_at(rotor: Rotor, position: float) -> float:
    """Radius of gyration about the shaft, m, of the disk at a position, or of a sleeve."""
    of_disks = [np.sqrt(disk.polar_inertia / disk.mass) for disk in _disks_at(rotor, position)]
    return float(max(of_disks, default=SLEEVE * diameter_at(rotor, position)))


def _disks_at(rotor: Rotor, position: float) -> list[Disk]:
    return [disk for disk in rotor.disks if is_near(disk.position, position) and disk.polar_inertia > 0]


def mounting_places(rotor: Rotor) -> list[float]:
    """Disks, then the ends of the shaft, then the middle of each long span, m."""
    disks, ends = places_of(rotor.disks, rotor), [0.0, rotor.length]
    stations = sorted(distinct([*disks, *ends, *(bearing.position for bearing in rotor.bearings)], rotor))
    spans = [(left + right) / 2 for left, right in pairwise(stations) if right - left > LONG_SPAN * rotor.length]
    return distinct([*disks, *ends, *spans], rotor)

"""A mass that the model lacks at one place of the shaft, or has too much of: a coupling, a sleeve, a nut, a heavier disk.

It resists acceleration along x and y, f = Ω² m q, and has no moments of inertia of its own: those of a part no longer than
the shaft is thick hardly count (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 5, for the
matrices of a disk). Unlike `mass` it moves each critical speed by how much its place moves there, and not at all where that
is a node of the mode.

Places that are tried are those where things are mounted: disks, the ends of the shaft, and the middle of long spans.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from ksmea.nonlinear.laws import LAWS
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import SeatedEffect, rotor_mass
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.1  # of the rotor's mass, of either sign: more is a part that no drawing forgets
NOTICED = (0.001, 0.05)  # of the rotor's mass, of either sign, are drawn
LONG_SPAN = 0.25  # of the shaft's length, between disks, bearings and ends


@dataclass(frozen=True)
class AddedMass(SeatedEffect):
    """A place of the shaft carries more mass, or less."""

    position: float | None = setting(None, "where it sits; null: on the first disk or end", unit="m", at_least=0)

    says = "The rotor carries {added_mass:more|less} {place} than in the model"
    check_next = "Parts on the shaft there that the rotor file lacks or has twice; weigh them."
    aliases: ClassVar[Mapping[str, str]] = {
        "mass": "both lower natural frequencies; several critical speeds, whose modes move that place differently",
        "disk_mass": "a disk has moments of inertia too; modes that tilt it, or weigh the disk",
        "disk_position": "both change what the disk does to each mode; measure its distance from a bearing, or weigh it",
    }

    what, default_place = "mass", "the first disk or end"
    sizes = (Size("added_mass", "kg", LARGEST, drawn=NOTICED, of=rotor_mass),)

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return mounting_places(problem.rotor)

    def site_law(self) -> SiteLaw:
        return SiteLaw(self.place, LAWS["mass"])


def mounting_places(rotor: Rotor) -> list[float]:
    """Disks, then the ends of the shaft, then the middle of each long span, m."""
    disks, ends = [disk.position for disk in rotor.disks], [0.0, rotor.length]
    stations = sorted({*disks, *ends, *(bearing.position for bearing in rotor.bearings)})
    spans = [(left + right) / 2 for left, right in pairwise(stations) if right - left > LONG_SPAN * rotor.length]
    return list(dict.fromkeys([*disks, *ends, *spans]))

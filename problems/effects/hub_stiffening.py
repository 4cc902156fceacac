"""A hub that stiffens the shaft beneath it: EI (1 + s) over the width of a disk's seat.

Models put a disk on a point of the shaft, while a hub that is shrunk on carries bending along with it. Friswell, Penny,
Garvey & Lees, Dynamics of Rotating Machines, 2010, example 5.8.3, compare models of such a seat, as API 684 does. Shear
flexibility and mass stay. The width is measured about the disk's middle; ends of it may lie anywhere between nodes: the
stiffness of an element that is covered in part follows from a stepped beam (`problems/rotor/finite_elements/shaft.py`).

If no width is given, it is the disk's thickness, from its moments of inertia as a ring, h² = 12 (I_d − I_p/2)/m. If
they give no thickness, as for a point disk, it is the shaft's diameter: hubs are about as long. Of a rotor that was
drawn, of a file, hubs with an unknown width are tried too: a stiff narrow hub acts much as a less stiff wide one.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.settings.settings import setting
from ksmea.units import MILLIMETRE
from problems.rotor.extension.effect import SeatedEffect, places_of
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import SAME_PLACE, Hub, Rotor
from problems.rotor.finite_elements.mesh import diameter_at
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.problem import RotorProblem

WIDTHS = (-0.8, 3.0)  # change of the width: a fifth to four times
NOTICED_WIDTHS = (0.1, 0.5)  # are drawn
LARGEST = 4.0  # EI five times: a solid hub half as thick again as the shaft, 1.5⁴
NOTICED = (0.1, 3.0)  # are drawn
THINNEST = 1e-3  # of the shaft's diameter: a thickness below it is rounding of moments of inertia


@dataclass(frozen=True)
class HubStiffening(SeatedEffect):
    """A disk's seat is stiffer in bending than the shaft."""

    if_nowhere: ClassVar[str] = "give its position and width where the rotor has no disk, or leave it out"

    position: float | None = setting(None, "the middle of the hub; null: the first disk", unit="m", at_least=0)
    width: float | None = setting(
        None, "of the hub; null: the thickness of the disk there, or the shaft's diameter", unit="m", above=0
    )

    is_width_free: bool = setting(False, "whether the width is an unknown, as its change")

    says = "The hub {place} makes the shaft {hub_stiffening} stiffer in bending"
    check_next = "Check shrink fit and width of this hub against the drawing: a longer or tighter fit confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "youngs_modulus": "both stiffen the shaft; several critical speeds, whose modes bend that place differently",
        "mass": "both move all modes; several critical speeds, whose modes bend that place differently",
        "disk_inertia": "both raise modes that tilt the disk; tap the rotor hanging free, or swing the disk on wires",
    }

    what, default_place, needs = "hub", "the first disk", "a disk on the rotor"

    @property
    def sizes(self) -> Sequence[Size]:
        stiffening = Size("hub_stiffening", "%", (0.0, LARGEST), drawn=NOTICED)
        width = Size("hub_width_change", "%", WIDTHS, drawn=NOTICED_WIDTHS)
        return (stiffening, width) if self.is_width_free else (stiffening,)

    def __str__(self) -> str:
        if not self.is_width_free or self.width is None:
            return super().__str__()
        return f"{super().__str__()} with a width that changes from {self.width / MILLIMETRE:.3g} mm"

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        stated = super().statement(sizes)
        if not self.is_width_free or self.width is None:
            return stated
        width = f"{{hub_width_change:wider|narrower}} than {self.width / MILLIMETRE:.3g} mm"
        sentence = f"The hub {super().__str__()} is {width} and makes the shaft {{hub_stiffening}} stiffer in bending"
        return dataclasses.replace(stated, sentence=sentence)

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return places_of(problem.rotor.disks, problem.rotor)

    def locations(self, problem: RotorProblem) -> Sequence[Self]:
        """At each disk; of a rotor that was drawn with an unknown width too."""
        hubs = super().locations(problem)
        free = [dataclasses.replace(hub, is_width_free=True) for hub in hubs if problem.is_as_drawn]
        return [*hubs, *free]

    def placed_on(self, problem: RotorProblem) -> Self:
        placed = super().placed_on(problem)
        return dataclasses.replace(placed, width=placed.width or hub_width(problem.rotor, placed.place))

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        width = (self.width or hub_width(rotor, self.place)) * (1 + float(theta[1]) if self.is_width_free else 1.0)
        return dataclasses.replace(rotor, hubs=(*rotor.hubs, Hub(self.place, width, float(theta[0]))))


def hub_width(rotor: Rotor, position: float) -> float:
    """Width of the hub of the disk at a position, m."""
    diameter = diameter_at(rotor, position)
    here = [disk for disk in rotor.disks if abs(disk.position - position) <= SAME_PLACE * rotor.length]
    widths = map(thickness, here)
    return next((width for width in widths if width > THINNEST * diameter), diameter)


def thickness(disk: Disk) -> float:
    """Thickness of a homogeneous ring with these moments of inertia, m; 0 if no ring has them."""
    return float(np.sqrt(max(0.0, 12 * (disk.diametral_inertia - disk.polar_inertia / 2) / disk.mass)))

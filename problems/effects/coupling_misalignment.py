"""Coupling misalignment: action of a coupling that is not true on the end of the shaft.

It acts at the frequency of rotation.

Hubs that are bored off centre push the end of the shaft aside, a force; flanges that are not square bend it, a moment. Both turn
with the shaft and do not depend on speed, as they come of the stiffness of the coupling and not of inertia. They act at the couplings
of the rotor, or if it states none at ends of the shaft that carry no disk:

    f or M = (r_x + i r_y) (1, −i)    at one end of the shaft.

J. K. Sinha, A. W. Lees & M. I. Friswell, Estimating unbalance and misalignment of a flexible rotating machine from a single
run-down, J. Sound Vib. 272 (2004) 967–989, find such forces and moments. Shafts that stand askew on the ground also act at twice
the frequency of rotation: where 2X was measured there is a second such vector, whose size and angle are its own.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.problem.load import FORCE, LOADS, Load
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import (
    PlacedEffect,
    rotor_mass,
    stiffness_scale,
    unbalance_scale,
)
from problems.rotor.extension.sizes import Size, VectorSize
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor
from problems.rotor.finite_elements.loads import forward_load
from problems.rotor.finite_elements.mesh import diameter_at
from problems.rotor.response.problem import RotorProblem

LARGEST = 10.0  # times the force of the largest unbalance u at √(k/m), u k/m; the arm of a moment is the shaft's length
TWICE = 2  # per turn
NOTICED = (0.003, 0.3)  # of the largest: vectors as long as these are drawn


@dataclass(frozen=True)
class CouplingMisalignment(PlacedEffect):
    """A coupling pushes or bends the end of the shaft, once per turn, and perhaps twice."""

    position: float | None = setting(
        None,
        "position of the coupling; null: the first of the rotor file, or without any the far end that carries no disk",
        unit="m",
        at_least=0,
    )
    kind: str = setting(FORCE, "what acts: a force (parallel offset) or a moment (angular offset)", choices=LOADS)
    twice: bool = setting(False, "whether it also acts twice per turn; a diagnosis sets it if 2X was measured")

    is_scanned: ClassVar[bool] = False
    check_next = "Run uncoupled: vibration that disappears confirms it; then align the coupling, cold and hot."
    aliases: ClassVar[Mapping[str, str]] = {
        "crack": "both make 2X; a crack's peaks at half a critical speed, as its sag, and has 3X too",
        "residual_bow": "both turn with the shaft at any speed; run uncoupled, or measure the bow on slow roll",
        "thermal_bow": "both turn with the shaft; a bow of heat is gone when the machine is cold",
        "unbalance": "an unbalance grows with Ω²; measure at low speed too, or run uncoupled",
        "skewed_disk": "moments that turn with the shaft; a disk's grows with Ω²: measure at low speed too",
    }

    what = "coupling"

    @property
    def sizes(self) -> Sequence[Size]:
        orders, unit = ("", "_2x") if self.twice else ("",), Load(0.0, "x", self.kind).unit
        names = [f"coupling_{self.kind}{order}" for order in orders]
        return [VectorSize(name, unit, 1.0, drawn=NOTICED, of=self._largest) for name in names]

    def __str__(self) -> str:
        return f"{self.kind} at {'the far end' if self.position is None else f'{self.position:g} m'}"

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        stated = super().statement(sizes)
        twice = f", and {{coupling_{self.kind}_2x:size}} at twice the speed" if self.twice else ""
        place = stated.place.removeprefix(f"{self.kind} ")
        sentence = f"The coupling acts on the shaft with a {self.kind} of {{coupling_{self.kind}}} {place}{twice}"
        return dataclasses.replace(stated, sentence=sentence)

    def locations(self, problem: RotorProblem) -> Sequence[CouplingMisalignment]:
        """Force and moment at each coupling, moments at nodes, or at each free end without a coupling.

        They also act twice per turn if that is measured.
        """
        twice = self.twice or any(channel.harmonic == TWICE for channel in problem.channels)
        nodes, rotor = problem.rotor.node_positions, problem.rotor
        places = rotor.couplings or free_ends(rotor)
        return [
            dataclasses.replace(self, position=place, kind=quantity, twice=twice)
            for quantity in LOADS
            for place in places
            if quantity == FORCE or np.min(np.abs(nodes - place)) <= SAME_PLACE * rotor.length
        ]

    def placed_on(self, problem: RotorProblem) -> CouplingMisalignment:
        rotor = problem.rotor
        if self.position is None:
            *_, end = rotor.couplings[:1] or free_ends(rotor) or [rotor.length]
            return dataclasses.replace(self, position=end)
        return super().placed_on(problem)

    def caveat(self, problem: RotorProblem) -> str:
        if problem.rotor.couplings:
            return ""
        return (
            "the rotor states no coupling, so that it was tried at the ends of the shaft that carry no disk; state the position of each"
            " under `couplings` in the rotor file"
        )

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        return forward_load(rotor, self.place, self.kind, len(speed))

    @property
    def further_orders(self) -> Sequence[int]:
        return (TWICE,) if self.twice else ()

    def loads_at(self, rotor: Rotor, speed: Array, order: int) -> ComplexArray:
        return self.loads(rotor, speed)

    def load_sizes_at(self, theta: Array, order: int) -> ComplexArray:
        return self.load_sizes(theta[:, 2:])

    def _largest(self, problem: RotorProblem) -> float:
        """N, or N m."""
        force = LARGEST * unbalance_scale(problem) * stiffness_scale(problem) / rotor_mass(problem)
        return force if self.kind == FORCE else force * problem.rotor.length


def free_ends(rotor: Rotor) -> tuple[float, ...]:
    """Ends of the shaft (m), at the outer bearings or beyond, where half a coupling finds room.

    All disks are more than a diameter away.
    """
    parts = [part.position for part in (*rotor.disks, *rotor.masses)]
    return tuple(
        end for end in (0.0, rotor.length) if not any(abs(part - end) < diameter_at(rotor, end) for part in parts)
    )

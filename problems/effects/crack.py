"""Crack: a transverse crack that breathes under the rotor's weight, and takes bending stiffness away where it is open.

One element of the shaft loses the part s of its bending stiffness along the diameter through the crack, which turns with
the shaft and lies at an angle α past +x at t = 0. The crack is open where it lies in the direction of the weight, and closed half a
turn later: with θ = Ωt + α its angle and γ that of the weight, the loss is

    s ½ (1 + cos(θ − γ)) n nᵀ,    n = (cos θ, sin θ),

whose unknowns are s cos α and s sin α. It makes 1X, 2X and 3X of the sag, with peaks at a critical speed, at half and at a
third of it. The weight rules the breathing as long as the vibration is small beside the sag, which holds for heavy horizontal
rotors below their critical speeds.

I. W. Mayes & W. G. R. Davies, Analysis of the response of a multi-rotor-bearing system containing a transverse crack in a rotor,
J. Vib. Acoust. Stress Reliab. Des. 106 (1984) 139–145, doi 10.1115/1.3269142; R. Gasch, A survey of the dynamic behaviour of a
simple rotating shaft with a transverse crack, J. Sound Vib. 160 (1993) 313–332, doi 10.1006/jsvi.1993.1026.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement import Measurement
from ksmea.parameters import Parameter
from ksmea.settings import setting
from ksmea.units import DEGREE
from problems.rotor.assembly import element_dof
from problems.rotor.data import Rotor
from problems.rotor.effect import PlacedEffect, drawn_vector, forward_vector, require_on_shaft
from problems.rotor.mesh import DOF_PER_NODE, element_at, locate
from problems.rotor.problem import RotorProblem
from problems.rotor.shaft import X_PLANE, Y_PLANE, plane_stiffness
from problems.rotor.turning import OF_CONJUGATE, weight_of

LARGEST = 0.5  # of the bending stiffness of an element, of each component: 0.71 in all
NOTICED = (0.02, 0.4)
N_BENDING = 2  # ways in which an element bends in a plane


@dataclass(frozen=True)
class Crack(PlacedEffect):
    """A transverse crack in one element of the shaft opens and closes under the weight."""

    if_nowhere: ClassVar[str] = "give its position"

    position: float | None = setting(
        None, "where it is: in the element of the shaft there; null: in the middle", unit="m", at_least=0
    )
    gravity_deg: float = setting(270.0, "where the weight points, past +x towards +y", unit="deg")

    aliases: ClassVar[Mapping[str, str]] = {
        "coupling_misalignment": "both make 2X; that of a crack peaks at half of a critical speed as its sag does, and has 3X beside it",
        "shaft_asymmetry": "both make 2X at half of a critical speed; a crack opens and closes, which makes 3X of its sag too: look there",
    }
    is_scanned: ClassVar[bool] = False  # 2X grows with it from 0, where a fit finds it
    turns: ClassVar[bool] = True

    def __str__(self) -> str:
        return "in the middle" if self.position is None else f"at {self.position:g} m"

    def seen_in(self, measurement: Measurement) -> Self | None:
        """Where harmonics beside 1X were measured: what it does at 1X alone others do too."""
        return None if all(channel.is_1x for channel in measurement.channels) else self

    def locations(self, problem: RotorProblem) -> Sequence[Crack]:
        """Beside each disk, where a shrink fit ends, or in the middle of a shaft without any."""
        places = sorted({disk.position for disk in problem.rotor.disks})
        return [dataclasses.replace(self, position=place) for place in places or [problem.rotor.length / 2]]

    def placed_on(self, problem: RotorProblem) -> Crack:
        require_on_shaft(problem, self.position, "crack")
        return self

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, "%", 0.01, -LARGEST, LARGEST) for name in ("crack_x", "crack_y"))

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return drawn_vector(rng, *NOTICED)

    def turning_rows(self, rotor: Rotor) -> Array:
        """The element's stiffness is Bᵀ B in each plane, with two rows for x and two for y."""
        index, _ = locate(rotor, rotor.length / 2 if self.position is None else self.position)
        squared, shapes = np.linalg.eigh(plane_stiffness(element_at(rotor, index)))
        bending = np.sqrt(squared[-N_BENDING:])[:, None] * shapes[:, -N_BENDING:].T
        rows = np.zeros((2 * N_BENDING, DOF_PER_NODE * len(rotor.node_positions)))
        rows[:, element_dof(index)] = np.concatenate([bending @ X_PLANE, bending @ Y_PLANE])
        return rows

    def turning_stiffness(self, theta: Array) -> ComplexArray:
        """−s f(θ) n nᵀ with f = ½ + ¼ (e^{i(θ−γ)} + conj) and n nᵀ = ½ + ¼ (S e^{2iθ} + conj)."""
        vector = forward_vector(theta)
        loss, turn = np.abs(vector), np.exp(1j * np.angle(vector))
        opening = turn * np.exp(-1j * self.gravity_deg * DEGREE) / 4  # f_1
        along = turn[:, None, None] ** 2 * OF_CONJUGATE / 4  # (n nᵀ)_2
        unit = np.eye(2) / 2  # (n nᵀ)_0
        first = opening[:, None, None]
        orders = [
            np.broadcast_to(unit / 2, along.shape),
            first * unit + np.conj(first) * along,
            along / 2,
            first * along,
        ]
        return np.stack([np.kron(-loss[:, None, None] * order, np.eye(N_BENDING)[None]) for order in orders], axis=1)

    def weight(self, rotor: Rotor) -> Array:
        return weight_of(rotor, self.gravity_deg * DEGREE)

"""Crack: a transverse crack that breathes under the rotor's weight.

It reduces bending stiffness while it is open.

A length ℓ of the shaft loses the part s of its bending stiffness along the diameter through the crack, which turns with
the shaft and lies at an angle α past +x at t = 0. The crack is open where it lies in the direction of the weight, and
closed half a turn later: with θ = Ωt + α its angle and γ the angle of the weight, the loss is

    s f n nᵀ,    f = ½ (1 + cos(θ − γ)),    n = (cos θ, sin θ),

whose unknowns are s cos α and s sin α. It makes 1X, 2X and 3X of the sag, with peaks at a critical speed, at half and
at a third of it. The weight rules the breathing as long as the vibration is small compared with the sag, which holds
for heavy horizontal rotors below their critical speeds. An open crack that adds the flexibility c, rad/(N m), has
s/(1 − s) = c EI/ℓ, so that s depends on the ℓ that is assumed.

An element that the length covers in part is a stepped beam. Its flexibility, as its right end moves under a force and a
moment, is F_0, and with an open crack F_0 + a g gᵀ with a = s f/(1 − s f), where g gᵀ is the part's own for its mean
moment. How the shaft is cut into elements matters little then: of the change, (h/z)²/12 is left out in an element of
length h at a distance z from where the bending moment is 0, as at the end of a shaft. With λ = gᵀ F_0⁻¹ g, the
stiffness along F_0⁻¹ g loses the part

    a λ/(1 + a λ) = λ s f/(1 − q f) = Σ c_k e^{ik(θ − γ)},    q = s (1 − λ),    p = √(1 − q),
    c_0 = λ s/(p (1 + p)),    c_k = λ s/((1 + p)² p) ρ^{k − 1},    ρ = q/(1 + p)².

I. W. Mayes & W. G. R. Davies, Analysis of the response of a multi-rotor-bearing system containing a transverse crack in a rotor,
J. Vib. Acoust. Stress Reliab. Des. 106 (1984) 139–145, doi 10.1115/1.3269142; R. Gasch, A survey of the dynamic behaviour of a
simple rotating shaft with a transverse crack, J. Sound Vib. 160 (1993) 313–332, doi 10.1006/jsvi.1993.1026.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Measurement
from ksmea.settings.settings import setting
from ksmea.units import DEGREE
from problems.rotor.extension.effect import PlacedEffect, forward_vector, places_of
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.extension.turning import HIGHEST, OF_CONJUGATE, weight_of
from problems.rotor.finite_elements.assembly import element_dof
from problems.rotor.finite_elements.data import Hub, Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE, diameter_at, elements
from problems.rotor.finite_elements.sections import right_end
from problems.rotor.finite_elements.shaft import X_PLANE, Y_PLANE, flexibility_under_hubs
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.35  # of the bending stiffness, of each component: 0.49 in all; of more, orders above the third count
NOTICED = (0.05, 0.33)
MAX_KEPT = 64  # rotors: effects that change one make others
SHORTEST = 1e-3  # length, of the shaft's diameter
TOUCHED = 1e-9  # of an element: less is rounding of where the length ends
HALVED = -0.5  # the stiffening under a hub that doubles flexibility, which then is larger by what it was
ORDERS = 2 * HIGHEST  # of the stiffness, up to that which couples the highest order of the motion with its negative


@dataclass(frozen=True)
class Crack(PlacedEffect):
    """A transverse crack in the shaft opens and closes under the weight."""

    if_nowhere: ClassVar[str] = "give its position"

    position: float | None = setting(
        None, "the middle of the length that it softens; null: the middle of the shaft", unit="m", at_least=0
    )
    length: float | None = setting(
        None, "of the shaft that loses bending stiffness; null: the shaft's diameter there", unit="m", above=0
    )
    gravity_deg: float = setting(270.0, "direction of the weight, past +x towards +y", unit="deg")

    says = "A crack {place} takes away {crack:size} of the bending stiffness where it is open"
    check_next = (
        "Stop the machine and inspect the shaft there by dye penetrant or ultrasound: an indication confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "coupling_misalignment": "both make 2X; a crack's peaks at half a critical speed, as its sag, and has 3X too",
        "shaft_asymmetry": "both make 2X at half of a critical speed; a crack opens and closes, which makes 3X of its sag too: look there",
    }
    is_scanned: ClassVar[bool] = False  # 2X grows with it from 0, where a fit finds it

    what = "crack"
    sizes = (VectorSize("crack", "%", LARGEST, drawn=NOTICED),)

    def __str__(self) -> str:
        return "in the middle" if self.position is None else f"at {self.position:g} m"

    def seen_in(self, measurement: Measurement) -> Self | None:
        """This effect if harmonics other than 1X were measured: at 1X alone, other effects look alike."""
        return None if all(channel.is_1x for channel in measurement.channels) else self

    def locations(self, problem: RotorProblem) -> Sequence[Crack]:
        """About each disk, or in the middle of a shaft without any."""
        places: list[float | None] = [*sorted(places_of(problem.rotor.disks, problem.rotor))] or [None]
        return [dataclasses.replace(self, position=place).placed_on(problem) for place in places]

    def placed_on(self, problem: RotorProblem) -> Crack:
        super().placed_on(problem)
        rotor = problem.rotor
        position = rotor.length / 2 if self.position is None else self.position
        diameter = diameter_at(rotor, position)
        length = self.length or diameter
        if not SHORTEST * diameter <= length <= rotor.length:
            raise SettingError(
                f"length: expected one of the shaft, {SHORTEST * diameter:g} to {rotor.length:g} m, got {length:g} m"
            )
        return dataclasses.replace(self, position=position, length=length)

    def turning_rows(self, rotor: Rotor) -> Array:
        """One for x of each element that it softens, then those for y."""
        bending = self._bending(rotor)
        found = np.zeros((2, len(bending), DOF_PER_NODE * len(rotor.node_positions)))
        for part, (index, (_, row)) in enumerate(bending.items()):
            for plane, of_plane in zip(found, (X_PLANE, Y_PLANE)):
                plane[part, element_dof(index)] = row @ of_plane
        return np.concatenate(found)

    def turning_stiffness(self, rotor: Rotor, theta: Array) -> ComplexArray:
        """Turning stiffness −Σ c_k e^{ik(θ − γ)} n nᵀ.

        With n nᵀ = ½ + ¼ (S e^{2iθ} + conj), up to the orders by which the motion is coupled.
        """
        vector = forward_vector(theta)
        turn, gravity = np.exp(1j * np.angle(vector)), np.exp(1j * self.gravity_deg * DEGREE)
        share = np.array([each for each, _ in self._bending(rotor).values()])
        order = np.arange(-ORDERS - 2, ORDERS + 3)
        lost = losses(np.abs(vector), share)[:, np.abs(order)] * ((turn / gravity)[:, None] ** order)[..., None]
        lost = lost[..., None] * np.eye(len(share))  # (n, order, element, element)
        along = turn[:, None, None] ** 2 * OF_CONJUGATE / 4  # (n nᵀ)_2
        first = 2 + ORDERS  # where order 0 is
        parts = ((np.broadcast_to(np.eye(2) / 2, along.shape), 0), (along, -2), (np.conj(along), 2))
        found = sum(
            np.einsum("nij,nmkl->nmikjl", part, lost[:, first + by : first + by + ORDERS + 1]) for part, by in parts
        )
        return -np.reshape(found, (len(theta), ORDERS + 1, 2 * len(share), 2 * len(share)))

    def _bending(self, rotor: Rotor) -> Mapping[int, tuple[float, Array]]:
        return softened(rotor, self.place, self.length or diameter_at(rotor, self.place))

    def weight(self, rotor: Rotor) -> Array:
        return weight_of(rotor, self.gravity_deg * DEGREE)


@lru_cache(MAX_KEPT)
def softened(rotor: Rotor, position: float, length: float) -> Mapping[int, tuple[float, Array]]:
    """The way to bend of each element that a length about a position (m) touches.

    λ, and the row (4,) of one plane that reads it, of unit stiffness.
    """
    softer = dataclasses.replace(rotor, hubs=(*rotor.hubs, Hub(position, length, HALVED)))
    found = {}
    for index, (before, after) in enumerate(zip(elements(rotor), elements(softer), strict=True)):
        if any(high - low > TOUCHED for low, high, _ in after.hubs[len(before.hubs) :]):
            whole = flexibility_under_hubs(before)
            _, by_moment = flexibility_under_hubs(after) - whole
            held = np.linalg.solve(whole, by_moment / np.sqrt(by_moment[1]))
            share = float(held @ whole @ held)
            found[index] = share, held @ right_end(before.length) / np.sqrt(share)
    return found


def losses(loss: Array, share: Array) -> Array:
    """c_k (n, n_order, n_element) for k = 0, 1, 2 … of losses s (n,) and λ (n_element,)."""
    s = loss[:, None]
    q = s * (1 - share)
    p = np.sqrt(1 - q)
    mean, first, ratio = share * s / (p * (1 + p)), share * s / ((1 + p) ** 2 * p), q / (1 + p) ** 2
    further = first[:, None] * ratio[:, None] ** np.arange(ORDERS + 2)[:, None]
    return np.concatenate([mean[:, None], further], axis=1)

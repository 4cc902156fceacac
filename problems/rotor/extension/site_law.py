"""Forces on a rotor that follow a law at a site.

They change its motion, its impedances and its free vibrations.

With Q the motion without a force f and G that per unit of it, q = Q + G f, and f is what its law makes of q
(`ksmea.nonlinear.laws`). Forces by laws that are linear in the motion enter one after the other: each changes what the following ones
see, which is exact, as a rank-two update of a receptance is. All others enter last and together
(`problems/rotor/extension/nonlinear_sites.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import DIRECTIONS, Channel
from ksmea.nonlinear.laws import Law, NonlinearLaw
from ksmea.nonlinear.steady_motion import SiteMotion
from ksmea.problem.load import FORCE, Load
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import unit_loads

# Of a force that is alike in opposite directions; the error of what is left out is stated by `steady_force`
ORDERS = (1, 3, 5)


@dataclass(frozen=True)
class SiteLaw:
    """The law that a force in x and y at a position (m) follows; a moment follows one of speed alone.

    One that is not linear in the motion may act at `further` positions alike, and acts at `orders` of the rotation in a
    motion that a speed going up leads to, or down.
    """

    position: float
    law: Law
    quantity: str = FORCE
    further: tuple[float, ...] = ()
    orders: tuple[int, ...] = ORDERS
    goes_up: bool = True

    @property
    def positions(self) -> tuple[float, ...]:
        return (self.position, *self.further)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The motion of the sites."""
        return tuple(Channel(position, axis) for position in self.positions for axis in DIRECTIONS)

    @property
    def loads(self) -> tuple[Load, ...]:
        """Unit forces at the sites, or moments."""
        return tuple(Load(position, axis, self.quantity) for position in self.positions for axis in DIRECTIONS)

    @property
    def is_linear(self) -> bool:
        """Whether the force is linear in the motion of its site.

        Its terms are proportional to the motion, or do not depend on it.
        """
        return not isinstance(self.law, NonlinearLaw)

    def rows(self, rotor: Rotor) -> Array:
        """The nodal loads of these, which also read the motion that they do work on, (n_load, n_dof)."""
        return unit_loads(rotor, self.loads, 1)[0].T.real

    def at_rest(self, coefficients: Array, speed: Array) -> ComplexArray:
        """The force (n_speed, 2), N, with coefficients (1, n_coefficient), on a site that does not move."""
        return self.law.at_motion(coefficients, speed, np.zeros((1, len(speed), 2), dtype=complex))[0]

    def stiffness(self, coefficients: Array, speed: Array) -> ComplexArray:
        """K (n_speed, 2, 2), N/m, of a linear law that follows the motion: f = −K q."""
        unit = np.broadcast_to(np.eye(2, dtype=complex)[:, None, None], (2, 1, len(speed), 2))
        return -np.stack([self.law.at_motion(coefficients, speed, motion)[0] for motion in unit], axis=-1)

    def stiffness_at(self, coefficients: Array, speed: Array, harmonic: float) -> ComplexArray:
        """Stiffness K at a harmonic of the speed.

        Mass and damping depend on the harmonic, and so does everything that has a mode of its own.
        """
        if self.law.has_own_mode:
            return self.stiffness(coefficients, harmonic * speed)
        mass, damping, stiffness = attached((self, coefficients), speed)
        frequency = (harmonic * speed)[:, None, None]
        return np.asarray(stiffness + 1j * frequency * damping - frequency**2 * mass, dtype=complex)


Force = tuple[SiteLaw, Array]  # with its coefficients (n, n_coefficient) SI


def split_by_law(forces: Sequence[Force]) -> tuple[list[Force], list[Force]]:
    """Forces by laws that are linear in the motion, and the other forces."""
    linear = [force for force in forces if force[0].is_linear]
    return linear, [force for force in forces if not force[0].is_linear]


def with_linear_forces(
    columns: ComplexArray, forces: Sequence[Force], seen: Sequence[Channel], speed: Array
) -> ComplexArray:
    """Motion and responses to unit loads with forces by linear laws acting.

    They are (n, n_speed, n_seen, 1 + n_load).

    `columns` (n, n_speed, n_seen, 1 + 2 n_force + n_load) are those without: the motion, the response to unit forces in x and
    y at the site of each force, and to the loads.
    """
    for site, coefficients in forces:
        rows = [seen.index(channel) for channel in site.channels]
        per_force = columns[..., 1:3]
        columns = np.delete(columns, (1, 2), axis=-1)
        for index in range(columns.shape[-1] if site.law.follows_motion else 1):
            column = columns[..., index]
            force = site.law.steady(coefficients, SiteMotion(speed, column[:, :, rows], per_force[:, :, rows]))
            columns[..., index] = column + (per_force @ force[..., None])[..., 0]
    return columns


def attached(force: Force, speed: Array) -> tuple[Array, Array, Array]:
    """Mass, damping and stiffness that a force by a linear law adds at its site.

    Mass is (2, 2), damping and stiffness (n_speed, 2, 2) at spin speeds.

    K(Ω) has a mass in what grows with Ω², which is the frequency of the motion, as a bearing has none; all else is a
    function of the spin speed, as coefficients of bearings are.
    """
    site, coefficients = force
    still, slow, fast = site.stiffness(coefficients, np.array([0.0, 1.0, 2.0])).real
    mass = -(still - 2 * slow + fast) / 2
    whole = site.stiffness(coefficients, speed)
    spin = speed[:, None, None]
    return mass, whole.imag / spin, whole.real + spin**2 * mass

"""Forces on a rotor that follow a law at a site: what they make of its motion, of its impedances and of its free motions.

With Q the motion without a force f and G that per unit of it, q = Q + G f, and f is what its law makes of q
(`ksmea.force_laws`). Several forces enter one after the other: each changes what the following ones see, which is exact
where laws are linear in the motion, as a rank-two update of a receptance is. One that is not comes last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import DIRECTIONS, Channel
from ksmea.errors import SettingError
from ksmea.force_laws import Law, NonlinearLaw
from ksmea.load import FORCE, Load
from ksmea.steady_motion import SiteMotion
from problems.rotor.data import Rotor
from problems.rotor.loads import unit_loads


@dataclass(frozen=True)
class SiteLaw:
    """The law that a force in x and y at a position (m) follows; a moment follows one of speed alone."""

    position: float
    law: Law
    kind: str = FORCE

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The motion of the site."""
        return tuple(Channel(self.position, axis) for axis in DIRECTIONS)

    @property
    def loads(self) -> tuple[Load, ...]:
        """Unit forces at the site, or moments."""
        return tuple(Load(self.position, axis, self.kind) for axis in DIRECTIONS)

    @property
    def is_linear(self) -> bool:
        """Whether the force is a sum of terms that are proportional to the motion of its site, or do not depend on it."""
        return not isinstance(self.law, NonlinearLaw)

    def rows(self, rotor: Rotor) -> Array:
        """The nodal loads of these, which also read the motion that they do work on, (2, n_dof)."""
        return unit_loads(rotor, self.loads, 1)[0].T.real

    def at_rest(self, coefficients: Array, speed: Array) -> ComplexArray:
        """The force (n_speed, 2), N, with coefficients (1, n_coefficient), on a site that does not move."""
        return self.law.at_motion(coefficients, speed, np.zeros((1, len(speed), 2), dtype=complex))[0]

    def stiffness(self, coefficients: Array, speed: Array) -> ComplexArray:
        """K (n_speed, 2, 2), N/m, of a linear law that follows the motion: f = −K q."""
        unit = np.broadcast_to(np.eye(2, dtype=complex)[:, None, None], (2, 1, len(speed), 2))
        return -np.stack([self.law.at_motion(coefficients, speed, motion)[0] for motion in unit], axis=-1)


Force = tuple[SiteLaw, Array]  # with its coefficients (n, n_coefficient) SI


def with_forces(columns: ComplexArray, forces: Sequence[Force], seen: Sequence[Channel], speed: Array) -> ComplexArray:
    """Motion and responses to unit loads (n, n_speed, n_seen, 1 + n_load) with all forces acting.

    `columns` (n, n_speed, n_seen, 1 + 2 n_force + n_load) are those without: the motion, the response to unit forces in x and
    y at the site of each force, and to the loads. Raises `SettingError` where a law that is not linear meets loads, to which
    there is no response of its own, or a second such law.
    """
    for site, coefficients in forces:
        rows = [seen.index(channel) for channel in site.channels]
        per_force = columns[..., 1:3]
        columns = np.delete(columns, (1, 2), axis=-1)
        if not site.is_linear and columns.shape[-1] > 1:
            raise SettingError(
                f"local_force: expected a law that is linear in the motion beside loads or another such force, got {site.law.name}"
            )
        for index in range(columns.shape[-1] if site.law.follows_motion else 1):
            column = columns[..., index]
            force = site.law.steady(coefficients, SiteMotion(speed, column[:, :, rows], per_force[:, :, rows]))
            columns[..., index] = column + (per_force @ force[..., None])[..., 0]
    return columns


def dense_parts(rotor: Rotor, force: Force, speed: Array) -> tuple[ComplexArray, ComplexArray]:
    """A force by a linear law, with coefficients (1, n_coefficient), in the matrices of the whole rotor: what it adds to the
    dynamic stiffness (n_speed, n_dof, n_dof), N/m, and to the nodal forces (n_speed, n_dof), N."""
    site, coefficients = force
    rows, acting = site.rows(rotor), site.at_rest(coefficients, speed)
    if site.law.follows_motion:
        return rows.T @ site.stiffness(coefficients, speed) @ rows, acting @ rows
    return np.zeros((1, *2 * rows.shape[1:]), dtype=complex), acting @ rows


def attached(force: Force, speed: Array) -> tuple[Array, Array, Array]:
    """Mass (2, 2), and damping and stiffness (n_speed, 2, 2) at spin speeds, that a force by a linear law adds at its site.

    K(Ω) has a mass in what grows with Ω², which is the frequency of the motion, as a bearing has none; all else is a
    function of the spin speed, as coefficients of bearings are."""
    site, coefficients = force
    still, slow, fast = site.stiffness(coefficients, np.array([0.0, 1.0, 2.0])).real
    mass = -(still - 2 * slow + fast) / 2
    whole = site.stiffness(coefficients, speed)
    spin = speed[:, None, None]
    return mass, whole.imag / spin, whole.real + spin**2 * mass

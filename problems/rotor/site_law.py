"""Forces on a rotor that follow a law at a site: what they make of its motion, of its impedances and of its free motions.

With Q the motion without a force f and G that per unit of it, q = Q + G f, and f is what its law makes of q
(`ksmea.force_laws`). Several forces enter one after the other: each changes what the following ones see, which is exact
where laws are linear in the motion, as a rank-two update of a receptance is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import DIRECTIONS, Channel
from ksmea.force_laws import Law, force_of
from ksmea.load import Load
from problems.rotor.assembly import displacement_row
from problems.rotor.data import Rotor


@dataclass(frozen=True)
class SiteLaw:
    """The law that a force in x and y at a position (m) follows."""

    position: float
    law: Law

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The motion of the site."""
        return tuple(Channel(self.position, axis) for axis in DIRECTIONS)

    @property
    def loads(self) -> tuple[Load, ...]:
        """Unit forces at the site."""
        return tuple(Load(self.position, axis) for axis in DIRECTIONS)

    def rows(self, rotor: Rotor) -> Array:
        """What reads the motion of the site, (2, n_dof)."""
        return np.stack([displacement_row(rotor, self.position, axis) for axis in DIRECTIONS])


Force = tuple[SiteLaw, Array]  # with its coefficients (n, n_coefficient) SI


def with_forces(columns: ComplexArray, forces: Sequence[Force], seen: Sequence[Channel], speed: Array) -> ComplexArray:
    """Motion and responses to unit loads (n, n_speed, n_seen, 1 + n_load) with all forces acting.

    `columns` (n, n_speed, n_seen, 1 + 2 n_force + n_load) are those without: the motion, the response to unit forces in x and
    y at the site of each force, and to the loads.
    """
    for site, coefficients in forces:
        rows = [seen.index(channel) for channel in site.channels]
        per_force = columns[..., 1:3]
        columns = np.delete(columns, (1, 2), axis=-1)
        for index in range(columns.shape[-1] if site.law.follows_motion else 1):
            column = columns[..., index]
            force = force_of(site.law, coefficients, speed, column[:, :, rows], per_force[:, :, rows])
            columns[..., index] = column + (per_force @ force[..., None])[..., 0]
    return columns


def dense_parts(rotor: Rotor, force: Force, speed: Array) -> tuple[ComplexArray, ComplexArray]:
    """A force with coefficients (1, n_coefficient) in the matrices of the whole rotor: what it adds to the dynamic
    stiffness (n_speed, n_dof, n_dof), N/m, and to the nodal forces (n_speed, n_dof), N."""
    site, coefficients = force
    rows = site.rows(rotor)
    acting = np.einsum("c,c...->...", coefficients[0], site.law.terms(speed))
    n_dof = rows.shape[1]
    if site.law.follows_motion:
        return rows.T @ acting @ rows, np.zeros((len(speed), n_dof), dtype=complex)
    return np.zeros((len(speed), n_dof, n_dof), dtype=complex), acting @ rows


def attached(force: Force) -> Array:
    """Mass, damping and stiffness (3, 2, 2) that a force which follows the motion, with coefficients (1, n_coefficient), adds
    at its site: M, C and K of its −Ω² M + iΩ C + K, which do not depend on speed."""
    site, coefficients = force
    at_rest, turning = np.einsum("c,c...->...", coefficients[0], site.law.terms(np.array([0.0, 1.0])))
    return np.stack([(at_rest - turning).real, turning.imag, at_rest.real])

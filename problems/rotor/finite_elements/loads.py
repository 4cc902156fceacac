"""Loads on the nodes of a rotor: unit forces and moments, and the rotating force of an unbalance.

Sign convention: a real load is Re(f e^{iΩt}); a moment about x turns φ_x up, as in the mesh. An unbalance at angle 0 points to +x
at t = 0 and turns to +y, so f = m e Ω² e^{iφ} (1, −i) in (x, y).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import DIRECTIONS
from ksmea.problem.load import Load
from problems.rotor.finite_elements.assembly import displacement_row, rotation_row
from problems.rotor.finite_elements.data import Rotor


def unit_loads(rotor: Rotor, loads: Sequence[Load], n_speed: int) -> ComplexArray:
    """The nodal forces of unit loads, the same at each speed, (n_speed, n_dof, n_load).

    Each may act anywhere on the shaft.
    """
    columns = np.stack([_nodal_load(rotor, load) for load in loads], axis=1)
    return np.broadcast_to(columns.astype(complex), (n_speed, *columns.shape))


def forward_load(rotor: Rotor, position: float, quantity: str, n_speed: int) -> ComplexArray:
    """Nodal forces of a unit force or moment that turns forward with the shaft, (1, −i) in x and y.

    It acts at a position (m); the forces are equal at each speed, (n_speed, n_dof, 1).
    """
    units = unit_loads(rotor, [Load(position, axis, quantity) for axis in DIRECTIONS], n_speed)
    return units @ np.array([[1], [-1j]])


def _nodal_load(rotor: Rotor, load: Load) -> Array:
    rotor.require_on_shaft(load.position, load.quantity)
    if load.quantity == "force":
        return displacement_row(rotor, load.position, load.direction)
    return rotation_row(rotor, load.position, load.direction)


def force_per_unbalance(rotor: Rotor, speed: Array) -> ComplexArray:
    """Nodal forces of a unit unbalance in each plane, (n_speed, n_dof, n_plane), N per kg m.

    The unbalance is 1 kg m at angle 0.
    """
    direction = np.stack(
        [
            displacement_row(rotor, plane.position, "x") - 1j * displacement_row(rotor, plane.position, "y")
            for plane in rotor.unbalance
        ],
        axis=-1,
    )
    return np.asarray(speed)[:, None, None] ** 2 * direction


def complex_unbalance(rotor: Rotor) -> ComplexArray:
    """m e e^{iφ} of each plane, (n_plane,) kg m."""
    return np.array([plane.magnitude * np.exp(1j * plane.phase) for plane in rotor.unbalance])

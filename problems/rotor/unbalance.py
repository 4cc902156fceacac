"""The rotating force of an unbalance.

Sign convention: a real force is Re(f e^{iΩt}). An unbalance at angle 0 points to +x at t = 0 and turns to +y, so
f = m e Ω² e^{iφ} (1, −i) in (x, y).
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray
from problems.rotor.assembly import displacement_row
from problems.rotor.data import Rotor


def force_per_unbalance(rotor: Rotor, speed: Array) -> ComplexArray:
    """Nodal forces of a unit unbalance (1 kg m at angle 0) in each plane, (n_speed, n_dof, n_plane), N per kg m."""
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

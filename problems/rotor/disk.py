"""The rigid disk: mass and gyroscopic matrices on the degrees of freedom (x, y, φ_x, φ_y) of its node."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from problems.rotor.data import Disk


def disk_mass(disk: Disk) -> Array:
    """(4, 4): translation and rotation about a diameter."""
    return np.diag([disk.mass, disk.mass, disk.diametral_inertia, disk.diametral_inertia])


def disk_gyroscopic(disk: Disk) -> Array:
    """(4, 4), multiplied by Ω in M q̈ + Ω G q̇ + K q = f.

    The disk's angular momentum about its own axis, I_p Ω, turns with the axis (φ_y, −φ_x, 1); its rate of change
    is I_p Ω (φ̇_y, −φ̇_x).
    """
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = disk.polar_inertia, -disk.polar_inertia
    return gyroscopic

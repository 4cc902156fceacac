"""Disks whose mass was weighed and whose size was measured."""

from __future__ import annotations

import math

from problems.rotor.data import Disk


def weighed_ring(position: float, *, mass: float, outer_radius: float, inner_radius: float, thickness: float) -> Disk:
    """A ring of given mass (kg) and size (m): the inertias are those of its mean density.

    >>> disk = weighed_ring(0.2, mass=2.0, outer_radius=0.1, inner_radius=0.0, thickness=0.01)
    >>> round(disk.mass, 12), round(disk.polar_inertia, 12)
    (2.0, 0.01)
    """
    volume = math.pi * (outer_radius**2 - inner_radius**2) * thickness
    return Disk.from_geometry(
        position, outer_radius=outer_radius, inner_radius=inner_radius, thickness=thickness, density=mass / volume
    )

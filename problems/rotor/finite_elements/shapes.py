"""Shapes of common parts: a shaft of one diameter with nodes at given positions, disks as rings of known mass and size."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from problems.rotor.finite_elements.data import Disk, Material, ShaftSegment
from problems.rotor.finite_elements.mesh import share_elements


def uniform_shaft(
    length: float, marks: Iterable[float], n_element: int, *, radius: float, material: Material
) -> tuple[ShaftSegment, ...]:
    """Segments of a shaft (m) that end at each mark, so that the mesh has a node there; elements shared by length."""
    ends = sorted({0.0, length, *marks})
    lengths = [float(piece) for piece in np.diff(ends)]
    counts = share_elements(n_element, lengths)
    return tuple(ShaftSegment(piece, radius, material, count) for piece, count in zip(lengths, counts, strict=True))


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

"""A shaft of one diameter, cut where something sits on it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from problems.rotor.data import Material, ShaftSegment
from problems.rotor.mesh import share_elements


def uniform_shaft(
    length: float, marks: Iterable[float], n_element: int, *, radius: float, material: Material
) -> tuple[ShaftSegment, ...]:
    """Segments of a shaft (m) that end at each mark, so that the mesh has a node there; elements shared by length."""
    ends = sorted({0.0, length, *marks})
    lengths = [float(piece) for piece in np.diff(ends)]
    counts = share_elements(n_element, lengths)
    return tuple(ShaftSegment(piece, radius, material, count) for piece, count in zip(lengths, counts, strict=True))

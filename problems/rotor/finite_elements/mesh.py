"""Mesh of a shaft: elements, nodes at given positions, location on the mesh.

Disks as rings of known mass and size.
"""

from __future__ import annotations

import bisect
import dataclasses
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.errors import SettingError
from problems.rotor.finite_elements.data import Hub, Rotor
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, Material, Segment, ShaftSegment

DOF_PER_NODE = 4  # x, y, rotation about x, rotation about y


@dataclass(frozen=True)
class Element:
    """A piece of a shaft segment between two neighbouring nodes."""

    segment: Segment
    start: float  # m
    hubs: tuple[tuple[float, float, float], ...] = ()  # from, to as fractions of its length; stiffening
    # of it as fractions of its segment, where that is not constant along its length
    ends: tuple[float, float] = (0.0, 1.0)

    @property
    def length(self) -> float:  # m
        return self.segment.length / self.segment.n_element


def elements(rotor: Rotor) -> tuple[Element, ...]:
    """The elements of a rotor's shaft from left to right; element e lies between nodes e and e + 1."""
    owners = [(segment, part) for segment in rotor.segments for part in range(segment.n_element)]
    starts = zip(owners, rotor.node_positions[:-1], strict=True)
    plain = (_element(owner, part, float(start)) for (owner, part), start in starts)
    return tuple(_with_hubs(element, rotor.hubs) for element in plain) if rotor.hubs else tuple(plain)


def _element(segment: Segment, part: int, start: float) -> Element:
    if isinstance(segment, CouplingSegment) or segment.is_cylinder:
        return Element(segment, start)
    return Element(segment, start, (), (part / segment.n_element, (part + 1) / segment.n_element))


def _with_hubs(element: Element, hubs: Sequence[Hub]) -> Element:
    """The element with those hubs that reach over it."""
    reach = [
        tuple(
            min(max((hub.position + side * hub.width / 2 - element.start) / element.length, 0.0), 1.0)
            for side in (-1, 1)
        )
        for hub in hubs
    ]
    over = tuple((low, high, hub.stiffening) for (low, high), hub in zip(reach, hubs) if high > low)
    return dataclasses.replace(element, hubs=over) if over else element


def element_at(rotor: Rotor, index: int) -> Element:
    """One of these."""
    ends = list(itertools.accumulate(segment.n_element for segment in rotor.segments))
    place = bisect.bisect_right(ends, index)
    owner = rotor.segments[place]
    element = _element(owner, index - ends[place] + owner.n_element, float(rotor.node_positions[index]))
    return _with_hubs(element, rotor.hubs) if rotor.hubs else element


def locate(rotor: Rotor, position: float) -> tuple[int, float]:
    """The element that holds a position (m), and the location inside it as a fraction of its length."""
    nodes = rotor.node_positions
    element = min(max(int(np.searchsorted(nodes, position, side="right")) - 1, 0), len(nodes) - 2)
    fraction = float((position - nodes[element]) / (nodes[element + 1] - nodes[element]))
    return element, min(max(fraction, 0.0), 1.0)


def diameter_at(rotor: Rotor, position: float) -> float:
    """Diameter of the shaft at a position (m), m; at a step that to its right."""
    element = element_at(rotor, locate(rotor, position)[0])
    segment = element.segment
    left, right = segment.outer_radius, getattr(segment, "outer_radius_right", None)
    if right is None:
        return 2 * left
    start = element.start - element.ends[0] * segment.length
    return 2 * (left + (right - left) * min(max((position - start) / segment.length, 0.0), 1.0))


def share_elements(n_element: int, lengths: Sequence[float]) -> tuple[int, ...]:
    """Elements per segment in proportion to length by largest remainder, at least one each.

    >>> share_elements(13, [0.2, 0.3, 0.5, 0.3]), share_elements(21, [0.2, 0.3, 0.5, 0.3])
    ((2, 3, 5, 3), (3, 5, 8, 5))
    """
    if n_element < len(lengths):
        raise SettingError(
            f"mesh: expected at least {len(lengths)} elements, got {n_element};"
            " disks need a node at the end of each of the shaft's segments"
        )
    quotas = [n_element * length / sum(lengths) for length in lengths]
    counts = [max(1, math.floor(quota + 1e-9)) for quota in quotas]  # 1e-9: a whole quota may round to just below it
    while sum(counts) < n_element:
        remainders = [quota - count for quota, count in zip(quotas, counts, strict=True)]
        counts[remainders.index(max(remainders))] += 1
    while sum(counts) > n_element:  # where many short segments were raised to one
        spare = [count - quota if count > 1 else -math.inf for quota, count in zip(quotas, counts, strict=True)]
        counts[spare.index(max(spare))] -= 1
    return tuple(counts)


def uniform_shaft(
    length: float, marks: Iterable[float], n_element: int, *, radius: float, material: Material
) -> tuple[ShaftSegment, ...]:
    """Segments of a shaft (m) that end at each mark, so that the mesh has a node there.

    Elements shared by length.
    """
    ends = sorted({0.0, length, *marks})
    lengths = [float(piece) for piece in np.diff(ends)]
    counts = share_elements(n_element, lengths)
    return tuple(ShaftSegment(piece, radius, material, count) for piece, count in zip(lengths, counts, strict=True))


def weighed_ring(position: float, *, mass: float, outer_radius: float, inner_radius: float, thickness: float) -> Disk:
    """A ring of given mass (kg) and size (m); its inertias follow from its mean density.

    >>> disk = weighed_ring(0.2, mass=2.0, outer_radius=0.1, inner_radius=0.0, thickness=0.01)
    >>> round(disk.mass, 12), round(disk.polar_inertia, 12)
    (2.0, 0.01)
    """
    volume = math.pi * (outer_radius**2 - inner_radius**2) * thickness
    return Disk.from_geometry(
        position, outer_radius=outer_radius, inner_radius=inner_radius, thickness=thickness, density=mass / volume
    )

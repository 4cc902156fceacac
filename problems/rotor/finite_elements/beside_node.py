"""Bearings, seals and disks that sit off the nodes of the mesh.

The shaft's own motion there, by the shapes of its elements.

A number of the rotor that moves them along the shaft (`problems/rotor/inputs`) leaves the mesh as it is, so that a response is a smooth
function of it. Beyond the ends of the shaft they are on a rigid extension of it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.measurement.channel import DIRECTIONS
from problems.rotor.finite_elements import shaft
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE, Element, element_at, locate
from problems.rotor.finite_elements.segments import Disk

MAX_KEPT = 256  # rows that parts are read by: most stay where they are while a number of another changes


def motion_rows(rotor: Rotor, position: float) -> tuple[Indices, Array]:
    """Degrees of freedom (8,) that move the shaft at a position (m), and rows (4, 8) that read it.

    The rows read x, y, φ_x and φ_y there.
    """
    inside = float(np.clip(position, 0.0, rotor.length))
    index, fraction = locate(rotor, inside)
    rows = _rows_within(element_at(rotor, index), fraction)
    if beyond := position - inside:
        rows = rows.copy()
        rows[0] += beyond * rows[3]  # x grows with φ_y, y with −φ_x
        rows[1] -= beyond * rows[2]
    return DOF_PER_NODE * index + np.arange(2 * DOF_PER_NODE), rows


@lru_cache(maxsize=MAX_KEPT)
def _rows_within(element: Element, fraction: float) -> Array:
    """Rows (4, 8) within an element, which are kept, and not to be written to."""
    deflection = [shaft.displacement_row(element, fraction, direction) for direction in DIRECTIONS]
    rows = np.array([*deflection, *shaft.rotation_rows(element, fraction)])
    rows.flags.writeable = False
    return rows


def bearing_rows(rotor: Rotor, bearing: Bearing) -> tuple[Indices, Array]:
    """Degrees of freedom that move a bearing, and rows (2, n) that read x and y there."""
    if not bearing.offset:
        node = rotor.node_at(bearing.position, "bearing")
        return DOF_PER_NODE * node + np.arange(2), np.eye(2)
    dof, rows = motion_rows(rotor, bearing.position + bearing.offset)
    return dof, rows[:2]


def disk_rows(rotor: Rotor, disk: Disk) -> tuple[Indices, Array]:
    """Degrees of freedom that move a disk, and rows (4, n) that read its x, y, φ_x, φ_y."""
    if not disk.offset:
        node = rotor.node_at(disk.position, "disk")
        return DOF_PER_NODE * node + np.arange(DOF_PER_NODE), np.eye(DOF_PER_NODE)
    return motion_rows(rotor, disk.position + disk.offset)

"""Undamped critical speeds of a rotor on bearings of one stiffness in x and y: a direct eigenproblem in the speed.

Shaft and disks are round, so that a motion at the frequency of rotation is a forward or a backward circular whirl: with u the
deflections in x and their slopes, y = ∓i x and M − i n G taken to them,

    K u = Ω² (M ∓ G′) u,

whose solutions with Ω² > 0 are the critical speeds, all at once. A thin disk can make M − G′ indefinite: it has no forward one then
(M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010, section 6.3).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ksmea.arrays import Array
from problems.rotor.assembly import Matrices, assemble_free, node_dof
from problems.rotor.data import Rotor

FORWARD = np.array([[1, 0], [-1j, 0], [0, 1j], [0, 1]])  # (x, y, φ_x, φ_y) of the deflection in x and its slope φ_y


def undamped_critical_speeds(rotor: Rotor, stiffness: float, free: Matrices | None = None) -> tuple[Array, Array]:
    """Forward and backward critical speeds (rad/s), each rising, with a stiffness (N/m) at every bearing's place; `free` are the
    matrices without bearings where they are known."""
    free = free or assemble_free(rotor)
    held = (free.stiffness + free.stiffness.T) / 2
    for bearing in rotor.bearings:
        dof = node_dof(rotor.node_at(bearing.position, "bearing"))[:2]
        held[dof, dof] += stiffness
    n_node = len(rotor.node_positions)
    forward, backward = (
        _critical_speeds(held, free, np.kron(np.eye(n_node), circle)) for circle in (FORWARD, FORWARD.conj())
    )
    return forward, backward


def _critical_speeds(stiffness: Array, free: Matrices, circles: Array) -> Array:
    """Those of circular whirl, whose motions are the columns of `circles` (n_dof, n)."""
    inertia = (circles.conj().T @ (free.mass - 1j * free.gyroscopic) @ circles).real
    own = (circles.conj().T @ stiffness @ circles).real
    per_squared = scipy.linalg.eigh(inertia, own, eigvals_only=True)  # 1/Ω²
    return np.sort(1 / np.sqrt(per_squared[per_squared > 0]))

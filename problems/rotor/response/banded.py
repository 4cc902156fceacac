"""The dynamic stiffness of a rotor as a banded system, solved at each speed by LAPACK's gbsv.

A shaft is a chain of elements: a node meets its two neighbours and nothing else, so that the work grows with the number
of nodes and not with its third power. Column j of a matrix A is stored as row j, A[i, j] at DIAGONAL + i − j.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import zgbsv, zgbtrf, zgbtrs

from ksmea.arrays import Array, ComplexArray
from problems.rotor.finite_elements.assembly import Matrices
from problems.rotor.finite_elements.mesh import DOF_PER_NODE

Array32 = NDArray[np.int32]

HALF_BANDWIDTH = 2 * DOF_PER_NODE - 1
DIAGONAL = 2 * HALF_BANDWIDTH  # behind as many places again, which the pivoting of gbsv fills
WIDTH = DIAGONAL + HALF_BANDWIDTH + 1
BLOCK = 2**18  # n_speed n_dof whose bands are in memory at once, 92 MB


def blocks(n_speed: int, n_dof: int) -> Iterator[slice]:
    """Parts of the speeds, one after the other, that keep memory small; whole for all but large models.

    >>> list(blocks(1000, 1000))
    [slice(0, 262, None), slice(262, 524, None), slice(524, 786, None), slice(786, 1000, None)]
    """
    size = max(1, BLOCK // n_dof)
    for first in range(0, max(n_speed, 1), size):
        yield slice(first, min(first + size, n_speed))


def band_of(matrix: Array) -> Array:
    """Real matrices (…, n_dof, n_dof) as their bands (…, n_dof, WIDTH)."""
    n = matrix.shape[-1]
    band = np.zeros((*matrix.shape[:-1], WIDTH))
    for offset in range(-HALF_BANDWIDTH, HALF_BANDWIDTH + 1):  # row − column
        columns = slice(max(0, -offset), n - max(0, offset))
        band[..., columns, DIAGONAL + offset] = np.diagonal(matrix, -offset, -2, -1)
    return band


def dynamic_stiffness_band(matrices: Matrices, speed: Array, harmonic: float = 1.0) -> ComplexArray:
    """Dynamic stiffness D = K + ΩN + iω(C + ΩG) − ω²M at ω = hΩ, (n_speed, n_dof, WIDTH) N/m.

    h is the harmonic, at each speed of rotation Ω (rad/s).
    """
    spin = np.asarray(speed)
    omega = harmonic * spin
    powers = np.stack([np.ones_like(omega), spin, -(omega**2), omega, omega * spin], axis=1)
    parts = np.zeros((powers.shape[1], len(matrices.mass), WIDTH, 2))  # real and imaginary, as complex numbers lie
    parts[:3, ..., 0] = band_of(np.stack([matrices.stiffness, matrices.circulatory, matrices.mass]))
    parts[3:, ..., 1] = band_of(np.stack([matrices.damping, matrices.gyroscopic]))
    band = np.empty((len(omega), *parts.shape[1:3]), dtype=complex)
    np.matmul(powers, parts.reshape(len(parts), -1), out=band.view(float).reshape(len(band), -1))
    if (hysteresis := matrices.hysteresis(harmonic)) is not None:
        band.real += band_of(hysteresis[0])
        band.imag += band_of(hysteresis[1])
    return band


def side_by_side(forces: Sequence[Array | ComplexArray], n_speed: int) -> ComplexArray:
    """Forces ([n_speed,] n_dof, n) as one new array (n_speed, n_dof, n_force), each force contiguous."""
    ends = np.cumsum([0, *(each.shape[-1] for each in forces)])
    rows = np.empty((n_speed, ends[-1], forces[0].shape[-2]), dtype=complex)
    for each, first, last in zip(forces, ends, ends[1:]):
        rows[:, first:last] = np.swapaxes(each, -1, -2)
    return np.swapaxes(rows, 1, 2)


def solve(band: ComplexArray, force: ComplexArray) -> ComplexArray:
    """D⁻¹ f at each speed, (n_speed, n_dof, n_force).

    `band` is used up, and so is `force` if `side_by_side` made it. `LinAlgError` if D is singular.
    """
    motion = np.ascontiguousarray(np.swapaxes(force, 1, 2), dtype=complex)  # each force in a row, which gbsv overwrites
    for columns, rows in zip(band, motion, strict=True):
        *_, info = zgbsv(HALF_BANDWIDTH, HALF_BANDWIDTH, columns.T, rows.T, overwrite_ab=True, overwrite_b=True)
        if info:
            raise np.linalg.LinAlgError("dynamic stiffness: expected a regular matrix, got a singular one")
    return np.swapaxes(motion, 1, 2)


def factorised(band: ComplexArray) -> tuple[ComplexArray, Array32]:
    """LU factors of D at each speed, as bands (n_speed, n_dof, WIDTH), and their pivots (n_speed, n_dof).

    `band` is used up. Raises `LinAlgError` if D is singular.
    """
    pivots = np.empty(band.shape[:2], dtype=np.int32)
    for columns, own in zip(band, pivots, strict=True):
        factors, own[:], info = zgbtrf(columns.T, HALF_BANDWIDTH, HALF_BANDWIDTH, overwrite_ab=True)
        if info:
            raise np.linalg.LinAlgError("dynamic stiffness: expected a regular matrix, got a singular one")
        columns[:] = factors.T
    return band, pivots


def solve_factorised(factors: ComplexArray, pivots: Array32, force: ComplexArray) -> ComplexArray:
    """D⁻¹ f at each speed, (n_speed, n_dof, n_force), to the bit as `solve` finds it."""
    motion = np.array(np.swapaxes(force, 1, 2), dtype=complex, order="C")
    for columns, own, rows in zip(factors, pivots, motion, strict=True):
        zgbtrs(columns.T, HALF_BANDWIDTH, HALF_BANDWIDTH, rows.T, own, overwrite_b=True)
    return np.swapaxes(motion, 1, 2)


def solve_both_ways(
    band: ComplexArray, force: ComplexArray, rows: Array | ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Solution D⁻¹ f at each speed, and rows times D⁻¹, by one factorisation.

    They are (n_speed, n_dof, n_force) and (n_speed, n_row, n_dof), of rows (n_row, n_dof) or (n_speed, n_row, n_dof);
    `band` is used up. Raises `LinAlgError` if D is singular.
    """
    motion = np.array(np.swapaxes(force, 1, 2), dtype=complex, order="C")
    seen = np.array(np.broadcast_to(rows, (len(band), *rows.shape[-2:])), dtype=complex, order="C")
    for columns, of_force, of_rows in zip(band, motion, seen, strict=True):
        factors, pivots, info = zgbtrf(columns.T, HALF_BANDWIDTH, HALF_BANDWIDTH, overwrite_ab=True)
        if info:
            raise np.linalg.LinAlgError("dynamic stiffness: expected a regular matrix, got a singular one")
        zgbtrs(factors, HALF_BANDWIDTH, HALF_BANDWIDTH, of_force.T, pivots, overwrite_b=True)
        zgbtrs(factors, HALF_BANDWIDTH, HALF_BANDWIDTH, of_rows.T, pivots, trans=1, overwrite_b=True)
    return np.swapaxes(motion, 1, 2), seen

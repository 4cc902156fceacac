"""Natural frequencies, damping and whirl from the damped eigenproblem; undamped critical speeds.

A natural mode is Re(q e^{λt}), λ = σ + iω_d; the shaft turns from +x to +y, and forward whirl turns with it.

On undamped bearings of one stiffness in x and y critical speeds are a direct eigenproblem in the speed. Shaft and disks are round,
so that a motion at the spin frequency is a forward or a backward circular whirl: with u the deflections in x and their slopes,
y = ∓i x and M − i n G taken to them,

    K u = Ω² (M ∓ G′) u,

whose solutions with Ω² > 0 are the critical speeds, all at once. A thin disk can make M − G′ indefinite: it has no forward one then
(M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010, section 6.3).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.rotordynamics.whirl import Campbell, Mode, direction_of_whirl
from problems.rotor.finite_elements.assembly import Matrices, assemble, assemble_free, node_dof
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE

OVERDAMPED = (
    1e-7  # |Im λ|/|λ| below which a root is real: rounding splits a double one into as much as √(1e-16) either side
)


def natural_modes(rotor: Rotor, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
    """The oscillating modes at a spin speed (rad/s) by rising frequency, the first `n_mode` or all.

    Shapes cover the shaft only.
    """
    matrices = assemble(rotor, speed)
    eigenvalues, vectors = eigenpairs(matrices, speed)
    oscillating = np.flatnonzero(eigenvalues.imag > OVERDAMPED * np.abs(eigenvalues))
    order = oscillating[np.argsort(eigenvalues[oscillating].imag)][:n_mode]
    n_dof = DOF_PER_NODE * len(rotor.node_positions)
    return tuple(mode_of(eigenvalues[index], vectors[:n_dof, index]) for index in order)


def eigenpairs(matrices: Matrices, speed: float) -> tuple[ComplexArray, ComplexArray]:
    """λ (n,) and shapes (2 n_dof, n) at a spin speed (rad/s).

    Housings without mass have infinite ones, which are left out.
    """
    if has_mass(matrices):
        eigenvalues, vectors = map(np.asarray, scipy.linalg.eig(state_matrix(matrices, speed)))
        return eigenvalues, vectors
    n_dof = len(matrices.mass)
    damping = matrices.damping + speed * matrices.gyroscopic
    stiffness = matrices.stiffness + speed * matrices.circulatory
    # Time in units of the frequency at which stiffness and mass weigh alike: rows of both are then of one size
    unit = np.sqrt(np.linalg.norm(stiffness) / np.linalg.norm(matrices.mass))
    none, one = np.zeros((n_dof, n_dof)), np.eye(n_dof)
    left = np.block([[none, one], [-stiffness / unit**2, -damping / unit]])
    right = scipy.linalg.block_diag(one, matrices.mass)
    (numerator, denominator), vectors = scipy.linalg.eig(left, right, homogeneous_eigvals=True)
    finite = np.abs(numerator) < INFINITE * np.abs(denominator)
    return np.asarray(unit * numerator[finite] / denominator[finite]), np.asarray(vectors[:, finite])


def has_mass(matrices: Matrices) -> bool:
    """Whether each degree of freedom has."""
    return bool(np.all(np.diag(matrices.mass) > 0))


def frequency_curves(matrices: Matrices) -> Callable[[Array], Array]:
    """Damped frequencies (n_speed, n_dof) as a function of spin speeds (n_speed,), rad/s.

    They rise at each speed. An overdamped pair counts as two at zero speed. Each column is a continuous function of speed, because the pairs
    never leave the count.
    """
    n_dof = len(matrices.mass)
    if not has_mass(matrices) or np.iscomplexobj(matrices.stiffness):

        def one_by_one(speed: Array) -> Array:
            found = [eigenpairs(matrices, float(spin))[0].imag for spin in speed]
            filled = [np.concatenate([np.zeros(n_dof), np.maximum(each, 0.0)]) for each in found]
            return np.array([np.sort(each)[-n_dof:] for each in filled])

        return one_by_one
    states = state_matrices(matrices)
    return lambda speed: np.sort(np.linalg.eigvals(states(speed)).imag, axis=1)[:, n_dof:]


def campbell_diagram(rotor: Rotor, speed: Array, n_mode: int) -> Campbell:
    """Natural frequencies and damping ratios of the first `n_mode` modes over spin speeds.

    Spin speeds are (n_speed,) rad/s.
    """
    frequency, damping_ratio = np.full((2, len(speed), n_mode), np.nan)
    for index, spin in enumerate(speed):
        eigenvalues, _ = eigenpairs(assemble(rotor, float(spin)), float(spin))
        oscillating = eigenvalues[eigenvalues.imag > OVERDAMPED * np.abs(eigenvalues)]
        lowest = oscillating[np.argsort(oscillating.imag)][:n_mode]
        frequency[index, : len(lowest)] = lowest.imag
        damping_ratio[index, : len(lowest)] = -lowest.real / np.abs(lowest)
    return Campbell(np.asarray(speed, dtype=float), frequency, damping_ratio)


def state_matrix(matrices: Matrices, speed: float) -> Array:
    """A of ż = A z with z = (q, q̇), (2 n_dof, 2 n_dof)."""
    state: Array = state_matrices(matrices)(np.array([speed]))[0]
    return state


def state_matrices(matrices: Matrices) -> Callable[[Array], Array]:
    """The state matrices (n_speed, 2 n_dof, 2 n_dof) as a function of spin speeds (n_speed,), rad/s."""
    n_dof = len(matrices.mass)
    steady, gyroscopic, circulatory = (
        -scipy.linalg.solve(matrices.mass, each, assume_a="pos")
        for each in (
            np.hstack([matrices.stiffness, matrices.damping]),
            matrices.gyroscopic,
            matrices.circulatory,
        )
    )

    def at_speeds(speed: Array) -> Array:
        state = np.zeros((len(speed), 2 * n_dof, 2 * n_dof), steady.dtype)
        state[:, :n_dof, n_dof:] = np.eye(n_dof)
        state[:, n_dof:] = steady
        state[:, n_dof:, :n_dof] += speed[:, None, None] * circulatory
        state[:, n_dof:, n_dof:] += speed[:, None, None] * gyroscopic
        return state

    return at_speeds


def mode_of(eigenvalue: complex, vector: ComplexArray) -> Mode:
    shape = vector.reshape(-1, DOF_PER_NODE)
    largest = np.unravel_index(np.argmax(np.abs(shape[:, :2])), (len(shape), 2))
    return Mode(
        frequency=float(eigenvalue.imag),
        damping_ratio=float(-eigenvalue.real / abs(eigenvalue)),
        whirl=direction_of_whirl(shape[:, 0], shape[:, 1]),
        shape=shape / shape[largest],
    )


INFINITE = 1e8  # times the unit of frequency: eigenvalues beyond are those of housings without mass
FORWARD = np.array([[1, 0], [-1j, 0], [0, 1j], [0, 1]])  # (x, y, φ_x, φ_y) of the deflection in x and its slope φ_y


def undamped_critical_speeds(rotor: Rotor, stiffness: float, free: Matrices | None = None) -> tuple[Array, Array]:
    """Forward and backward critical speeds (rad/s), each rising, with equal bearing stiffness (N/m).

    It is at every bearing's place; `free` are the matrices without bearings if they are known.
    """
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
    """Critical speeds of circular whirl, with motions in the columns of `circles` (n_dof, n)."""
    inertia = (circles.conj().T @ (free.mass - 1j * free.gyroscopic) @ circles).real
    own = (circles.conj().T @ stiffness @ circles).real
    per_squared = scipy.linalg.eigh(inertia, own, eigvals_only=True)  # 1/Ω²
    return np.sort(1 / np.sqrt(per_squared[per_squared > 0]))

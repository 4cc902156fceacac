"""Natural frequencies, damping and whirl of a rotor on its bearings, from the damped eigenproblem.

A free motion is Re(q e^{λt}), λ = σ + iω_d; the shaft turns from +x to +y, and forward whirl turns with it.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ksmea.arrays import Array, ComplexArray
from ksmea.modes import Campbell, Mode
from ksmea.whirl import direction_of_whirl
from problems.rotor.assembly import Matrices, assemble
from problems.rotor.data import Rotor
from problems.rotor.mesh import DOF_PER_NODE

OVERDAMPED = (
    1e-7  # |Im λ|/|λ| below which a root is real: rounding splits a double one into as much as √(1e-16) either side
)


def natural_modes(rotor: Rotor, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
    """The oscillating modes at a spin speed (rad/s) by rising frequency, the first `n_mode` or all."""
    matrices = assemble(rotor)
    eigenvalues, vectors = map(np.asarray, scipy.linalg.eig(state_matrix(matrices, speed)))
    oscillating = np.flatnonzero(eigenvalues.imag > OVERDAMPED * np.abs(eigenvalues))
    order = oscillating[np.argsort(eigenvalues[oscillating].imag)][:n_mode]
    n_dof = len(matrices.mass)
    return tuple(_mode(eigenvalues[index], vectors[:n_dof, index]) for index in order)


def natural_frequencies(matrices: Matrices, speed: float) -> Array:
    """Damped frequencies at a spin speed, (n_dof,) rad/s, rising; an overdamped pair counts as two at zero speed.

    Each entry is a continuous function of speed, because the pairs never leave the count.
    """
    eigenvalues = scipy.linalg.eigvals(state_matrix(matrices, speed))
    return np.sort(eigenvalues.imag)[len(matrices.mass) :]


def campbell_diagram(rotor: Rotor, speed: Array, n_mode: int) -> Campbell:
    """Natural frequencies and damping ratios of the first `n_mode` modes over spin speeds (n_speed,) rad/s."""
    matrices = assemble(rotor)
    frequency, damping_ratio = np.full((2, len(speed), n_mode), np.nan)
    for index, spin in enumerate(speed):
        eigenvalues: ComplexArray = np.asarray(scipy.linalg.eigvals(state_matrix(matrices, float(spin))), dtype=complex)
        oscillating = eigenvalues[eigenvalues.imag > OVERDAMPED * np.abs(eigenvalues)]
        lowest = oscillating[np.argsort(oscillating.imag)][:n_mode]
        frequency[index, : len(lowest)] = lowest.imag
        damping_ratio[index, : len(lowest)] = -lowest.real / np.abs(lowest)
    return Campbell(np.asarray(speed, dtype=float), frequency, damping_ratio)


def state_matrix(matrices: Matrices, speed: float) -> Array:
    """A of ż = A z with z = (q, q̇), (2 n_dof, 2 n_dof)."""
    n_dof = len(matrices.mass)
    damping = matrices.damping + speed * matrices.gyroscopic
    stiffness = matrices.stiffness + speed * matrices.circulatory
    accelerations = -scipy.linalg.solve(matrices.mass, np.hstack([stiffness, damping]), assume_a="pos")
    return np.vstack([np.hstack([np.zeros((n_dof, n_dof)), np.eye(n_dof)]), accelerations])


def _mode(eigenvalue: complex, vector: ComplexArray) -> Mode:
    shape = vector.reshape(-1, DOF_PER_NODE)
    largest = np.unravel_index(np.argmax(np.abs(shape[:, :2])), (len(shape), 2))
    return Mode(
        frequency=float(eigenvalue.imag),
        damping_ratio=float(-eigenvalue.real / abs(eigenvalue)),
        whirl=direction_of_whirl(shape[:, 0], shape[:, 1]),
        shape=shape / shape[largest],
    )

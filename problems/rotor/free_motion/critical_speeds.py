"""Critical speeds of a rotor on its bearings: spin speeds that equal a damped natural frequency.

The Campbell diagram is scanned with the rotor's lowest modes, which costs a hundredth of scanning it with all degrees
of freedom, and each crossing found there is corrected with the whole rotor by Newton's method on its own eigenpair
(A. Ruhe, Algorithms for the nonlinear eigenvalue problem, SIAM J. Numer. Anal. 10 (1973) 674–689). If a correction
does not end near its start, the whole rotor is scanned.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from problems.rotor.finite_elements.assembly import Matrices, assemble
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.free_motion.free_motion import free_motion_of
from problems.rotor.free_motion.modes import frequency_curves, state_matrix

REACH = 4.0  # modes up to this many times the highest speed carry the scan: its errors stay far below its step
MIN_MODES = 12
NEAR = 0.02  # relative: a correction that ends further from its start has found another crossing
TOLERANCE = 1e-11  # relative, of eigenvalues and speeds


def critical_speeds(rotor: Rotor, highest: float, n_scan: int = 64) -> Array:
    """Rising speeds up to `highest` (rad/s) at which a damped natural frequency equals the spin speed.

    The Campbell diagram is scanned at `n_scan` speeds; a frequency that crosses twice between two scanned speeds is
    missed, so raise `n_scan` if two criticals of one curve lie close.
    """
    scanned = np.linspace(0.0, highest, n_scan + 1)[1:]
    if any(bearing.table is not None or bearing.pedestal is not None for bearing in rotor.supported):
        return _with_changing_bearings(rotor, scanned)
    whole = assemble(rotor)
    low, basis = _lowest_modes(whole, REACH * highest)
    found = [_corrected(whole, low, basis, start) for start in _crossings(frequency_curves(low), scanned)]
    corrected = np.sort(np.array([speed for speed in found if speed is not None]))
    if len(corrected) < len(found) or np.any(np.diff(corrected) <= 1e-9 * highest):
        return _crossings(frequency_curves(whole), scanned)
    return corrected


def _with_changing_bearings(rotor: Rotor, scanned: Array) -> Array:
    """Critical speeds of a rotor whose bearings change with speed or stand on pedestals.

    Scanned in the space of its lowest modes, each crossing corrected with the whole rotor at its own speed.
    """
    low = free_motion_of(rotor, float(scanned[-1]))
    found = _crossings(low.frequencies, scanned)

    def matrices_at(speed: float) -> Matrices:
        return assemble(rotor, speed)

    corrected = [_crossing(matrices_at, _pair_near(matrices_at(start), start), start) for start in found]
    both = zip(found, corrected)
    return np.sort([other if other and abs(other - start) <= NEAR * start else start for start, other in both])


def _pair_near(matrices: Matrices, speed: float) -> Eigenpair:
    """An eigenpair near λ = iΩ by inverse iteration."""
    damping = matrices.damping + speed * matrices.gyroscopic
    stiffness = matrices.stiffness + speed * matrices.circulatory
    dynamic = stiffness + 1j * speed * damping - speed**2 * matrices.mass
    vector = np.ones(len(dynamic)) + 1j * np.arange(len(dynamic)) / len(dynamic)
    for _ in range(3):
        vector = np.linalg.solve(dynamic, vector / np.linalg.norm(vector))
    return Eigenpair(1j * speed, vector / np.linalg.norm(vector))


def _crossings(frequencies: Callable[[Array], Array], scanned: Array) -> Array:
    """Rising spin speeds (rad/s) equal to a natural frequency.

    `frequencies` returns (n_speed, n) rad/s for speeds (n_speed,).
    """
    table = frequencies(scanned) - scanned[:, None]
    intervals, curves = np.nonzero(np.sign(table[:-1]) * np.sign(table[1:]) < 0)
    crossings = []
    for interval, curve in zip(intervals, curves):

        def excess(speed: float, curve: int = int(curve)) -> float:
            return float(frequencies(np.array([speed]))[0, curve] - speed)

        low, high = float(scanned[interval]), float(scanned[interval + 1])
        crossings.append(scipy.optimize.brentq(excess, low, high, rtol=1e-10))
    return np.sort(np.array(crossings))


def _lowest_modes(matrices: Matrices, highest: float) -> tuple[Matrices, Array]:
    """Rotor in the space of its lowest undamped modes and of deflections under damper forces.

    The modes go up to a frequency (rad/s); the basis of that space is (n_dof, n_low).
    """
    symmetric = (matrices.stiffness + matrices.stiffness.T) / 2
    squared, shapes = scipy.linalg.eigh(symmetric, matrices.mass)
    n_mode = max(MIN_MODES, int(np.count_nonzero(squared <= highest**2)))
    basis = shapes[:, :n_mode]
    damped = np.flatnonzero(np.any(matrices.damping != 0, axis=0))
    if 0 < len(damped) < len(symmetric) / 2 and squared[0] > 1e-9 * squared[-1]:
        deflections = np.linalg.solve(symmetric, np.eye(len(symmetric))[:, damped])
        basis = np.hstack([basis, deflections * np.linalg.norm(basis[:, 0]) / np.linalg.norm(deflections, axis=0)])
    directions, sizes, _ = np.linalg.svd(basis / np.linalg.norm(basis, axis=0), full_matrices=False)
    basis = directions[:, sizes > 1e-9 * sizes[0]]
    return matrices.on(basis), basis


def _corrected(whole: Matrices, low: Matrices, basis: Array, start: float) -> float | None:
    """Crossing of the whole rotor next to a crossing of its lowest modes; None if none is nearby."""
    eigenvalues, vectors = scipy.linalg.eig(state_matrix(low, start))
    nearest = int(np.argmin(np.abs(eigenvalues.imag - start)))
    pair = Eigenpair(complex(eigenvalues[nearest]), basis @ vectors[: len(low.mass), nearest])
    found = _crossing(lambda _: whole, pair, start)
    return found if found is not None and abs(found - start) <= NEAR * start else None


@dataclass(frozen=True, eq=False)
class Eigenpair:
    """λ (rad/s) and its deflections (n_dof,)."""

    value: complex
    vector: ComplexArray


def _crossing(matrices_at: Callable[[float], Matrices], pair: Eigenpair | None, speed: float) -> float | None:
    """The speed at which Im λ of one eigenpair equals it, by secants; None if they do not converge."""
    before: tuple[float, float] | None = None  # speed and excess
    for _ in range(20):
        pair = _eigenpair(matrices_at(speed), speed, pair) if pair is not None else None
        if pair is None:
            return None
        excess = pair.value.imag - speed
        if abs(excess) <= TOLERANCE * speed:
            return speed
        slope = -1.0 if before is None or before[0] == speed else (excess - before[1]) / (speed - before[0])
        before = speed, excess
        if slope == 0.0:
            return None
        speed -= excess / slope
    return None


def _eigenpair(matrices: Matrices, speed: float, start: Eigenpair) -> Eigenpair | None:
    """Solution of (λ² M + λ D + K) q = 0 nearest to a start, by Newton's method.

    q is scaled to sᴴ q = 1, s the start.
    """
    damping = matrices.damping + speed * matrices.gyroscopic
    stiffness = matrices.stiffness + speed * matrices.circulatory
    scale = 1 / np.linalg.norm(stiffness, 1)
    n = len(stiffness)
    row = start.vector.conj() / np.vdot(start.vector, start.vector)
    value, vector = start.value, start.vector
    bordered = np.zeros((n + 1, n + 1), dtype=complex)
    for _ in range(15):
        dynamic = scale * (value**2 * matrices.mass + value * damping + stiffness)
        derivative = scale * (2 * value * matrices.mass + damping) @ vector
        size = np.linalg.norm(derivative) or 1.0
        bordered[:n, :n], bordered[:n, n], bordered[n, :n] = dynamic, derivative / size, row
        try:
            step = np.linalg.solve(bordered, np.append(-dynamic @ vector, 0.0))
        except np.linalg.LinAlgError:
            return None
        vector = vector + step[:n]
        value += step[n] / size
        if abs(step[n] / size) <= TOLERANCE * abs(value):
            return Eigenpair(value, vector)
    return None

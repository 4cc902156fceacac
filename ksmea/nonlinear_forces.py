"""Forces that depend on the motion of their site otherwise than linearly: their part that turns with the shaft (1X).

Under Re(q e^{iφ}), φ = Ωt, the site has the orbit r(φ) and a force F(r) on it the part at the frequency of rotation

    f = (1/π) ∫ F(r(φ)) e^{−iφ} dφ    over one turn.

What such a force does at other frequencies, and that back at this one, is left out (harmonic balance with one harmonic: T. Detroux,
L. Renson, L. Masset and G. Kerschen, Comput. Methods Appl. Mech. Eng. 296 (2015) 18–38, doi 10.1016/j.cma.2015.07.017).
The shaft turns from x to y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray

QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # x to y
OF_CONJUGATE = (
    np.array([[1, -1j], [-1j, -1]]) / 2
)  # the conjugate forward part of a motion, as a vector that turns forward
N_ANGLE = 64  # of half a turn; the other half has the same force with its sign changed
TWICE = np.exp(2j * np.pi * (np.arange(N_ANGLE) + 0.5) / N_ANGLE)  # e^{2iφ} at these


@dataclass(frozen=True)
class ForceOnOrbit:
    """A force (…, 2) N on a motion q and its derivatives (…, 2, 2) N/m with respect to q and to its conjugate."""

    force: ComplexArray
    by_motion: ComplexArray
    by_conjugate: ComplexArray

    def where(self, chosen: NDArray[np.bool_], other: ForceOnOrbit) -> ForceOnOrbit:
        """This one where `chosen` (…,) is true, the other elsewhere."""
        matrix = chosen[..., None, None]
        return ForceOnOrbit(
            np.where(chosen[..., None], self.force, other.force),
            np.where(matrix, self.by_motion, other.by_motion),
            np.where(matrix, self.by_conjugate, other.by_conjugate),
        )


ForceOfMotion = Callable[[Array, ComplexArray], ForceOnOrbit]  # coefficients (n, n_coefficient), q (n, n_speed, 2)


def rotating_asymmetry(coefficients: Array, motion: ComplexArray) -> ForceOnOrbit:
    """A stiffness that is larger by Δ along one axis of the shaft, which turns with it, and smaller by Δ across it: with that
    axis at an angle α and κ = Δ e^{2iα}, f = −κ conj(q_f) (1, −i), where q_f = (q_x + i q_y)/2 turns forward; backward
    whirl it answers at three times the frequency. Coefficients: real and imaginary part of κ, N/m.

    Genta, Dynamics of Rotating Systems, 2005, ch. 5."""
    kappa = (coefficients[:, 0] + 1j * coefficients[:, 1])[:, None, None, None]
    by_conjugate = -kappa * np.broadcast_to(OF_CONJUGATE, (*motion.shape, 2))
    return ForceOnOrbit(_times(by_conjugate, np.conj(motion)), np.zeros_like(by_conjugate), by_conjugate)


def cubic_spring(coefficients: Array, motion: ComplexArray) -> ForceOnOrbit:
    """F = −k₃ |r|² r, alike in all directions: f = −k₃ (½ |q|² q + ¼ (q·q) conj(q)). Coefficient: k₃, N/m³.

    On a circle |r| = a it is k₃ a² times the motion; along a line of that amplitude three quarters of it, as Duffing's:

    >>> f = cubic_spring(np.array([[1.0]]), np.array([[[1, -1j], [1, 0]]])).force
    >>> np.abs(f).tolist()
    [[[1.0, 1.0], [0.75, 0.0]]]
    """
    size = coefficients[:, :1, None]
    conjugate = np.conj(motion)
    squared = np.sum(np.abs(motion) ** 2, axis=-1, keepdims=True)
    product = np.sum(motion**2, axis=-1, keepdims=True)
    force = -size * (squared * motion / 2 + product * conjugate / 4)
    unit = np.eye(motion.shape[-1])
    by_motion = (squared[..., None] * unit + _outer(motion, conjugate) + _outer(conjugate, motion)) / 2
    by_conjugate = _outer(motion, motion) / 2 + product[..., None] * unit / 4
    return ForceOnOrbit(force, -size[..., None] * by_motion, -size[..., None] * by_conjugate)


def spring_above_an_amplitude(coefficients: Array, motion: ComplexArray) -> ForceOnOrbit:
    """F = −k (1 − δ/|r|) r where the orbit lies outside of |r| = δ, and none inside: a stop all around the shaft with a
    clearance. Coefficients: k N/m, δ m."""
    return rub(np.pad(coefficients, [(0, 0), (0, 1)]), motion)


def rub(coefficients: Array, motion: ComplexArray) -> ForceOnOrbit:
    """The same stop with friction μ against the turning shaft: F = −k (1 − δ/|r|) (r + μ J r), J a quarter turn from x to y.
    Coefficients: k N/m, δ m, μ.

    With b(φ) = 1 − δ/|r| where the orbit lies outside of δ, and b_m the mean of b e^{−imφ} over a turn, f without friction is
    −k (b₀ q + b₂ conj(q)). Its derivatives have the like means of ∂b/∂|r| / |r| beside it."""
    stiffness, clearance, friction = (each[:, None, None] for each in coefficients.T)
    conjugate = np.conj(motion)
    squared = np.sum(np.abs(motion) ** 2, axis=-1, keepdims=True)
    product = np.sum(motion**2, axis=-1, keepdims=True)
    radius = np.sqrt(
        np.maximum(squared / 2 + (product * TWICE).real / 2, np.finfo(float).tiny)
    )  # (n, n_speed, n_angle)
    ratio = np.minimum(clearance / radius, 1.0)
    (b0, b2, _), (s0, s2, s4) = (_means(each) for each in (1 - ratio, np.where(ratio < 1, ratio / radius**2, 0.0)))
    forward, mixed = _outer(motion, motion), _outer(motion, conjugate) + _outer(conjugate, motion)
    unit = np.eye(motion.shape[-1])
    by_motion = b0 * unit + (forward * np.conj(s2) + mixed * s0 + np.conj(forward) * s2) / 4
    by_conjugate = b2 * unit + (forward * s0 + mixed * s2 + np.conj(forward) * s4) / 4
    turned = -stiffness[..., None] * (np.eye(2) + friction[..., None] * QUARTER_TURN)
    force = b0[..., 0] * motion + b2[..., 0] * conjugate
    return ForceOnOrbit(_times(turned, force), turned @ by_motion, turned @ by_conjugate)


def _means(over_angle: Array) -> ComplexArray:
    """Means of values (…, n_angle) times e^{−imφ} for m = 0, 2 and 4, (3, …, 1, 1)."""
    means = over_angle @ np.conj(TWICE[:, None]) ** np.arange(3) / N_ANGLE
    return np.asarray(np.moveaxis(means, -1, 0)[..., None, None])


def _times(matrix: Array | ComplexArray, vector: Array | ComplexArray) -> ComplexArray:
    return np.asarray((matrix @ vector[..., None])[..., 0])


def _outer(column: ComplexArray | Array, row: ComplexArray | Array) -> ComplexArray:
    return np.asarray(column[..., :, None] * row[..., None, :])

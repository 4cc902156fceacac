"""Nonlinear forces on a site of the shaft as functions of its motion, at every angle of the orbit.

A law is a function of coefficients (n, n_coefficient), an orbit r (n, n_angle, 2), m, and e^{iφ} (n_angle,), φ = Ωt
the angle of the shaft, which turns from x to y. It gives the force (n, n_angle, 2), N, and its derivatives by r
(n, n_angle, 2, 2), N/m. If a force has a corner, as at the onset of contact, `rounding` replaces it by a parabola whose
width is this fraction of the clearance; searches for a solution first follow the rounded force. The harmonics of a
force are the subject of `ksmea.nonlinear.harmonic_balance`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray

OrbitForce = Callable[[Array, Array, ComplexArray, float], tuple[Array, Array]]


def rotating_asymmetry(coefficients: Array, orbit: Array, turn: ComplexArray, rounding: float) -> tuple[Array, Array]:
    """Stiffness that is larger by Δ along one axis of the shaft, which turns with it, and smaller across.

    With that axis at an angle α, κ = Δ e^{2iα} and r = x + iy, F = −κ e^{2iφ} conj(r). It answers forward whirl at its
    own frequency, backward whirl at three times that. Coefficients: real and imaginary part of κ, N/m.

    Genta, Dynamics of Rotating Systems, 2005, ch. 5.
    """
    turned = (coefficients @ [1, 1j])[:, None] * turn**2
    rows = np.stack([turned.real, turned.imag, turned.imag, -turned.real], axis=-1)
    derivative = -rows.reshape(*rows.shape[:-1], 2, 2)
    return _times(derivative, orbit), derivative


def cubic_spring(coefficients: Array, orbit: Array, turn: ComplexArray, rounding: float) -> tuple[Array, Array]:
    """F = −k₃ |r|² r, alike in all directions. Coefficient: k₃, N/m³."""
    size = -coefficients[:, :1, None]
    squared = np.sum(orbit**2, axis=-1, keepdims=True)
    derivative = size[..., None] * (squared[..., None] * np.eye(2) + 2 * orbit[..., :, None] * orbit[..., None, :])
    return size * squared * orbit, derivative


def spring_above_an_amplitude(
    coefficients: Array, orbit: Array, turn: ComplexArray, rounding: float
) -> tuple[Array, Array]:
    """F = −k (1 − δ/|r|) r where the orbit lies outside of |r| = δ, and none inside.

    A stop all around the shaft with a clearance. Coefficients: k N/m, δ m.
    """
    return rub(np.pad(coefficients, [(0, 0), (0, 1)]), orbit, turn, rounding)


def rub(coefficients: Array, orbit: Array, turn: ComplexArray, rounding: float) -> tuple[Array, Array]:
    """Stop with friction μ against the turning shaft: F = −k (1 − δ/|r|) (r + μ J r) outside |r| = δ.

    J is a quarter turn from x to y: the surface of the shaft slides in the direction of its rotation, whatever its
    whirl. Coefficients: k N/m, δ m, μ.

    J. Jiang and H. Ulbrich, Nonlinear Dyn. 24 (2001) 269–283; A. Muszynska, Rotordynamics, 2005, ch. 5."""
    stiffness, clearance, friction = (each[:, None] for each in coefficients.T)
    moved = orbit[..., 0] + 1j * orbit[..., 1]  # a quarter turn from x to y multiplies it by i
    radius = np.maximum(np.abs(moved), np.finfo(float).tiny)
    depth, width = radius - clearance, np.maximum(rounding * clearance, np.finfo(float).tiny)
    slope = np.clip(np.clip(depth, -width, width) / width + 0.5, 0.0, 1.0)
    across = np.where(depth > width / 2, depth, width * slope**2 / 2) / radius  # what is pressed in, over the radius
    outwards, pushing = moved / radius, -stiffness * (1 + 1j * friction)
    turned = (slope - across) * outwards
    derivative = np.empty((*orbit.shape, 2))
    for column, (by, straight) in enumerate(((outwards.real, 1), (outwards.imag, 1j))):
        changed = pushing * (straight * across + by * turned)
        derivative[..., 0, column], derivative[..., 1, column] = changed.real, changed.imag
    return (pushing * across * moved)[..., None].view(float), derivative


def on_sites(forces: Sequence[OrbitForce], n_coefficient: Sequence[int]) -> OrbitForce:
    """Forces on several sites, each with its own coefficients, as one force on the orbits of all.

    The orbits are (n, n_angle, 2 n_site).
    """
    columns = np.split(np.arange(sum(n_coefficient)), np.cumsum(n_coefficient)[:-1])

    def force(coefficients: Array, orbit: Array, turn: ComplexArray, rounding: float) -> tuple[Array, Array]:
        acting = np.empty_like(orbit)
        derivative = np.zeros((*orbit.shape, orbit.shape[-1]))
        for index, (one, own) in enumerate(zip(forces, columns, strict=True)):
            at = slice(2 * index, 2 * index + 2)
            acting[..., at], derivative[..., at, at] = one(coefficients[:, own], orbit[..., at], turn, rounding)
        return acting, derivative

    return force


def _times(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])

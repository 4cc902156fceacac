"""Poles of the synchronous response of a rotor on any bearings, from its poles on nominal bearings.

The synchronous dynamic stiffness D(Ω) = K + ΩN + iΩ(C + ΩG) − Ω² M is singular at complex speeds Ω_r = ω_r + iδ_r. On nominal
bearings D₀⁻¹ = Σ x_k l_kᵀ / (Ω − Ω_k), which is computed once per rotor. Bearings change it at their ports alone, D = D₀ + Pᵀ ΔZ P,
so that with H = P D₀⁻¹ Pᵀ the poles on them are the roots of a small matrix N = I + H ΔZ,

    N y = 0,   wᵀ N = 0,   D⁻¹ ≈ −D₀⁻¹ Pᵀ ΔZ y wᵀ P D₀⁻¹ / (wᵀ N′ y (Ω − Ω_r))   near Ω_r

(the formula of Woodbury). They are found in two steps. The nominal poles within reach, with all others as a flexibility that does
not depend on the speed, and ΔZ as a straight line, make a small eigenproblem. Newton's method with right and left vectors leads
from there to the roots, each step cubing the error (P. Lancaster, Numer. Math. 4 (1962) 199–208).

Sets of unknowns that have the same bearings share their poles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.assembly import Matrices
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import force_per_unbalance
from problems.rotor.free_motion.stability import low_modes, nominal_springs
from problems.rotor.response.dense import channel_rows
from problems.rotor.response.links import NOMINAL_PHASE

N_MODE = 40  # of the rotor on nominal springs, and its deflections under forces at its ports: frequencies within 1e-7
N_NEWTON = 3  # steps from the small eigenproblem to the poles: its errors of 1e-2 become rounding
CENTRE = 0.25  # of the reach, at which the small eigenproblem is exact: in the middle of the measured speeds
OFF_POLE = 1e-13  # relative distance from an exact root at which N is inverted


@dataclass(frozen=True, eq=False)
class Poles:
    """Poles of the synchronous response of n parameter sets."""

    speed: ComplexArray  # (n, n_pole) Ω_r, rad/s
    haste: (
        Array  # (n, n_pole) 1 − dω_r/dΩ at a fixed frequency: by how much faster or slower a mode sees the speed change
    )
    residue: ComplexArray  # (n, n_pole, n_channel) R_r, m rad/s


@dataclass(frozen=True, eq=False)
class Spectrum:
    """D₀⁻¹ as a sum over its K poles, seen from p ports and read by channels.

    Columns of `basis` (n_dof, m) are what modes are made of.
    """

    speed: ComplexArray  # (K,) Ω_k, rad/s
    shapes: ComplexArray  # (m, K) x_k
    left: ComplexArray  # (K, m) l_k
    ports: Array  # (p, m)
    nominal: ComplexArray  # (p,) impedances, N/m
    gyroscopic: Array  # (m, m) G, by which D changes with the spin alone: ∂D/∂Ω = iω G at a fixed frequency ω
    basis: Array
    rows: Array  # (n_channel, n_dof) that read the motion

    @cached_property
    def read(self) -> ComplexArray:  # (n_channel, K)
        return self.rows @ self.basis @ self.shapes

    @cached_property
    def at_ports(self) -> ComplexArray:  # (p, K)
        return self.ports @ self.shapes

    @cached_property
    def from_ports(self) -> ComplexArray:  # (K, p)
        return self.left @ self.ports.T

    @cached_property
    def outer(self) -> ComplexArray:  # (K, p p)
        return np.einsum("ak,kb->kab", self.at_ports, self.from_ports).reshape(len(self.speed), -1)

    @cached_property
    def spin(self) -> ComplexArray:  # (K, K)
        return self.left @ self.gyroscopic @ self.shapes


def spectrum_of(matrices: Matrices, ports: Array, nominal: ComplexArray, basis: Array, rows: Array) -> Spectrum:
    """The spectrum of matrices (m, m) with nominal impedances (p,) N/m at ports (p, m)."""
    m = len(matrices.mass)
    stiffness = matrices.stiffness + ports.T @ (nominal[:, None] * ports)
    of_speed = matrices.circulatory + 1j * matrices.damping
    of_square = 1j * matrices.gyroscopic - matrices.mass
    lower = -np.linalg.solve(of_square, np.hstack([stiffness, of_speed]))
    speed, vectors = np.linalg.eig(np.vstack([np.hstack([np.zeros((m, m)), np.eye(m)]), lower]))
    left = np.linalg.inv(vectors)[:, m:] @ np.linalg.inv(of_square)
    return Spectrum(speed, vectors[:m], left, ports, nominal, matrices.gyroscopic, basis, rows)


@lru_cache(maxsize=64)
def spectrum(
    rotor: Rotor, highest: float, channels: tuple[Channel, ...], positions: tuple[float, ...] = ()
) -> Spectrum:
    """Spectrum of a rotor on nominal impedances: as large as its bearings', but well damped.

    Further ports lie at `positions` (m).
    """
    low = low_modes(rotor, highest, positions, N_MODE)
    nominal = np.concatenate([NOMINAL_PHASE * nominal_springs(rotor.supported), np.zeros(len(low.sites))])
    return spectrum_of(
        low.matrices, np.vstack([low.ports, low.sites]), nominal, low.basis, channel_rows(rotor, channels)
    )


def poles_on(spectrum: Spectrum, impedance: ComplexArray, force: ComplexArray, reach: float) -> Poles:
    """Poles with |Ω_r| up to about `reach` (rad/s), with other impedances at the ports.

    They replace the nominal ones.

    `impedance` (3, n, p, p) N/m and `force` (3, n, n_dof) N are coefficients of Ω⁰, Ω¹, Ω².
    """
    change = impedance.copy()
    change[0] -= np.diag(spectrum.nominal)
    flat = np.ascontiguousarray(np.moveaxis(change, 1, 0)).reshape(change.shape[1], -1)
    _, first, group = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    change = change[:, first]
    speed, right, left, slope = _roots(spectrum, change, *_guess(spectrum, change, reach))
    inverse = 1 / (speed[..., None] - spectrum.speed)  # (n, r, K)
    shape = -inverse * (
        _times(_at(change, speed), right) @ spectrum.from_ports.T
    )  # (n, r, K), as sums of nominal modes
    shape /= np.sum(left * _times(slope, right), axis=-1, keepdims=True)
    shape_left = inverse * (left @ spectrum.at_ports)  # (n, r, K)
    of_spin = 1j * speed * np.sum((shape_left @ spectrum.spin) * shape, axis=-1)
    modal = force @ spectrum.basis @ spectrum.left.T  # (3, n, K)
    size = sum(
        speed[group] ** power * np.sum(shape_left[group] * part[:, None], axis=-1) for power, part in enumerate(modal)
    )
    read = shape @ spectrum.read.T  # (n, r, n_channel)
    return Poles(speed[group], (1 - of_spin).real[group], size[..., None] * read[group])


@lru_cache(maxsize=64)
def unit_force(rotor: Rotor) -> ComplexArray:
    """Nodal forces per unit of unbalance at 1 rad/s, (n_dof, n_plane)."""
    return np.asarray(force_per_unbalance(rotor, np.ones(1))[0])


def block_diagonal(blocks: Sequence[ComplexArray]) -> ComplexArray:
    """Impedances (…, k, k) of groups of ports as one matrix of all, (…, p, p)."""
    ends = np.cumsum([block.shape[-1] for block in blocks])
    whole = np.zeros((*blocks[0].shape[:-2], ends[-1], ends[-1]), dtype=complex)
    for end, block in zip(ends, blocks):
        own = slice(end - block.shape[-1], end)
        whole[..., own, own] = block
    return whole


def _guess(spectrum: Spectrum, change: ComplexArray, reach: float) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Poles (n, r), and right and left null vectors (n, r, p) of N, by the small eigenproblem.

    With e the nominal modes within reach, s the forces at the ports, F the flexibility of the others and Z₀ + Z₁Ω for ΔZ,

        (Ω − Ω_k) e = L s,      s + (Z₀ + Z₁Ω) (X e + F s) = 0.
    """
    near, n = np.abs(spectrum.speed) < reach, change.shape[1]
    out, into, n_near = spectrum.at_ports[:, near], spectrum.from_ports[near], int(near.sum())
    centre = CENTRE * reach
    flexibility = (spectrum.at_ports[:, ~near] / (centre - spectrum.speed[~near])) @ spectrum.from_ports[~near]
    seen = np.hstack([out, flexibility])
    constant, of_speed = (
        change[0] - centre**2 * change[2],
        change[1] + 2 * centre * change[2],
    )  # the tangent at the centre
    p = len(out)
    fixed = np.zeros((n, n_near + p, n_near + p), dtype=complex)
    fixed[:, :n_near] = np.hstack([np.diag(centre - spectrum.speed[near]), -into])
    fixed[:, n_near:] = (constant + centre * of_speed) @ seen
    fixed[:, n_near:, n_near:] += np.eye(p)
    moving = np.zeros_like(fixed)
    moving[:, :n_near, :n_near] = np.eye(n_near)
    moving[:, n_near:] = of_speed @ seen
    inverse, vectors = np.linalg.eig(np.linalg.solve(fixed, moving))  # −1/(Ω − centre)
    order = np.argsort(-np.abs(inverse), axis=1)[:, :n_near]
    speed: ComplexArray = np.asarray(centre - 1 / np.take_along_axis(inverse, order, axis=1), dtype=complex)
    right = np.take_along_axis(vectors, order[:, None], axis=2)
    left = np.linalg.solve(fixed.swapaxes(1, 2), np.linalg.inv(vectors).swapaxes(1, 2))
    left = np.take_along_axis(left, order[:, None], axis=2)[:, n_near:]
    return speed, (seen @ right).swapaxes(1, 2).astype(complex), left.swapaxes(1, 2).astype(complex)


def _roots(
    spectrum: Spectrum, change: ComplexArray, speed: ComplexArray, right: ComplexArray, left: ComplexArray
) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
    """Roots and null vectors from approximate ones, and N′ (n, r, p, p)."""
    for _ in range(N_NEWTON):
        speed = speed * (1 + OFF_POLE)
        matrix, slope = _matrix_and_slope(spectrum, change, speed)
        right = _solved(matrix, _times(slope, right))
        left = _solved(matrix.swapaxes(2, 3), _times(slope.swapaxes(2, 3), left))
        speed = speed - np.sum(left * _times(matrix, right), axis=-1) / np.sum(left * _times(slope, right), axis=-1)
    return speed, right, left, slope


def _matrix_and_slope(
    spectrum: Spectrum, change: ComplexArray, speed: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """N and N′ at speeds (n, r), (n, r, p, p) each."""
    p = len(spectrum.ports)
    inverse = 1 / (speed[..., None] - spectrum.speed)
    receptance = (inverse @ spectrum.outer).reshape(*speed.shape, p, p)
    slope = -(inverse**2 @ spectrum.outer).reshape(*speed.shape, p, p)
    impedance = _at(change, speed)
    of_impedance = change[1][:, None] + 2 * speed[..., None, None] * change[2][:, None]
    matrix, of_matrix = np.eye(p) + receptance @ impedance, slope @ impedance + receptance @ of_impedance
    return matrix.astype(complex), of_matrix


def _at(coefficients: ComplexArray, speed: ComplexArray) -> ComplexArray:
    """Matrices with coefficients (3, n, p, p) of the powers of Ω at speeds (n, r), (n, r, p, p)."""
    omega = speed[..., None, None]
    return coefficients[0][:, None] + omega * (coefficients[1][:, None] + omega * coefficients[2][:, None])


def _times(matrices: ComplexArray, vectors: ComplexArray) -> ComplexArray:
    """Matrices (…, p, p) times vectors (…, p)."""
    return (matrices @ vectors[..., None])[..., 0]


def _solved(matrices: ComplexArray, vectors: ComplexArray) -> ComplexArray:
    """Solutions of these matrices (…, p, p) for right-hand sides (…, p), each scaled to length 1."""
    found: ComplexArray = np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0], dtype=complex)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)

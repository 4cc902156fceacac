"""The response of a rotor while its speed sweeps at a constant rate, as a tracking filter sees it.

With the shaft at the angle φ, φ̇ = Ω and Ω̇ = α, the motion is Re(q e^{iφ}). Near a critical speed the steady q is a sum over
modes, with a pole at the complex speed Ω_r = ω_r + iδ_r: where the synchronous dynamic stiffness D(Ω) = K + iΩ C − Ω² M + iΩ² G
is singular. A mode that is swept through has instead of R_r / (Ω − Ω_r)

    R_r i ∫₀^∞ exp(−i (Ω − Ω_r) s + i β s² / 2) ds = R_r i √π/(2a) w(−(Ω − Ω_r)/(2a)),   a² = −iβ/2,  Re a > 0,

where w is the Faddeeva function: for β > 0 it peaks late, and then beats between the unbalance and a free motion that decays
(F. M. Lewis, Trans. ASME 54 (1932) 253–261; the integral is 7.4.2 of Abramowitz & Stegun). What the modes make of it is
added to the steady response, which keeps all else. Of a rotor with constant coefficients this is exact, the tangential force
of the unbalance included: m e d²/dt² e^{iφ}, twice by parts, is that residue of Ω² D⁻¹.

Gyroscopic forces take the natural frequency along with the speed, which is as a faster sweep: β = α / (1 − dω_r/dΩ). What
else changes with the speed (the damping of a mode, its shape, the coefficients of its bearings) is taken as it is at the
critical speed. D and the forces are parabolas in Ω through three speeds: exact for bearings that follow straight lines.

The sweep has lasted so long that its start has died out. A mode that does not decay has no such response and is left as it
is. Poles are those of the rotor's lowest modes, whose frequencies are right within 1e-6 on the RK-4 and 1e-4 on the three-disk rotor: where damping ratios are as small, what
is left of a steady peak shows in the few rows that lie on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import wofz

from ksmea.arrays import Array, ComplexArray

REACH = 4.0  # poles up to this many times the highest speed: of those beyond a sweep changes 1e-7 of the peak
NODES = np.array([1.0, 2.0, 3.0]) / 3  # of the highest speed: where D and the forces are met


@dataclass(frozen=True, eq=False)
class Sweep:
    """Constant rates, and the highest speed that the modes must suit, whichever speeds are looked at."""

    acceleration: Array  # (n,) rad/s²
    highest: float  # rad/s

    @property
    def nodes(self) -> Array:
        """The three speeds (rad/s) at which stiffness and forces are to be given."""
        return NODES * self.highest


@dataclass(frozen=True, eq=False)
class Poles:
    """Poles of the synchronous response of n parameter sets."""

    speed: ComplexArray  # (n, n_pole) Ω_r, rad/s
    haste: Array  # (n, n_pole) β/α
    residue: ComplexArray  # (n, n_pole, n_channel) R_r, m rad/s


def parabola(values: ComplexArray, nodes: Array) -> ComplexArray:
    """Coefficients of Ω⁰, Ω¹, Ω² through values (…, 3) at three speeds (rad/s), (3, …)."""
    return np.moveaxis(values @ np.linalg.inv(np.vander(nodes, increasing=True)).T, -1, 0)


def synchronous_poles(stiffness: ComplexArray, force: ComplexArray, rows: Array, gyroscopic: Array) -> Poles:
    """Poles of rows D⁻¹ f from coefficients of the powers of Ω.

    `stiffness` (3, n, m, m), N/m and so on, `force` (3, n, m), N and so on; `rows` (n_channel, m) read the motion, and
    `gyroscopic` (m, m) is G, by which D changes with the spin alone: ∂D/∂Ω = iω G at a fixed frequency ω.
    """
    n, m = stiffness.shape[1:3]
    lower = -np.linalg.solve(stiffness[2], np.concatenate([stiffness[0], stiffness[1]], axis=2))
    upper = np.broadcast_to(np.hstack([np.zeros((m, m)), np.eye(m)]), (n, m, 2 * m))
    speed, vectors = np.linalg.eig(np.concatenate([upper, lower], axis=1))
    shapes = vectors[:, :m]  # (n, m, n_pole)
    left = np.linalg.solve(stiffness[2].swapaxes(1, 2), np.linalg.inv(vectors)[:, :, m:].swapaxes(1, 2))
    at_pole = sum(part[:, :, None] * speed[:, None] ** power for power, part in enumerate(force))
    residue = np.einsum("cm,nmp,nkp,nkp->npc", rows, shapes, left, at_pole, optimize=True)
    of_spin = 1j * speed * np.einsum("nmp,mk,nkp->np", left, gyroscopic, shapes, optimize=True)
    return Poles(speed, (1 - of_spin).real, residue)


def sweep_change(poles: Poles, speed: Array, sweep: Sweep) -> ComplexArray:
    """What n sweeps, at rates that are not 0, add to the steady response at speeds (n_speed,) rad/s, (n, n_speed, n_channel) m."""
    swept = (poles.speed.imag > 0) & (poles.haste > 0) & (np.abs(poles.speed) < REACH * sweep.highest)
    pole = poles.speed[swept][:, None]
    root = 2 * np.sqrt(-0.5j * (sweep.acceleration[:, None] * poles.haste)[swept])[:, None]
    argument = (pole - speed) / root
    # a rotor that starts from rest crosses no critical speed below zero: what would ring from there is left out
    side = np.where((pole.real > 0) | (argument.imag > 0), 1, -1)
    change = np.zeros((*poles.speed.shape, len(speed)), dtype=complex)
    change[swept] = 1j * np.sqrt(np.pi) / root * side * wofz(side * argument) - 1 / (speed - pole)
    return np.asarray(change.swapaxes(1, 2) @ poles.residue)

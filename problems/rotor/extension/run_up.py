"""The response of a rotor while its speed sweeps at a constant rate, as a tracking filter sees it.

With the shaft at the angle φ, φ̇ = Ω and Ω̇ = α, the motion is Re(q e^{iφ}). Near a critical speed the steady q is a
sum over modes, with a pole at the complex speed Ω_r = ω_r + iδ_r, at which the synchronous dynamic stiffness
D(Ω) = K + iΩ C − Ω² M + iΩ² G is singular. A mode that is swept through has instead of R_r / (Ω − Ω_r)

    R_r i ∫₀^∞ exp(−i (Ω − Ω_r) s + i β s² / 2) ds = R_r i √π/(2a) w(−(Ω − Ω_r)/(2a)),   a² = −iβ/2,  Re a > 0,

where w is the Faddeeva function: for β > 0 it peaks late, and then beats between the unbalance and a free motion that decays
(F. M. Lewis, Trans. ASME 54 (1932) 253–261; the integral is 7.4.2 of Abramowitz & Stegun). What the modes make of it is
added to the steady response, which keeps all else. Of a rotor with constant coefficients this is exact, the tangential force
of the unbalance included: m e d²/dt² e^{iφ}, twice by parts, is that residue of Ω² D⁻¹.

Gyroscopic forces take the natural frequency along with the speed, which is as a faster sweep: β = α / (1 − dω_r/dΩ). What
else changes with the speed (the damping of a mode, its shape, the coefficients of its bearings) is taken as it is at the
critical speed. D and the forces are parabolas in Ω through three speeds: exact for bearings that follow straight lines.

The sweep has lasted so long that its start has died out. A mode that does not decay has no such response and is left as it
is. How the poles are found: `problems/rotor/extension/synchronous_poles.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import wofz

from ksmea.arrays import Array, ComplexArray
from problems.rotor.extension.synchronous_poles import Poles

REACH = 2.5  # poles up to this many times the highest speed: of those beyond a sweep changes 1e-6 of the peak
NODES = np.array([1.0, 2.0, 3.0]) / 3  # of the highest speed: where D and the forces are met
FAR = 7.0  # |z| beyond which the series of w(z) takes over: its first five terms are right within 1e-8
# Of z⁻² in i√π z w(z) = −1 − …, from the highest power (7.1.23 of Abramowitz & Stegun)
SERIES = (945 / 32, 105 / 16, 15 / 8, 3 / 4, 1 / 2)


@dataclass(frozen=True, eq=False)
class Sweep:
    """Constant rates, and the highest speed that the modes must suit, whichever speeds are looked at."""

    acceleration: Array  # (n,) rad/s²
    highest: float  # rad/s

    @property
    def nodes(self) -> Array:
        """The three speeds (rad/s) at which stiffness and forces are to be given."""
        return NODES * self.highest

    @property
    def reach(self) -> float:
        """How far poles matter, rad/s."""
        return REACH * self.highest


def parabola(values: ComplexArray, nodes: Array) -> ComplexArray:
    """Coefficients (3, …) of Ω⁰, Ω¹, Ω² through values (3, …) at three speeds (rad/s)."""
    return np.tensordot(np.linalg.inv(np.vander(nodes, increasing=True)), values, axes=1)


def sweep_change(poles: Poles, speed: Array, sweep: Sweep) -> ComplexArray:
    """Change (n, n_speed, n_channel), m, of the steady response at `speed`, rad/s, by n sweeps, no rate 0."""
    swept = (poles.speed.imag > 0) & (poles.haste > 0) & (np.abs(poles.speed) < sweep.reach)
    pole = poles.speed[swept][:, None]
    root = 2 * np.sqrt(-0.5j * (sweep.acceleration[:, None] * poles.haste)[swept])[:, None]
    change = np.zeros((*poles.speed.shape, len(speed)), dtype=complex)
    change[swept] = _swept_less_steady((pole - speed) / root, pole) / root
    residue = np.where(swept[..., None], poles.residue, 0)
    return np.asarray(change.swapaxes(1, 2) @ residue)


def _swept_less_steady(argument: ComplexArray, pole: ComplexArray) -> ComplexArray:
    """Swept less steady-state response, i√π w(z) + 1/z.

    Behind the pole (Im z < 0) there is 2 exp(−z²) in w, which is the ringing. A rotor that starts from rest crosses no
    critical speed below zero, and nothing rings from there.
    """
    found = np.empty_like(argument)
    is_far = np.abs(argument) > FAR
    near, far = argument[~is_far], argument[is_far]
    above = np.where(near.imag > 0, 1, -1)
    found[~is_far] = 1j * np.sqrt(np.pi) * above * wofz(above * near) + 1 / near
    found[is_far] = -np.polyval((*SERIES, 0), far**-2.0) / far
    passed = (pole.real > 0) & (argument.imag < 0)
    found[passed] += 2j * np.sqrt(np.pi) * np.exp(-(argument[passed] ** 2))
    return found

"""What carries the bearings, in series with them: a spring with a loss factor and a mass in each axis, for each bearing or for all.

With z_b the bearing's impedance and a the support's dynamic compliance, the shaft feels z = (1 + z_b a)⁻¹ z_b, which at
a = 0 is that of a bearing on rigid ground. The compliance is a function of the frequency of the motion, whatever the spin
speed is: a = s / (1 + iη sgn ω − s ω² m), s the compliance of the spring. Bearings that stand on a common support feel each
other: it moves by v = a Σ z_b (q_b − v), so that bearing b pushes with z_b (q_b − v), v = (1 + a Σ z_b)⁻¹ a Σ z_b q_b.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from problems.rotor.finite_elements.data import inverse, product


@dataclass(frozen=True, eq=False)
class Support:
    """The supports of all bearings, which are alike, or the one that is common to them, for n parameter sets."""

    spring: Array  # (2 axes, n) m/N, compliance
    mass: Array  # (n,) kg
    loss_factor: float  # η of the springs
    is_common: bool = False

    def compliance(self, frequency: Array) -> ComplexArray:
        """Dynamic compliance (2 axes, n, n_frequency) m/N at frequencies (n_frequency,) rad/s."""
        spring, mass = self.spring[:, :, None], self.mass[:, None]
        loss = self.loss_factor * np.sign(frequency)
        return np.asarray(spring / (1 + 1j * loss - spring * mass * frequency**2))


def in_series(impedance: ComplexArray, compliance: ComplexArray) -> ComplexArray:
    """(1 + z a)⁻¹ z of 2 × 2 impedances (n_bearing, 2, 2, n, n_frequency) and compliances (2, n, n_frequency)."""
    (xx, xy), (yx, yy) = np.moveaxis(impedance, 0, 2)
    a_x, a_y = compliance[:, None]
    own_x, own_y = 1 + xx * a_x, 1 + yy * a_y
    determinant = own_x * own_y - xy * a_y * yx * a_x
    changed = np.empty_like(impedance)
    changed[:, 0, 0] = (own_y * xx - xy * a_y * yx) / determinant
    changed[:, 0, 1] = (own_y * xy - xy * a_y * yy) / determinant
    changed[:, 1, 0] = (own_x * yx - yx * a_x * xx) / determinant
    changed[:, 1, 1] = (own_x * yy - yx * a_x * xy) / determinant
    return changed


def in_series_with(supports: Sequence[Support], impedance: ComplexArray, frequency: Array) -> ComplexArray:
    """Impedances of bearings (n_bearing, 2, 2, n, n_frequency) on those supports that each bearing has for itself."""
    for support in supports:
        if not support.is_common:
            impedance = in_series(impedance, support.compliance(frequency))
    return impedance


def ports_on(supports: Sequence[Support], impedance: ComplexArray, frequency: Array) -> ComplexArray:
    """Impedances (n_port, n_port, n, n_frequency) from the motion of any port to the force on any other, of bearings
    (n_bearing, 2, 2, n, n_frequency) on all supports."""
    impedance = in_series_with(supports, impedance, frequency)
    n_port, shape = 2 * len(impedance), impedance.shape[-2:]
    common = np.zeros((2, *shape), dtype=complex)
    for support in supports:
        if support.is_common:
            common += support.compliance(frequency)
    return on_common(impedance, common).reshape(n_port, n_port, *shape)


def on_common(impedance: ComplexArray, compliance: ComplexArray) -> ComplexArray:
    """Impedances of bearings (n_bearing, 2, 2, n, n_frequency) that stand together on a compliance (2, n, n_frequency), from the
    motion of one bearing (second n_bearing) to the force on another: (n_bearing, 2, n_bearing, 2, n, n_frequency) N/m."""
    unit = np.eye(2)[..., None, None]
    carried = inverse(unit + compliance[:, None] * impedance.sum(axis=0))
    moved = [product(carried, compliance[:, None] * each) for each in impedance]  # v per motion of each bearing
    coupled = np.empty((len(impedance), 2, *impedance.shape[:2], *compliance.shape[1:]), dtype=complex)
    for bearing, own in enumerate(impedance):
        for other, motion in enumerate(moved):
            coupled[bearing, :, other] = product(own, unit - motion if other == bearing else -motion)
    return coupled

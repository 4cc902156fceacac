"""What carries the bearings, in series with each of them: a spring with a loss factor and a mass in each axis.

With z_b the bearing's impedance and a the support's dynamic compliance, the shaft feels z = (1 + z_b a)⁻¹ z_b, which at
a = 0 is that of a bearing on rigid ground. The compliance is a function of the frequency of the motion, whatever the spin
speed is: a = s / (1 + iη sgn ω − s ω² m), s the compliance of the spring.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray


@dataclass(frozen=True, eq=False)
class Support:
    """The supports of all bearings, which are alike, for n parameter sets."""

    spring: Array  # (2 axes, n) m/N, compliance
    mass: Array  # (n,) kg
    loss_factor: float  # η of the springs

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

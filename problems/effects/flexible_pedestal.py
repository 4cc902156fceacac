"""Flexible pedestals: each bearing stands on a spring with a mass, so that the shaft feels both in series.

With z_b the bearing's impedance and z_p = (1 + iη)/s − Ω² m that of the pedestal in each axis, the shaft feels
z = z_p (z_b + z_p)⁻¹ z_b. Written with the pedestal's compliance a = s / (1 + iη − s Ω² m) it is z = (1 + z_b a)⁻¹ z_b,
which at s = 0 is a rigid pedestal's, whatever its mass. All pedestals are alike, and probes measure against the ground.

J. C. Nicholas, J. K. Whalen & S. D. Franklin, Improving critical speed calculations using flexible bearing support FRF
compliance data, Proc. 15th Turbomachinery Symposium (1986) 69–78; API 684; Friswell, Penny, Garvey & Lees, Dynamics of
Rotating Machines, 2010, chapter 5.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.parameters import Parameter
from ksmea.settings import setting
from ksmea.units import MICROMETRE_PER_KILONEWTON
from problems.rotor.effect import RotorEffect, column, drawn
from problems.rotor.problem import RotorProblem
from problems.rotor.sizes import rotor_mass, stiffness_scale

SOFTEST = 2.0  # times the compliance of the stiffest bearing; a softer one is no pedestal
HEAVIEST = 0.5  # of the rotor
NOTICED_COMPLIANCE = (0.2, 1.0)  # of the compliance of the stiffest bearing, in each direction, are drawn
NOTICED_MASS = (0.06, 0.3)  # of the rotor, are drawn


@dataclass(frozen=True)
class FlexiblePedestal(RotorEffect):
    """What carries the bearings gives way, and has a mass."""

    loss_factor: float = setting(
        0.02,
        "η of the pedestals' springs: bolted steel structures have 0.01 to 0.05, and without any they could resonate"
        " without limit",
        above=0,
        at_most=1,
    )

    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_stiffness": "a pedestal's mass softens it with speed too; a sensor on the casing",
    }
    stage: ClassVar[int] = 1

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        softest = SOFTEST / stiffness_scale(problem)
        return (
            Parameter("pedestal_compliance_x", "µm/kN", MICROMETRE_PER_KILONEWTON, 0.0, softest),
            Parameter("pedestal_compliance_y", "µm/kN", MICROMETRE_PER_KILONEWTON, 0.0, softest),
            Parameter("pedestal_mass", "kg", 1.0, 0.0, HEAVIEST * rotor_mass(problem)),
        )

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        compliances = [drawn(rng, *NOTICED_COMPLIANCE) / stiffness_scale(problem) for _ in range(2)]
        return np.array([*compliances, drawn(rng, *NOTICED_MASS) * rotor_mass(problem)])

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        spring, mass = theta[:, :2].T[:, :, None], column(theta[:, 2])
        compliance = spring / (1 + 1j * self.loss_factor - spring * mass * speed**2)  # (2 axes, n, n_speed)
        # (1 + z a)⁻¹ z of 2 × 2 matrices, a diagonal
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

"""Flexible pedestals: each bearing stands on a spring with a mass, in series with the bearing.

At a compliance of 0 it is rigid, whatever its mass and loss factor (`problems/rotor/finite_elements/bearing.py`). All pedestals are
alike, and probes measure against the ground. The softest is one that the rotor's weight presses down by `SAG`: on it the rotor would
have a natural frequency of √(g/SAG)/2π = 35 Hz, and softer mounts are isolators. Limits of the bearings' stiffness say nothing of it.

J. C. Nicholas, J. K. Whalen & S. D. Franklin, Improving critical speed calculations using flexible bearing support FRF
compliance data, Proc. 15th Turbomachinery Symposium (1986) 69–78; API 684; Friswell, Penny, Garvey & Lees, Dynamics of
Rotating Machines, 2010, chapter 5.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.numerics.screening import sobol
from ksmea.settings.settings import setting
from ksmea.units import MILLIMETRE
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, rotor_mass
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.bearing import Support
from problems.rotor.free_motion.static_load import GRAVITY
from problems.rotor.response.problem import RotorProblem

SAG = 0.2 * MILLIMETRE
HEAVIEST = 5.0  # of the rotor: a casing outweighs its rotor several times
LOSSIEST = 0.3  # η: bolted steel structures have 0.01 to 0.05, concrete on soil 0.1
# Of resonant pedestals from which fits start: how many, the lightest, in parts of the rotor, the highest resonance, in highest
# speeds, the lowest loss factor, and the largest ratio of the compliance in x or y to their mean
N_RESONANT, LIGHTEST, ABOVE, LEAST_LOSS, UNEQUAL = 128, 0.02, 2.0, 0.003, 1.5
NOTICED_COMPLIANCE = (0.01, 0.1)  # of the softest, in each direction, are drawn
NOTICED_LOSS = (0.01, 0.05)  # are drawn
NOTICED_MASS = (0.06, 0.3)  # of the rotor, are drawn


@dataclass(frozen=True)
class FlexiblePedestal(RotorEffect):
    """The pedestals of the bearings give way, and have a mass."""

    extent = ALL_BEARINGS
    loss_factor: float | None = setting(
        None, "η of the pedestals' springs, if it is known; null: an unknown", above=0, at_most=1
    )

    words = "flexible pedestals"
    says = "The pedestals yield by {pedestal_compliance_x} in x and {pedestal_compliance_y} in y, with a mass of {pedestal_mass} each"
    check_next = (
        "Measure casing vibration at both bearings:"
        " motion comparable with the shaft's confirms it; then check bolts and grout."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_stiffness": "a pedestal's mass softens it with speed too; a sensor on the casing",
        "foundation_resonance": "a block moves all bearings alike; sensors on the casings of two bearings, or on the foundation",
        "short_journal_bearing": "both are soft and in series with the bearings; a sensor on the casing, warm and cold oil",
        "bearing_mass": "a pedestal softens with frequency too; a sensor on the casing",
    }

    @property
    def sizes(self) -> Sequence[Size]:
        return SIZES if self.loss_factor is None else SIZES[:-1]

    def scan_further(self, problem: RotorProblem) -> Array:
        """Pedestals of all masses that resonate within the measured speeds, or not far above."""
        upper = np.array([item.upper for item in self.parameters(problem)])
        lowest, highest = np.min(problem.speed), ABOVE * np.max(problem.speed)
        drawn = sobol(N_RESONANT, 4) + 0.5 / N_RESONANT
        speed = lowest * (highest / lowest) ** drawn[:, 0]
        lightest = np.clip(
            1 / (upper[0] * speed**2), LIGHTEST * rotor_mass(problem), upper[2]
        )  # not beyond the softest
        mass = lightest * (upper[2] / lightest) ** drawn[:, 1]
        compliance, ratio = 1 / (mass * speed**2), UNEQUAL ** (2 * drawn[:, 2] - 1)
        loss = LEAST_LOSS * (LOSSIEST / LEAST_LOSS) ** drawn[:, 3]
        values = np.stack([compliance * ratio, compliance / ratio, mass, loss], axis=1)
        return np.minimum(values[:, : len(upper)], upper)

    def support(self, theta: Array) -> Support:
        loss_factor = theta[:, 3] if self.loss_factor is None else self.loss_factor
        return Support(theta[:, :2].T, theta[:, 2], loss_factor)


def softest_pedestal(problem: RotorProblem) -> float:
    """Compliance, m/N, at which the rotor's weight presses each pedestal down by `SAG`.

    Each carries its bearing's share of the weight.
    """
    return SAG * max(1, len(problem.rotor.bearings)) / (GRAVITY * rotor_mass(problem))


SIZES = (
    Size("pedestal_compliance_x", "µm/kN", (0.0, 1.0), drawn=NOTICED_COMPLIANCE, of=softest_pedestal),
    Size("pedestal_compliance_y", "µm/kN", (0.0, 1.0), drawn=NOTICED_COMPLIANCE, of=softest_pedestal),
    Size("pedestal_mass", "kg", (0.0, HEAVIEST), drawn=NOTICED_MASS, of=rotor_mass),
    Size("pedestal_loss_factor", "%", (0.0, LOSSIEST), drawn=NOTICED_LOSS),
)

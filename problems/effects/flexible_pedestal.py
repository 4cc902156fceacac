"""Flexible pedestals: each bearing stands on a spring with a mass, so that the shaft feels both in series.

At a compliance of 0 it is rigid, whatever its mass (`problems/rotor/finite_elements/bearing.py`). All pedestals are alike, and probes
measure against the ground.

J. C. Nicholas, J. K. Whalen & S. D. Franklin, Improving critical speed calculations using flexible bearing support FRF
compliance data, Proc. 15th Turbomachinery Symposium (1986) 69–78; API 684; Friswell, Penny, Garvey & Lees, Dynamics of
Rotating Machines, 2010, chapter 5.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, rotor_mass, stiffness_scale
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.bearing import Support

SOFTEST = 2.0  # times the compliance of the stiffest bearing; a softer one is no pedestal
HEAVIEST = 0.5  # of the rotor
NOTICED_COMPLIANCE = (0.2, 1.0)  # of the compliance of the stiffest bearing, in each direction, are drawn
NOTICED_MASS = (0.06, 0.3)  # of the rotor, are drawn


@dataclass(frozen=True)
class FlexiblePedestal(RotorEffect):
    """What carries the bearings gives way, and has a mass."""

    extent = ALL_BEARINGS
    loss_factor: float = setting(
        0.02,
        "η of the pedestals' springs: bolted steel structures have 0.01 to 0.05, and without any they could resonate"
        " without limit",
        above=0,
        at_most=1,
    )

    words = "flexible pedestals"
    says = "The pedestals yield by {pedestal_compliance_x} in x and {pedestal_compliance_y} in y, with a mass of {pedestal_mass} each"
    check_next = "Foundation bolts, grout and pedestal; measure casing vibration at both bearings."
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_stiffness": "a pedestal's mass softens it with speed too; a sensor on the casing",
        "foundation_resonance": "a block moves all bearings alike; sensors on the casings of two bearings, or on the foundation",
        "short_journal_bearing": "both are soft and in series with the bearings; a sensor on the casing, warm and cold oil",
    }

    sizes = (
        Size("pedestal_compliance_x", "µm/kN", (0.0, SOFTEST), drawn=NOTICED_COMPLIANCE, per=stiffness_scale),
        Size("pedestal_compliance_y", "µm/kN", (0.0, SOFTEST), drawn=NOTICED_COMPLIANCE, per=stiffness_scale),
        Size("pedestal_mass", "kg", (0.0, HEAVIEST), drawn=NOTICED_MASS, of=rotor_mass),
    )

    def support(self, theta: Array) -> Support:
        return Support(theta[:, :2].T, theta[:, 2], self.loss_factor)

"""Damping of the bearings that changes with speed: c (1 + b Ω/Ω₁), both axes and all bearings alike.

Oil films damp less as their Sommerfeld number rises; over a limited band a straight line stands for that (J. W. Lund,
Review of the concept of dynamic coefficients for fluid film journal bearings, J. Tribology 109 (1987) 37–41). Ω₁ is the
highest speed of the problem that the effect is added to, and stays so when the problem is seen at others. Direct
dampings change, cross-coupled ones do not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array, ComplexArray
from ksmea.settings.settings import setting
from problems.effects.speed_dependent_stiffness import SlopeOverSpeed
from problems.rotor.extension.sizes import Size

LOWEST, HIGHEST = -0.9, 5.0  # of what it is at rest: it never drives the rotor
NOTICED = (1.0, 4.5)  # are drawn; damping that falls with speed hardly shows


@dataclass(frozen=True)
class SpeedDependentDamping(SlopeOverSpeed):
    """The bearings' damping rises or falls with speed."""

    full_speed: float | None = setting(
        None, "the speed at which the change is b; null: the highest of the problem", unit="rad/s", above=0
    )

    words = "damping over speed"
    says = "Bearing damping is {damping_slope:higher|lower} at full speed than at rest"
    check_next = (
        "Record oil temperature and load over the run: identifying bands of speed apart confirms it if damping differs."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "clearance_rub": "both lower a peak; a run with more unbalance",
        "unbalance": "both change the heights of peaks against each other; a further resonance, a trial weight",
        "external_damping": "both change peak heights; several critical speeds, of which some hardly move the bearings",
        "run_up_acceleration": "both lower a peak; a second run-up at another rate, a coast-down",
        "timing_delay": "both change how the phase goes with speed; a wider band, a square wave into all channels",
    }

    sizes = (Size("damping_slope", "%", (LOWEST, HIGHEST), drawn=NOTICED, rises=True),)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        changed = impedance.copy()
        for axis in (0, 1):
            changed.imag[:, axis, axis] *= self.factor(speed, theta)
        return changed

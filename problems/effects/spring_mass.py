"""A spring-mass on the shaft that the model lacks.

A dynamic absorber, a flexible disk, blades or a coupling half on a soft hub.

A mass m with the natural frequency f₀ and the damping ratio ζ moves in x and y against the shaft. Far below f₀ it is an added mass, near f₀
it splits a critical speed in two or holds the shaft at rest, far above it nearly lets go (J. P. Den Hartog, Mechanical Vibrations, 1956,
section 3.2; `ksmea.nonlinear.laws.SpringMass`). A stiffer one than three times √(k/m) is an added mass. Free vibration
leaves it out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.nonlinear.laws import LAWS, Law
from ksmea.settings.settings import setting
from problems.effects.added_mass import mounting_places
from problems.rotor.extension.effect import SeatedEffect, rotor_mass, stiffness_scale
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.2  # of the rotor's mass
HIGHEST = 3.0  # natural frequency, times √(k/m), k the stiffest bearing and m the rotor's mass
MOST_DAMPED = 0.3  # damping ratio: more leaves no resonance
NOTICED_MASS, NOTICED_FREQUENCY, NOTICED_RATIO = (0.005, 0.1), (0.1, 0.45), (0.03, 0.5)  # of the limits, are drawn
LAW = LAWS["spring_mass"]


def _highest(problem: RotorProblem) -> float:
    return float(HIGHEST * np.sqrt(stiffness_scale(problem) / rotor_mass(problem)))


def _most_damped(problem: RotorProblem) -> float:  # so that what is drawn is a part of it
    return MOST_DAMPED


@dataclass(frozen=True)
class SpringMassOnShaft(SeatedEffect):
    """A mass on a spring moves with the shaft and against it."""

    position: float | None = setting(None, "position of the mass; null: the first disk or end", unit="m", at_least=0)

    is_scanned: ClassVar[bool] = (
        False  # starts come from the force at its place; scans of three unknowns at each place take minutes
    )
    words = "spring-mass on the shaft"
    says = "A mass of {attached_mass} moves on a spring against the shaft {place}, with a natural frequency of {attached_frequency}"
    check_next = (
        "Tap flexible disks, blades, couplings and loose parts there at rest: this natural frequency confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "added_mass": "both lower natural frequencies; a speed near its own frequency: the shaft stands still there",
        "foundation_resonance": "both add a resonance; a sensor on the foundation, a tap test of the part at rest",
    }

    for_drawings_only: ClassVar[bool] = True
    what, default_place = "spring-mass", "on the first disk or end"
    sizes = (
        Size("attached_mass", "kg", (0.0, LARGEST), drawn=NOTICED_MASS, of=rotor_mass),
        Size("attached_frequency", "Hz", (0.0, 1.0), drawn=NOTICED_FREQUENCY, of=_highest),
        Size("attached_damping_ratio", "%", (0.0, 1.0), drawn=NOTICED_RATIO, of=_most_damped),
    )

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return mounting_places(problem.rotor)

    def site_law(self) -> SiteLaw:
        return SiteLaw(self.place, LAW)

    def force_at(self) -> tuple[float, Law] | None:
        return None if self.position is None else (self.position, LAW)

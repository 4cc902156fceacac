"""A force or moment at one place of the shaft that follows a law.

It is the result of `+experiment=locate` as part of a model.

The laws are in `ksmea.nonlinear.laws` – a vector that turns with the shaft, a spring, damper, mass or cross-coupling, a
stop … – or a smooth function of speed (`ksmea.nonlinear.smooth_law`). It follows the motion of its site as all else
leaves it, and moves it. Nothing is said of its cause, and a diagnosis does not try it by itself: a location does, at
every place and with every law.

Limits follow from dimensions: with k the largest stiffness, m the rotor's mass and u the largest unbalance, the scale
of forces is u k/m, the unbalance force at the speed √(k/m), of lengths u/m and of times √(m/k). Of either sign, springs
go up to k, dampers to √(k m), masses to m and unbalances to u; forces that grow less with speed go to ten times their
scale, since bands may lie far above √(k/m). Moments are forces on an arm as long as the shaft. Amplitudes begin at
zero, and so do the parts of a spring-mass. The angle of a vector, or of an asymmetry, counts from the phase origin of
the data, as the angle of a further unbalance does.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.nonlinear.laws import LAWS, MOMENT_LAWS, Law, NonlinearLaw
from ksmea.nonlinear.smooth_law import SMOOTH, smooth
from ksmea.problem.load import FORCE, MOMENT
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import (
    RotorEffect,
    drawn_either_side,
    require_on_shaft,
    rotor_mass,
    stiffness_scale,
    unbalance_scale,
)
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.response.problem import RotorProblem

PREFIX = "local_"  # of its unknowns: a rotor may have a k_x of its own
NOTICED = (0.005, 0.2)  # of the limits, of either sign, are drawn
# Limits by unit: a number, and powers of the scales of force, length and time and of the length of the shaft.
LARGEST = {
    "N": (10, 1, 0, 0, 0),
    "N s/rad": (10, 1, 0, 1, 0),
    "g mm": (1, 1, 0, 2, 0),
    "MN/m": (1, 1, -1, 0, 0),
    "kN s/m": (1, 1, -1, 1, 0),
    "kg": (1, 1, -1, 2, 0),
    "MN/mm³": (0.01, 1, -3, 0, 0),
    "µm": (100, 0, 1, 0, 0),
    "": (1, 0, 0, 0, 0),
    "Hz": (3, 0, 0, -1, 0),
    "%": (0.5, 0, 0, 0, 0),
    "N m": (10, 1, 0, 0, 1),
    "N m s/rad": (10, 1, 0, 1, 1),
    "kg m²": (1, 1, 0, 2, 1),
}
TYPED = {
    "/Ω²": "_per_speed2",
    "/Ω": "_per_speed",
    "Δk": "asymmetry",
    "k₃": "k3",
    "δ": "clearance",
    "μ": "friction",
    "ζ": "damping_ratio",
}


@dataclass(frozen=True)
class LocalForce(RotorEffect):
    """Something acts at one place, by a law whose cause is not named."""

    if_nowhere: ClassVar[str] = "give its position, which takes a file (problem=extended problem.file=extended.yaml)"

    position: float | None = setting(None, "position of the force; has to be given", unit="m", at_least=0)
    law: str = setting("mass", "what it follows (docs/location.md)", choices=(*LAWS, *MOMENT_LAWS, SMOOTH))
    knots: list[float] = setting(
        [], f"of law={SMOOTH}: speeds at which it has a value of its own, rising; beyond them nothing is known of it",
        unit="rad/s",
    )  # fmt: skip

    def __str__(self) -> str:
        return self._law.name if self.position is None else f"{self._law.name} at {self.position:g} m"

    def check(self) -> None:
        if self.law != SMOOTH and self.knots:
            raise SettingError(
                f"knots: expected none of law={self.law}, got {len(self.knots)}; they are for law={SMOOTH}"
            )
        if self.law == SMOOTH and (len(self.knots) < 2 or np.any(np.diff(self.knots) <= 0)):
            raise SettingError(f"knots: expected two rising speeds or more for law={SMOOTH}, got {self.knots}")

    @property
    def _law(self) -> Law:
        return smooth(np.array(self.knots)) if self.law == SMOOTH else {**LAWS, **MOMENT_LAWS}[self.law]

    def locations(self, problem: RotorProblem) -> Sequence[LocalForce]:
        """This effect if it has a position; it knows of no place by itself."""
        return [] if self.position is None else [self]

    def placed_on(self, problem: RotorProblem) -> LocalForce:
        site = self.site_law()
        require_on_shaft(problem, self.position, site.quantity)
        site.rows(problem.rotor)
        return self

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        stiffness, mass, unbalance = stiffness_scale(problem), rotor_mass(problem), unbalance_scale(problem)
        scales = np.array(
            [unbalance * stiffness / mass, unbalance / mass, np.sqrt(mass / stiffness), problem.rotor.length]
        )

        def largest(unit: str) -> float:
            number, *powers = LARGEST[unit]
            return float(number * np.prod(scales ** np.array(powers)))

        jumps = isinstance(self._law, NonlinearLaw) and self._law.bends
        return tuple(
            Parameter(_name(name), unit, size, max(least, -largest(unit)), largest(unit), jumps)
            for (name, unit, size), least in zip(self._law.coefficients, self._law.least.tolist(), strict=True)
        )

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        parts = [(item, drawn_either_side(rng, *NOTICED)) for item in self.parameters(problem)]
        return np.array([item.upper * (part if item.lower else abs(part)) for item, part in parts])

    def site_law(self) -> SiteLaw:
        if self.position is None:
            raise SettingError("position: expected the place of the force, got none; give one, or what locate writes")
        return SiteLaw(self.position, self._law, MOMENT if self.law in MOMENT_LAWS else FORCE)


def _name(coefficient: str) -> str:
    """The unknown that a coefficient is, in letters that can be typed."""
    for symbol, word in TYPED.items():
        coefficient = coefficient.replace(symbol, word)
    return PREFIX + re.sub(r"\W+", "_", coefficient)

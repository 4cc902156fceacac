"""A force at one place of the shaft that follows a law: what `+experiment=locate` finds, as part of a model.

The laws are those of `ksmea.force_laws`: a vector that turns with the shaft, or a spring, damper, mass or cross-coupling at
its site. It follows the motion there as all else leaves it, and moves it. Nothing is said of its cause, and a diagnosis does
not try it by itself: that is what a location does, at every place and with every law.

Limits are those of dimensions: with k the largest stiffness, m the rotor's mass and u the largest unbalance, the scale of
forces is u k/m, that of the unbalance at the speed √(k/m), of lengths u/m and of times √(m/k). Of either sign, springs go up
to k, dampers to √(k m), masses to m and unbalances to u; what grows less with speed to ten times its scale, since bands may
lie far above √(k/m). The angle of a vector is that of the data, wherever their phase begins, as that of a further unbalance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.force_laws import LAWS
from ksmea.parameters import Parameter
from ksmea.settings import setting
from problems.rotor.effect import RotorEffect, drawn_either_side, require_on_shaft
from problems.rotor.problem import RotorProblem
from problems.rotor.site_law import SiteLaw
from problems.rotor.sizes import rotor_mass, stiffness_scale, unbalance_scale

PREFIX = "local_"  # of its unknowns: a rotor may have a k_xx of its own
NOTICED = (0.005, 0.2)  # of the limits, of either sign, are drawn
# Limits by unit: a number, and powers of the scales of force, length and time.
LARGEST = {
    "N": (10, 1, 0, 0),
    "N s/rad": (10, 1, 0, 1),
    "g mm": (1, 1, 0, 2),
    "MN/m": (1, 1, -1, 0),
    "kN s/m": (1, 1, -1, 1),
    "kg": (1, 1, -1, 2),
    "MN/mm³": (1, 1, -3, 0),
    "µm": (100, 0, 1, 0),
    "": (1, 0, 0, 0),
}
FROM_ZERO = ("µm",)  # amplitudes, which have no sign
PLAIN = {"/Ω": "_per_speed", "Δk": "asymmetry", "k₃": "k3", "δ": "clearance", "μ": "friction"}  # to be typed


@dataclass(frozen=True)
class LocalForce(RotorEffect):
    """Something acts at one place, by a law whose cause is not named."""

    position: float | None = setting(None, "where it acts; has to be given", unit="m", at_least=0)
    law: str = setting("mass", "what it follows (docs/location.md)", choices=tuple(LAWS))

    def __str__(self) -> str:
        return LAWS[self.law].name if self.position is None else f"{LAWS[self.law].name} at {self.position:g} m"

    def locations(self, problem: RotorProblem) -> Sequence[LocalForce]:
        """Where it is given: it knows of no place by itself."""
        return [] if self.position is None else [self]

    def placed_on(self, problem: RotorProblem) -> LocalForce:
        self.site_law()
        require_on_shaft(problem, self.position, "force")
        return self

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        stiffness, mass, unbalance = stiffness_scale(problem), rotor_mass(problem), unbalance_scale(problem)
        force, length, time = unbalance * stiffness / mass, unbalance / mass, np.sqrt(mass / stiffness)

        def largest(unit: str) -> float:
            times, of_force, of_length, of_time = LARGEST[unit]
            return float(times * force**of_force * length**of_length * time**of_time)

        return tuple(
            Parameter(_name(name), unit, size, 0.0 if unit in FROM_ZERO else -largest(unit), largest(unit))
            for name, unit, size in LAWS[self.law].coefficients
        )

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        parts = [(item, drawn_either_side(rng, *NOTICED)) for item in self.parameters(problem)]
        return np.array([item.upper * (part if item.lower else abs(part)) for item, part in parts])

    def site_law(self) -> SiteLaw:
        if self.position is None:
            raise SettingError("position: expected the place of the force, got none; give one, or what locate writes")
        return SiteLaw(self.position, LAWS[self.law])


def _name(coefficient: str) -> str:
    """The unknown that a coefficient is."""
    for symbol, word in PLAIN.items():
        coefficient = coefficient.replace(symbol, word)
    return PREFIX + coefficient

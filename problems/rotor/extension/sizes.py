"""Unknowns of an effect, one line each.

Name, unit, limits, and the sizes that are drawn for data that hide the effect.

>>> size = Size("mass_change", "%", 0.2, drawn=(0.003, 0.1))  # between ±20 %, drawn between ±0.3 and ±10 %
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.problem.parameters import Parameter
from ksmea.units import (
    DEGREE,
    GRAM_MILLIMETRE,
    HERTZ,
    MICROMETRE,
    MICROMETRE_PER_KILONEWTON,
    MICROSECOND,
    MILLIMETRE,
    MILLIRADIAN,
)
from problems.rotor.response.problem import RotorProblem

SI_PER_UNIT = {
    "%": 0.01,
    "kg": 1.0,
    "N": 1.0,
    "N m": 1.0,
    "kN": 1e3,
    "MN/m": 1e6,
    "MN/mm³": 1e15,
    "kN s/m": 1e3,
    "N s/m²": 1.0,
    "µm/kN": MICROMETRE_PER_KILONEWTON,
    "µm": MICROMETRE,
    "mm": MILLIMETRE,
    "µs": MICROSECOND,
    "g mm": GRAM_MILLIMETRE,
    "deg": DEGREE,
    "Hz": HERTZ,
    "mrad": MILLIRADIAN,
}

Scale = Callable[[RotorProblem], float]


@dataclass(frozen=True)
class Size:
    """One unknown of an effect.

    `limits` and `drawn` are SI: numbers, or parts of a size `of` the problem, or multiples of 1 `per` such a size.
    """

    name: str
    unit: str
    limits: float | tuple[float, float]  # lowest and highest; one number: the highest of either sign
    drawn: tuple[
        float, float
    ]  # each factor between them is equally likely; of either sign if the lowest limit is negative
    of: Scale | None = None
    per: Scale | None = None
    lowest: Scale | None = None  # of a problem, SI, in place of that of `limits`
    rises: bool = False  # whether positive values alone are drawn
    makes_jumps: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        return (self.name,)

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        limits = self.limits_on(problem)
        size = SI_PER_UNIT[self.unit]
        return tuple(Parameter(name, self.unit, size, *limits, self.makes_jumps) for name in self.names)

    def limits_on(self, problem: RotorProblem) -> tuple[float, float]:
        """Lowest and highest value on a problem, SI."""
        lowest, highest = self.limits if isinstance(self.limits, tuple) else (-self.limits, self.limits)
        of_problem = self._scaled(lowest, problem) if self.lowest is None else self.lowest(problem)
        return of_problem, self._scaled(highest, problem)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        """Plausible values (e,) SI; one below the lowest limit has the other sign."""
        lowest, _ = self.limits_on(problem)
        value = self._scaled((drawn if self.rises or lowest >= 0 else drawn_either_side)(rng, *self.drawn), problem)
        return np.array([value if value >= lowest else -value])

    def _scaled(self, value: float, problem: RotorProblem) -> float:
        if self.of is not None:
            return value * self.of(problem)
        return value if self.per is None else value / self.per(problem)


@dataclass(frozen=True)
class VectorSize(Size):
    """Two unknowns, the components x and y of a vector: `drawn` limits its length, at any angle."""

    @property
    def names(self) -> tuple[str, ...]:
        return f"{self.name}_x", f"{self.name}_y"

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return np.array([self._scaled(value, problem) for value in drawn_vector(rng, *self.drawn).tolist()])


def drawn(rng: np.random.Generator, least: float, most: float) -> float:
    """A number between `least` and `most`, each factor between them as likely as any other."""
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def drawn_either_side(rng: np.random.Generator, least: float, most: float) -> float:
    """A number between `least` and `most`, or its negative."""
    return float(rng.choice([-1.0, 1.0]) * drawn(rng, least, most))


def drawn_vector(rng: np.random.Generator, least: float, most: float) -> Array:
    """Cartesian components (2,) of a vector as long as between `least` and `most`, at any angle."""
    length, angle = drawn(rng, least, most), rng.uniform(0, 2 * np.pi)
    return length * np.array([np.cos(angle), np.sin(angle)])

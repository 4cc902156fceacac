"""Numbers drawn evenly in their logarithm, rounded, and the search limits about a true value."""

from __future__ import annotations

import math

import numpy as np

from ksmea.problem.parameters import Parameter
from ksmea.units import DEGREE, GRAM_MILLIMETRE, KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE

Range = tuple[float, float]  # drawn from evenly in the logarithm, unless said otherwise

DIGITS = 4
UNITS = {
    "stiffness": ("MN/m", MEGANEWTON_PER_METRE),
    "damping": ("kN s/m", KILONEWTON_SECOND_PER_METRE),
    "unbalance": ("g mm", GRAM_MILLIMETRE),
    "angle": ("deg", DEGREE),
}
# Search limits: the upper one in parts of the lower one, and where between them the true value lies, evenly in the logarithm: the
# middle says nothing. Of the paper's limits, as far as known, the ratios are 10, 100 and 10.
LIMIT_RATIOS = {"stiffness": (4.0, 30.0), "damping": (10.0, 300.0), "unbalance": (4.0, 30.0)}
LIMIT_PLACE = 0.1, 0.9


def log_uniform(ends: Range, rng: np.random.Generator) -> float:
    """A number drawn evenly in its logarithm."""
    return rounded(math.exp(rng.uniform(*np.log(ends))))


def rounded(value: float) -> float:
    """To so many digits that machines which round differently draw the same."""
    return float(f"{value:.{DIGITS}g}")


def limited_about(name: str, quantity: str, true: float, rng: np.random.Generator) -> Parameter:
    """An unknown with drawn limits about its true value, SI."""
    ratio, place = log_uniform(LIMIT_RATIOS[quantity], rng), rng.uniform(*LIMIT_PLACE)
    lower, upper = rounded(true / ratio**place), rounded(true * ratio ** (1 - place))
    return Parameter(name, *UNITS[quantity], lower, upper)

"""The maximum of a likelihood near a point, of several that differ in the noise alone the highest."""

from __future__ import annotations

from contextlib import suppress

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent
from ksmea.likelihood import Likelihood
from ksmea.maximisation import maximise
from ksmea.point import Point


def with_best_noise(likelihood: Likelihood, best: Point) -> Point:
    """A maximum, or a higher one to which its unknowns lead with another level of the noise: floor or none, the data often allow
    both."""
    with suppress(BudgetSpent):
        for start in likelihood.other_noise(best.theta):
            again = maximise(likelihood, start)
            best = again if again.deviance < best.deviance else best
    return best


def nearest_maximum(likelihood: Likelihood, u: Array) -> Point:
    """The maximum of the likelihood nearest to u (d,); of several that differ in the noise alone, the highest."""
    return with_best_noise(likelihood, maximise(likelihood, likelihood.start(u)))

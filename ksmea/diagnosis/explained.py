"""Best explanation, an effect or a pair, with the quality of its fit and its rivals.

Rivals are explanations that fit the data about as well.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.diagnosis.model_averaging import akaike_weights, heaviest
from ksmea.diagnosis.trials import Explanation
from ksmea.fits.fitting import polished
from ksmea.fits.lack_of_fit import FitQuality, fit_quality
from ksmea.fits.stable_fits import stable_fit


@dataclass(frozen=True)
class Explained:
    """The best effect or pair of effects, polished, then all others that explain the data about as well."""

    quality: FitQuality
    near: tuple[Explanation, ...]

    @property
    def best(self) -> Explanation:
        return self.near[0]

    @property
    def is_ambiguous(self) -> bool:
        return any(each.names != self.best.names for each in self.near)


def with_near(best: Explanation, others: Iterable[Explanation], rng: np.random.Generator) -> Explained:
    """An explanation and all others that come near it.

    Pairs are kept only if their effects both have a size.
    """
    able = [each for each in others if len(each.applied) == 1 or each.has_sizes]
    return led_by(0, [best, *(each for each in able if each.is_near(best) and not each.is_same(best))], rng)


def led_by(index: int, near: Sequence[Explanation], rng: np.random.Generator) -> Explained:
    """Explanations, the one of an index first."""
    best = near[index]
    fit = stable_fit(polished(best.fit), best.fit.point.theta)
    others = (each for place, each in enumerate(near) if place != index)
    return Explained(fit_quality(fit, rng), (dataclasses.replace(best, fit=fit), *others))


def by_weight(explained: Explained, level: float, rng: np.random.Generator) -> Explained:
    """Explanations led by the one with clearly more weight than the best one by BIC.

    Its residuals must be noise as well.
    """
    near = explained.near
    names = [each.names for each in near]
    deviance, d = np.array([each.fit.deviance for each in near]), np.array([each.fit.likelihood.d for each in near])
    index = heaviest(names, akaike_weights(deviance, d, names))
    other = led_by(index, near, rng) if index else explained
    return other if other.quality.p >= min(level, explained.quality.p) else explained

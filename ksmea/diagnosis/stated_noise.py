"""Is the noise as large as it is stated? Where what a fit leaves looks like noise in every respect but its size, the model is
not to blame: the noise is taken as large as the fit leaves it.

A misfit that spreads evenly over speeds, channels and phases cannot be told from noise. The statistics that do not depend on
the size of the noise (`ksmea.diagnosis.fit_quality`) say whether it does; χ² then says how large the noise is. Noise that
is stated too large is left as it is: it may hold what no two readings of one run differ by.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import scipy

from ksmea.diagnosis.fit_quality import CHI2, FitQuality, fit_quality
from ksmea.diagnosis.fitting import BaselineFits, Fit, refitted
from ksmea.measurement import Measurement


def is_size_alone(quality: FitQuality, level: float) -> bool:
    """Whether a fit is rejected at `level`, and by χ² alone."""
    others = [p for name, p in quality.p_by_statistic.items() if name != CHI2]
    if len(others) == len(quality.p_by_statistic) or quality.p >= level:
        return False
    return min(others) * len(others) >= level  # Bonferroni's bound: χ² is what rejects


def is_stated_too_large(quality: FitQuality, n_left: int, level: float) -> bool:
    """Whether so little is left by n_left degrees of freedom less often than `level`, with noise as it is stated."""
    return CHI2 in quality.p_by_statistic and float(scipy.stats.chi2.cdf(quality.reduced_chi2 * n_left, n_left)) < level


def as_left(measurement: Measurement, quality: FitQuality) -> Measurement:
    """The measurement with noise as large as a fit leaves it; its noise is known."""
    if measurement.noise is None:
        raise ValueError("stated noise: expected a measurement with noise that is stated, got none")
    factor = float(np.sqrt(quality.reduced_chi2))
    return dataclasses.replace(measurement, noise=measurement.noise.scaled(factor))


def with_noise_as_left(baseline: BaselineFits, level: float, rng: np.random.Generator) -> BaselineFits:
    """The same fits with noise as the best of them leaves it, where that is all that speaks against it at `level`."""
    measurement = baseline.best.likelihood.measurement
    if measurement.noise is None:
        return baseline
    quality = fit_quality(baseline.best, rng)
    return baseline.refitted(as_left(measurement, quality)) if is_size_alone(quality, level) else baseline


def is_noise_as_stated(fit: Fit, measurement: Measurement, level: float, rng: np.random.Generator) -> bool:
    """Whether a model that was fitted with other noise leaves noise as a measurement states it."""
    return fit_quality(refitted(fit, measurement), rng).p >= level

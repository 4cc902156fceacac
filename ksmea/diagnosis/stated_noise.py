"""Is the noise as large as it is stated? Where what a fit leaves looks like noise in every respect but its size, the model is
not to blame: the noise is taken as large as the fit leaves it.

A misfit that spreads evenly over speeds, channels and phases cannot be told from noise. The statistics that do not depend on
the size of the noise (`ksmea.diagnosis.fit_quality`) say whether it does; χ² then says how large the noise is.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.diagnosis.fit_quality import CHI2, FitQuality
from ksmea.measurement import Measurement


def is_size_alone(quality: FitQuality, level: float) -> bool:
    """Whether a fit is rejected at `level`, and by χ² alone."""
    others = [p for name, p in quality.p_by_statistic.items() if name != CHI2]
    if len(others) == len(quality.p_by_statistic) or quality.p >= level:
        return False
    return min(others) * len(others) >= level  # Bonferroni's bound: χ² is what rejects


def as_left(measurement: Measurement, quality: FitQuality) -> Measurement:
    """The measurement with noise as large as a fit leaves it; its noise is known."""
    if measurement.noise is None:
        raise ValueError("stated noise: expected a measurement with noise that is stated, got none")
    factor = float(np.sqrt(quality.reduced_chi2))
    return dataclasses.replace(measurement, noise=measurement.noise.scaled(factor))

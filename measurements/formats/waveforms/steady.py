"""One vector of a record at a steady speed.

The mean over its windows, with the error of that mean as its noise.

Of n windows with the scatter s (total) the mean of independent ones has the standard error s/√n. What drifts or beats stays alike from
one window to the next; with the correlation ρ of neighbours n is worth n (1 − ρ)/(1 + ρ) independent windows (a first-order
autoregressive course; ρ > 0 only).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.units import RPM
from measurements.formats.user_answers import VECTORS
from measurements.formats.waveforms.order_tracking import Tracked

EACH, MEAN = VECTORS
STEADY = 0.02  # of the mean speed, by which a steady one varies at most
ROUNDING = 1e-9  # relative: windows that differ by less are copies of each other
MOST_CORRELATED = 0.9


def mean_of_windows(values: ComplexArray) -> tuple[ComplexArray, Array | None]:
    """Mean over windows (n_window, …) and its standard error (total).

    None without scatter to take it from.
    """
    mean = np.mean(values, axis=0)
    n = len(values)
    off = values - mean
    variance = np.sum(np.abs(off) ** 2, axis=0) / max(n - 1, 1)
    if n < 2 or np.any(variance <= (ROUNDING * np.abs(mean)) ** 2):
        return mean, None
    following = np.sum((off[1:] * np.conj(off[:-1])).real, axis=0) / np.sum(np.abs(off) ** 2, axis=0)
    correlation = np.clip(following, 0.0, MOST_CORRELATED)
    return mean, np.asarray(np.sqrt(variance / n * (1 + correlation) / (1 - correlation)))


def mean_speed(speed: Array, where: str) -> float:
    """The speed of a record, the mean of its windows. Raises `SettingError` if it is not steady."""
    mean = float(np.mean(speed))
    if np.ptp(speed) > STEADY * mean:
        raise SettingError(
            f"{where}: expected a steady speed with vectors=mean, got {np.min(speed) / RPM:.6g} to {np.max(speed) / RPM:.6g} rpm; give"
            " vectors=each, or cut the record"
        )
    return mean


def without_phases(found: Tracked) -> Tracked:
    """Amplitudes of windows whose angles have no origin, with their own noise: σ/√2 of a vector's total σ."""
    sigma = None if found.sigma is None else found.sigma / np.sqrt(2)
    return dataclasses.replace(found, values=np.abs(found.values).astype(complex), sigma=sigma)


def mean_of(found: Tracked, where: str) -> Tracked:
    """All windows of a record as one."""
    speed = mean_speed(found.speed, where)
    mean, sigma = mean_of_windows(found.values)
    return dataclasses.replace(
        found,
        time=found.time[:1],
        speed=np.array([speed]),
        values=mean[None],
        sigma=None if sigma is None else sigma[None],
        first=found.first[:1],
    )

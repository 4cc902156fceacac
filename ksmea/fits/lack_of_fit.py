"""Lack-of-fit test: five residual statistics, calibrated by simulation; understated noise.

The statistics are autocorrelation over speed, cross-channel correlation, the largest residual, the mean square of
one band and channel, and χ² if the noise level is known. Each is compared with simulated residuals of the fit: noise
minus its projection on the tangent of the fitted model. The smallest p-value is compared with the smallest of the
same simulations, so that together they reject a right model as often as their level says (Westfall & Young 1993,
min-P). In a campaign, neighbours and bands lie within one run. Standard tests do not hold here: Ljung–Box at a
nominal 1 % rejects 6 to 10 % of clean data after a fit.

If residuals look like noise in every respect but their size, the stated noise level is wrong and the model is not: a
misfit that spreads evenly over speeds, channels and phases cannot be distinguished from noise. The statistics that
do not depend on the noise level decide that, χ² then gives the level. Noise that is stated too large is kept: it may
hold what differs between runs only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.fits.fitting import BaselineFits, Fit, refitted
from ksmea.likelihood.fisher import span
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.records.identification import LackOfFit

LACK_OF_FIT_LEVEL = 0.01  # chance of rejecting a right model, in records of a fit
LAGS = 3  # of the autocorrelation, in speeds
MAX_VALUES = 2**22  # numbers simulated at once, which bounds the memory
N_BAND = 6  # equal numbers of speeds, shared among the runs
CHI2 = "χ²"  # the one that depends on the size of the noise
STATISTICS = (
    "autocorrelation over speed",
    "cross-channel correlation",
    "largest residual",
    "band and channel",
    CHI2,
)


@dataclass(frozen=True)
class FitQuality:
    """Quality of a fit: lack-of-fit test and residuals.

    `p` is of the lack-of-fit test, the smallest of `p_by_statistic` corrected for their number. `residuals` (n_speed,
    n_channel) in units of the noise, complex or real, and where most of the misfit sits.
    """

    p: float
    p_by_statistic: dict[str, float]
    residuals: Array | ComplexArray
    reduced_chi2: float
    worst_band: tuple[float, float]  # rad/s
    worst_channel: int
    worst_excess: float  # mean square there relative to that of all residuals

    @property
    def worst_statistic(self) -> str:
        return min(self.p_by_statistic, key=lambda name: self.p_by_statistic[name])


def fit_quality(fit: Fit, rng: np.random.Generator, *, n_simulated: int = 4000) -> FitQuality:
    """The lack-of-fit test of a fit."""
    likelihood = fit.likelihood
    measurement = likelihood.measurement
    response = fit.response()
    residuals = likelihood.left(fit.point.theta, response)
    shape, real, rows = residuals.shape, measurement.is_amplitude, measurement.rows
    n_mean = residuals.size * measurement.dimensions
    n_prior = likelihood.d - likelihood.n_free
    whitened = fit.point.whitened[:, : likelihood.d]
    directions = span(np.vstack([whitened[:n_mean], whitened[len(whitened) - n_prior :]]))  # priors are data too
    scale_free = likelihood.noise_is_estimated
    sampled = [residual_statistics(residuals[None], rows, scale_free=scale_free)]
    n_chunk = max(1, MAX_VALUES // n_mean)
    for start in range(0, n_simulated, n_chunk):
        noise = rng.standard_normal((min(n_chunk, n_simulated - start), n_mean + n_prior))
        noise -= (noise @ directions) @ directions.T
        noise = noise[:, :n_mean]
        simulated = noise.reshape(len(noise), *shape) if real else as_complex(noise, shape)
        simulated = likelihood.without_alike(fit.point.theta, simulated)  # the tangent has none of it
        sampled.append(residual_statistics(simulated, rows, scale_free=scale_free))
    statistics = np.concatenate(sampled)
    # p of every sample among all of them, the data's own included: no p is below 1/(n + 1)
    ranks = np.array([upper_ranks(column) for column in statistics.T]).T / len(statistics)
    smallest = ranks.min(axis=1)
    names = STATISTICS if not likelihood.noise_is_estimated else STATISTICS[:-1]
    band, channel, excess = _worst_location(residuals, rows)
    speed = measurement.speed
    return FitQuality(
        p=float(np.mean(smallest <= smallest[0])),
        p_by_statistic=dict(zip(names, map(float, ranks[0]))),
        residuals=residuals,
        reduced_chi2=float(
            np.sum(np.abs(residuals) ** 2) * measurement.dimensions / max(likelihood.n_residual - likelihood.n_free, 1)
        ),
        worst_band=(float(speed[band][0]), float(speed[band][-1])),
        worst_channel=channel,
        worst_excess=excess,
    )


def lack_of_fit(fit: Fit, rng: np.random.Generator) -> LackOfFit:
    """The test of a fit as a record, rejected at `LACK_OF_FIT_LEVEL`."""
    tested = fit_quality(fit, rng)
    return LackOfFit(float(tested.p), tested.worst_statistic, bool(tested.p < LACK_OF_FIT_LEVEL))


def as_complex(noise: Array, shape: tuple[int, ...]) -> ComplexArray:
    """Unit noise in two real parts per datum → complex of unit variance.

    Real parts first, as the likelihood has them.
    """
    n_datum = noise.shape[1] // 2
    combined = np.empty((len(noise), n_datum), dtype=complex)
    np.divide(noise[:, :n_datum], np.sqrt(2), out=combined.real)
    np.divide(noise[:, n_datum:], np.sqrt(2), out=combined.imag)
    return combined.reshape(len(noise), *shape)


def residual_statistics(residuals: Array | ComplexArray, rows: Sequence[slice], *, scale_free: bool) -> Array:
    """Statistics (n, 4 or 5) of residuals (n, n_speed, n_channel), each run at its `rows`.

    All but the last do not depend on their scale.
    """
    squared = residuals.real**2 + residuals.imag**2
    total = squared.sum(axis=(1, 2))
    mean = (total / residuals[0].size)[:, None, None]
    unit, squared = residuals * (1 / np.sqrt(mean)), squared / mean
    statistics = [
        np.sum([_autocorrelation(unit[:, run]) for run in rows], axis=0),
        _cross_correlation(unit),
        np.sqrt(squared.max(axis=(1, 2))),
        _band_and_channel(squared, _bands(rows)),
    ]
    return np.stack(statistics if scale_free else [*statistics, total], axis=1)


def _autocorrelation(unit: Array | ComplexArray) -> Array:
    """Σ over lags and channels of the autocorrelation over speed, which a smooth misfit makes positive."""
    n, n_speed, _ = unit.shape
    parts = np.ascontiguousarray(unit).view(float).reshape(n, -1)  # of complex ones both parts, whose products add up
    step = parts.shape[1] // (n_speed or 1)
    lags = range(1, min(LAGS, n_speed - 1) + 1)
    return sum((np.einsum("ni,ni->n", parts[:, lag * step :], parts[:, : -lag * step]) for lag in lags), np.zeros(n))


def _cross_correlation(unit: Array | ComplexArray) -> Array:
    """Σ over pairs of channels of their squared correlation."""
    products = np.matmul(unit.transpose(0, 2, 1), np.conj(unit))
    pairs = np.triu_indices(unit.shape[2], 1)
    total: Array = np.sum(np.abs(products[:, pairs[0], pairs[1]]) ** 2, axis=1) / unit.shape[1]
    return total


def _band_and_channel(squared: Array, bands: Sequence[Indices]) -> Array:
    """The largest mean square of one band and channel."""
    largest: Array = np.max(np.stack([squared[:, band].mean(axis=1).max(axis=1) for band in bands]), axis=0)
    return largest


def _bands(rows: Sequence[slice]) -> list[Indices]:
    n_band = max(1, N_BAND // len(rows))
    parts = [part for run in rows for part in np.array_split(np.arange(run.start, run.stop), n_band)]
    return [part for part in parts if len(part)]


def _worst_location(residuals: Array | ComplexArray, rows: Sequence[slice]) -> tuple[Indices, int, float]:
    """Band (indices of speeds), channel and relative mean square where it is largest."""
    squared = np.abs(residuals) ** 2
    bands = _bands(rows)
    means = np.array([squared[band].mean(axis=0) for band in bands])
    band, channel = np.unravel_index(np.argmax(means), means.shape)
    return bands[band], int(channel), float(means[band, channel] / max(squared.mean(), np.finfo(float).tiny))


def upper_ranks(values: Array) -> Indices:
    """How many of the values (n,) are at least as large as each."""
    return len(values) - np.searchsorted(np.sort(values), values, side="left")


def whirl_parts(residuals: Array | ComplexArray, channels: Sequence[Channel]) -> dict[float, ComplexArray]:
    """Forward and backward whirl (2, n_speed) in complex residuals at 1X, by position.

    Planes have probes in two directions: a forward circular motion is (1, −i) in x and y, a backward one (1, i).
    """
    found = {}
    for position in dict.fromkeys(channel.position for channel in channels):
        there = [index for index, item in enumerate(channels) if item.is_1x and item.position == position]
        across = [index for index in there if not channels[index].is_parallel_to(channels[there[0]])]
        if across:
            pair = sorted((there[0], across[0]), key=lambda index: channels[index].direction)
            read = np.array([channels[index].cosines for index in pair])  # of x and y by each of the two
            x, y = np.linalg.inv(read) @ residuals[:, pair].T
            found[position] = np.stack([(x + 1j * y) / 2, (x - 1j * y) / 2])
    return found


def is_size_alone(quality: FitQuality, level: float) -> bool:
    """Whether a fit is rejected at `level`, and by χ² alone."""
    others = [p for name, p in quality.p_by_statistic.items() if name != CHI2]
    if len(others) == len(quality.p_by_statistic) or quality.p >= level:
        return False
    return min(others) * len(others) >= level  # Bonferroni's bound: χ² is what rejects


def is_stated_too_large(quality: FitQuality, n_left: int, level: float) -> bool:
    """Whether residuals of n_left degrees of freedom are as small less often than `level`.

    Noise is as stated.
    """
    return CHI2 in quality.p_by_statistic and float(scipy.stats.chi2.cdf(quality.reduced_chi2 * n_left, n_left)) < level


def as_left(measurement: Measurement, quality: FitQuality) -> Measurement:
    """The measurement with noise as large as a fit leaves it; its noise is known."""
    if measurement.noise is None:
        raise ValueError("stated noise: expected a measurement with noise that is stated, got none")
    factor = float(np.sqrt(quality.reduced_chi2))
    return dataclasses.replace(measurement, noise=measurement.noise.scaled(factor))


def with_noise_as_left(baseline: BaselineFits, level: float, rng: np.random.Generator) -> BaselineFits:
    """Fits with the noise level of the best one's residuals, if only the noise level is rejected.

    The lack-of-fit test is at `level`.
    """
    measurement = baseline.best.measurement
    if measurement.noise is None:
        return baseline
    quality = fit_quality(baseline.best, rng)
    return baseline.refitted(as_left(measurement, quality)) if is_size_alone(quality, level) else baseline


def is_noise_as_stated(fit: Fit, measurement: Measurement, level: float, rng: np.random.Generator) -> bool:
    """Whether the residuals of a model fitted with other noise are consistent with the stated noise.

    The noise is the one that the measurement states."""
    return fit_quality(refitted(fit, measurement), rng).p >= level

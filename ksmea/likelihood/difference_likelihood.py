"""Likelihood of the differences between runs: what is alike in all runs at a speed cancels.

Examples are runout, a bow or an unbalance. The differences of the runs at a speed, in a channel, from any one of
them have a covariance C that is not diagonal. With independent noise of variance V their likelihood equals the
likelihood of the runs with one more complex number b for each speed and channel, alike in all of them, that is free
and has no part in the noise's estimate (restricted likelihood). With n real numbers of a datum, r = μ − y, W = Σ 1/V
and b = Σ (r / V) / W over the runs,

    −2 ln L = n [ Σ ln V + ln W + Σ |r − b|² / V ] + constant = n [ ln det C + d* C⁻¹ d ] + constant.

It does not depend on the run that differences are taken from. V is the variance of the readings,
s² = (relative · |y|)² + floor²: the model does not know all that they show.

H. D. Patterson and R. Thompson, Biometrika 58 (1971) 545–554, doi 10.1093/biomet/58.3.545: the likelihood of
contrasts.
"""

from __future__ import annotations

from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray
from ksmea.likelihood.fisher import Point, noise_variance_slopes
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import log_term
from ksmea.measurement.speeds import COMMON_SPEED, equal_speeds
from ksmea.problem.case import Case
from ksmea.problem.counted import Model

Number = TypeVar("Number", np.float64, np.complex128)


def likelihood_of(case: Case, *, stable_only: bool = False) -> Likelihood:
    """The likelihood of a measurement, or of how its runs differ where the campaign requests that."""
    likelihood_class = DifferenceLikelihood if case.measurement.is_by_differences else Likelihood
    return likelihood_class(Model(case.problem), case.measurement, stable_only=stable_only)


class DifferenceLikelihood(Likelihood):
    """The likelihood of how runs of a campaign differ at equal speeds, in complex data."""

    @property
    def n_residual(self) -> int:
        n_speed, n_channel = len(self.measurement.speed), len(self.measurement.channels)
        return (n_speed - len(self._groups)) * n_channel * self.measurement.dimensions

    def at(self, theta: Array) -> Point:
        response, slope = self.model.linearise(theta[: self.d])
        noise, observable = self.noise(theta), self.measurement.kind
        residual, variance = self._residual(response), self._variance(theta, response)
        left, slope = self._left(residual, variance), self._left(slope, variance[..., None])
        of_mean = 2 * (np.conj(left)[..., None] * slope).real / variance[..., None]
        n_noise = len(theta) - self.d
        of_noise = noise_variance_slopes(self._amplitude, noise)[..., :n_noise]
        total = self._spread(self._sum(1 / variance))
        excess = (1 - 1 / (variance * total) - np.abs(left) ** 2 / variance) / variance
        gradient = observable.dimensions * np.concatenate([of_mean, excess[..., None] * of_noise], axis=-1)
        means = observable.real_parts((slope / np.sqrt(variance)[..., None]).reshape(-1, self.d))
        variances = self._whitened_noise(variance, of_noise)
        whitened = np.zeros((len(means) + len(variances), len(theta)))
        whitened[: len(means), : self.d], whitened[len(means) :, self.d :] = means, variances
        return self.with_priors(Point(theta, self._deviance(residual, variance), gradient.sum(axis=(0, 1)), whitened))

    def log_density(self, theta: Array) -> float:
        reference = log_term(self._sum(1 / self._reference_variance), 1.0, self.measurement.kind)
        return super().log_density(theta) - 0.5 * float(np.sum(reference))

    def left(self, theta: Array, response: ComplexArray) -> ComplexArray:
        """Residuals of a response (n_speed, n_channel) without the part common to all runs.

        They are in units of the noise.
        """
        variance = self._variance(theta, response)
        return self._left(-self._residual(response), variance) / np.sqrt(variance)

    def without_alike(self, theta: Array, left: Array | ComplexArray) -> ComplexArray:
        variance = self._variance(theta, self.measurement.values)[..., None]
        values: ComplexArray = np.asarray(left, dtype=complex).transpose(1, 2, 0) * np.sqrt(variance)
        remaining: ComplexArray = self._left(values, variance) / np.sqrt(variance)
        return remaining.transpose(2, 0, 1)

    def alike(self, theta: Array, response: ComplexArray) -> ComplexArray:
        """Part of the residuals of a response that is common to all runs, (n_speed, n_channel), m."""
        residual = -self._residual(response)
        return residual - self._left(residual, self._variance(theta, response))

    def whitened_difference(self, response: ComplexArray, other: ComplexArray, theta: Array) -> Array:
        variance = self._variance(theta, other)
        change = self._left(response - other, variance) / np.sqrt(variance)
        return self.measurement.kind.real_parts(change.ravel())

    def _residual(self, response: ComplexArray) -> ComplexArray:
        return np.asarray(response - self.measurement.values, dtype=complex)

    def _variance(self, theta: Array, response: Array | ComplexArray) -> Array:
        return np.broadcast_to(self.noise(theta).variance(self._amplitude), self._amplitude.shape)

    def _deviance(self, residual: Array | ComplexArray, variance: Array) -> float:
        left = self._left(np.asarray(residual, dtype=complex), variance)
        total, reference = self._sum(1 / variance), self._sum(1 / self._reference_variance)
        logarithms = np.sum(log_term(total, reference, self.measurement.kind))
        return super()._deviance(left, variance) + float(logarithms)

    def _for_noise(self, u: Array) -> tuple[Array, Array]:
        squared = (
            np.abs(self._left(self._residual(self.model.response(u[None])[0]), np.ones_like(self._amplitude))) ** 2
        )
        counts = self._member.sum(axis=1)
        return self._amplitude, squared * self._spread(counts / np.maximum(counts - 1, 1))[:, None]

    def _whitened_noise(self, variance: Array, slopes: Array) -> Array:
        """Rows of J (m, k) in which the levels of the noise show.

        With M the part that W keeps and A = diag(∂V / V), the information is n/2 tr(M A M A').
        """
        if not slopes.shape[-1]:
            return np.empty((0, 0))
        rows = []
        for group in self._groups:
            weight = 1 / np.sqrt(variance[group]).T  # (n_channel, n_run)
            weight /= np.linalg.norm(weight, axis=1, keepdims=True)
            left = np.eye(len(group)) - weight[:, :, None] * weight[:, None, :]
            relative = slopes[group] / variance[group][..., None]  # (n_run, n_channel, k)
            rows.append(np.einsum("cij,jck,cjl->cilk", left, relative, left).reshape(-1, slopes.shape[-1]))
        return np.asarray(np.sqrt(self.measurement.dimensions / 2) * np.concatenate(rows))

    @cached_property
    def _amplitude(self) -> Array:
        return np.abs(self.measurement.values)

    @cached_property
    def _groups(self) -> list[Array]:
        """Rows of equal speed."""
        return [np.asarray(group) for group in equal_speeds(self.measurement.speed, COMMON_SPEED)]

    @cached_property
    def _member(self) -> Array:
        """Which rows are of which group (n_group, n_speed): 1 or 0."""
        return np.array([np.isin(np.arange(len(self.measurement.speed)), group) for group in self._groups], dtype=float)

    def _sum(self, values: NDArray[Number]) -> NDArray[Number]:
        """Sums over the runs (n_group, …)."""
        return np.tensordot(self._member, values, 1).astype(values.dtype)

    def _spread(self, values: NDArray[Number]) -> NDArray[Number]:
        """Values of groups (n_group, …) at their rows (n_speed, …)."""
        return np.tensordot(self._member.T, values, 1).astype(values.dtype)

    def _left(self, values: NDArray[Number], variance: Array) -> NDArray[Number]:
        """Values (n_speed, n_channel, …) less their weighted means over the runs."""
        return values - self._spread(self._sum(values / variance) / self._sum(1 / variance))

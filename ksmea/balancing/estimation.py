"""Unknown weights of a run from its own response.

Their posterior under a flat prior, and their joint region.

The response of the run is predicted from the runs whose weights are known: influence coefficients, and the drift at its time
from what its neighbours in time show of it (kriging). What is left over is the weights' doing.

The unknown weights of a run fit as many complex numbers of it exactly; the residuals of the other numbers show the
spread between runs if the runs with known weights have no residuals to estimate it from.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import ComplexArray, Indices
from ksmea.balancing.fit import COMMON, Fit
from ksmea.errors import SettingError

N_STEP = 4  # each takes the spread and the uncertainty of the coefficients at the weights found before


@dataclass(frozen=True)
class WeightEstimate:
    """Weights (n_unknown,) kg m of a run in `planes` (indices), and their covariance.

    It is the covariance of their complex errors.

    `chi2` is the χ² of the residuals with `n_left` complex degrees of freedom, and `p` its p-value.
    """

    planes: Indices
    weights: ComplexArray
    covariance: ComplexArray
    chi2: float
    n_left: int
    p: float


def estimated(fit: Fit, run: int, planes: Indices) -> WeightEstimate:
    """Weights of a run in some planes if its other weights are known; the run must not be used by the fit.

    Raises `SettingError` if there are more planes than entries."""
    readings, one = fit.readings, np.array([run])
    n_entry = int(np.sum(~readings.is_missing[run]))
    if len(planes) > n_entry:
        raise SettingError(
            f"run {readings.names[run]}: expected at most {n_entry} unknown weights, one for each speed and channel, got"
            f" {len(planes)}; measure at another speed or with another probe"
        )
    solution = fit.solution
    across = fit.covariance(one, solution.runs)
    drift = across @ solution.white
    gain = across @ solution.columns_solved
    own = fit.covariance(one, one) - across @ solution.solve(across.conj().T)
    weights = np.nan_to_num(readings.weights[one])
    weights[0, planes] = 0
    spread = fit.components.spread
    for _ in range(N_STEP):
        load = np.sum(np.abs(weights / fit.influence.scale) ** 2, axis=1) - fit.load[one]
        columns = fit.columns(one, weights)[0] - gain
        covariance = own + fit.components.growth * load[0] * spread
        covariance = covariance + columns @ solution.coefficient_covariance @ columns.conj().T
        effective = fit.influence.effective(weights)
        effective[0, planes] = 0
        without = (fit.influence.bare + effective[0] @ fit.influence.planes) * fit.influence.gain(
            readings.deviation[one]
        )[0]
        seen = np.where(readings.is_missing[run], 0, readings.response[run] - without - drift)
        by = (fit.influence.planes[planes] * fit.influence.gain(readings.deviation[one])).T
        weighted = np.linalg.solve(covariance, by)
        found_covariance = np.linalg.inv(by.conj().T @ weighted)
        found = found_covariance @ (weighted.conj().T @ seen)
        weights[0, planes] = fit.influence.marked(found)
    left = seen - by @ found
    n_left = n_entry - len(planes)
    chi2 = float(np.vdot(left, np.linalg.solve(covariance, left)).real)
    slope = 1 + 3 * fit.influence.growth.real * np.abs(weights[0, planes] / fit.influence.scale) ** 2
    return WeightEstimate(
        planes,
        weights[0, planes],
        np.asarray(found_covariance / np.outer(slope, slope)),
        chi2,
        n_left,
        tail(chi2, n_left, fit.dof),
    )


def tail(chi2: float, n: int, dof: float) -> float:
    """p-value of a sum of n squared complex residuals, each of variance 1.

    `dof` are the degrees of freedom of the covariance."""
    if n <= 0 or dof <= 0:
        return 1.0
    return float(scipy.stats.f.sf(chi2 / n, 2 * n, 2 * dof if np.isfinite(dof) else 1e9))


def polar_interval(value: complex, radius: float) -> tuple[tuple[float, float], tuple[float, float] | None]:
    """Sizes and angles (rad) within a circle around a complex number; no angle where the circle holds 0.

    >>> size, angle = polar_interval(2.0 + 0j, 1.0)
    >>> size, bool(np.allclose(angle, (-np.pi / 6, np.pi / 6)))
    ((1.0, 3.0), True)
    """
    size = abs(value)
    if radius >= size:
        return (0.0, size + radius), None
    half, middle = float(np.arcsin(radius / size)), float(np.angle(value))
    return (size - radius, size + radius), (middle - half, middle + half)


def scaled_by_unknown_runs(fit: Fit) -> Fit:
    """A fit whose covariance is not free, with one factor on it from what all its runs leave.

    Entries count as uncorrelated.
    """
    data = fit.readings
    found = [
        estimated(fit, int(run), np.flatnonzero(np.isnan(data.weights[run])))
        for run in np.setdiff1d(np.arange(len(data.names)), data.is_known)
    ]
    n_left = sum(each.n_left for each in found)
    if fit.is_free or n_left == 0:
        return fit
    own = fit.dof if fit.method == COMMON else 0.0
    factor = (own + sum(each.chi2 for each in found)) / (own + n_left)
    components = dataclasses.replace(fit.components, spread=factor * fit.components.spread)
    return dataclasses.replace(fit, components=components, method=COMMON, dof=own + n_left)

"""Misfits: runs whose weights contradict their marks, and entries that contradict their neighbours.

All p values are of a test alone; `level / number of tests` is what they are to be compared with (Bonferroni).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.balancing.fit import NO, Asked, Fit, fitted
from ksmea.balancing.readings import Readings

N_ROUND = 6  # fits, and so many runs that may be left out, each fit without those that did not fit the one before
TAIL_DOF = 4.0  # complex; an assumption: entries scatter as Student's t with 8 degrees of freedom, not as a normal
DEGREE = 2  # of the polynomial over speed that neighbouring speeds are compared by
FEWEST_SPEEDS = DEGREE + 3  # complex numbers: one speed left out, and one degree of freedom still there


@dataclass(frozen=True)
class Prediction:
    """Errors of the response of each run used by a fit, predicted from the other runs.

    Residuals (n_run, n_entry) m at its known weights, and their covariances (n_run, n_entry, n_entry) m²."""

    residual: ComplexArray
    covariance: ComplexArray

    @property
    def chi2(self) -> Array:
        solved = np.linalg.solve(self.covariance, self.residual[:, :, None])[:, :, 0]
        return np.asarray(np.einsum("ie,ie->i", self.residual.conj(), solved).real)

    @property
    def entry(self) -> ComplexArray:
        """Residual of each entry next to the other entries of its run, each of variance 1, (n_run, n_entry)."""
        inverse = np.linalg.inv(self.covariance)
        solved = np.einsum("ief,if->ie", inverse, self.residual)
        return np.asarray(solved / np.sqrt(np.einsum("iee->ie", inverse).real))


def predicted(fit: Fit) -> Prediction:
    """Prediction of each run from all others: Q_ii⁻¹ (Q y)_i and Q_ii⁻¹.

    Q is the inverse covariance of the residuals of the coefficients.

    Dubrule, Math. Geology 15 (1983) 687–699, has the identity for kriging.
    """
    solution = fit.solution
    n_run, n_entry = len(fit.used), fit.readings.response.shape[1]
    own = np.linalg.inv(fit.covariance(fit.used, fit.used))
    solved = solution.columns_solved
    own = own - solved @ solution.coefficient_covariance @ solved.conj().T
    blocks = own.reshape(n_run, n_entry, n_run, n_entry)[np.arange(n_run), :, np.arange(n_run)]
    covariance = np.linalg.inv(blocks)
    white = solution.white.reshape(n_run, n_entry, 1)
    return Prediction((covariance @ white)[:, :, 0], np.asarray(covariance))


def fitted_without_misfits(
    readings: Readings, known: Indices, level: float, asked: Asked
) -> tuple[Fit, dict[int, float]]:
    """Fit to the runs whose known weights explain their response, and p of each other run by its index.

    The first run to go is the worst of a fit without drift. Each further fit judges all runs again, takes the worst
    away and gives back the runs that fit now. Runs go one at a time: runs that drifted together are the drift, and
    several at once would take it away. No run is left out if covariances are not estimated from the runs themselves."""
    fit = fitted(readings, known, Asked(NO, NO, NO))
    if not fit.is_free:
        return fitted(readings, known, asked), {}
    out: dict[int, float] = {}
    for number in range(N_ROUND):
        before, p = set(out), dict(zip(known.tolist(), run_p(fit, known).tolist()))
        unlikely = [run for run in sorted(p, key=lambda run: p[run]) if p[run] < level / len(known)]
        worst = [run for run in unlikely if run not in before][:1]
        out = {run: p[run] for run in unlikely if run in {*before, *worst}}
        if number and set(out) == before:
            break
        fit = fitted(readings, np.setdiff1d(known, list(out)), asked)
    return fit, out


def run_p(fit: Fit, runs: Indices) -> Array:
    """p-value of each run's distance from the response predicted by the others at its known weights.

    Distances of the runs used are the reference. Runs scatter more than a normal distribution; the logarithms of
    their χ² are nearly normal, and their median and median deviation are insensitive to a few wrong runs."""
    n_entry = np.sum(~fit.readings.is_missing, axis=1)
    used = dict(zip(fit.used.tolist(), np.log(predicted(fit).chi2 / n_entry[fit.used])))
    log = np.array([used[run] if run in used else np.log(_chi2(fit, run) / n_entry[run]) for run in runs.tolist()])
    reference = np.array(list(used.values()))
    deviation = float(scipy.stats.median_abs_deviation(reference, scale="normal"))
    return np.asarray(scipy.stats.norm.sf((log - np.median(reference)) / deviation))


def _chi2(fit: Fit, run: int) -> float:
    """χ² of a run with known weights that the fit does not use."""
    one, solution = np.array([run]), fit.solution
    across = fit.covariance(one, solution.runs)
    left = fit.residual(one)[0] - across @ solution.white
    columns = fit.columns(one, fit.readings.weights[one])[0] - across @ solution.columns_solved
    covariance = fit.covariance(one, one) - across @ solution.solve(across.conj().T)
    covariance = covariance + columns @ solution.coefficient_covariance @ columns.conj().T
    return float(np.vdot(left, np.linalg.solve(covariance, left)).real)


@dataclass(frozen=True)
class EntryMisfit:
    """An entry that is unlike its neighbours, which have it at `expected` (m).

    `n_test` entries were tested.
    """

    run: int
    entry: int
    p: float
    n_test: int
    measured: complex
    expected: complex


def misfits_beside_channels(fit: Fit, level: float) -> list[EntryMisfit]:
    """Entries that do not fit the other speeds and channels of their run."""
    if not fit.is_free:
        return []
    prediction = predicted(fit)
    ratio = prediction.entry
    sd = 1 / np.sqrt(np.einsum("iee->ie", np.linalg.inv(prediction.covariance)).real)
    p = scipy.stats.f.sf(np.abs(ratio) ** 2, 2, 2 * min(fit.dof, TAIL_DOF))
    measured = fit.readings.response[fit.used]
    p[fit.readings.is_missing[fit.used]] = 1.0
    return [
        EntryMisfit(
            int(fit.used[i]), int(e), float(p[i, e]), p.size, measured[i, e], measured[i, e] - ratio[i, e] * sd[i, e]
        )
        for i, e in zip(*np.nonzero(p < level / p.size))
    ]


def misfits_beside_speeds(readings: Readings, level: float) -> list[EntryMisfit]:
    """Entries that do not fit the other speeds of their run and channel.

    The one most unlike is left out as long as it is unlikely.

    Each response over speed is a polynomial of low degree; externally studentised residuals are F distributed, the
    variance pooled over the runs of a channel. Cook & Weisberg, *Residuals and Influence in Regression*, 1982, ch. 2.
    """
    n_run, n_speed, n_channel = len(readings.names), len(readings.speed), len(readings.channels)
    if n_speed < FEWEST_SPEEDS:
        return []
    values = readings.response.reshape(n_run, n_speed, n_channel)
    keep = ~readings.is_missing.reshape(values.shape)
    found: list[EntryMisfit] = []
    while worst := _most_unlike(values, keep, readings.speed, level):
        run, speed, channel = np.unravel_index(worst.entry, values.shape)
        keep[run, speed, channel] = False
        found.append(dataclasses.replace(worst, run=int(run), entry=int(speed * n_channel + channel)))
    return found


def _most_unlike(values: ComplexArray, keep: Mask, speed: Array, level: float) -> EntryMisfit | None:
    """Entry, by its flat index, with the lowest p, if that is below the level over the number of tests."""
    best: EntryMisfit | None = None
    n_run, _, n_channel = values.shape
    n_test = values.size
    scaled = (speed - speed.mean()) / np.ptp(speed)
    for channel in range(n_channel):
        squares, dof, tests = 0.0, 0, []
        for run in range(n_run):
            kept = np.flatnonzero(keep[run, :, channel])
            if len(kept) < FEWEST_SPEEDS - 1:
                continue
            basis = np.vander(scaled[kept], DEGREE + 1)
            hat = basis @ np.linalg.pinv(basis)
            left = values[run, kept, channel] - hat @ values[run, kept, channel]
            deleted = left / (1 - np.diag(hat))  # measured - expected of the others
            squares += float(np.sum(np.abs(left) ** 2))
            dof += len(kept) - DEGREE - 1
            tests += list(zip([run] * len(kept), kept, np.abs(left) ** 2 / (1 - np.diag(hat)), deleted))
        for run, index, square, deleted in tests:
            if dof < 2 or squares - square <= 0:
                continue
            p = float(scipy.stats.f.sf(square / ((squares - square) / (dof - 1)), 2, 2 * (dof - 1)))
            if p < level / n_test and (best is None or p < best.p):
                measured = complex(values[run, index, channel])
                flat = int(np.ravel_multi_index((run, index, channel), values.shape))
                best = EntryMisfit(run, flat, p, n_test, measured, measured - complex(deleted))
    return best

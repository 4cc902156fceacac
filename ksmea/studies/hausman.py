"""Hausman test of a campaign: the joint fit of its runs against the fit of their differences.

If something alike in all runs is not in the model, the two fits disagree. Under a right model both estimates are
consistent and the joint one is efficient, so that the change Δ between them has the covariance C_d − C_j and
Δ* (C_d − C_j)⁻¹ Δ is χ² (J. A. Hausman, Econometrica 46 (1978) 1251–1271, doi 10.2307/1913827). With w the directions
in which differences have a share λ of the joint information I, I_d w = λ I w and w* I w = 1, that is
Σ (w* I Δ)² / (1/λ − 1) over the directions that they determine. Both fits use the noise of the differences: the noise
of the joint fit contains its misfit. The module also compares the noise shown by repeats.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import scipy
from scipy import linalg

from ksmea.arrays import Array, Indices
from ksmea.fits.repeats import repeats
from ksmea.fits.starts import EDGE
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.difference_likelihood import DifferenceLikelihood
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.campaign import Campaign
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import compared_speeds
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from ksmea.problem.parameters import PHASE_ORIGIN
from ksmea.records.campaign import BothWaysRecord, MovedRecord, RepeatsRecord

SHARES = (0.01, 0.98)  # of the information: below, differences tell next to nothing; above, they are all there is
MOVED = 3.0  # standard errors from which an unknown is named
DISAGREE = 0.01  # p below which any is
MOSTLY = 0.5  # of an unknown's variance in directions that differences tell, for it to be compared


def both_ways(case: Case, x: Array) -> BothWaysRecord | None:
    """Both fits of a campaign fitted jointly at x (d,) SI, or None if no comparison is possible.

    Differences between runs determine nothing for amplitudes, other speeds in each run, equal weights, or no noise. The
    comparison also needs two runs, data that are not differences already, fits that succeed, and residuals enough."""
    problem, measurement = case.problem, case.measurement
    campaign = measurement.campaign
    if campaign is None or len(campaign.runs) < 2 or measurement.is_amplitude or campaign.reference:
        return None
    if measurement.noise is not None and measurement.noise.is_absent:
        return None
    compared = compared_speeds(measurement.speed, measurement.rows)
    in_differences = campaign.part(compared)
    if not all(run.n_speed for run in in_differences.runs):
        return None
    by_reference = dataclasses.replace(in_differences, reference=campaign.runs[0].name)
    part = dataclasses.replace(measurement.part(compared), campaign=by_reference)
    start, d = np.clip(problem.parameters.to_cube(x), 0.0, 1.0), len(x)
    try:
        differing = DifferenceLikelihood(Model(aligned(problem, part)), part)
        if differing.n_residual <= len(differing.lower):
            return None
        by_differences = nearest_maximum(differing, start)
        known = dataclasses.replace(measurement, noise=differing.noise_of(by_differences.theta, measurement))
        joint = nearest_maximum(Likelihood(Model(problem), known if measurement.noise is None else measurement), start)
        free = _within_limits(by_differences.theta[:d], joint.theta[:d])
        block = np.ix_(free, free)
        shares, directions = linalg.eigh(by_differences.information[block], joint.information[block])
    except (np.linalg.LinAlgError, ArithmeticError):
        return None
    testable = (shares > SHARES[0]) & (shares < SHARES[1])
    if not np.any(testable):
        return None
    variance = 1 / shares[testable] - 1
    along = directions[:, testable].T @ joint.information[block] @ (by_differences.theta[:d] - joint.theta[:d])[free]
    p = float(scipy.stats.chi2.sf(np.sum(along**2 / variance), np.sum(testable)))
    moved = directions[:, testable] @ along / np.sqrt(directions[:, testable] ** 2 @ variance)  # in standard errors
    is_compared = np.sum(directions[:, testable] ** 2, axis=1) > MOSTLY * np.sum(directions**2, axis=1)
    named = [at for at in np.argsort(-np.abs(moved)) if is_compared[at] and abs(moved[at]) > MOVED and p < DISAGREE]
    values = problem.parameters.in_units(problem.parameters.to_si(by_differences.theta[:d]))[free]
    items = [problem.parameters.items[index] for index in free]
    movements = (MovedRecord(items[at].name, items[at].unit, float(values[at]), float(moved[at])) for at in named)
    return BothWaysRecord(p, int(np.sum(testable)), tuple(movements), _shows_machine(campaign))


def _within_limits(*fits: Array) -> Indices:
    """Unknowns (n_free,) that end at no search limit in any of these fits (d,) of the unit cube.

    A value at a limit is not an estimate."""
    return np.flatnonzero(np.all([(u > EDGE) & (u < 1 - EDGE) for u in fits], axis=0))


def _shows_machine(campaign: Campaign) -> bool:
    """Whether the model of the machine says that runs differ.

    They differ by their weights, or by unknowns of their own.
    """
    return any(run.all_weights for run in campaign.runs) or any(name != PHASE_ORIGIN for name in campaign.own)


SLIGHT = 0.1  # a part of the noise below this part of the other everywhere does not show


def repeats_of(measurement: Measurement) -> RepeatsRecord | None:
    """None of data without repeats, or with too few."""
    found = repeats(measurement)
    if found is None:
        return None
    [(relative, floor)] = found.noise.levels
    smallest, largest = found.amplitude
    return RepeatsRecord(
        relative=0.0 if relative * largest < SLIGHT * floor else relative,
        floor=0.0 if floor < SLIGHT * relative * smallest else floor,
        degrees=found.degrees,
        are_runs=found.are_runs,
        between=found.between,
        standing_out=found.standing_out,
    )

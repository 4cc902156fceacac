"""Starts of fits of a baseline model and its effects: points of the unit cube with small misfit.

The misfit, which has wide basins, is the mean |ln ratio| of amplitudes (`ksmea.numerics.screening`) after the common
factor of all unbalance and the common phase, which act on all data at 1X alike, have been set to what suits these
best. At other harmonics, at which a model may have no response at all, the median amplitude of the data is added to
both amplitudes, so that what is far below it counts alike. It costs a response instead of a fit, and is computed for batches of
points all over the box, and around the best of these for clouds of points that close in on them.

If small amplitudes have another cause than the model, such as a runout, that misfit is small far from the resonances
of the data. `screened_both_ways` therefore also ranks points by the modal assurance criterion, in which large
amplitudes weigh most: the part of the data, as a vector, that lies across the response's own (R. J. Allemang, Sound
and Vibration 37 (8), 2003, 14–21).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.measurement import Measurement
from ksmea.numerics.screening import Screened, joined, log_ratio, mean_log_misfit, ranked, sobol
from ksmea.problem.case import Case
from ksmea.problem.differences_problem import as_searched
from ksmea.problem.parameters import PHASE_ORIGIN
from ksmea.problem.problem import Problem
from ksmea.units import TURN

MAX_VALUES = 2**21  # complex numbers of a batch of responses, which limits the memory
EDGE = 1e-9  # of the unit cube: an unknown so near to its limit lies on it
CROWDING = 1.5  # power by which scanned values crowd towards 0
PER_VALUE = 8  # points that each scanned value of an effect contributes
CLOUDS = (0.05, 0.02, 0.01)  # standard deviations of the clouds, in parts of the unit cube
FEWEST_CLOUDS = 5  # of the narrower widths, each of which has half as many as the one before
CLOUD_POINTS = 32  # points of each cloud


def screened(case: Case, points: Array) -> Screened:
    """Points (n, d) of the unit cube in order of their misfit.

    The common factor of all unbalance and the common phase are set to suit the data.
    """
    [found] = _ranked_by([_by_ratio], case, points)
    return found


def screened_both_ways(case: Case, points: Array) -> tuple[Screened, Screened]:
    """Points of `screened`, and points by the part of the data at 1X not a multiple of the response."""
    by_ratio, by_shape = _ranked_by([_by_ratio, _by_shape], case.for_screening(), points)
    return by_ratio, by_shape


# Aligns points, given as values (n, d) SI, which it may change, and their responses, with the data: points and misfits.
Way = Callable[[Case, Array, ComplexArray], tuple[Array, Array]]


def _ranked_by(ways: Sequence[Way], case: Case, points: Array) -> list[Screened]:
    case = as_searched(case)
    problem, n_chunk = case.problem, max(1, MAX_VALUES // case.measurement.values.size)
    parts = []
    for start in range(0, len(points), n_chunk):
        x = problem.parameters.to_si(points[start : start + n_chunk])
        response = problem.response(x)
        parts.append([way(case, x.copy(), response) for way in ways])
    return [ranked(*(np.concatenate(each) for each in zip(*of_way))) for of_way in zip(*parts)]


def scanned(case: Case, points: Array, values: Array, n_cloud: int) -> Screened:
    """The best points of an extended problem.

    Screenings of the baseline model's points (n, d) at values (m, e) of the effects' unknowns, and clouds around the best
    `n_cloud` of them.
    """
    return refined_by_clouds(case, screened_at(case, points, values), n_cloud)


def screened_at(case: Case, points: Array, values: Array) -> Screened:
    """Best of the baseline model's points (n, d) at each of the values (m, e) of effects' unknowns.

    All are in the unit cube.
    """
    best = []
    for value in values:
        found = screened(case, np.hstack([points, np.tile(value, (len(points), 1))]))
        best.append(found.best(PER_VALUE))
    return joined(*best)


def refined_by_clouds(case: Case, found: Screened, n_cloud: int) -> Screened:
    """Clouds of points around the best ones, `n_cloud` at most, narrower around fewer and fewer.

    Unknowns that are costly to change take few values, equal ones in all clouds of a width; numbers known to a
    tolerance stay as they are.
    """
    d = found.points.shape[1]
    cloud = scipy.stats.norm.ppf(sobol(CLOUD_POINTS, d) + 0.5 / CLOUD_POINTS)
    known = case.problem.parameters.with_prior
    costly = list(np.setdiff1d(case.problem.costly, known))
    cloud[:, known] = 0.0
    cloud[:, costly] = np.clip(np.rint(cloud[:, costly]), -1, 1)
    for narrowed, width in enumerate(CLOUDS):
        centres = found.apart(min(n_cloud, max(FEWEST_CLOUDS, n_cloud >> narrowed)), width / 2)
        points = centres.points[:, None] + width * cloud
        points[..., costly] = width * np.rint(points[..., costly] / width)
        points = np.clip(points, 0.0, 1.0).reshape(-1, d)
        found = joined(centres, screened(case, points))
    return found


def scan_values(zero: Array, n_value: int) -> Array:
    """Values (n, e) of effects' unknowns in the unit cube to start from.

    About `n_value` for one unknown and twice as many for each more, spread over their limits and denser towards 0,
    which lies at `zero` (e,).
    """
    e = len(zero)
    n = 2 ** ((n_value - 1).bit_length() + e - 1)
    spread = sobol(n, e) + 0.5 / n  # in (0, 1)
    at_lower, at_upper = zero < EDGE, zero > 1 - EDGE
    reach = np.where(at_lower, spread, np.where(at_upper, -spread, 2 * spread - 1))
    room = np.where(reach > 0, 1 - zero, zero)
    return np.asarray(zero + np.sign(reach) * room * np.abs(reach) ** CROWDING)


def _by_ratio(case: Case, x: Array, response: ComplexArray) -> tuple[Array, Array]:
    """Points (n, d) aligned with the data, and their misfits (n,)."""
    problem, measurement = case.problem, case.measurement
    amplitude, measured = np.abs(response), np.abs(measurement.values)
    nonzero = measured != 0
    at_1x = [item.is_1x for item in measurement.channels]
    quiet, is_1x = _quiet(measurement), np.broadcast_to(at_1x, measured.shape)[nonzero]
    ratio = log_ratio((amplitude + quiet)[:, nonzero], (measured + quiet)[nonzero])
    shift = np.log(scale_unbalance(problem, x, np.exp(-np.median(ratio[:, is_1x], axis=1))))
    if turning := turning_angles(case):
        forward = np.divide(
            measurement.values, measured, out=np.zeros_like(measurement.values), where=nonzero & (quiet == 0)
        )
        behind = np.divide(response, amplitude, out=np.zeros_like(response), where=amplitude > 0)
        turn(x, turning, np.angle(np.einsum("nsc,sc->n", np.conj(behind), forward)))
    ratio[:, is_1x] += shift[:, None]
    return np.clip(problem.parameters.to_cube(x), 0.0, 1.0), mean_log_misfit(ratio)


def _by_shape(case: Case, x: Array, response: ComplexArray) -> tuple[Array, Array]:
    """Points (n, d) with the scale and phase that suit the data best, and 1 − MAC (n,)."""
    problem, measurement = case.problem, case.measurement
    at_1x = [item.is_1x for item in measurement.channels]
    seen, measured = measurement.seen(response)[..., at_1x], measurement.values[:, at_1x]
    across = (np.conj(seen) * measured).sum(axis=(1, 2))
    size = np.maximum((np.abs(seen) ** 2).sum(axis=(1, 2)), np.finfo(float).tiny)
    scale_unbalance(problem, x, np.maximum(np.abs(across) / size, np.finfo(float).tiny))
    if turning := turning_angles(case):
        turn(x, turning, np.angle(across))
    misfit = 1 - np.abs(across) ** 2 / (size * np.sum(np.abs(measured) ** 2))
    return np.clip(problem.parameters.to_cube(x), 0.0, 1.0), np.where(np.isfinite(misfit), misfit, np.inf)


def scale_unbalance(problem: Problem, x: Array, factor: Array) -> Array:
    """All unbalance in x (n, d) SI, in place, by one factor (n,) as far as the limits of each admit.

    The factor that it is.
    """
    parameters = problem.parameters
    masses = [index for index, parameter in enumerate(parameters) if parameter.is_unbalance]
    if not masses:
        return np.ones(len(x))
    with np.errstate(divide="ignore"):
        factor = np.clip(
            factor,
            np.max(parameters.lower[masses] / x[:, masses], axis=1),
            np.min(parameters.upper[masses] / x[:, masses], axis=1),
        )
    x[:, masses] *= factor[:, None]
    return factor


def turn(x: Array, turning: list[int], angle: Array) -> None:
    """The angles `turning` in x (n, d) SI, in place, by angles (n,)."""
    x[:, turning] = (x[:, turning] + angle[:, None] + TURN / 2) % TURN - TURN / 2


def _quiet(measurement: Measurement) -> Array:
    """Median amplitude at the harmonic of each channel (n_channel,), m; 0 for 1X."""
    harmonics = np.array([channel.harmonic for channel in measurement.channels])
    medians = {each: np.median(np.abs(measurement.values[:, harmonics == each])) for each in set(harmonics.tolist())}
    return np.array([0.0 if each == 1 else float(medians[each]) for each in harmonics.tolist()])


def turning_angles(case: Case) -> list[int]:
    """The indices of the angles that turn all data alike.

    The phase origin, or else the phases of all unbalance.
    """
    if case.measurement.is_amplitude:
        return []
    names = case.problem.parameters.names
    if PHASE_ORIGIN in names:
        return [names.index(PHASE_ORIGIN)]
    return [index for index, parameter in enumerate(case.problem.parameters) if parameter.is_full_turn]

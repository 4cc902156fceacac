"""Where fits should start: points of the unit cube ranked by a misfit with wide basins.

The sharp peaks of a lightly damped rotor give the likelihood many narrow maxima. The mean |ln ratio| of amplitudes, after
the common factor of all unbalance and the common phase, which act on all data alike, have been set to what suits the
data best, falls towards the right one from much further away, and costs a response instead of a fit: it is computed for
batches of points all over the box, and around the best of these for clouds of points that close in on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, qmc

from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.measurement import Measurement
from ksmea.parameters import PHASE_ORIGIN
from ksmea.units import TURN

MOST_VALUES = 2**21  # complex numbers of a batch of responses, which bounds the memory
EDGE = 1e-9  # of the unit cube: an unknown so near to its bound lies on it
CROWDING = 1.5  # power by which scanned values crowd towards 0
PER_VALUE = 8  # points that each scanned value of an effect contributes
CLOUDS = (0.05, 0.02, 0.01)  # standard deviations of the clouds, in parts of the unit cube
CLOUD_CENTRES = 48  # best points that a cloud is laid around
CLOUD_POINTS = 32  # points of each cloud


@dataclass(frozen=True)
class Screened:
    """Points (n, d) of the unit cube and their misfits (n,), best first."""

    points: Array
    misfits: Array

    def apart(self, count: int, distance: float) -> Screened:
        """The best points, `count` at most, that are not nearer than `distance` to a better one."""
        chosen: list[int] = []
        for index, point in enumerate(self.points):
            if not chosen or np.linalg.norm(self.points[chosen] - point, axis=1).min() >= distance:
                chosen.append(index)
                if len(chosen) == count:
                    break
        return Screened(self.points[chosen], self.misfits[chosen])

    def thinned(self, count: int) -> Array:
        """Points (count, d) at most: the best, and fewer and fewer of those behind them."""
        last = len(self.points) - 1
        return self.points[np.unique(np.rint(last * np.linspace(0, 1, count) ** 2).astype(int))]


def screened(problem: Problem, measurement: Measurement, points: Array) -> Screened:
    """Points (n, d) of the unit cube by their misfit, the common factor of all unbalance and the common phase set to what
    suits the data."""
    n_chunk = max(1, MOST_VALUES // measurement.values.size)
    parts = [
        _aligned(problem, measurement, points[start : start + n_chunk]) for start in range(0, len(points), n_chunk)
    ]
    return _ranked([part[0] for part in parts], [part[1] for part in parts])


def scanned(problem: Problem, measurement: Measurement, points: Array, zero: Array, n_value: int) -> Screened:
    """The best points of an extended problem: screenings of the plain model's points (n, d) at values of the effects'
    unknowns all over their bounds, and clouds around the best of them. `zero` (e,) is where there is no effect."""
    best = []
    for value in scan_values(zero, n_value):
        found = screened(problem, measurement, np.hstack([points, np.tile(value, (len(points), 1))]))
        best.append(Screened(found.points[:PER_VALUE], found.misfits[:PER_VALUE]))
    return closed_in(problem, measurement, _ranked([each.points for each in best], [each.misfits for each in best]))


def closed_in(problem: Problem, measurement: Measurement, found: Screened) -> Screened:
    """Clouds of points around the best ones, narrower and narrower; unknowns that are costly to change take few values."""
    d = found.points.shape[1]
    cloud = norm.ppf(qmc.Sobol(d, scramble=False).random(CLOUD_POINTS) + 0.5 / CLOUD_POINTS)
    costly = list(problem.costly)
    cloud[:, costly] = np.clip(np.rint(cloud[:, costly]), -1, 1)
    for width in CLOUDS:
        centres = found.apart(CLOUD_CENTRES, width / 2)
        points = np.clip(centres.points[:, None] + width * cloud, 0.0, 1.0).reshape(-1, d)
        around = screened(problem, measurement, points)
        found = _ranked([centres.points, around.points], [centres.misfits, around.misfits])
    return found


def scan_values(zero: Array, n_value: int) -> Array:
    """Values (n, e) of effects' unknowns in the unit cube to start from: about `n_value` for one unknown and twice as many
    for each more, spread over their bounds and denser towards 0, which lies at `zero` (e,)."""
    e = len(zero)
    exponent = (n_value - 1).bit_length() + e - 1
    spread = qmc.Sobol(e, scramble=False).random_base2(exponent) + 0.5 / 2**exponent  # in (0, 1)
    at_lower, at_upper = zero < EDGE, zero > 1 - EDGE
    reach = np.where(at_lower, spread, np.where(at_upper, -spread, 2 * spread - 1))
    room = np.where(reach > 0, 1 - zero, zero)
    return zero + np.sign(reach) * room * np.abs(reach) ** CROWDING


def _ranked(points: Sequence[Array], misfits: Sequence[Array]) -> Screened:
    together = np.concatenate(misfits)
    order = np.argsort(together, kind="stable")
    return Screened(np.concatenate(points)[order], together[order])


def _aligned(problem: Problem, measurement: Measurement, points: Array) -> tuple[Array, Array]:
    """Points (n, d) aligned with the data, and their misfits (n,)."""
    parameters = problem.parameters
    x = parameters.to_si(points)
    response = problem.response(x)
    measured = measurement.values
    seen = np.abs(measured) > 0
    with np.errstate(divide="ignore"):
        ratio = np.log(np.abs(measured[seen])) - np.log(np.abs(response[:, seen]))
    shift = np.zeros(len(points))
    masses = [index for index, parameter in enumerate(parameters) if parameter.is_unbalance]
    if masses:  # all by one factor, as far as the bounds of each admit
        factor = np.exp(np.median(ratio, axis=1))
        with np.errstate(divide="ignore"):
            factor = np.clip(
                factor,
                np.max(parameters.lower[masses] / x[:, masses], axis=1),
                np.min(parameters.upper[masses] / x[:, masses], axis=1),
            )
        x[:, masses] *= factor[:, None]
        shift = np.log(factor)
    if turning := _turning(problem, measurement):
        with np.errstate(invalid="ignore"):
            aligned = np.conj(response / np.abs(response)) * (measured / np.maximum(np.abs(measured), 1e-300))
        turn = np.angle(np.nan_to_num(aligned).sum(axis=(1, 2)))
        x[:, turning] = (x[:, turning] + turn[:, None] + TURN / 2) % TURN - TURN / 2
    return np.clip(parameters.to_cube(x), 0.0, 1.0), np.mean(np.abs(ratio - shift[:, None]), axis=1)


def _turning(problem: Problem, measurement: Measurement) -> list[int]:
    """The places of the angles that turn all data alike: the phase origin, or else the phases of all unbalance."""
    if measurement.is_amplitude:
        return []
    names = problem.parameters.names
    if PHASE_ORIGIN in names:
        return [names.index(PHASE_ORIGIN)]
    return [index for index, parameter in enumerate(problem.parameters) if parameter.is_full_turn]

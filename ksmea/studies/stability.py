"""Stability threshold of the model that a study found, with an interval.

The interval comes from the interval of the growth rate by the delta method: the covariance of the estimates is the
inverse of the Fisher information, to which the limits of the search add the information of a value drawn evenly
between them. Steps of one standard deviation along its principal directions change the growth rate at each speed,
and their squares add up. The ends are the lowest speeds at which the upper and the lower end of the growth rate are
above 0.
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from ksmea.arrays import Array
from ksmea.inference.cramer_rao import Identifiability, identifiability
from ksmea.measurement.noise import Noise
from ksmea.problem.problem import Problem
from ksmea.records.estimate import StabilityRecord
from ksmea.records.record import finite
from ksmea.rotordynamics.stability import scanned_speeds

SEARCHED = 1.5  # times the highest measured speed
RANGE_INFORMATION = 12.0  # 1 / variance of a value drawn evenly from 0 to 1


def stability_of(
    problem: Problem,
    x: Array,
    noise: Noise | None,
    kind: str,
    *,
    noise_known: bool = True,
    level: float = 0.95,
    information: Identifiability | None = None,
) -> StabilityRecord | None:
    """The stability threshold at values x (d,) SI that data of a kind with this noise were fitted by.

    An interval only where there is noise. None where the problem cannot tell. `information` of such data at x is
    computed if it is not given.
    """
    if not problem.knows_stability:
        return None
    measured = float(np.max(problem.speed))
    threshold = low = high = problem.stability_threshold(x, SEARCHED * measured)
    if noise is not None and not noise.is_absent:
        speed = scanned_speeds(SEARCHED * measured)
        rate = problem.growth_rate(x, speed)
        fisher = _information(problem, x, noise, kind, noise_known) if information is None else information.information
        reach = NormalDist().inv_cdf((1 + level) / 2) * _standard_deviation(problem, x, speed, fisher)
        low, high = min(threshold, _onset(speed, rate + reach)), max(threshold, _onset(speed, rate - reach))
    return StabilityRecord(finite(threshold), finite(low), finite(high), level, measured, SEARCHED * measured)


def _information(problem: Problem, x: Array, noise: Noise, kind: str, noise_known: bool) -> Array:
    """Fisher information (d, d), 1/SI²; none where the response has no sensitivity."""
    try:
        return identifiability(problem, x, noise, kind, noise_known=noise_known).information
    except np.linalg.LinAlgError:
        return np.zeros((len(x), len(x)))


def _standard_deviation(problem: Problem, x: Array, speed: Array, information: Array) -> Array:
    """Standard deviation of the growth rate at each speed, (n_speed,) 1/s."""
    parameters = problem.parameters
    in_cube = information * np.outer(parameters.width, parameters.width)
    precision, directions = np.linalg.eigh(in_cube + RANGE_INFORMATION * np.eye(len(x)))
    u = parameters.to_cube(x)
    steps = (directions / np.sqrt(precision)).T
    ends = np.clip(u + np.stack([steps, -steps]), 0.0, 1.0)  # (2, d, d)
    rates = np.array([[problem.growth_rate(parameters.to_si(end), speed) for end in side] for side in ends])
    return np.asarray(np.linalg.norm((rates[0] - rates[1]) / 2, axis=0))


def _onset(speed: Array, rate: Array) -> float:
    """The lowest speed at which a growth rate is above 0, straight between scanned speeds.

    Infinite where it is nowhere.
    """
    above = np.flatnonzero(rate > 0)
    if not len(above):
        return np.inf
    first = int(above[0])
    if first == 0:
        return 0.0
    part = rate[first - 1] / (rate[first - 1] - rate[first])
    return float(speed[first - 1] + part * (speed[first] - speed[first - 1]))

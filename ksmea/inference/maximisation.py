"""Maximisation of a likelihood: from one start, from many, and from one point to the nearest maximum.

A maximum is found by Fisher scoring: Newton's method on the deviance with the Fisher information for its Hessian, in
the box of the unknowns. Of several maxima that differ in the noise alone the highest counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol

import numpy as np
from scipy.linalg.lapack import dgels, dtrtrs  # of few unknowns, in a tenth of the time of numpy's own
from scipy.optimize import lsq_linear

from ksmea.arrays import Array, Indices, Mask
from ksmea.errors import BudgetSpent
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood

MAX_ITERATIONS = 300  # unknowns that nearly compensate each other make long curved valleys
MAX_BEND_RATIO = 0.75  # of a bend to the step that it corrects (Transtrum & Sethna)

# Damping of a step, relative to the information: at first, and where no step leads down any more.
FIRST_DAMPING, LAST_DAMPING = 1e-6, 1e8

PATIENCE = 15  # iterations by whose pace a search is given up that is to come below a ceiling
PROMISED = 10.0  # times what a step promises: the most that an undamped search still comes down, once it has passed SETTLED steps
SETTLED = 3

VALLEY = 0.2  # part by which the deviance in the valley of a maximum may differ from what the parabola around that says

# Two maxima are one where their deviances are as near as this, and the difference is as small to the data (standard errors).
CLOSE, NEAR = 1e-2, 0.5


NOTHING = np.empty(0, dtype=int)


class Maximised(Protocol):
    """Interface of a likelihood for Fisher scoring.

    `ksmea.likelihood.likelihood.Likelihood` explains its members. The first d of θ are the unknowns in the unit cube.
    Values a `period` apart are equal, and the information says nothing beyond `longest_step`."""

    @property
    def d(self) -> int: ...
    @property
    def lower(self) -> Array: ...
    @property
    def upper(self) -> Array: ...
    @property
    def period(self) -> Array: ...
    @property
    def longest_step(self) -> Array: ...
    @property
    def least_gain(self) -> float: ...
    @property
    def linearises_at_once(self) -> bool: ...
    def at(self, theta: Array) -> Point: ...
    def deviance(self, theta: Array) -> float: ...
    def curvature(self, point: Point, step: Array) -> Array: ...
    def other_noise(self, theta: Array) -> list[Array]: ...


def maximise(
    likelihood: Maximised,
    start: Array | Point,
    *,
    fixed: int | Indices = NOTHING,
    max_iterations: int = MAX_ITERATIONS,
    tolerance: float = 1e-7,
    least_gain: float = 0.0,
    ceiling: float = np.inf,
) -> Point:
    """Maximum of the likelihood within the limits, by Fisher scoring from θ (p,) or a known point.

    `fixed` are indices of unknowns that keep their values (for profiles, one). Steps solve the scoring equations in
    the box as bounded least squares, damped as by Levenberg and Marquardt, and once a step has failed they bend with
    the mean (geodesic acceleration). They end

    - if a step is expected to lower the deviance by less than `tolerance`,
    - if it lowers it by less than `least_gain`, or the likelihood's own,
    - after `max_iterations`,
    - if, by their pace or their predicted gain, the deviance would still lie above `ceiling` after these,
    - if the model's budget is spent; a budget that does not admit the first Jacobian raises `BudgetSpent`.

    M. R. Osborne, Fisher's method of scoring, Int. Stat. Rev. 60 (1992) 99–117, doi 10.2307/1403504; M. K. Transtrum
    and J. P. Sethna, Improvements to the Levenberg–Marquardt algorithm for nonlinear least-squares minimization,
    2012, arXiv 1201.5885.
    """
    point = start if isinstance(start, Point) else likelihood.at(np.clip(start, likelihood.lower, likelihood.upper))
    free = ~np.isin(np.arange(len(point.theta)), fixed)
    damping = FIRST_DAMPING
    passed = []
    try:
        for left in range(max_iterations, 0, -1):
            passed.append(point.deviance)
            if not _comes_below(ceiling, passed, left):
                break
            step, expected = _step(likelihood, point, free, damping, point.gradient)
            is_hopeless = len(passed) > SETTLED and point.deviance - PROMISED * expected > ceiling
            if expected < tolerance or (is_hopeless and damping == FIRST_DAMPING):
                break
            if damping > FIRST_DAMPING:
                step = step + _bend(likelihood, point, free, damping, step)
            theta = np.clip(point.theta + step, likelihood.lower, likelihood.upper)
            deviance, found = _tried(likelihood, theta, is_promising=damping == FIRST_DAMPING)
            gain = point.deviance - deviance
            if gain > 0:
                point = likelihood.at(theta) if found is None else found
                damping = max(damping / 10, FIRST_DAMPING)
                if gain < max(least_gain, likelihood.least_gain):
                    break
            else:  # also where the trial is not finite
                damping = max(damping * 10, 1e-3)
                if damping > LAST_DAMPING:
                    break
    except BudgetSpent:
        pass
    return point


def _tried(likelihood: Maximised, theta: Array, *, is_promising: bool) -> tuple[float, Point | None]:
    """Deviance at θ (p,), infinite if no response exists, and the whole point or None.

    The point is computed if it costs little more and a step is likely to lead on from there."""
    if not (is_promising and likelihood.linearises_at_once):
        return likelihood.deviance(theta), None
    try:
        point = likelihood.at(theta)
    except np.linalg.LinAlgError:
        return np.inf, None
    return point.deviance, point


def promised(likelihood: Maximised, point: Point) -> float:
    """By how much the first step from a point is expected to lower the deviance."""
    return _step(likelihood, point, np.full(len(point.theta), True), FIRST_DAMPING, point.gradient)[1]


def _comes_below(ceiling: float, passed: Sequence[float], left: int) -> bool:
    """Whether passed deviances lead below a ceiling in the remaining iterations.

    The pace of the last ones counts.
    """
    if len(passed) <= PATIENCE:
        return True
    pace = (passed[-1 - PATIENCE] - passed[-1]) / PATIENCE
    return passed[-1] - left * pace <= ceiling


def best_maxima(
    likelihood: Maximised,
    starts: Sequence[Array],
    *,
    first_iterations: int,
    survivors: int,
    ceiling: float = np.inf,
    last_iterations: int = MAX_ITERATIONS,
    below: float = np.inf,
    reach: float = np.inf,
) -> list[Point]:
    """Different maxima of the likelihood, highest first.

    A few iterations start from every θ; the best points, `survivors` at most, are continued to the end, by
    `last_iterations` more at most. If all have a deviance above `ceiling`, the best point that was met is returned.
    Searches that do not come `below` a deviance, or within `reach` of the best one before them, are given up on the
    way.
    """
    useful = min(ceiling, below)
    first = [
        maximise(likelihood, theta, max_iterations=first_iterations, tolerance=1e-2, ceiling=useful) for theta in starts
    ]
    best = sorted(first, key=lambda each: each.deviance)[:survivors]
    if best[0].deviance > ceiling:
        return best[:1]
    found: list[Point] = []
    for point in best:
        useful = min([below, *(each.deviance + reach for each in found)])
        again = maximise(likelihood, point.theta, max_iterations=last_iterations, tolerance=1e-4, ceiling=useful)
        found.append(again)
    return distinct(likelihood, found)


def distinct(likelihood: Maximised, maxima: Sequence[Point]) -> list[Point]:
    """Different ones of these maxima, highest first.

    Two are equal if their deviances are, and the data see no difference.
    """
    found: list[Point] = []
    for point in sorted(maxima, key=lambda each: each.deviance):
        if not any(_is_same(likelihood, point, other) for other in found):
            found.append(point)
    return found


def _is_same(likelihood: Maximised, point: Point, other: Point) -> bool:
    if point.deviance - other.deviance > CLOSE:
        return False
    return bool(np.linalg.norm(other.triangle @ _from(likelihood, other, point.theta)) < NEAR)


def _from(likelihood: Maximised, point: Point, theta: Array) -> Array:
    """The shortest way (p,) from a point to θ (p,), whole turns apart."""
    step = theta - point.theta
    turns = np.isfinite(likelihood.period)
    step[turns] -= likelihood.period[turns] * np.rint(step[turns] / likelihood.period[turns])
    return np.asarray(step)


def is_in_valley(likelihood: Maximised, point: Point, theta: Array) -> bool:
    """Whether θ (p,) is taken to lie in the valley of a maximum, so that a search would end there.

    The deviance rises from the maximum to the middle of the way and to θ like the parabola around it. Two evaluations
    cannot prove that; a neighbouring valley would have to rise alike.
    """
    way = _from(likelihood, point, theta)
    for part in (0.5, 1.0):
        step = part * way
        expected = float(point.gradient @ step + np.sum((point.triangle @ step) ** 2))
        rise = likelihood.deviance(point.theta + step) - point.deviance
        if not (rise >= 0 and abs(rise - expected) < VALLEY * max(expected, 1.0)):
            return False
    return True


def _bend(likelihood: Maximised, point: Point, free: Mask, damping: float, step: Array) -> Array:
    """Bend of a step (p,) that keeps it in a curved valley.

    None if it is nearly the step itself, or unknown.
    """
    try:
        curvature = likelihood.curvature(point, step)
    except np.linalg.LinAlgError:  # no finite response there
        return np.zeros_like(step)
    bend, _ = _step(likelihood, point, free, damping, 2 * point.whitened.T @ curvature)
    scale = np.sqrt(np.sum(point.triangle**2, axis=0))
    is_small = np.linalg.norm(scale * bend) <= MAX_BEND_RATIO * np.linalg.norm(scale * step)
    return bend / 2 if is_small else np.zeros_like(step)


def _step(likelihood: Maximised, point: Point, free: Mask, damping: float, gradient: Array) -> tuple[Array, float]:
    """Step (p,) that lowers the quadratic model of the deviance most within the limits, and the decrease."""
    if not np.any(free):
        return np.zeros(len(free)), 0.0
    sensitivity, gradient = point.triangle[:, free], gradient[free]
    scale = np.sqrt(np.sum(sensitivity**2, axis=0))
    scale = np.maximum(scale, 1e-12 * scale.max(initial=np.finfo(float).tiny))
    lower = np.maximum(likelihood.lower - point.theta, -likelihood.longest_step)[free] * scale
    upper = np.minimum(likelihood.upper - point.theta, likelihood.longest_step)[free] * scale
    damped = np.vstack([sensitivity / scale, np.sqrt(damping) * np.eye(len(scale))])
    triangle = np.asarray(np.linalg.qr(damped, mode="r"))
    target = -dtrtrs(triangle, gradient / scale / 2, trans=1)[0]
    scaled = dtrtrs(triangle, target)[0]
    if np.any(scaled < lower) or np.any(scaled > upper):
        scaled = _bounded(triangle, target, scaled, lower, upper)
    expected = float(np.sum(target**2) - np.sum((triangle @ scaled - target) ** 2))
    step = np.zeros(len(point.theta))
    step[free] = scaled / scale
    return step, expected


def _bounded(triangle: Array, target: Array, best: Array, lower: Array, upper: Array) -> Array:
    """Least squares within bounds, from the best values without bounds.

    Values outside stay on their bounds if the gradient confirms it; otherwise active sets are used."""
    values, inside = best, np.full(len(best), True)
    while np.any(outside := inside & ((values < lower) | (values > upper))):
        inside &= ~outside
        values = np.clip(values, lower, upper)
        if np.any(inside):
            rest = target - triangle[:, ~inside] @ values[~inside]
            values[inside] = dgels(triangle[:, inside], rest)[1][: np.count_nonzero(inside)]
    gradient = triangle.T @ (triangle @ values - target)
    if np.all(np.where(values <= lower, gradient >= 0, gradient <= 0)[~inside]):
        return values
    limits = (np.minimum(lower, -1e-300), np.maximum(upper, 1e-300))
    return np.clip(lsq_linear(triangle, target, limits, method="bvls").x, lower, upper)


def with_best_noise(likelihood: Likelihood, best: Point) -> Point:
    """A maximum, or a higher one to which its unknowns lead with another level of the noise.

    Floor or none, the data often allow both.
    """
    with suppress(BudgetSpent):
        for start in likelihood.other_noise(best.theta):
            again = maximise(likelihood, start)
            best = again if again.deviance < best.deviance else best
    return best


def nearest_maximum(likelihood: Likelihood, u: Array) -> Point:
    """The maximum of the likelihood nearest to u (d,).

    Of several maxima that differ in the noise alone, it is the highest.
    """
    return with_best_noise(likelihood, maximise(likelihood, likelihood.start(u)))

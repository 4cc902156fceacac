"""Confidence intervals of identified unknowns from the likelihood of the measurement.

The deviance of the profile likelihood, D(θᵢ) = min over all other unknowns of −2 ln L, rises from its minimum to both
sides. The interval holds all values of θᵢ at which it has risen by less than the critical rise c (`ksmea.inference.critical_rise`),
which is simulated if data are few. If several maxima of the likelihood are as likely, it reaches from the lowest to the highest
such value around any of them.

If the profile is a parabola, its ends lie at θ̂ ± √c · sd with sd from the Fisher information (Gauss–Newton). That is checked at
both ends. If it fails by more than `REGULAR` of the width, or a search limit is in the way, the ends are computed from the profile
itself. A side on which the profile stays below c up to the limit is open.

D. M. Bates and D. G. Watts, Nonlinear Regression Analysis and Its Applications (Wiley, 1988), chapter 6,
doi 10.1002/9780470316757; D. J. Venzon and S. H. Moolgavkar, Appl. Stat. 37 (1988) 87–94, doi 10.2307/2347496.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import brentq

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent
from ksmea.inference.critical_rise import critical_rise
from ksmea.inference.maximisation import Maximised, distinct, maximise
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.noise import Noise
from ksmea.numerics.parallel import ALONE, Workers

REGULAR = 0.05  # the ends of a parabola may miss those of the profile by this part of the half-width
FAR = 8.0  # rise of the deviance from a known point of a profile to where the next is computed; more is too far away
SHORTEST = 2.0**-12  # of a step along a profile, below which it is cut no further
LOWER = 0.01  # a deviance this far below the maximum's is another maximum, from where all begins again
EXACT = 0.01  # of the deviance on a profile, and of its ends in half-widths
MAX_MOVES = 5  # better maxima that are met; at the last one intervals are given up
# Where the response jumps, evaluations of all profiles of an unknown, three times those of an even one, and better maxima: an edge of the
# likelihood would be followed in ever shorter steps, with another maximum behind each of its corners.
MOST_EVALUATIONS, MOST_MOVES = 120, 2


@dataclass(frozen=True)
class Interval:
    """The values of one unknown that the measurement is compatible with, SI.

    `basis` is one of: gauss-newton (a parabola, checked), profile (both ends on the profile likelihood), hull (the
    same around several maxima, not all values between are compatible), lower limit and upper limit (the other side is open), not identifiable (both are), information (a parabola that was not checked).
    """

    low: float  # -inf where open
    high: float  # inf where open
    basis: str


@dataclass(frozen=True)
class Estimate:
    """Maximum of the likelihood nearest to an identified point, with an interval per unknown.

    It is x (d,), SI.

    `point` is the maximum, `noise` the known level, or the estimated one corrected for the degrees of freedom that the
    fit took.
    """

    x: Array
    intervals: tuple[Interval, ...]
    point: Point
    noise: Noise

    @property
    def deviance(self) -> float:
        return self.point.deviance


class _Profile:
    """Root of the rise of the deviance above the lowest along one unknown.

    It is a straight line around the best maximum if the model is linear.

    Each point is maximised from the nearest one that is known, the others following along the tangent at the maximum,
    or where that leads up steeply, out of a curved valley, along the secant of the two nearest known ones. An angle that
    is free to turn has no limits: half a turn to either side is all there is of it.
    """

    def __init__(self, likelihood: _Limited, maximum: Point, index: int, lowest: float) -> None:
        self.sd, self._tangent = _tangent(likelihood, maximum, index)
        self.start = float(maximum.theta[index])
        half_turn = likelihood.period[index] / 2
        self.limits = (self.start - half_turn, self.start + half_turn) if np.isfinite(half_turn) else (0.0, 1.0)
        self._likelihood = likelihood
        self._index = index
        self._lowest = lowest
        self._known: dict[float, Point | None] = {self.start: maximum}  # by value; None where there is no response
        self._settled: set[float] = set()

    def root(self, value: float) -> float:
        """Root √(D − D̂) at this value, minimised over all others; infinite without a response."""
        if value not in self._known:
            theta, higher = self._predicted(value)
            self._known[value] = self._maximised(theta) if np.isfinite(higher) else None
        point = self._known[value]
        return np.inf if point is None else float(np.sqrt(max(point.deviance - self._lowest, 0.0)))

    def settled_root(self, value: float) -> float:
        """√(D − D̂) as by `root`, after other noise levels are tried: data often allow both a floor and none."""
        root, point = self.root(value), self._known[value]
        if point is not None and value not in self._settled:
            self._settled.add(value)
            others = self._likelihood.other_noise(point.theta)
            points = [point, *(self._maximised(theta, point.deviance - EXACT) for theta in others)]
            self._known[value] = min(points, key=lambda each: each.deviance)
            root = self.root(value)
        return root

    def is_near(self, value: float) -> bool:
        """Whether what is known leads to this value without leaving the valley that the profile follows."""
        return value in self._known or self._predicted(value)[1] < FAR

    def _predicted(self, value: float) -> tuple[Array, float]:
        """θ to start from (p,), and its deviance less the deviance of the nearest known point."""
        known = [point for point in self._known.values() if point is not None]
        near, *further = sorted(known, key=lambda point: abs(point.theta[self._index] - value))
        slopes = [self._tangent]
        if further:
            step = further[0].theta - near.theta
            slopes.append(step / step[self._index])
        starts = []
        for slope in slopes:
            longest = self._likelihood.longest_step
            theta = near.theta + np.clip((value - near.theta[self._index]) * slope, -longest, longest)
            theta[self._index] = value
            starts.append((theta, self._likelihood.deviance(self._inside(theta)) - near.deviance))
        return min(starts, key=lambda start: start[1])

    def _inside(self, theta: Array) -> Array:
        return np.clip(theta - _turns(theta, self._likelihood.period), self._likelihood.lower, self._likelihood.upper)

    def _maximised(self, theta: Array, ceiling: float = np.inf) -> Point:
        point = maximise(
            self._likelihood,
            self._inside(theta),
            fixed=self._index,
            tolerance=EXACT,
            least_gain=EXACT,
            ceiling=ceiling,
        )
        if point.deviance < self._lowest - LOWER:
            raise _BetterMaximum(point)
        if self._likelihood.is_spent:  # and this no maximum
            raise _EvaluationsSpent
        return replace(point, theta=point.theta + _turns(theta, self._likelihood.period))


def _turns(theta: Array, period: Array) -> Array:
    """The whole turns (p,) by which angles that are free to turn lie off the middle of their limits."""
    turns = np.zeros_like(theta)
    free = np.isfinite(period)
    turns[free] = period[free] * np.rint((theta[free] - 0.5) / period[free])
    return turns


class _BetterMaximum(Exception):
    def __init__(self, point: Point) -> None:
        self.point = point


class _EvaluationsSpent(BudgetSpent):
    """Raised if the profiles of an unknown need more evaluations than they may take."""


class _Limited:
    """Likelihood for at most `most` evaluations and Jacobians, with `_EvaluationsSpent` beyond."""

    def __init__(self, behind: Maximised, most: float) -> None:
        self._behind, self._left = behind, most
        self.d, self.lower, self.upper, self.period = behind.d, behind.lower, behind.upper, behind.period
        self.longest_step, self.least_gain = behind.longest_step, behind.least_gain
        self.linearises_at_once = behind.linearises_at_once

    @property
    def is_spent(self) -> bool:
        """Whether more evaluations than allowed were requested."""
        return self._left < 0

    def at(self, theta: Array) -> Point:
        return self._counted(1).at(theta)

    def deviance(self, theta: Array) -> float:
        return self._counted(1).deviance(theta)

    def curvature(self, point: Point, step: Array) -> Array:
        return self._counted(2).curvature(point, step)

    def other_noise(self, theta: Array) -> list[Array]:
        return self._counted(1).other_noise(theta)

    def _counted(self, n: int) -> Maximised:
        self._left -= n
        if self.is_spent:
            raise _EvaluationsSpent
        return self._behind


def _jumps(likelihood: Maximised) -> bool:
    """Whether the response jumps, where steps that gain little lead along an edge of the likelihood."""
    return likelihood.least_gain > 0


def estimate(
    likelihood: Likelihood,
    maximum: Point,
    *,
    level: float = 0.95,
    check: bool = True,
    others: Sequence[Point] = (),
    rises: Array | None = None,
    profiled: Iterable[int] | None = None,
    workers: Workers = ALONE,
) -> Estimate:
    """Intervals of confidence `level` around a maximum of the likelihood and `others` that are known.

    They belong to the highest of these and of any that a profile meets. `rises` (n_maximum, d) of the deviance are
    given for each maximum and unknown. Default: the critical rise.

    Without `check`, for unknowns that are not `profiled`, and if a profile cannot be computed, the information at the maximum is
    used, without further evaluations of the model. Workers share the intervals.
    """
    if rises is None:
        rises = np.full((1 + len(others), likelihood.d), critical_rise(likelihood, level, [maximum, *others]))
    intervals = None
    if check:
        maximum, intervals = checked_intervals(likelihood, [maximum, *others], rises, workers, profiled)
    if intervals is None:
        intervals = [information_interval(likelihood, maximum, index, rise) for index, rise in enumerate(rises[0])]
    parameters = likelihood.model.problem.parameters
    return Estimate(
        parameters.to_si(maximum.theta[: likelihood.d]),
        tuple(in_si(interval, parameter.lower, parameter.upper) for interval, parameter in zip(intervals, parameters)),
        maximum,
        _unbiased(likelihood, maximum),
    )


def checked_intervals(
    likelihood: Maximised,
    maxima: Sequence[Point],
    rises: Array,
    workers: Workers = ALONE,
    profiled: Iterable[int] | None = None,
) -> tuple[Point, list[Interval] | None]:
    """Best of some maxima and the intervals in the unit cube.

    In them the deviance of each unknown rises by less than `rises` (n_maximum, d). Empty if profile after profile finds
    a higher maximum, so uneven is the likelihood, or one cannot be computed. A newly found one takes the largest rises
    of all.
    """
    for _ in range(MOST_MOVES if _jumps(likelihood) else MAX_MOVES):
        best = distinct(likelihood, maxima)
        rises = np.array([next(rise for rise, point in zip(rises, maxima) if point is one) for one in best])
        maxima = best
        of_unknown = partial(_joined, likelihood, maxima, rises)
        own = list(range(likelihood.d) if profiled is None else map(int, profiled))
        try:
            checked = dict(zip(own, workers.each(of_unknown, own)))
            return maxima[0], [
                checked[index]
                if index in checked
                else information_interval(likelihood, maxima[0], index, float(rises[0, index]))
                for index in range(likelihood.d)
            ]
        except _BetterMaximum as found:
            maxima = [maximise(likelihood, found.point.theta), *maxima]
            rises = np.vstack([rises.max(axis=0), rises])
        except np.linalg.LinAlgError:
            break
    return maxima[0], None


def _joined(likelihood: Maximised, maxima: Sequence[Point], rises: Array, index: int) -> Interval:
    """Interval of one unknown around the best of some maxima and all that are likely enough.

    It is in the unit cube. Maxima are in order, best first; the deviance rises by less than (n_maximum, d).
    """
    lowest = maxima[0].deviance
    limited = _Limited(likelihood, MOST_EVALUATIONS if _jumps(likelihood) else np.inf)
    best, *others = (
        _checked(limited, point, index, float(rise), lowest)
        for point, rise in zip(maxima, rises[:, index])
        if point.deviance - lowest < rise
    )
    beyond = [other for other in others if other.low < best.low or other.high > best.high]
    if not beyond:
        return best
    parts = sorted([best, *beyond], key=lambda part: part.low)
    reached = np.maximum.accumulate([part.high for part in parts])
    low, high = parts[0].low, float(reached[-1])
    has_gap = any(part.low > before for part, before in zip(parts[1:], reached))
    basis = _basis(low, high)
    if basis == "profile" and any(part.basis == "information" for part in parts):
        basis = "information"
    return Interval(low, high, "hull" if has_gap and basis == "profile" else basis)


def _checked(likelihood: _Limited, maximum: Point, index: int, rise: float, lowest: float) -> Interval:
    """Interval of one unknown around one maximum, its ends checked or computed on the profile.

    It is in the unit cube. At its ends the deviance is `rise` above the lowest. If no evaluations remain for that, the
    information is used.
    """
    profile = _Profile(likelihood, maximum, index, lowest)
    try:
        return _on_profile(profile, maximum, rise, lowest)
    except _EvaluationsSpent:
        return information_interval(likelihood, maximum, index, rise - (maximum.deviance - lowest))


def _on_profile(profile: _Profile, maximum: Point, rise: float, lowest: float) -> Interval:
    """The interval whose ends a profile checks or finds."""
    wanted = np.sqrt(rise)
    ends = profile.start + np.array([-1.0, 1.0]) * np.sqrt(rise - (maximum.deviance - lowest)) * profile.sd
    if (
        profile.limits[0] < ends[0]
        and ends[1] < profile.limits[1]
        and all(profile.is_near(end) and abs(profile.root(end) / wanted - 1) < REGULAR for end in ends)
        and all(abs(profile.settled_root(end) / wanted - 1) < REGULAR for end in ends)
    ):
        return Interval(float(ends[0]), float(ends[1]), "gauss-newton")
    low, high = (_end(profile, wanted, sign) for sign in (-1, 1))
    return Interval(low, high, _basis(low, high))


def _basis(low: float, high: float) -> str:
    if np.isinf(low):
        return "not identifiable" if np.isinf(high) else "upper limit"
    return "lower limit" if np.isinf(high) else "profile"


def _end(profile: _Profile, wanted: float, sign: int) -> float:
    """Value at which the profile reaches the root at its lower (−1) or upper (1) side, or infinity."""
    limit = profile.limits[sign > 0]
    width = min(wanted * profile.sd, abs(limit - profile.start))
    inner, reach = profile.start, width
    while inner != limit:
        outer = limit if reach >= abs(limit - profile.start) else profile.start + sign * reach
        shortest = SHORTEST * abs(outer - inner)
        while abs(outer - inner) > shortest and not profile.is_near(outer):
            outer = (inner + outer) / 2
            reach = abs(outer - profile.start)
        if np.isinf(profile.root(outer)):  # what has a response ends here
            return inner
        if profile.root(outer) < wanted or profile.settled_root(outer) < wanted:
            inner, reach = outer, 2 * reach
            continue
        inner = brentq(lambda value: profile.root(value) - wanted, inner, outer, xtol=EXACT * width, rtol=1e-12)
        before, settled = profile.root(inner), profile.settled_root(inner)
        if settled > (1 - REGULAR) * wanted or before - settled < REGULAR * wanted:  # else it lies farther out
            return inner
    return sign * np.inf


def _tangent(likelihood: Maximised, maximum: Point, index: int) -> tuple[float, Array]:
    """Standard deviation of one unknown, and the slope of the others along the profile (p,)."""
    theta = maximum.theta
    free = (theta > likelihood.lower) & (theta < likelihood.upper)
    free[index] = True
    whitened = maximum.whitened[:, free]
    own = np.flatnonzero(np.flatnonzero(free) == index)[0]
    column, others = whitened[:, own], np.delete(whitened, own, axis=1)
    follow = -np.linalg.lstsq(others, column, rcond=1e-10)[0] if others.size else np.empty(0)
    length = np.linalg.norm(column + others @ follow)
    tangent = np.zeros(len(theta))
    tangent[np.delete(np.flatnonzero(free), own)] = follow
    tangent[index] = 1.0
    return (float(1 / length) if length > 0 else np.inf), tangent


def information_interval(likelihood: Maximised, maximum: Point, index: int, rise: float) -> Interval:
    """The interval as the information has it, open where it reaches beyond the limits."""
    sd, _ = _tangent(likelihood, maximum, index)
    low, high = maximum.theta[index] + np.array([-1.0, 1.0]) * np.sqrt(rise) * sd
    low, high = (low if low > 0 else -np.inf), (high if high < 1 else np.inf)
    basis = _basis(low, high)
    return Interval(low, high, "information" if basis == "profile" else basis)


def in_si(interval: Interval, lower: float, upper: float) -> Interval:
    """An interval in the unit cube as one between the limits of its unknown."""
    width = upper - lower
    return Interval(lower + float(interval.low) * width, lower + float(interval.high) * width, interval.basis)


def _unbiased(likelihood: Likelihood, maximum: Point) -> Noise:
    noise = likelihood.noise(maximum.theta)
    left = likelihood.n_residual - likelihood.n_free
    if not likelihood.noise_is_estimated or left <= 0:
        return noise
    return noise.scaled(float(np.sqrt(likelihood.n_residual / left)))

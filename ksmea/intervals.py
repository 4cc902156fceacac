"""Confidence intervals of identified unknowns from the likelihood of the measurement.

The deviance of the profile likelihood, D(θᵢ) = min over all other unknowns of −2 ln L, rises from its minimum to both
sides. The interval holds all values of θᵢ at which it has risen by less than c: the quantile of χ² with one degree of
freedom, or, where the noise is estimated along, n ln(1 + F/(n − d)) with the quantile of F(1, n − d) from n residuals
and d unknowns, which is exact for a linear model.

Where the profile is a parabola, its ends lie at θ̂ ± √c · sd with sd from the Fisher information (Gauss–Newton); that
is checked at both ends, and where it fails by more than `REGULAR` of the width, or a search limit is in the way, they
are found on the profile itself. A side on which the profile stays below c up to the limit is open.

D. M. Bates and D. G. Watts, Nonlinear Regression Analysis and Its Applications (Wiley, 1988), chapter 6,
doi 10.1002/9780470316757; D. J. Venzon and S. H. Moolgavkar, Appl. Stat. 37 (1988) 87–94, doi 10.2307/2347496.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import brentq

from ksmea.arrays import Array
from ksmea.likelihood import Likelihood, Point
from ksmea.maximisation import Maximised, maximise
from ksmea.measurement import Noise

REGULAR = 0.05  # the ends of a parabola may miss those of the profile by this part of the half-width
FAR = 8.0  # rise of the deviance from a known point of a profile to where the next is computed; more is too far away
SHORTEST = 2.0**-12  # of a step along a profile, below which it is cut no further
LOWER = 0.01  # a deviance this far below the maximum's is another maximum, from where all begins again


@dataclass(frozen=True)
class Interval:
    """The values of one unknown that the measurement is compatible with, SI.

    `kind` is one of: gauss-newton (a parabola, checked), profile (both ends on the profile likelihood), lower limit and
    upper limit (the other side is open), not identifiable (both are), information (a parabola that was not checked).
    """

    low: float  # -inf where open
    high: float  # inf where open
    kind: str


@dataclass(frozen=True)
class Estimate:
    """The maximum of the likelihood nearest to an identified point, x (d,) SI, with an interval per unknown.

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
    """The root of the rise of the deviance along one unknown, which is a straight line where the model is linear.

    Each point is maximised from the nearest one that is known, the others following along the tangent at the maximum,
    or where that leads up steeply, out of a curved valley, along the secant of the two nearest known ones.
    """

    def __init__(self, likelihood: Maximised, maximum: Point, index: int) -> None:
        self.sd, self._tangent = _tangent(likelihood, maximum, index)
        self.start = float(maximum.theta[index])
        self._likelihood = likelihood
        self._maximum = maximum
        self._index = index
        self._known = [maximum]
        self._roots = {self.start: 0.0}

    def root(self, value: float) -> float:
        """√(D − D̂) where the unknown has this value and all others suit it best, infinite where the model has no response;
        the same whenever it is asked again."""
        if value not in self._roots:
            self._roots[value] = self._maximised(value)
        return self._roots[value]

    def is_near(self, value: float) -> bool:
        """Whether what is known leads to this value without leaving the valley that the profile follows."""
        return value in self._roots or self._predicted(value)[1] < FAR

    def _predicted(self, value: float) -> tuple[Array, float]:
        """θ to start from (p,), and how much higher its deviance is than that of the nearest known point."""
        near, *further = sorted(self._known, key=lambda point: abs(point.theta[self._index] - value))
        slopes = [self._tangent]
        if further:
            step = further[0].theta - near.theta
            slopes.append(step / step[self._index])
        for slope in slopes:
            theta = near.theta + (value - near.theta[self._index]) * slope
            theta[self._index] = value
            inside = np.clip(theta, self._likelihood.lower, self._likelihood.upper)
            higher = self._likelihood.deviance(inside) - near.deviance
            if higher < FAR:
                break
        return theta, higher

    def _maximised(self, value: float) -> float:
        theta, higher = self._predicted(value)
        if not np.isfinite(higher):
            return np.inf
        point = maximise(self._likelihood, theta, fixed=self._index, tolerance=1e-4)
        rise = point.deviance - self._maximum.deviance
        if rise < -LOWER:
            raise _BetterMaximum(point)
        self._known.append(point)
        return float(np.sqrt(max(rise, 0.0)))


class _BetterMaximum(Exception):
    def __init__(self, point: Point) -> None:
        self.point = point


def estimate(likelihood: Likelihood, maximum: Point, *, level: float = 0.95, check: bool = True) -> Estimate:
    """The intervals of confidence `level` around a maximum of the likelihood; a profile that meets a higher maximum
    moves all of them there.

    Without `check`, and where a profile cannot be computed, the information at the maximum is believed, at no further
    evaluation of the model.
    """
    rise = critical_rise(likelihood, level)
    intervals = None
    if check:
        maximum, intervals = checked_intervals(likelihood, maximum, rise)
    if intervals is None:
        intervals = [information_interval(likelihood, maximum, index, rise) for index in range(likelihood.d)]
    parameters = likelihood.model.problem.parameters
    return Estimate(
        parameters.to_si(maximum.theta[: likelihood.d]),
        tuple(in_si(interval, parameter.lower, parameter.upper) for interval, parameter in zip(intervals, parameters)),
        maximum,
        _unbiased(likelihood, maximum),
    )


def checked_intervals(likelihood: Maximised, maximum: Point, rise: float) -> tuple[Point, list[Interval] | None]:
    """The maximum and its intervals in the unit cube; none where profile after profile finds a higher one, so uneven is the likelihood,
    or one cannot be computed."""
    for _ in range(3):
        try:
            return maximum, [_checked(likelihood, maximum, index, rise) for index in range(likelihood.d)]
        except _BetterMaximum as found:
            maximum = maximise(likelihood, found.point.theta)
        except np.linalg.LinAlgError:
            break
    return maximum, None


def critical_rise(likelihood: Likelihood, level: float) -> float:
    """The rise of the deviance at the ends of an interval of confidence `level`."""
    if not likelihood.noise_is_estimated:
        return float(stats.chi2.ppf(level, 1))
    n, left = likelihood.n_residual, likelihood.n_residual - likelihood.d
    return float(n * np.log1p(stats.f.ppf(level, 1, left) / left)) if left > 0 else np.inf


def _checked(likelihood: Maximised, maximum: Point, index: int, rise: float) -> Interval:
    """The interval of one unknown in the unit cube, its ends checked or found on the profile."""
    profile = _Profile(likelihood, maximum, index)
    wanted = np.sqrt(rise)
    ends = profile.start + np.array([-1.0, 1.0]) * wanted * profile.sd
    if (
        0 < ends[0]
        and ends[1] < 1
        and all(profile.is_near(end) and abs(profile.root(end) / wanted - 1) < REGULAR for end in ends)
    ):
        return Interval(float(ends[0]), float(ends[1]), "gauss-newton")
    low, high = (_end(profile, wanted, limit) for limit in (0.0, 1.0))
    return Interval(low, high, _kind(low, high))


def _kind(low: float, high: float) -> str:
    if np.isinf(low):
        return "not identifiable" if np.isinf(high) else "upper limit"
    return "lower limit" if np.isinf(high) else "profile"


def _end(profile: _Profile, wanted: float, limit: float) -> float:
    """Where the profile reaches the wanted root between its maximum and a limit; infinite where it does not."""
    sign = 1.0 if limit == 1.0 else -1.0
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
        if profile.root(outer) >= wanted:
            return brentq(lambda value: profile.root(value) - wanted, inner, outer, xtol=0.003 * width, rtol=1e-12)
        inner, reach = outer, 2 * reach
    return sign * np.inf


def _tangent(likelihood: Maximised, maximum: Point, index: int) -> tuple[float, Array]:
    """Standard deviation of one unknown, and how the others move with it along the profile (p,), from the information.
    Unknowns on a limit stay there."""
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
    kind = _kind(low, high)
    return Interval(low, high, "information" if kind == "profile" else kind)


def in_si(interval: Interval, lower: float, upper: float) -> Interval:
    """An interval in the unit cube as one between the limits of its unknown."""
    width = upper - lower
    return Interval(lower + float(interval.low) * width, lower + float(interval.high) * width, interval.kind)


def _unbiased(likelihood: Likelihood, maximum: Point) -> Noise:
    noise = likelihood.noise(maximum.theta)
    left = likelihood.n_residual - likelihood.d
    if not likelihood.noise_is_estimated or left <= 0:
        return noise
    factor = float(np.sqrt(likelihood.n_residual / left))
    return Noise(noise.relative * factor, noise.floor * factor)

"""Parts of a Bode plot: unwrapped phase lag, resonances, and residuals counted against noise alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from statistics import NormalDist

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.rotordynamics.half_power import full_peaks
from ksmea.show.charts.chart import Element, Level, Span, Words
from ksmea.show.charts.colours import CONTEXT
from ksmea.show.charts.responses import ModelCurve

TURN = 360.0  # degrees
CLOSE = 0.05  # of a speed: resonances that are nearer get a column of their own
N_SD = 2.0  # of the noise: the band of residuals
PART_AROUND = 0.5  # of their distance, that a column of a close pair shows on both sides
MOST_NAMED = 8  # resonances with their speed
STEPS = (45, 90, 180, 360)  # degrees between ticks of a phase
MOST_TICKS = 5
LEAST_SIGMA, ROOM = 3.0, 1.1  # that the axis of residuals shows at least, and times the largest residual


def lag_along(curve: ModelCurve, column: int) -> Array:
    """Phase lag (n,), degrees, of a model's curve without jumps, each run on its own.

    It begins between 0 and 360.
    """
    runs = np.split(-np.angle(curve.values[:, column]), list(curve.breaks))
    lags = [np.degrees(np.unwrap(lag)) for lag in runs]
    return np.concatenate([lag - TURN * np.floor(lag[0] / TURN) if len(lag) else lag for lag in lags])


def lags_along(curves: Sequence[ModelCurve], column: int) -> list[Array]:
    """Phase lags (n,), degrees, of several models, each run in the turn nearest to the last model's.

    The typical distance of a run counts: two models that pass an antiresonance on different sides meet in one part alone.
    """
    last = lag_along(curves[-1], column)
    lags = [lag_along(curve, column) for curve in curves[:-1]]
    near = [_nearer(lag, curve.speed, curve.breaks, curves[-1], last) for lag, curve in zip(lags, curves)]
    return [*near, last]


def _nearer(lag: Array, speed: Array, breaks: Sequence[int], other: ModelCurve, of_other: Array) -> Array:
    """A lag (n,), degrees, whose runs are shifted by whole turns to another model's."""
    expected = _at_speeds(other, of_other, speed, breaks)
    if expected is None:
        return lag
    turns = [np.round(np.median((expected - lag)[rows]) / TURN) for rows in _runs(len(speed), breaks)]
    return lag + TURN * np.repeat(turns, np.diff([0, *breaks, len(speed)]))


def nearest_lag(measured: ComplexArray, speed: Array, breaks: Sequence[int], curve: ModelCurve, column: int) -> Array:
    """Measured phase lag (n_speed,), degrees, in the turn that is nearest to a model's, run by run."""
    lag = np.degrees(-np.angle(measured))
    expected = _at_speeds(curve, lag_along(curve, column), speed, breaks)
    return lag if expected is None else np.asarray(lag + TURN * np.round((expected - lag) / TURN))


def _at_speeds(curve: ModelCurve, lag: Array, speed: Array, breaks: Sequence[int]) -> Array | None:
    """The lag of a model's curve at other speeds, run by run; None if the runs are not the curve's."""
    rows = zip(_runs(len(speed), breaks), _runs(len(curve.speed), curve.breaks))
    found = [np.interp(speed[own], *_ascending(curve.speed[fine], lag[fine])) for own, fine in rows]
    return np.concatenate(found) if sum(map(len, found)) == len(speed) else None


def _ascending(speed: Array, values: Array) -> tuple[Array, Array]:
    order = np.argsort(speed, kind="stable")
    return speed[order], values[order]


def _runs(n: int, breaks: Sequence[int]) -> list[slice]:
    starts = [0, *breaks, n]
    return [slice(first, last) for first, last in pairwise(starts)]


def phase_ticks(low: float, high: float) -> dict[float, str]:
    """Multiples of 45, 90, 180 or 360° between two ends, at most five."""
    for step in STEPS:
        ticks = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
        if len(ticks) <= MOST_TICKS:
            break
    return {float(each): f"{each:.0f}".replace("-", "−") for each in ticks + 0.0}  # −0.0 becomes 0


def resonances(curve: ModelCurve) -> list[float]:
    """Speeds of the peaks of a model's response, as root sum of squares over the channels.

    Each is there once for all runs: those within half a half-power width are one. A single channel may also rise before it falls to an antiresonance."""
    found: list[tuple[float, float]] = []
    for rows in _runs(len(curve.speed), curve.breaks):
        rising = _ascending(curve.speed[rows], np.linalg.norm(curve.values[rows], axis=1))
        found += [(peak.speed, peak.width) for peak in full_peaks(*rising)]
    kept: list[tuple[float, float]] = []
    for at, width in sorted(found):
        if not kept or at - kept[-1][0] > max(width, kept[-1][1]) / 2:
            kept.append((at, width))
    return [at for at, _ in kept]


def close_pairs(at: Sequence[float]) -> list[tuple[float, float]]:
    """Neighbouring resonances that are closer than 5 %."""
    return [(one, other) for one, other in pairwise(at) if other - one < CLOSE * other]


def around(pair: tuple[float, float]) -> tuple[float, float]:
    """Ends of a column that shows a close pair."""
    room = PART_AROUND * (pair[1] - pair[0])
    return pair[0] - room, pair[1] + room


def marks(at: Sequence[float], *, with_names: bool, are_apart: bool, form: str = ".0f") -> Iterator[Level]:
    """Lines at resonances, whose names are their speeds in a format.

    Of a close pair the first has the names of both, unless they are drawn apart."""
    pairs = {} if are_apart else dict(close_pairs(at))
    for each in at if len(at) <= MOST_NAMED else ():
        is_second = each in pairs.values()
        name = f"{each:{form}}" + (f", {pairs[each]:{form}}" if each in pairs and pairs[each] not in pairs else "")
        label = name if with_names and not is_second else ""
        yield Level(at=each, along="x", dash="solid", width=0.5, label=label, colour=CONTEXT, opacity=0.7)


def outside(parts: Mapping[str, Array]) -> str:
    """For example '10 of 180 outside ± 2 σ; noise alone: 8'."""
    every = np.concatenate([np.ravel(left) for left in parts.values()])
    every = every[np.isfinite(every)]
    expected = 2 * (1 - NormalDist().cdf(N_SD)) * len(every)
    n_outside = np.count_nonzero(np.abs(every) > N_SD)
    return f"{n_outside} of {len(every)} outside ± {N_SD:g} σ; noise alone: {expected:.0f}"


def residual_reach(parts: Mapping[str, Array]) -> float:
    """Both ends of the axis of residuals, in units of the noise."""
    return ROOM * max(LEAST_SIGMA, *(float(np.nanmax(np.abs(left))) for left in parts.values()))


def residual_ground(parts: Mapping[str, Array], most: float, right: float) -> Iterator[Element]:
    """The band of ± 2 σ, and above the panel how many residuals lie outside of it."""
    yield Span(low=-N_SD, high=N_SD)
    yield Level(at=0.0, dash="solid", width=0.6)
    yield Words(x=right, y=most, text=outside(parts), side="right", edge="bottom", offset=(0.0, 1.0))

"""Times of the keyphasor's mark in a sampled signal, one per turn, at a stated edge.

A mark is away from the level at rest for a few per cent of a turn, or the signal is at one of two levels for about half of it. With
a short mark the leading edge is meant, rising or falling as the mark is high or low. If the upper level lasts from 25 to 75 % of a
turn, nothing in the record says which of the two edges is meant, and the two differ by up to 180°: the edge is an open question. The
share of the upper level is taken from whole turns, edge to edge, so that it does not depend on where a record is cut.

An edge is at half of its own height, between the levels on either side of it: filters make pulses lower and edges slower as the
speed rises. A steep edge lies between two samples; of a slow one a straight line is fitted to the samples from a quarter to three
quarters of the height.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from ksmea.arrays import Array, Indices
from ksmea.errors import SettingError
from measurements.formats.questions import OpenQuestion
from measurements.formats.user_answers import KEYPHASOR_EDGES

RISING, FALLING = KEYPHASOR_EDGES
EDGE_REMARK = "keyphasor edge"  # how the remark begins that says the edge
EDGE_IN_FILE = re.compile(rf"^\s*#\s*{EDGE_REMARK}: ({RISING}|{FALLING})\b", re.MULTILINE)
OPEN = (0.25, 0.75)  # share of the upper level in which either edge may be meant
CLEAR = 10.0  # times as high as what the signal does at rest, in the median
SHORT = 0.4  # share of a record, below which a mark is measured from the level at rest
LEVELS = (5, 95)  # percentiles that stand for the two levels of other signals
# Heights that a mark is seen at and is over at. Lower ones are for pulses that a filter makes smaller as the speed rises.
ABOVE_REST = ((0.5, 0.25), (0.35, 0.175), (0.2, 0.1))
OF_TWO_LEVELS = ((0.75, 0.25), (0.6, 0.4), (0.55, 0.45))
IRREGULAR = 1.5  # times as long as the turn before: a pulse is missing, or one too many
MOST_IRREGULAR = 0.2  # of all turns: beyond that the signal is none of a keyphasor
NEARBY = 11  # marks
ALIKE = 0.9  # of the highest mark: marks that are as high differ by their samples alone
QUARTER, HALF, THREE_QUARTERS = 0.25, 0.5, 0.75  # of the height of an edge
FITTED = 4  # samples inside of a slow edge, from which on a line is fitted
SLOW = 1.0  # degrees: an edge that lasts longer is remarked on


@dataclass(frozen=True)
class Mark:
    """The mark's passages in a record."""

    time: Array  # (n_turn + 1,) s
    edge: str
    share: float  # of a turn at the upper level
    duration: float  # of the edge, degrees; 0 if it is too steep to say

    @property
    def remark(self) -> str:
        """The edge and why, in words."""
        slow = f"; it takes {self.duration:.0f}°, as of a filtered signal" if self.duration > SLOW else ""
        return f"{EDGE_REMARK}: {self.edge}, upper level for {100 * self.share:.2g} % of a turn{slow}"


@dataclass(frozen=True)
class _Lobes:
    """Marks in a height (n_sample,), by sample numbers.

    The last one before each mark, its first, its last and the first after it; the last mark may lack its end.
    """

    before: Indices
    first: Indices
    last: Indices
    after: Indices


def mark_of(time: Array, keyphasor: Array, edge: str | None) -> Mark:
    """The passages of the mark at an edge; without one at the leading edge of a short mark.

    Raises `OpenQuestion` if either edge may be meant, `SettingError` if there are no pulses.
    """
    height, points_up, is_short = _height(keyphasor)
    lobes = _lobes(time, height, ABOVE_REST if is_short else OF_TWO_LEVELS)
    leading, slow_leading = _edges(time, height, lobes, is_short=is_short, leading=True)
    trailing, slow_trailing = _edges(time, height, lobes, is_short=is_short, leading=False)
    n = min(len(leading) - 1, len(trailing))
    share = float(np.median((trailing[:n] - leading[:n]) / np.diff(leading)[:n]))
    turn = float(np.median(np.diff(leading)))
    share = share if points_up else 1 - share
    degrees = 360 / turn * max(slow_leading, slow_trailing)
    chosen = edge or _only_edge(share, degrees)
    is_leading = (chosen == RISING) == points_up
    return Mark(leading if is_leading else trailing, chosen, share, degrees)


def require_one_edge(path: str, texts: Mapping[str, str]) -> None:
    """Raise `SettingError` if files, by their name, state different edges.

    An import wrote them at their heads.
    """
    said = {file: found[1] for file, text in texts.items() if (found := EDGE_IN_FILE.search(text))}
    edges = list(dict.fromkeys(said.values()))
    if len(edges) > 1:
        one, other = (next(file for file, edge in said.items() if edge == each) for each in edges)
        raise SettingError(
            f"{path}: expected phases from one edge of the keyphasor's mark, got {edges[0]} in {one} and {edges[1]} in {other};"
            f" import all runs with --keyphasor-edge {edges[0]}"
        )


def _only_edge(share: float, degrees: float) -> str:
    if OPEN[0] <= share <= OPEN[1]:
        slow = f", with edges that take {degrees:.0f}°" if degrees > SLOW else ""
        raise OpenQuestion(
            f"keyphasor: expected which edge of the mark phases count from, as its upper level lasts for {100 * share:.3g} % of a"
            f" turn{slow}, got nothing; give keyphasor_edge=rising or falling, the same for all records of a machine",
            "keyphasor_edge",
            ("RISING_OR_FALLING",),
            RISING,
        )
    return RISING if share < HALF else FALLING


def _height(keyphasor: Array) -> tuple[Array, bool, bool]:
    """The signal from 0, at rest or the lower level, to 1, whether 1 is up, and whether marks are short."""
    rest = float(np.median(keyphasor))
    up, down = float(np.max(keyphasor)) - rest, rest - float(np.min(keyphasor))
    if max(up, down) > 0:
        height = (keyphasor - rest) / (up if up >= down else -down)
        if float(np.median(np.abs(height))) * CLEAR <= 1 and np.mean(height > HALF) < SHORT:
            return height, up >= down, True
    low, high = np.percentile(keyphasor, LEVELS)
    if not high > low:
        raise _no_pulses()
    return (keyphasor - low) / (high - low), True, False


def _no_pulses() -> SettingError:
    return SettingError("keyphasor: expected a pulse in each turn, got none; name the column of the keyphasor")


def _lobes(time: Array, height: Array, thresholds: tuple[tuple[float, float], ...]) -> _Lobes:
    """Marks by the highest thresholds that leave one in each turn.

    Otherwise the thresholds with the fewest odd turns are used.
    """
    found = [_between(height, *each) for each in thresholds]
    odd = [_irregular(time[each.first]) for each in found]
    best = int(np.argmin(odd))
    if odd[best] > MOST_IRREGULAR:
        raise _no_pulses()
    return found[best]


def _irregular(pulses: Array) -> float:
    """Share of turns that are much longer or shorter than the one before; 1 of fewer than two turns."""
    turns = np.diff(pulses)
    if len(turns) < 2:
        return 1.0
    ratio = turns[1:] / turns[:-1]
    return float(np.mean((ratio > IRREGULAR) | (ratio < 1 / IRREGULAR)))


def _between(height: Array, seen: float, over: float) -> _Lobes:
    """The marks of a height: seen at one threshold, over below the other."""
    state = np.where(height >= seen, 1, np.where(height < over, -1, 0))  # 0 keeps what was before
    known = np.flatnonzero(state)
    change = np.flatnonzero(np.diff(state[known]))
    rises, falls = change[state[known[change]] < 0], change[state[known[change]] > 0]
    falls = falls[falls > rises[0]] if len(rises) else falls[:0]  # the record may begin inside of a mark
    return _Lobes(known[rises], known[rises + 1], known[falls], known[falls + 1])


def _edges(time: Array, height: Array, lobes: _Lobes, *, is_short: bool, leading: bool) -> tuple[Array, float]:
    """Times at which marks begin, or end, and their median duration, s (0 of steep edges)."""
    top, base = _levels(height, lobes, is_short=is_short, leading=leading)
    n = len(lobes.first) if leading else len(lobes.last)
    start, stop = (lobes.before, lobes.first) if leading else (lobes.last, lobes.after)
    middle = (top + base) / 2
    times, spans = np.empty(n), np.zeros(n)
    steep = (stop[:n] - start[:n] == 1) & ((height[start[:n]] < middle) != (height[stop[:n]] < middle))
    at, to = start[:n][steep], stop[:n][steep]
    times[steep] = time[at] + (middle[steep] - height[at]) / (height[to] - height[at]) * (time[to] - time[at])
    for mark in np.flatnonzero(~steep):
        low, high = _reach(height, lobes, int(mark), leading=leading)
        part = (height[low:high] - base[mark]) / (top[mark] - base[mark])
        times[mark], spans[mark] = _crossing(time[low:high], part if leading else part[::-1], reverse=not leading)
    return times, float(np.median(spans)) if n else 0.0


def _levels(height: Array, lobes: _Lobes, *, is_short: bool, leading: bool) -> tuple[Array, Array]:
    """The levels on either side of each edge.

    The extreme of marks nearby, and the level at rest or the extreme between marks nearby. Samples hit the tips of
    short marks unequally well, and a record may begin or end within one.
    """
    n = len(lobes.first) if leading else len(lobes.last)
    stops = np.append(lobes.after, len(height))[: len(lobes.first)]
    tops = np.array([np.max(height[first:stop]) for first, stop in zip(lobes.first, stops)])
    top = maximum_filter1d(tops, NEARBY)[:n]
    top = np.where(top > ALIKE * np.max(tops), np.max(tops), top)
    if is_short:
        return top, np.zeros(n)
    starts = np.insert(lobes.after, 0, 0)[: len(lobes.first)]
    between = np.array([np.min(height[start : stop + 1]) for start, stop in zip(starts, lobes.before)])
    base = minimum_filter1d(between, NEARBY)
    return top, base if leading else np.append(base[1:], base[-1])[:n]


def _reach(height: Array, lobes: _Lobes, mark: int, *, leading: bool) -> tuple[int, int]:
    """Samples in which an edge lies: the mark, and half of what is before it, or after it."""
    n = len(height)
    first, stop = int(lobes.first[mark]), int(lobes.after[mark]) if mark < len(lobes.after) else n
    if leading and not mark:  # the record may begin inside of an earlier mark
        return int(np.argmin(height[:first])), stop
    if leading:
        return (int(lobes.after[mark - 1]) + int(lobes.before[mark])) // 2, stop
    following = int(lobes.first[mark + 1]) if mark + 1 < len(lobes.first) else n
    return first, (stop + following + 1) // 2


def _crossing(time: Array, part: Array, *, reverse: bool) -> tuple[float, float]:
    """When a rising height, from 0 to 1, passes a half, and how long it takes from 0 to 1 at its slope.

    `reverse`: the height is in the other order than the times.
    """
    time = time[::-1] if reverse else time
    after = int(np.argmax(part >= HALF))
    inside = slice(0, 0)
    if np.any(part >= THREE_QUARTERS):
        stop = int(np.argmax(part >= THREE_QUARTERS))
        below = np.flatnonzero(part[:stop] <= QUARTER)
        inside = slice(int(below[-1]) + 1 if len(below) else 0, stop)
    if inside.stop - inside.start >= FITTED:
        slope, offset = np.polyfit(time[inside] - time[inside.start], part[inside], 1)
        if slope != 0:
            passed = time[inside.start] + (HALF - offset) / slope
            if min(time[0], time[-1]) <= passed <= max(time[0], time[-1]):
                return float(passed), abs(float(1 / slope))
    before = max(after - 1, 0)
    rise = part[after] - part[before]
    share = (HALF - part[before]) / rise if rise > 0 else 0.0
    return float(time[before] + share * (time[after] - time[before])), 0.0

"""The times of a row: each contestant in a process of its own, all in turn.

A ratio is taken within a turn, where both sides met the same neighbours and the same clock rate, and its median and quartiles over
the turns. The ratio of two medians would have the changes between turns in it. No library does this: pytest-benchmark and pyperf time
one function after the other by the wall clock, in one environment, and know neither values nor quality of results.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.harness.processes import NotRun, Processes
from benchmarks.harness.row import Contestant, Row

LEAST_SECONDS = 0.02  # of a timed block: shorter ones are of the size of a clock's and a scheduler's steps
BUSIEST = 20  # a call's wall time is taken for no less than this part of it: what sleeps has no CPU time
LONG = 1.0  # s of a first call, beyond which it counts as what a call takes


@dataclass
class Measured:
    """Result of one contestant: seconds a unit and quality in each turn, or why there are none."""

    contestant: Contestant
    version: str = ""
    calls: int = 0
    seconds: list[float] = field(default_factory=list)
    qualities: list[float] = field(default_factory=list)
    parts: list[dict[str, float]] = field(default_factory=list)
    difference: float | None = None  # of its values from ours
    skipped: str = ""
    units: float = 1.0
    expected: float = 0.0  # s, wall, of one timed block
    values: Any = None  # of the first run

    def skip(self, reason: object) -> None:
        self.skipped, self.seconds, self.qualities = str(reason), [], []

    def ratio_to(self, ours: Measured) -> tuple[float, float, float]:
        return paired_ratio(self.seconds, ours.seconds)

    @property
    def quality(self) -> float | None:
        return float(np.median(self.qualities)) if self.qualities else None

    def failed(self, above: float | None) -> int | None:
        """How many turns ended with a quality above a limit."""
        return None if above is None or not self.qualities else sum(each > above for each in self.qualities)


def measured(row: Row, processes: Processes, turns: int) -> list[Measured]:
    """All contestants of a row, the first one ours.

    One that cannot run is left out of the turns, with the reason; where that is ours, so are all.
    """
    found = [Measured(contestant) for contestant in row.contestants]
    ours = found[0]
    for each in found:
        _attempt(_start, row, each, processes)
        if each is not ours and each.values is not None and ours.values is not None:
            each.difference = largest_difference(each.values, ours.values)
    running = [each for each in found if not each.skipped]
    for turn in range(_turns(row, sum(each.expected for each in running), turns)):
        for each in running if turn % 2 == 0 else running[::-1]:
            if not each.skipped:  # what fails now has no times at all, since pairs would be torn
                _attempt(_take, row, each, processes, turn)
    for each in found[1:]:
        if ours.skipped and not each.skipped:
            each.skip(f"nothing to compare with: {ours.skipped}")
    return found


def _attempt(step: Any, row: Row, each: Measured, processes: Processes, *arguments: Any) -> None:
    """A step of a contestant in its process; that ends where the step fails."""
    environment, name = each.contestant.environment, each.contestant.name
    try:
        process = processes.of(environment, name)
        step(row, each, lambda method, **values: process.ask(row.limit, method, **values), *arguments)
    except NotRun as reason:
        processes.drop(environment, name)
        each.skip(reason)


def _start(row: Row, each: Measured, ask: Any) -> None:
    contestant = each.contestant
    ready = ask("prepare", task=contestant.task, settings=dict(contestant.settings), library=contestant.library)
    each.version, each.units = f"{contestant.library} {ready['version'] or 'of this folder'}", float(ready["units"])
    if not row.is_warmed:
        each.calls = 1
        return
    once = ask("run", turn=0, calls=1)  # what is made at the first call alone: caches, compiled code
    each.values = ask("values")["values"]
    if once["wall"] < LONG:
        once = ask("run", turn=0, calls=1)
    each.calls = calls_of_a_block(max(once["cpu"], once["wall"] / BUSIEST))
    each.expected = each.calls * once["wall"]


def _take(row: Row, each: Measured, ask: Any, turn: int) -> None:
    """One timed block."""
    answer = ask("run", turn=turn, calls=each.calls)
    each.seconds.append(answer[row.clock] / (each.calls * each.units))
    each.parts.append(answer["parts"])
    if answer["quality"] is not None:
        each.qualities.append(answer["quality"])


def _turns(row: Row, for_one: float, wanted: int) -> int:
    """Number of turns: as many as the budget of the row allows.

    They are at most those wanted, at least the row's least or what is wanted.
    """
    wanted = wanted if row.turns is None else min(wanted, row.turns)
    allowed = math.floor(row.budget / for_one) if for_one > 0 else wanted
    return max(min(wanted, allowed), min(wanted, row.least_turns))


def calls_of_a_block(seconds: float) -> int:
    """How many calls of so many seconds are timed together.

    >>> calls_of_a_block(0.003), calls_of_a_block(5.0)
    (7, 1)
    """
    return max(1, math.ceil(LEAST_SECONDS / max(seconds, 1e-7)))


def quartiles(values: object) -> tuple[float, float, float]:
    """First quartile, median and third quartile.

    >>> quartiles([4.0, 1.0, 3.0, 2.0, 5.0])
    (2.0, 3.0, 4.0)
    """
    q1, median, q3 = np.quantile(np.asarray(values, dtype=float), [0.25, 0.5, 0.75]).tolist()
    return q1, median, q3


def paired_ratio(theirs: object, ours: object) -> tuple[float, float, float]:
    """Quartiles of theirs over ours, turn by turn.

    >>> paired_ratio([10.0, 40.0, 30.0], [1.0, 2.0, 3.0])
    (10.0, 10.0, 15.0)
    """
    return quartiles(np.asarray(theirs, dtype=float) / np.asarray(ours, dtype=float))


def largest_difference(theirs: object, ours: object) -> float:
    """The largest absolute difference over the largest absolute value of ours.

    Not a number where shapes differ.

    >>> largest_difference([1.0, 2.1], [1.0, -2.0]), largest_difference([1.0], [1.0, 2.0])
    (2.05, nan)
    """
    one, other = np.asarray(theirs), np.asarray(ours)
    if one.shape != other.shape:
        return float("nan")
    scale = np.max(np.abs(other), initial=0.0)
    difference = float(np.max(np.abs(one - other), initial=0.0))
    return difference / float(scale) if scale > 0 else difference


def exponent(sizes: object, seconds: object) -> float:
    """Of the power law c·sizeᵖ that fits best in logarithms.

    >>> round(exponent([1, 10, 100], [3.0, 30.0, 300.0]), 6)
    1.0
    """
    return float(np.polyfit(np.log(np.asarray(sizes, float)), np.log(np.asarray(seconds, float)), 1)[0])

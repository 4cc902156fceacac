"""The times of a row: each contestant in a process of its own, all in turn."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.pairs import Quartiles, largest_difference, paired_ratio, quartiles
from benchmarks.harness.processes import NotRun, Processes, versions
from benchmarks.harness.row import Contestant, Row

LEAST_SECONDS = 0.02  # of a timed block: shorter ones are of the size of a clock's and a scheduler's steps
BUSIEST = 20  # a call's wall time is taken for no less than this part of it: what sleeps has no CPU time
LONG = 1.0  # s of a first call, beyond which it counts as what a call takes
LEAST_TURNS = 3  # of what takes so long that the row's budget would allow fewer


@dataclass
class Measured:
    """What is known of one contestant: seconds a unit and quality in each turn, or why there are none."""

    contestant: Contestant
    version: str = ""
    calls: int = 0
    seconds: list[float] = field(default_factory=list)
    qualities: list[float] = field(default_factory=list)
    parts: list[dict[str, float]] = field(default_factory=list)
    difference: float | None = None  # of its values from ours
    skipped: str = ""

    @property
    def time(self) -> Quartiles:
        return quartiles(self.seconds)

    def ratio_to(self, ours: Measured) -> Quartiles:
        return paired_ratio(self.seconds, ours.seconds)

    @property
    def quality(self) -> float | None:
        return float(np.median(self.qualities)) if self.qualities else None


def measured(row: Row, processes: Processes, turns: int) -> list[Measured]:
    """All contestants of a row, the first one ours. One that cannot run is left out of the turns, with the reason; where
    that is ours, so are all."""
    found = [Measured(contestant) for contestant in row.contestants]
    with tempfile.TemporaryDirectory() as folder:
        runners = [_Runner(row, each, processes, Path(folder)) for each in found]
        running = [runner for runner in runners if not runner.measured.skipped]
        turns = _turns(row, running, turns)
        for turn in range(turns):
            for runner in running if turn % 2 == 0 else running[::-1]:
                runner.take(turn)
    ours = found[0]
    for each in found[1:]:
        if ours.skipped and not each.skipped:
            each.skipped, each.seconds = f"nothing to compare with: {ours.skipped}", []
    return found


def _turns(row: Row, running: list[_Runner], wanted: int) -> int:
    """As many as the budget of the row allows, at most those wanted, at least `LEAST_TURNS` or what is wanted."""
    wanted = wanted if row.turns is None else min(wanted, row.turns)
    for_one = sum(runner.expected for runner in running)
    allowed = math.floor(row.budget / for_one) if for_one > 0 else wanted
    return max(min(wanted, allowed), min(wanted, LEAST_TURNS))


def calls_of_a_block(seconds: float) -> int:
    """How many calls of so many seconds are timed together.

    >>> calls_of_a_block(0.003), calls_of_a_block(5.0)
    (7, 1)
    """
    return max(1, math.ceil(LEAST_SECONDS / max(seconds, 1e-7)))


class _Runner:
    """A contestant in its process."""

    def __init__(self, row: Row, measured: Measured, processes: Processes, folder: Path) -> None:
        self.row, self.measured, self._processes = row, measured, processes
        self.expected = 0.0  # s, wall, of one timed block
        try:
            self._start(folder)
        except NotRun as reason:
            self._give_up(reason)

    def _start(self, folder: Path) -> None:
        contestant = self.measured.contestant
        process = self._processes.of(contestant.environment, contestant.name)
        version = versions(process, [contestant.library])[contestant.library]
        self.measured.version = f"{contestant.library} {version or 'of this folder'}"
        self._units = float(self._ask(do="prepare", task=contestant.task, settings=dict(contestant.settings))["units"])
        if not self.row.is_warmed:
            self.measured.calls = 1
            return
        once = self._run(0, 1)  # what is made at the first call alone: caches, compiled code
        self._compare(folder)
        if once["wall"] < LONG:
            once = self._run(0, 1)
        self.measured.calls = calls_of_a_block(max(once["cpu"], once["wall"] / BUSIEST))
        self.expected = self.measured.calls * once["wall"]

    def take(self, turn: int) -> None:
        """One timed block; what fails now has no times at all, since pairs would be torn."""
        measured = self.measured
        if measured.skipped:
            return
        try:
            answer = self._run(turn, measured.calls)
        except NotRun as reason:
            self._give_up(reason)
            return
        measured.seconds.append(answer[self.row.clock] / (measured.calls * self._units))
        measured.parts.append(answer["parts"])
        if answer["quality"] is not None:
            measured.qualities.append(answer["quality"])

    def _give_up(self, reason: NotRun) -> None:
        contestant, measured = self.measured.contestant, self.measured
        self._processes.drop(contestant.environment, contestant.name)
        measured.skipped, measured.seconds, measured.qualities = str(reason), [], []

    def _run(self, turn: int, calls: int) -> dict[str, Any]:
        return self._ask(do="run", turn=turn, calls=calls)

    def _compare(self, folder: Path) -> None:
        """The values of the first run, kept by the first contestant and compared by the others."""
        reference = folder / "ours.npy"
        mine = reference if self.measured.contestant is self.row.contestants[0] else folder / "theirs.npy"
        if self._ask(do="values", file=str(mine)).get("none"):
            return
        if mine != reference and reference.is_file():
            self.measured.difference = largest_difference(np.load(mine), np.load(reference))

    def _ask(self, **request: Any) -> dict[str, Any]:
        contestant = self.measured.contestant
        process = self._processes.of(contestant.environment, contestant.name)
        return process.ask(self.row.limit, name=contestant.name, **request)

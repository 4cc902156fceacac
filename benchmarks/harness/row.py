"""Rows of a benchmark group, each one piece of work by several contestants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

HERE, PEERS = "here", "peers"  # environments: this one, and that of `python -m benchmarks setup`
CPU, WALL = "cpu", "wall"
OWN, ROSS, NUMPY = "ksmea-bench", "ross-rotordynamics", "numpy"
OF_PEERS = {ROSS, "smt", "openturns", "pydacefit", "pymoo", "benchopt"}  # installed in their environment only


@dataclass(frozen=True)
class Contestant:
    """One way to do a row's work.

    `task` is "module:function" of what makes a `Task`; `library` the distribution whose version is stated; `environment` where
    it runs. `at_least` is the demand on the ratio of its time over that of the row's first contestant, `note` what is to be
    known when that ratio is read.
    """

    name: str
    task: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    library: str = OWN
    environment: str = HERE
    at_least: float | None = None
    note: str = ""


def by(
    name: str, task: str, library: str = OWN, at_least: float | None = None, note: str = "", **settings: Any
) -> Contestant:
    """Contestant whose task is "module:function" in `benchmarks.tasks`, in its library's environment."""
    environment = PEERS if library in OF_PEERS else HERE
    return Contestant(name, f"benchmarks.tasks.{task}", settings, library, environment, at_least, note)


@dataclass(frozen=True)
class Row:
    """One piece of work by several contestants; the first is ours.

    The others' times are divided by its time.

    `size` is what the work grows with (its name in `size_of`), `unit` what seconds are counted for. `quality` names the number
    that says how good a result is, smaller being better. A row that `is_quick` belongs to the short check. `budget` is the wall
    time, s, that its turns may take, and `limit` that of one call.
    """

    group: str
    name: str
    contestants: tuple[Contestant, ...]
    unit: str = "call"
    size: float | None = None
    size_of: str = ""
    clock: str = CPU
    quality: str = ""
    is_quick: bool = False
    budget: float = 20.0
    turns: int | None = None  # at most
    least_turns: int = 3  # of what takes so long that the budget would allow fewer
    is_warmed: bool = True  # a first call is made that does not count; not where one takes minutes
    limit: float = 600.0
    failed_above: float | None = None  # a quality beyond which a result counts as failed
    no_more_than: float | None = None  # s a unit of ours: a demand on the time itself

    @property
    def title(self) -> str:
        return f"{self.group}: {self.name}" + ("" if self.size is None else f", {self.size:g} {self.size_of}".rstrip())

"""Budget of true-model evaluations for any method, and a journal of finished ones: a killed run replays them exactly.

All random numbers of a run come from its seeds, so that it asks for the same evaluations in the same order. Each
request is written when it is finished; a run that starts again is served from the file for as long as it asks for the
same points, bit for bit, and computes from then on.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NoReturn, TypeVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import BudgetSpent
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.load import Load
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.modes import Campbell, Mode
from ksmea.settings.regular_files import open_regular

# An entry: lengths of question and answer in bytes, their checksum, then both as they lie in memory.
HEADER = struct.Struct("<QQI")


class Journal:
    """Questions (what is asked for, and the parameter sets) and answers (complex arrays) of one run, oldest first."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._past = _entries(path)
        self._replayed = 0
        self._file: BinaryIO = open_regular(path, "w+b")
        self._end = 0

    def answer(self, member: str, question: Array) -> ComplexArray | None:
        """The flat answer to the next question, if that is what was asked before; None: it must be computed."""
        if self._replayed < len(self._past):
            asked, answer = self._past[self._replayed]
            if asked == _asked(member, question):
                self._replayed += 1
                self._end += HEADER.size + len(asked) + len(answer)
                return np.frombuffer(answer, dtype=complex)
            self._past = self._past[: self._replayed]  # another path from here on: what followed is of no use
        return None

    def write(self, member: str, question: Array, answer: ComplexArray) -> None:
        """Keep an answer, behind all that has been replayed."""
        asked, answered = _asked(member, question), np.ascontiguousarray(answer).tobytes()
        self._file.seek(self._end)
        self._file.truncate()
        self._file.write(HEADER.pack(len(asked), len(answered), zlib.crc32(asked + answered)) + asked + answered)
        self._file.flush()
        os.fsync(self._file.fileno())
        self._end = self._file.tell()

    def close(self) -> None:
        self._file.close()


def _asked(member: str, question: Array) -> bytes:
    return member.encode() + np.ascontiguousarray(question).tobytes()


def _entries(path: Path) -> list[tuple[bytes, bytes]]:
    """The whole entries of a journal; a torn or damaged one ends it."""
    try:
        with open_regular(path) as file:
            content = file.read()
    except FileNotFoundError:
        content = b""
    entries: list[tuple[bytes, bytes]] = []
    start = 0
    while start + HEADER.size <= len(content):
        n_question, n_answer, checksum = HEADER.unpack_from(content, start)
        start += HEADER.size
        body = content[start : start + n_question + n_answer]
        if len(body) < n_question + n_answer or zlib.crc32(body) != checksum:
            break
        entries.append((body[:n_question], body[n_question:]))
        start += n_question + n_answer
    return entries


class JournaledProblem(ProblemProxy):
    """A problem whose responses and sensitivities are served from a journal, or computed and written into it. The same rotor
    elsewhere has no journal: its answers are for these speeds and channels."""

    def __init__(self, problem: Problem, journal: Journal) -> None:
        self._behind = problem
        self._journal = journal

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return behind

    def response(self, x: Array) -> ComplexArray:
        """One parameter set after the other, so that a run that is killed among them loses the one in work alone."""
        shape = len(self.speed), len(self.channels)
        return (
            np.stack([self._one(row[None]).reshape(shape) for row in x]) if len(x) else np.empty((0, *shape), complex)
        )

    def _one(self, x: Array) -> ComplexArray:
        answer = self._journal.answer("response", x)
        if answer is None:
            answer = self._behind.response(x)
            self._journal.write("response", x, answer)
        return np.ascontiguousarray(answer)  # as the journal gives it back: sums over it round alike

    def sensitivity(self, x: Array) -> ComplexArray:
        answer = self._journal.answer("sensitivity", x)
        if answer is None:
            answer = self._behind.sensitivity(x)
            self._journal.write("sensitivity", x, answer)
        return np.ascontiguousarray(answer).reshape(len(self.speed), len(self.channels), len(self.parameters))


Found = TypeVar("Found")

JACOBIAN_AS_EVALUATIONS = 2  # a response and an adjoint-like solution; it is recorded apart


@dataclass
class Budget:
    """Evaluations of the true model at most, a Jacobian counted as `jacobian_cost` of them; what is spent, and whether more was
    asked for."""

    evaluations: int
    jacobian_cost: int = 0
    spent: int = 0
    was_refused: bool = False

    @property
    def left(self) -> int:
        return self.evaluations - self.spent

    def refuse(self) -> NoReturn:
        self.was_refused = True
        raise BudgetSpent(f"the budget of {self.evaluations} evaluations of the true model is spent")


class BudgetedProblem(ProblemProxy):
    """A problem that answers within a budget. Of a batch that exceeds it, what is left is evaluated before `BudgetSpent` is
    raised, so that a method that goes on asking has seen exactly as much as the budget holds. An evaluation is of one set of
    unknowns, at any speeds; free motions of one, such as its modes, count as one too."""

    def __init__(self, behind: Problem, budget: Budget) -> None:
        self._behind = behind
        self.budget = budget

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return BudgetedProblem(behind, self.budget)

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        def within(problem: Problem) -> Problem:
            made = change(BudgetedProblem(problem, self.budget))
            return made.behind if isinstance(made, BudgetedProblem) else made

        return self.around(self._behind.changed(within))

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        return self._as_one(lambda: self._behind.critical_speeds(x, highest))

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        return self._as_one(lambda: self._behind.modes(x, speed, n_mode))

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        return self._as_one(lambda: self._behind.campbell(x, speed, n_mode))

    def growth_rate(self, x: Array, speed: Array) -> Array:
        return self._as_one(lambda: self._behind.growth_rate(x, speed))

    def stability_threshold(self, x: Array, highest: float) -> float:
        return self._as_one(lambda: self._behind.stability_threshold(x, highest))

    def is_stable(self, x: Array) -> bool:
        return self._as_one(lambda: self._behind.is_stable(x))

    def response(self, x: Array) -> ComplexArray:
        return self._within(x, self._behind.response)

    def dense_response(self, x: Array) -> ComplexArray:
        return self._within(x, self._behind.dense_response)

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self._within(x, lambda points: self._behind.load_response(points, loads))

    def sensitivity(self, x: Array) -> ComplexArray:
        self._require_jacobian()
        sensitivity = self._behind.sensitivity(x)
        self.budget.spent += self.budget.jacobian_cost
        return sensitivity

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        self._require_jacobian()
        both = self._behind.linearised(x)
        self.budget.spent += self.budget.jacobian_cost
        return both

    def _within(self, x: Array, evaluate: Callable[[Array], ComplexArray]) -> ComplexArray:
        n_admitted = min(len(x), self.budget.left)
        if n_admitted or not len(x):
            response = evaluate(x[:n_admitted])
            self.budget.spent += n_admitted
        if n_admitted < len(x):
            self.budget.refuse()
        return response

    def _as_one(self, evaluate: Callable[[], Found]) -> Found:
        if not self.budget.left:
            self.budget.refuse()
        found = evaluate()
        self.budget.spent += 1
        return found

    def _require_jacobian(self) -> None:
        if self.budget.jacobian_cost > self.budget.left:
            self.budget.refuse()

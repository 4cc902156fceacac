"""A journal of finished model evaluations: a run that was killed replays them exactly instead of repeating them.

All random numbers of a run come from its seeds, so that it asks for the same evaluations in the same order. Each
request is written when it is finished; a run that starts again is served from the file for as long as it asks for the
same points, bit for bit, and computes from then on.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.parameters import Parameters
from ksmea.regular_files import open_regular

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

    def answer(self, kind: str, question: Array) -> ComplexArray | None:
        """The flat answer to the next question, if that is what was asked before; None: it must be computed."""
        if self._replayed < len(self._past):
            asked, answer = self._past[self._replayed]
            if asked == _asked(kind, question):
                self._replayed += 1
                self._end += HEADER.size + len(asked) + len(answer)
                return np.frombuffer(answer, dtype=complex)
            self._past = self._past[: self._replayed]  # another path from here on: what followed is of no use
        return None

    def write(self, kind: str, question: Array, answer: ComplexArray) -> None:
        """Keep an answer, behind all that has been replayed."""
        asked, answered = _asked(kind, question), np.ascontiguousarray(answer).tobytes()
        self._file.seek(self._end)
        self._file.truncate()
        self._file.write(HEADER.pack(len(asked), len(answered), zlib.crc32(asked + answered)) + asked + answered)
        self._file.flush()
        os.fsync(self._file.fileno())
        self._end = self._file.tell()

    def close(self) -> None:
        self._file.close()


def _asked(kind: str, question: Array) -> bytes:
    return kind.encode() + np.ascontiguousarray(question).tobytes()


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


class JournaledProblem(Problem):
    """A problem whose responses and sensitivities are served from a journal, or computed and written into it."""

    def __init__(self, problem: Problem, journal: Journal) -> None:
        self._problem = problem
        self._journal = journal

    @property
    def parameters(self) -> Parameters:
        return self._problem.parameters

    @property
    def speed(self) -> Array:
        return self._problem.speed

    @property
    def channels(self) -> tuple[Channel, ...]:
        return self._problem.channels

    def at(self, speed: Array, channels: Sequence[Channel]) -> Problem:
        """The same rotor elsewhere, without the journal, whose answers are for these speeds and channels."""
        return self._problem.at(speed, channels)

    @property
    def has_free_phase(self) -> bool:
        return self._problem.has_free_phase

    @property
    def costly(self) -> Indices:
        return self._problem.costly

    @property
    def sites(self) -> Array:
        return self._problem.sites

    @property
    def knows_stability(self) -> bool:
        return self._problem.knows_stability

    def growth_rate(self, x: Array, speed: Array) -> Array:
        return self._problem.growth_rate(x, speed)

    def response(self, x: Array) -> ComplexArray:
        """One parameter set after the other, so that a run that is killed among them loses the one in work alone."""
        shape = len(self.speed), len(self.channels)
        return (
            np.stack([self._one(row[None]).reshape(shape) for row in x]) if len(x) else np.empty((0, *shape), complex)
        )

    def _one(self, x: Array) -> ComplexArray:
        answer = self._journal.answer("response", x)
        if answer is None:
            answer = self._problem.response(x)
            self._journal.write("response", x, answer)
        return answer

    @property
    def has_sensitivity(self) -> bool:
        return self._problem.has_sensitivity

    def sensitivity(self, x: Array) -> ComplexArray:
        answer = self._journal.answer("sensitivity", x)
        if answer is None:
            answer = self._problem.sensitivity(x)
            self._journal.write("sensitivity", x, answer)
        return answer.reshape(len(self.speed), len(self.channels), len(self.parameters))

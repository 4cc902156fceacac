"""Journal of finished evaluations: a killed run replays them exactly.

All random numbers of a run come from its seeds, so that it requests the same evaluations in the same order. Each
request is written when it is finished; a run that starts again is served from the file for as long as it requests the
same points, bit for bit, and computes from then on.
"""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.problem import Problem
from ksmea.settings.regular_files import open_regular

# An entry: lengths of question and answer in bytes, their checksum, then both as they lie in memory.
HEADER = struct.Struct("<QQI")


class Journal:
    """Questions and answers of one run, oldest first.

    A question is the request and its parameter sets, an answer a complex array.
    """

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
    """Problem with responses and sensitivities from a journal, or computed and written into it.

    The rotor at other speeds or channels has no journal: its answers are for these speeds and channels.
    """

    def __init__(self, problem: Problem, journal: Journal) -> None:
        self._behind = problem
        self._journal = journal

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return behind

    def response(self, x: Array) -> ComplexArray:
        """Response of one parameter set after the other.

        A run that is killed among them loses only the one in work.
        """
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

"""The processes that time things, as seen from the one that asks them."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
ONE_THREAD = dict.fromkeys(
    ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
) | {"OPENTURNS_NUM_THREADS": "1"}
NO_PEERS = "no environment of peers: python -m benchmarks setup"


class NotRun(Exception):
    """Why a contestant has no time: its library is absent, it failed or it took too long."""


class Process:
    """One `benchmarks.harness.worker` by an interpreter, with one thread."""

    def __init__(self, interpreter: str) -> None:
        self._log = tempfile.TemporaryFile("w+")  # noqa: SIM115 – closed by `end`
        self._folder = tempfile.TemporaryDirectory(prefix="ksmea-benchmarks-")  # for what libraries leave behind
        paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        self._connection, theirs = multiprocessing.Pipe()
        with theirs:
            self._process = subprocess.Popen(
                [interpreter, "-m", "benchmarks.harness.worker", str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdout=self._log,
                stderr=self._log,
                cwd=self._folder.name,
                env=os.environ | ONE_THREAD | {"PYTHONPATH": paths, "PYTHONWARNINGS": "ignore"},
            )

    def end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._connection.close()
        self._log.close()
        self._folder.cleanup()

    def ask(self, limit: float, method: str, **arguments: Any) -> dict[str, Any]:
        """The answer to a request within `limit` s, or `NotRun`."""
        try:
            self._connection.send((method, arguments))
            if not self._connection.poll(limit):
                raise NotRun(f"takes more than {limit:g} s")
            answer: dict[str, Any] = self._connection.recv()
        except (EOFError, ConnectionError):
            raise NotRun(self._death()) from None
        if "absent" in answer:
            raise NotRun(f"{answer['absent']} is not installed: python -m benchmarks setup")
        if "failed" in answer:
            raise NotRun(answer["failed"])
        return answer

    def _death(self) -> str:
        self._process.wait()
        self._log.seek(0)
        said = [line.strip() for line in self._log.read().splitlines() if line.strip()]
        return f"its process ended with {self._process.returncode}: {said[-1] if said else 'it said nothing'}"[:300]


class Processes:
    """The processes of a group, each kept for the next row that asks for it.

    Some libraries take ten seconds to import.
    """

    def __init__(self, interpreters: Mapping[str, str]) -> None:
        self.interpreters = interpreters
        self._running: dict[tuple[str, str], Process] = {}

    def of(self, environment: str, name: str) -> Process:
        """The process of a contestant."""
        if environment not in self.interpreters:
            raise NotRun(NO_PEERS)
        if (environment, name) not in self._running:
            self._running[environment, name] = Process(self.interpreters[environment])
        return self._running[environment, name]

    def drop(self, environment: str, name: str) -> None:
        """End it: it has died, or is still at what took too long."""
        if process := self._running.pop((environment, name), None):
            process.end()

    def close(self) -> None:
        for key in list(self._running):
            self.drop(*key)


@contextlib.contextmanager
def started(peers: Path) -> Iterator[Processes]:
    """Processes of this environment and of that of the peers, if it is there, until the end of the block."""
    interpreters = {"here": sys.executable}
    for python in (peers / "bin" / "python", peers / "Scripts" / "python.exe"):
        if python.is_file():
            interpreters["peers"] = str(python)
    with contextlib.closing(Processes(interpreters)) as processes:
        yield processes

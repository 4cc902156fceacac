"""The processes that time things, as seen from the one that asks them."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

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
        self.interpreter = interpreter
        self._log = tempfile.TemporaryFile("w+")  # noqa: SIM115 – closed by `end`
        self._folder = tempfile.TemporaryDirectory(prefix="ksmea-benchmarks-")  # for what libraries leave behind
        paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        self._process = subprocess.Popen(
            [interpreter, "-m", "benchmarks.harness.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            cwd=self._folder.name,
            env=os.environ | ONE_THREAD | {"PYTHONPATH": paths, "PYTHONWARNINGS": "ignore"},
        )
        self._answers = b""

    def end(self) -> None:
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._log):
            if stream is not None:
                stream.close()
        self._folder.cleanup()

    def ask(self, limit: float, **request: Any) -> dict[str, Any]:
        """The answer to a request within `limit` s, or `NotRun`."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise NotRun(self._death()) from None
        answer: dict[str, Any] = json.loads(self._line(limit))
        if "absent" in answer:
            raise NotRun(f"{answer['absent']} is not installed: python -m benchmarks setup")
        if "failed" in answer:
            raise NotRun(answer["failed"])
        return answer

    def _line(self, limit: float) -> bytes:
        assert self._process.stdout is not None
        end = time.monotonic() + limit
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            while b"\n" not in self._answers:
                if not selector.select(max(end - time.monotonic(), 0.0)):
                    raise NotRun(f"takes more than {limit:g} s")
                read = os.read(self._process.stdout.fileno(), 65536)
                if not read:
                    raise NotRun(self._death())
                self._answers += read
        line, _, self._answers = self._answers.partition(b"\n")
        return line

    def _death(self) -> str:
        self._process.wait()
        self._log.seek(0)
        said = [line.strip() for line in self._log.read().splitlines() if line.strip()]
        return f"its process ended with {self._process.returncode}: {said[-1] if said else 'it said nothing'}"[:300]


class Processes:
    """The processes of a group, each kept for the next row that asks for it: some libraries take ten seconds to import."""

    def __init__(self, interpreters: Mapping[str, str]) -> None:
        self.interpreters = interpreters
        self._running: dict[tuple[str, str], Process] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exception_type: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in self._running.values():
            process.end()
        self._running.clear()

    def of(self, environment: str, name: str) -> Process:
        """The process of a contestant."""
        if environment not in self.interpreters:
            raise NotRun(NO_PEERS)
        if (environment, name) not in self._running:
            self._running[environment, name] = Process(self.interpreters[environment])
        return self._running[environment, name]

    def drop(self, environment: str, name: str) -> None:
        """End it: it has died, or is still at what took too long."""
        process = self._running.pop((environment, name), None)
        if process is not None:
            process.end()


def interpreters(peers: Path) -> dict[str, str]:
    """The interpreter of each environment by name; that of the peers where it is there."""
    found = {"here": sys.executable}
    python = next(
        (path for path in (peers / "bin" / "python", peers / "Scripts" / "python.exe") if path.is_file()), None
    )
    if python is not None:
        found["peers"] = str(python)
    return found


def versions(process: Process, libraries: Sequence[str]) -> dict[str, str | None]:
    """Which version of each library a process has."""
    known: dict[str, str | None] = process.ask(60.0, do="version", of=list(libraries))["versions"]
    return known

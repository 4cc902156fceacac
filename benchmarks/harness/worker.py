"""A process that prepares a task and times it.

`python -m benchmarks.harness.worker DESCRIPTOR`, an end of a pipe.

A request is the name of a method of `Worker` with its arguments, its answer what that returns. `{"failed": "…"}` says what went wrong,
`{"absent": "…"}` which module is not installed. Standard library alone, so that it runs beside any library. CPU seconds are
those of this process and of the processes that it has started and waited for.
"""

from __future__ import annotations

import gc
import importlib
import importlib.metadata
import resource
import sys
import time
from multiprocessing.connection import Connection
from typing import Any

from benchmarks.harness.task import Task


class Worker:
    """One task at a time, so that no row pays for the memory of another."""

    task: Task | None = None
    result: Any = None  # of the last call

    def prepare(self, task: str, settings: dict[str, Any], library: str) -> dict[str, Any]:
        self.task = self.result = None
        module, _, function = task.partition(":")
        self.task = getattr(importlib.import_module(module), function)(**settings)
        return {"units": self.task.units, "version": _version(library)}

    def run(self, turn: int, calls: int) -> dict[str, Any]:
        """Seconds of so many calls together, and how good the last one was.

        Nothing is collected meanwhile, as `timeit` does.
        """
        task = self.task
        gc.collect()
        gc.disable()
        cpu, wall = cpu_seconds(), time.perf_counter()
        for _ in range(calls):
            result = task.run(turn)
        wall, cpu = time.perf_counter() - wall, cpu_seconds() - cpu
        gc.enable()
        self.result = result
        return {
            "cpu": cpu,
            "wall": wall,
            "quality": None if task.quality is None else float(task.quality(result)),
            "parts": {} if task.parts is None else task.parts(result),
        }

    def values(self) -> dict[str, Any]:
        """Result of the last call, as nested lists.

        Arrays of two versions of numpy do not read each other.
        """
        if self.task.values is None:
            return {"values": None}
        import numpy as np  # not before something is to be compared: a process that times starts bare

        return {"values": np.asarray(self.task.values(self.result)).tolist()}


def cpu_seconds() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _version(library: str) -> str | None:
    try:
        return importlib.metadata.version(library)
    except importlib.metadata.PackageNotFoundError:
        return None


def main(descriptor: int) -> None:
    requests, worker = Connection(descriptor), Worker()
    while True:
        try:
            method, arguments = requests.recv()
        except EOFError:
            return
        try:
            answer = getattr(worker, method)(**arguments)
        except ModuleNotFoundError as error:
            answer = {"absent": str(error.name)}
        except Exception as error:
            answer = {"failed": f"{type(error).__name__}: {error}".splitlines()[0][:300]}
        requests.send(answer)


if __name__ == "__main__":
    main(int(sys.argv[1]))

"""A process that prepares tasks and times them: a request and its answer are a line of JSON each.

    python -m benchmarks.harness.worker

| request | answer |
|---|---|
| `{"do": "prepare", "name": …, "task": "module:function", "settings": {…}}` | `{"units": …}` |
| `{"do": "run", "name": …, "turn": 3, "calls": 20}` | `{"cpu": s, "wall": s, "quality": …, "parts": …}` of all calls together |
| `{"do": "values", "name": …, "file": …}` | `{}`; the file holds what the last run gave, as numpy writes it |
| `{"do": "version", "of": ["numpy", …]}` | `{"versions": {…}}` |

An answer `{"failed": "…"}` says what went wrong, `{"absent": "…"}` which module is not installed. Standard library alone, so that
it runs beside any library. CPU seconds are those of this process and of the processes that it has started and waited for.
"""

from __future__ import annotations

import gc
import importlib
import importlib.metadata
import json
import os
import resource
import sys
import time
from typing import Any

from benchmarks.harness.task import Task


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what libraries print is no answer
    tasks: dict[str, Task] = {}
    results: dict[str, Any] = {}
    for line in sys.stdin:
        try:
            answer = answered(json.loads(line), tasks, results)
        except ModuleNotFoundError as error:
            answer = {"absent": str(error.name)}
        except Exception as error:
            answer = {"failed": f"{type(error).__name__}: {error}".splitlines()[0][:300]}
        answers.write(json.dumps(answer) + "\n")


def answered(request: dict[str, Any], tasks: dict[str, Task], results: dict[str, Any]) -> dict[str, Any]:
    """The answer to one request."""
    name = request.get("name", "")
    match request["do"]:
        case "prepare":
            tasks.clear()  # of one row at a time, so that no row pays for the memory of another
            results.clear()
            module, _, function = request["task"].partition(":")
            tasks[name] = getattr(importlib.import_module(module), function)(**request["settings"])
            return {"units": tasks[name].units}
        case "run":
            return timed(tasks[name], request, results)
        case "values":
            return saved(tasks[name], results[name], request["file"])
        case "version":
            return {"versions": {library: _version(library) for library in request["of"]}}
        case other:
            raise ValueError(f"a request: expected prepare, run, values or version, got {other}")


def timed(task: Task, request: dict[str, Any], results: dict[str, Any]) -> dict[str, Any]:
    """Seconds of so many calls, and how good the last one was. Nothing is collected meanwhile, as `timeit` does."""
    turn, calls = request["turn"], range(request["calls"])
    gc.collect()
    gc.disable()
    cpu, wall = cpu_seconds(), time.perf_counter()
    for _ in calls:
        result = task.run(turn)
    wall, cpu = time.perf_counter() - wall, cpu_seconds() - cpu
    gc.enable()
    results[request["name"]] = result
    return {
        "cpu": cpu,
        "wall": wall,
        "quality": None if task.quality is None else float(task.quality(result)),
        "parts": {} if task.parts is None else task.parts(result),
    }


def saved(task: Task, result: Any, file: str) -> dict[str, Any]:
    import numpy as np  # not before something is to be compared: a process that times starts bare

    if task.values is None:
        return {"none": True}
    np.save(file, np.asarray(task.values(result)))
    return {}


def cpu_seconds() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _version(library: str) -> str | None:
    try:
        return importlib.metadata.version(library)
    except importlib.metadata.PackageNotFoundError:
        return None


if __name__ == "__main__":
    main()

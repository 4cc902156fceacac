"""What many records cost: collecting 100 000 of them, calling a finished sweep of 10 000 runs again, a run's overhead.

    python benchmarks/many_records.py [--collect 100000] [--resume 10000] [--overhead 500]

Records are copies of one real run's. Times and memory are those of whole processes.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench.jobs.records import RecordWriter, read_records
from bench.plan.plan import Plan, all_runs, read_plan, write_plan

CHEAPEST = ["optimizer.generations=1", "optimizer.population=5", "method.max_updates=1", "surrogate=none", "samples=25"]
LIMITS = {"collect": "30 s and 1000 MB", "resume": "5 s", "overhead": "5 ms"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--collect", type=int, default=100_000)
    parser.add_argument("--resume", type=int, default=10_000)
    parser.add_argument("--overhead", type=int, default=500)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        _bench(place, "repetitions=1", "output=real", *CHEAPEST)
        plan = read_plan(place / "real")
        record = next(iter(read_records(place / "real").values())).content()

        runs = all_runs(plan.cells, arguments.collect, plan.versions)
        _fill(place / "many", dataclasses.replace(plan, runs=runs), record)
        took, memory = _bench(place, "collect", "many")
        print(f"collecting {arguments.collect} records: {took:.1f} s, {memory:.0f} MB (limit {LIMITS['collect']})")

        command = [f"repetitions={arguments.resume}", "output=resumed", *CHEAPEST]
        runs = all_runs(plan.cells, arguments.resume, plan.versions)
        _fill(place / "resumed", dataclasses.replace(plan, runs=runs), record)
        size = (place / "resumed" / "records" / "batch-0000.jsonl").stat().st_size
        took, _ = _bench(place, *command)
        assert (place / "resumed" / "records" / "batch-0000.jsonl").stat().st_size == size, "something was computed"
        print(f"calling a finished sweep of {arguments.resume} runs again: {took:.1f} s (limit {LIMITS['resume']})")

        started = time.monotonic()
        _bench(place, f"repetitions={arguments.overhead}", "workers=1", "output=overhead", *CHEAPEST)
        took = (
            time.monotonic() - started - _bench(place, "repetitions=1", "workers=1", "output=overhead1", *CHEAPEST)[0]
        )
        own = sum(line.elapsed for line in read_records(place / "overhead").values())
        overhead = (took - own) / arguments.overhead
        print(f"overhead of a run beyond its own work: {1e3 * overhead:.2f} ms (limit {LIMITS['overhead']})")


def _bench(folder: Path, *words: str) -> tuple[float, float]:
    """Seconds and peak megabytes of one call."""
    started = time.monotonic()
    program = f"import sys; sys.argv[1:] = {json.dumps(words)}; from bench.__main__ import main; main()"
    subprocess.run([sys.executable, "-c", program], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - started, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def _fill(output: Path, plan: Plan, record: dict) -> None:
    """A finished experiment, every run with a copy of the same record."""
    write_plan(plan, output)
    with RecordWriter(output, 0, plan) as writer:
        for run in plan.runs:
            writer.started(run)
            writer.result(run, record)


if __name__ == "__main__":
    main()

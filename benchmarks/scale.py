"""Cost of many runs of an empty model: plan, record, status, collect, resume, claims and start.

It is for 10² to 10⁵ runs; the start is a job's.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.scale [--runs 100,1000,10000,100000] [--rows benchmarks/scale.csv]

Each step is a process of its own. A row has its CPU and wall seconds, peak memory, how often it opened a file of the results'
folder, and how many files and bytes lie there. Records are copies of one real run's, written by the real writer, 100 runs in each
batch. The step `run` alone computes: what 100 runs in one worker cost beyond their own work. Sizes that the file of rows has
are not measured again.

The exponents are those of n between the two largest sizes, in what they cost more than the smallest. A simulation of a million runs, from these figures, follows.
"""

from __future__ import annotations

import argparse
import dataclasses
import heapq
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench import main as bench_main
from bench.jobs.claims import Claims, clear, deal
from bench.jobs.presence import at_work
from bench.jobs.records import RecordWriter, read_records
from bench.jobs.work import Job, work
from bench.plan.plan import all_runs, read_plan, write_plan

# An empty model: nothing but the method's own bookkeeping is left of a run.
EMPTY = ["optimizer.generations=1", "optimizer.population=5", "method.max_updates=1", "surrogate=none", "samples=25"]
REAL, MANY = "real", "many"  # folders: of two runs that were computed, of copies of their second
PER_BATCH = 100  # runs
RUN, N_RUN = "run", 100  # a step of its own, and its runs
COLUMNS = ["step", "runs", "cpu_s", "wall_s", "memory_mb", "opened", "files", "megabytes"]

# The simulation: runs that take seconds with a heavy tail, on a cluster that gives so many cores at once.
MILLION, CORES = 1_000_000, 100
MEDIAN, SPREAD = 1.2, 1.0  # s and ln s of lognormal run times: 1.2 s is a run of Table 3
SUBMITTED = 0.6  # s a job from submission to start: eight empty jobs through Slurm take 3.6 to 6.2 s


def plan(n: int) -> None:
    """The plan of n runs, written and read."""
    real = read_plan(Path(REAL))
    write_plan(dataclasses.replace(real, runs=all_runs(real.cells, n, real.versions)), Path(MANY))


def record(n: int) -> None:
    """A started line and a result of every run."""
    real, many = read_plan(Path(REAL)), read_plan(Path(MANY))
    content = read_records(Path(REAL))[
        real.runs[1].key
    ].content()  # the first keeps curves for figures, all others do not
    for batch in range(0, n, PER_BATCH):
        with RecordWriter(Path(MANY), batch // PER_BATCH, many) as writer:
            for run in many.runs[batch : batch + PER_BATCH]:
                writer.started(run)
                writer.result(run, content)


def status(n: int) -> None:
    """`status` of n finished runs."""
    bench_main.run(["status", MANY])


def collect(n: int) -> None:
    """`collect` of them, with its figure."""
    bench_main.run(["collect", MANY])


def resume(n: int) -> None:
    """Second call of a finished command, which finds nothing to do."""
    bench_main.run([f"repetitions={n}", f"output={MANY}", *EMPTY])


def claim(n: int) -> None:
    """All runs dealt out, and claimed and ended by one job.

    The job takes as long for each as a run of Table 3.
    """
    output = Path(MANY)
    deal(output, [run.key for run in read_plan(output).runs], n // PER_BATCH)
    with at_work(output, 0) as presence:
        claims = Claims(output, presence)
        while taken := claims.take(MEDIAN, 1):
            for key in taken[1]:
                claims.done(key)
    clear(output)


def job(n: int) -> None:
    """The start of one job, which finds nothing to do."""
    work(Job(Path(MANY)))


STEPS: dict[str, Callable[[int], None]] = {
    step.__name__: step for step in (plan, record, status, collect, resume, claim, job)
}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", default="100,1000,10000,100000")
    parser.add_argument("--rows", type=Path, default=Path("benchmarks/scale.csv"))
    parser.add_argument("--step", nargs=2, help=argparse.SUPPRESS)  # what the processes of single steps are told
    words = parser.parse_args()
    if words.step:
        print(json.dumps(measured(STEPS[words.step[0]], int(words.step[1]))), file=sys.stderr)
        return
    for n in map(int, words.runs.split(",")):
        if n not in set(done(words.rows).query("step != @RUN")["runs"]):
            add(words.rows, rows_of(n))
    if RUN not in set(done(words.rows)["step"]):
        add(words.rows, [run_row()])
    frame = pd.read_csv(words.rows).sort_values("runs", kind="stable")
    print(frame.to_string(index=False, float_format="%.4g"))
    print(exponents(frame).to_string(float_format="%.2f"))
    print(simulated(frame).to_string(index=False, float_format="%.3g"))


def done(path: Path) -> pd.DataFrame:
    """The rows that a file has."""
    return pd.read_csv(path) if path.exists() else pd.DataFrame(columns=COLUMNS)


def add(path: Path, rows: list[dict[str, Any]]) -> None:
    made = pd.DataFrame(rows, columns=COLUMNS)
    made.to_csv(path, mode="a", header=not path.exists(), index=False, float_format="%.4g", lineterminator="\n")


def rows_of(n: int) -> list[dict[str, Any]]:
    """All steps at n runs, one after the other in a folder of their own."""
    with tempfile.TemporaryDirectory() as folder:
        _bench(Path(folder), "repetitions=2", f"output={REAL}", *EMPTY)
        return [_row(step, n, Path(folder)) for step in STEPS]


def _row(step: str, n: int, folder: Path) -> dict[str, Any]:
    command = [sys.executable, "-m", "benchmarks.scale", "--step", step, str(n)]
    root = str(Path(__file__).parents[1])
    paths = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = os.environ | {"PYTHONPATH": paths}
    done = subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True, text=True)
    files = [path for path in (folder / MANY).rglob("*") if path.is_file()]
    there = {"files": len(files), "megabytes": sum(path.stat().st_size for path in files) / 1e6}
    return {"step": step, "runs": n, **json.loads(done.stderr.splitlines()[-1]), **there}


def measured(step: Callable[[int], None], n: int) -> dict[str, float]:
    """CPU and wall seconds of a step, peak memory in MB, and number of files it opened.

    Its imports are included.
    """
    opened = 0
    inside = str(Path(MANY).absolute())

    def count(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal opened
        if event == "open" and isinstance(arguments[0], (str, os.PathLike)):
            opened += os.path.abspath(os.fspath(arguments[0])).startswith(inside)

    sys.addaudithook(count)
    started = time.monotonic()
    step(n)
    used = resource.getrusage(resource.RUSAGE_SELF)
    return {
        "cpu_s": used.ru_utime + used.ru_stime,
        "wall_s": time.monotonic() - started,
        "memory_mb": _peak_memory(),
        "opened": opened,
    }


def _peak_memory() -> float:
    """Peak memory of this process, MB; `getrusage` has that of the process it was forked from among it."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:")) / 1024


def run_row() -> dict[str, Any]:
    """Wall seconds that N_RUN runs in one worker cost beyond their own work."""
    with tempfile.TemporaryDirectory() as folder:
        place, beyond = Path(folder), []
        for n in (1, N_RUN + 1):
            took = _bench(place, f"repetitions={n}", "workers=1", f"output=n{n}", *EMPTY)
            beyond.append(took - sum(line.elapsed or 0.0 for line in read_records(place / f"n{n}").values()))
    return {"step": RUN, "runs": N_RUN, "wall_s": beyond[1] - beyond[0]}


def _bench(folder: Path, *words: str) -> float:
    """Wall seconds of one call of the command line."""
    started = time.monotonic()
    subprocess.run([sys.executable, "-m", "bench", *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - started


def exponents(frame: pd.DataFrame) -> pd.DataFrame:
    """Of n between the two largest sizes, in what they cost more than the smallest."""
    found: dict[str, dict[str, float]] = {}
    for step, mine in frame[frame["step"] != RUN].groupby("step", sort=False):
        more = mine.iloc[-2:]
        found[str(step)] = {
            name: _slope(more["runs"].to_numpy(float), (more[name] - mine[name].iloc[0]).to_numpy(float))
            for name in ("cpu_s", "memory_mb", "opened")
        }
    return pd.DataFrame(found).T


def _slope(n: np.ndarray, cost: np.ndarray) -> float:
    return float(np.polyfit(np.log(n), np.log(cost), 1)[0]) if (cost > 0).all() else 0.0


def simulated(frame: pd.DataFrame) -> pd.DataFrame:
    """A million runs on a cluster, for several numbers of runs in a job.

    Each job starts, does its runs one after the other, and the next takes its core. Every cost is proportional to the
    runs, as the largest size has it.
    """
    largest = frame[frame["runs"] == frame["runs"].max()].set_index("step")
    factor = MILLION / largest["runs"].iloc[0]
    seconds = largest["cpu_s"] * factor
    per_run = float(frame.loc[frame["step"] == RUN, "wall_s"].iloc[0]) / N_RUN
    runs = np.random.default_rng(0).lognormal(np.log(MEDIAN), SPREAD, MILLION) + per_run
    rows = []
    for n in (100, 1000, 10_000):
        jobs = runs.reshape(-1, n).sum(axis=1) + seconds["job"] + SUBMITTED
        cores = [0.0] * CORES
        for took in jobs:
            heapq.heappush(cores, heapq.heappop(cores) + took)
        rows.append(
            {
                "runs a job": n,
                "jobs": len(jobs),
                "hours": (max(cores) + seconds["plan"] + seconds["collect"]) / 3600,
                "without overhead": runs.sum() / CORES / 3600,
                "idle share": 1 - sum(cores) / (CORES * max(cores)),
                "starting share": len(jobs) * seconds["job"] / jobs.sum(),
                "gigabytes": largest["megabytes"].max() * factor / 1e3,
            }
        )
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main()

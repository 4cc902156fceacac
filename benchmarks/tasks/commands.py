"""Whole commands, each a process of its own in a folder of the task's own.

Start and imports are included.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from itertools import count
from pathlib import Path

from benchmarks.harness.task import Task

# One evaluation and no interval: nothing but the bench's own bookkeeping is left of a run.
EMPTY = ["method=direct", "optimizer=random_search", "optimizer.evaluations=1", "study.intervals=none"]
NOTHING = Path(__file__).parent / "benchopt_nothing"


def importing(module: str) -> Task:
    return _command(["-c", f"import {module}"])


def bench(words: list[str]) -> Task:
    """A command of the command line that changes nothing."""
    return _command(["-m", "bench", *words])


def runs(n: int) -> Task:
    """So many runs that do nothing, a folder of results for each call."""
    folder, numbers = _folder(), count()

    def run(turn: int) -> None:
        _call(folder, "-m", "bench", *EMPTY, f"repetitions={n}", "workers=1", f"output={next(numbers)}")

    return Task(run)


def on_results(words: list[str], n: int) -> Task:
    """A command on finished runs.

    Status, collect, or the experiment's own once more, which computes nothing.
    """
    folder = _folder()
    experiment = [*EMPTY, f"repetitions={n}", "workers=1", "output=done"]
    _call(folder, "-m", "bench", *experiment)
    asked = [*words, "done"] if words else experiment
    return Task(lambda turn: _call(folder, "-m", "bench", *asked))


def table3(workers: int, repetitions: int = 20) -> Task:
    """The main job, Table 3 of the paper: 80 runs."""
    folder, numbers = _folder(), count()
    words = ["+experiment=table3", f"repetitions={repetitions}", f"workers={workers}"]

    def run(turn: int) -> None:
        _call(folder, "-m", "bench", *words, f"output={next(numbers)}")

    return Task(run)


def benchopt(n: int, again: bool = False) -> Task:
    """`benchopt run` of so many solvers that do nothing, one or all hundred.

    `again` finds them in its cache.
    """
    folder = _folder()
    place = folder / "nothing"
    shutil.copytree(NOTHING, place)
    chosen = ["-s", "Nothing[seed=0]"] if n == 1 else []

    def run(turn: int) -> None:
        if not again:
            for made in ("outputs", "__cache__"):
                shutil.rmtree(place / made, ignore_errors=True)
        _call(folder, "-m", "benchopt", "run", str(place), "--no-plot", "--no-html", "-r", "1", *chosen)

    if again:
        run(0)
    return Task(run)


def _command(words: list[str]) -> Task:
    folder = _folder()
    return Task(lambda turn: _call(folder, *words))


def _call(folder: Path, *words: str) -> None:
    done = subprocess.run([sys.executable, *words], cwd=folder, check=False, capture_output=True, text=True)
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise RuntimeError(f"{' '.join(words)} ended with {done.returncode}: {said[-1] if said else ''}")


def _folder() -> Path:
    """Inside the folder of the process, which goes with it."""
    return Path(tempfile.mkdtemp(dir=".")).absolute()

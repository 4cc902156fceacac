"""Kill a sweep again and again, restart it each time, and compare with an undisturbed run.

    python benchmarks/kill_and_restart.py [--kills 30] [--repetitions 50] [--how group|interrupt|worker]

`group` sends SIGKILL to the whole process group at random moments, `interrupt` SIGINT, `worker` SIGKILL to a single
worker process while the rest goes on. It prints how many runs were computed more than once, which must not be more than
were in flight, and whether the tables are identical (times aside). Exit code 1 where they are not.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd

CHEAP = ["optimizer.generations=30", "optimizer.population=50", "method.max_updates=4", "samples=30,40,50,60"]


def main() -> int:
    arguments = _arguments()
    rng = np.random.default_rng(arguments.seed)
    with tempfile.TemporaryDirectory() as folder:
        undisturbed, disturbed = Path(folder) / "undisturbed", Path(folder) / "disturbed"
        took = _run(_command(undisturbed, arguments))
        n_run = 4 * arguments.repetitions
        print(f"undisturbed: {n_run} runs in {took:.1f} s, record files: {len(_record_files(undisturbed))}")
        workers = 2
        kills = 0
        while kills < arguments.kills:
            longest = 2.2 + took / arguments.kills  # s; a call needs about two to get going
            if _disturbed(_command(disturbed, arguments), arguments.how, rng, longest):
                kills += 1
            elif kills:  # it has ended before the kill: what is left is too short to be killed
                break
        _run(_command(disturbed, arguments))
        events = _events(disturbed)
        repeated = sum(count - 1 for count in Counter(key for event, key in events if event == "started").values())
        results = Counter(key for event, key in events if event == "result")
        print(
            f"{kills} kills ({arguments.how}); {repeated} runs were started again, at most {workers} were in flight each time"
        )
        same = all(_same(undisturbed / name, disturbed / name) for name in ("table3.csv", "runs.csv"))
        print(
            f"runs with more than one result: {sum(count > 1 for count in results.values())}; tables identical: {same}"
        )
        return 0 if same and repeated <= workers * max(kills, 1) else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--repetitions", type=int, default=50)
    parser.add_argument("--how", choices=("group", "interrupt", "worker"), default="group")
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


def _command(output: Path, arguments: argparse.Namespace) -> list[str]:
    settings = [*CHEAP, f"repetitions={arguments.repetitions}", "workers=2", f"output={output}"]
    return [sys.executable, "-m", "bench", "+experiment=table3", *settings]


def _run(command: list[str]) -> float:
    started = time.monotonic()
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
    return time.monotonic() - started


def _disturbed(command: list[str], how: str, rng: np.random.Generator, longest: float) -> bool:
    """Start it and kill at a random moment; False where it ended before."""
    process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        process.wait(timeout=rng.uniform(0.3, longest))
        return False
    except subprocess.TimeoutExpired:
        pass
    if how == "worker":
        workers = _workers(process.pid)
        if workers:
            os.kill(int(rng.choice(workers)), signal.SIGKILL)
        process.wait()
        return True
    os.killpg(process.pid, signal.SIGKILL if how == "group" else signal.SIGINT)
    process.wait()
    return True


def _workers(parent: int) -> list[int]:
    """Processes below the fork server of a bench process."""
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    return [
        int(worker) for child in children for worker in Path(f"/proc/{child}/task/{child}/children").read_text().split()
    ]


def _record_files(output: Path) -> list[Path]:
    return list((output / "records").glob("*.jsonl"))


def _events(output: Path) -> list[tuple[str, str]]:
    events = []
    for path in _record_files(output):
        for text in path.read_text(errors="replace").splitlines():
            try:
                line = json.loads(text)
            except ValueError:
                continue
            if "key" in line:
                events.append((line["event"], line["key"]))
    return events


def _same(one: Path, other: Path) -> bool:
    return _timeless(pd.read_csv(one)).equals(_timeless(pd.read_csv(other)))


def _timeless(frame: pd.DataFrame) -> pd.DataFrame:
    if "parameter" in frame:
        return frame[frame["parameter"] != "time"]
    return frame[[column for column in frame if not column.startswith("time")]]


if __name__ == "__main__":
    sys.exit(main())

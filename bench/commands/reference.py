"""Reference results: tables and runs of a released version, each file headed by its origin.

`results/reference/table3.csv` is the table; `table3.runs.csv` holds its runs, if a table is made of several. Both begin
with lines `# {…}`: the plan's head (command, commit, versions, platform) and a line per cell with its settings and
seed.
"""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path
from typing import Any

import pandas as pd

from bench.commands.folders import one_folder
from bench.jobs.lines import RESULTS
from bench.jobs.processors import counted_processors, mixed_processors, processors
from bench.plan.plan import PLAN_FILE, Plan, plan_from_lines, plan_lines, read_plan
from bench.plan.report import report_named
from bench.storage.files import replace_file
from bench.storage.own_files import REFERENCE
from ksmea.errors import SettingError, unknown


def reference(words: list[str]) -> int:
    """`reference NAME|DIR`: make results/reference/ of an experiment that is done, by committed code."""
    for path in write_reference(one_folder(words, "reference")):
        print(f"written: {path}")
    return 0


def write_reference(output: Path, folder: Path = REFERENCE) -> list[Path]:
    """Make the reference of an experiment whose runs are all done, by committed code."""
    plan = read_plan(output)
    if "+" in plan.commit:
        raise SettingError(
            f"{output / PLAN_FILE}: expected results of committed code, got {plan.commit}; commit and run again"
        )
    counts = counted_processors(processors(output), plan)
    for processor in counts:  # one, or it is refused; the plan knows where it was planned
        plan = dataclasses.replace(plan, platform=processor)
    if mixed := mixed_processors(counts):
        raise SettingError(
            f"{output}: expected results of one kind of processor, but {mixed}; choose another output=DIR"
        )
    head = "".join(f"# {json.dumps(_without_place(line))}\n" for line in plan_lines(plan) if line["line"] != "run")
    made = report_named(plan.report.table).make(plan, output)
    if not made.runs["status"].isin(RESULTS).all():
        raise SettingError(f"{output}: expected a result of every planned run; give the experiment's command again")
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, content in made.files.items():
        if not name.endswith(".csv"):
            continue
        path = folder / (f"{plan.name}.runs.csv" if name == "runs.csv" else name)
        replace_file(path, head.encode() + content)
        written.append(path)
    return written


def _without_place(line: dict[str, Any]) -> dict[str, Any]:
    """A plan's line without the folder that it was written to, which is nobody else's."""
    if "command" not in line:
        return line
    return {**line, "command": [word for word in line["command"] if not word.startswith("output=")]}


def reference_tables(folder: Path = REFERENCE) -> list[str]:
    """Names of the tables there that say what they were made from.

    `benchmarks.csv` is times, which nobody computes again.
    """
    return sorted({path.name.partition(".")[0] for path in folder.glob("*.csv") if _has_head(path)})


def _has_head(path: Path) -> bool:
    with path.open(encoding="utf-8") as file:
        return file.read(1) == "#"


def read_reference(table: str, folder: Path = REFERENCE) -> tuple[Plan, pd.DataFrame]:
    """Plan with head and cells, and the runs of a reference table, or the table if it has no file of runs."""
    known = reference_tables(folder)
    if table not in known:
        raise unknown("reference table", table, known)
    path = folder / f"{table}.runs.csv"
    lines = (path if path.is_file() else folder / f"{table}.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    head = [json.loads(line[1:]) for line in lines if line.startswith("#")]
    frame = pd.read_csv(io.StringIO("".join(line for line in lines if not line.startswith("#"))), dtype={"key": str})
    return plan_from_lines(head), frame

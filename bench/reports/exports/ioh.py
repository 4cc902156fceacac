"""Courses in the format of IOHprofiler, which IOHanalyzer and iohinspector read.

For each algorithm a folder with a JSON file per function and, per dimension, a table of all its runs one after the other, each
below a line of names. Format: IOHexperimenter's `logger::Analyzer` (de Nobel et al., Evol. Comput. 32 (2024) 205–210, doi
10.1162/evco_a_00342). `raw_y` is the excess.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bench.reports.exports.courses import COLUMNS, Course, Courses, file_name, file_names, grouped

VERSION = "0.3.22"  # of IOHexperimenter, whose format it is
NAMES = {"cost": "evaluations", "excess": "raw_y", "evaluations": "model_evaluations"}  # that readers ask for
HEADER = [NAMES.get(column, column) for column in COLUMNS]
OF_A_RUN = ("seed", "repetition", "jacobian_price")


def write_ioh(found: Courses, output: Path) -> None:
    """Write a folder for each algorithm."""
    algorithms = grouped(found.courses, "algorithm")
    folders = file_names(algorithm for (algorithm,), _ in algorithms)
    for (algorithm,), courses in algorithms:
        for (function, family), group in grouped(courses, "function", "family"):
            name = f"f{function}_{file_name(family)}"
            folder = output / folders[algorithm]
            (folder / f"data_{name}").mkdir(parents=True)
            scenarios = []
            for (unknowns,), runs in grouped(group, "unknowns"):
                path = f"data_{name}/IOHprofiler_f{function}_DIM{unknowns}.dat"
                (folder / path).write_text("".join(map(_table, runs)), encoding="utf-8")
                scenarios.append({"dimension": unknowns, "path": path, "runs": [*map(_run, runs)]})
            meta = {
                "version": VERSION,
                "suite": found.experiment,
                "function_id": function,
                "function_name": family,
                "maximization": False,
                "algorithm": {"name": algorithm, "info": f"commit {found.commit}"},
                "run_attributes": OF_A_RUN,
                "attributes": HEADER,
                "scenarios": scenarios,
            }
            (folder / f"IOHprofiler_{name}.json").write_text(json.dumps(meta, indent=1), encoding="utf-8")


def _table(course: Course) -> str:
    rows = [HEADER, *([f"{value:.17g}" for value in row] for row in course.values)]
    return "".join(" ".join(row) + "\n" for row in rows)


def _run(course: Course) -> dict[str, Any]:
    """A run's entry. The point itself is in no trace."""
    best = int(course.excess.argmin())
    return {
        "instance": course.place.instance,
        "evals": int(course.costs[-1]),
        "best": {"evals": int(course.costs[best]), "y": float(course.excess[best]), "x": []},
        **{name: getattr(course, name) for name in OF_A_RUN},
    }

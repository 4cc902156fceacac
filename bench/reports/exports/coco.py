"""Courses in the format of COCO, which cocopp reads: an archive for each algorithm.

In an archive is an index file (`.info`) per function, with three lines per dimension, and per dimension two equal tables of all
runs, each run below a line of names: the `.dat` that cocopp reads by values and the `.tdat` that it reads by evaluations. Format:
the `bbob` logger of Hansen et al., Optim. Methods Softw. 36 (2021) 114–144, doi 10.1080/10556788.2020.1808977. Fopt is 0 and the
function's value the excess.

No suite is named: cocopp takes what names none as its own functions of the same numbers, and knows no others.
"""

from __future__ import annotations

import io
import tarfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bench.reports.exports.courses import Course, Courses, file_names, grouped

# The last target of cocopp, which takes no value of 0 or less: a lower excess is as good.
PRECISION = 1e-8
HEADER = (
    "% function evaluation | noise-free fitness - Fopt (0.000000000000e+00) | best noise-free fitness - Fopt"
    " | measured fitness | best measured fitness\n"
)


def write_coco(found: Courses, output: Path) -> None:
    """Write an archive for each algorithm."""
    algorithms = grouped(found.courses, "algorithm")
    names = file_names(algorithm for (algorithm,), _ in algorithms)
    for (algorithm,), courses in algorithms:
        with tarfile.open(output / f"{names[algorithm]}.tar.gz", "w:gz") as archive:
            for (function,), group in grouped(courses, "function"):
                entries = []
                for (unknowns,), runs in grouped(group, "unknowns"):
                    path = f"data_f{function}/bbobexp_f{function}_DIM{unknowns}"
                    table = "".join(map(_table, runs))
                    for ending in (".dat", ".tdat"):
                        _add(archive, f"{names[algorithm]}/{path}{ending}", table)
                    entries.append(_entry(names[algorithm], function, unknowns, f"{path}.dat", runs, found))
                _add(archive, f"{names[algorithm]}/bbobexp_f{function}.info", "\n".join(entries))


def _entry(name: str, function: int, unknowns: int, path: str, runs: Sequence[Course], found: Courses) -> str:
    """The three lines of a function in a dimension; each run as instance:cost|last value."""
    head = f"funcId = {function}, DIM = {unknowns}, Precision = {PRECISION:.3e}, algId = '{name}'"
    ends = [f"{run.place.instance}:{int(run.costs[-1])}|{_values(run)[-1]:.1e}" for run in runs]
    return f"{head}\n% {found.experiment}, commit {found.commit}\n{', '.join([path, *ends])}\n"


def _table(course: Course) -> str:
    rows = [f"{int(cost)} {' '.join([f'{value:+10.9e}'] * 4)}\n" for cost, value in zip(course.costs, _values(course))]
    return HEADER + "".join(rows)


def _values(course: Course) -> np.ndarray:
    return np.maximum(course.excess, PRECISION)


def _add(archive: tarfile.TarFile, name: str, text: str) -> None:
    content = text.encode()
    entry = tarfile.TarInfo(name)
    entry.size = len(content)
    archive.addfile(entry, io.BytesIO(content))

"""Courses as one long table: a row for each improvement and end of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from bench.reports.exports.courses import COLUMNS, Courses
from bench.reports.tables import csv_text

OF_PLACE = ("algorithm", "family", "unknowns", "instance")
OF_RUN = ("seed", "repetition", "jacobian_price")


def write_table(found: Courses, output: Path) -> None:
    """Write `courses.csv`."""
    lengths = [len(course.values) for course in found.courses]
    columns = {name: [getattr(course.place, name) for course in found.courses] for name in OF_PLACE}
    columns |= {name: [getattr(course, name) for course in found.courses] for name in OF_RUN}
    frame = pd.DataFrame({name: np.repeat(np.array(values), lengths) for name, values in columns.items()})
    frame[[*COLUMNS]] = np.concatenate([course.values for course in found.courses])
    (output / "courses.csv").write_text(csv_text(frame), encoding="utf-8")

"""Results of several experiments together: one table, and the figure that needs two of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from bench.jobs.records import read_records
from bench.plan.plan import read_plan
from bench.reports.collect import draw
from bench.reports.identification.agreement_charts import mesh_chart
from bench.reports.identification.summary import curves_by_cell, for_figures
from bench.reports.pages.document import PAGE
from bench.reports.pages.index import write_index
from bench.reports.tables import csv_text
from bench.storage.files import replace_file
from ksmea.errors import visible_lines


def collect_all(output: Path, parts: Sequence[Path]) -> None:
    """One table of all tables, and the figure that needs two of them.

    It has 13 against 21 elements, the paper's Fig. 5.
    """
    frames, true_responses = [], {}
    for part in parts:
        plan = read_plan(part)
        if plan.report.table == "summary":
            frame = pd.read_csv(part / f"{plan.name}.csv")
            frames.append(frame.assign(table=plan.name))
            true_responses[plan.name] = curves_by_cell(plan, read_records(part, for_figures, plan))
    if not frames:
        return
    table = pd.concat(frames, ignore_index=True)
    table.insert(0, "table", table.pop("table"))
    replace_file(output / f"{output.name}.csv", csv_text(table).encode())
    meshes = [curves[min(curves)][0] for name in ("table3", "table4") if (curves := true_responses.get(name))]
    drawn = draw(lambda: {"mesh.png": lambda: mesh_chart(*meshes)}, output)[0] if len(meshes) == 2 else {}
    write_index(output)
    written = [f"{output.name}.csv", *drawn, PAGE]
    print(visible_lines(f"\nwritten to {output}: {', '.join(written)}"))

"""`export ioh|coco|csv NAME|DIR [--out DIR]`: the course of each run for other benchmarks' programs.

`instances.csv` next to it says which settings the numbers of functions and instances stand for. `export measurement` writes a
synthetic measurement (`bench/commands/export_measurement.py`).
"""

from __future__ import annotations

from pathlib import Path

from bench.commands.export_measurement import export_measurement
from bench.commands.folders import one_folder, with_option
from bench.jobs.records import damage_notes, damaged_lines
from bench.plan.plan import read_plan
from bench.reports.exports.coco import write_coco
from bench.reports.exports.courses import read_courses, write_table
from bench.reports.exports.ioh import write_ioh
from bench.reports.tables import csv_text
from bench.storage.files import new_folder
from ksmea.errors import SettingError, unknown, visible

MEASUREMENT = "measurement"
FORMATS = {"ioh": write_ioh, "coco": write_coco, "csv": write_table}


def export(words: list[str]) -> int:
    """Write the files into a new folder, by default in the folder of the results; print their contents."""
    if words[:1] == [MEASUREMENT]:
        return export_measurement(words[1:])
    names, out = with_option(words, "--out", "export")
    if names and names[0] not in FORMATS:
        raise unknown("format of export:", names[0], [*FORMATS, MEASUREMENT])
    if len(names) != 2:
        got = " ".join(names) or "nothing"
        raise SettingError(f"export: expected a format and a folder of results, as ioh contest, got {got}")
    asked, name = names
    folder = one_folder([name], "export")
    output = folder / asked if out is None else Path(out)
    with new_folder(output) as partial:
        plan = read_plan(folder)
        found = read_courses(plan, folder)
        FORMATS[asked](found, partial)
        (partial / "instances.csv").write_text(csv_text(found.instances), encoding="utf-8")
    n_algorithm = len({course.place.algorithm for course in found.courses})
    counts = f"{len(found.courses)} runs (algorithms: {n_algorithm}, instances: {len(found.instances)})"
    left_out = f"; left out: {found.n_left_out} not done or without a known maximum" if found.n_left_out else ""
    print(visible(f"{plan.name}: {counts} in {output}{left_out}"))
    for note in (*plan.notes, *damage_notes(damaged_lines(folder))):
        print(visible(f"note: {note}"))
    return 0

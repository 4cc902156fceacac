"""Long tables of an imported rotor as CSV files next to the rotor file, which names them.

Short ones stay in it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ksmea.units import RPM
from problems.rotor_import.model import Entry, ImportedRotor
from problems.rotor_import.yaml_text import in_unit

MOST_INLINE = 12  # rows: about what a line of a screen holds
UNIT = {
    "k": "N/m",
    "c": "N s/m",
    "m": "kg",
    "r": "N/m",
    "i": "N/m",
    "s": "rpm",
    "f": "rpm",
}  # by a column's first letter


def with_tables_beside(rotor: ImportedRotor, stem: str) -> tuple[ImportedRotor, dict[str, str]]:
    """The rotor with names of files in place of long tables, and the text of each.

    Names begin with `stem`.
    """
    files: dict[str, str] = {}
    parts: dict[str, Any] = {}
    for key, what in (("bearings", "bearing"), ("seals", "seal")):
        parts[key] = [
            _named(entry, f"{stem}_{what}_{number}.csv", files)
            for number, entry in enumerate(getattr(rotor, key), start=1)
        ]
    parts["bearings"] = [
        {**entry, "support": _named(entry["support"], f"{stem}_support_{number}.csv", files)}
        if "support" in entry
        else entry
        for number, entry in enumerate(parts["bearings"], start=1)
    ]
    return replace(rotor, **parts), files


def _named(entry: Entry, name: str, files: dict[str, str]) -> Entry:
    table = entry.get("table")
    if table is None or len(next(iter(table.values()))) <= MOST_INLINE:
        return entry
    files[name] = _csv(table)
    return {**entry, "table": name}


def _csv(table: dict[str, list[float]]) -> str:
    heading = ",".join(f"{name} [{UNIT[name[0]]}]" for name in table)
    speed, *others = table.values()
    columns = [[in_unit(each, RPM) for each in speed], *others]
    rows = [",".join(repr(float(value)) for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([heading, *rows]) + "\n"

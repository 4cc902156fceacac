"""Tables of the evidence pages, generated from the committed results in results/reference."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from plugin_pages import table

REFERENCE = Path(__file__).resolve().parents[2] / "results" / "reference"
Row = Mapping[str, str]
Columns = Sequence[tuple[str, Callable[[Row], str]]]  # heading, cell of a row


def evidence_table(name: str) -> str:
    """Markdown table of one reference result, a row per row of its CSV file that is kept."""
    file, columns = TABLES[name]
    keep = KEEP.get(name, lambda row: True)
    with (REFERENCE / file).open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    rows = [row for row in rows if keep(row)]
    return table([head for head, _ in columns], [[cell(row) for _, cell in columns] for row in rows])


def _of(key: str, digits: int | None = None) -> Callable[[Row], str]:
    """Cell with one column, rounded to significant digits unless None."""

    def cell(row: Row) -> str:
        value = row[key]
        return f"{float(value):.{digits}g}" if digits is not None and value else value or "–"

    return cell


def _share(part: str, whole: str) -> Callable[[Row], str]:
    """Cell "part of whole"."""
    return lambda row: f"{row[part]} of {row[whole]}"


def _interval(low: str, high: str) -> Callable[[Row], str]:
    """Cell with the two ends of an interval in per cent."""
    return lambda row: f"{float(row[low]):.1f}–{float(row[high]):.1f} %"


def _ratio(row: Row) -> str:
    """Ratio of times with its quartiles, three digits."""
    return "{:.3g} ({:.3g}–{:.3g})".format(*(float(row[key]) for key in ("ratio", "ratio_q1", "ratio_q3")))


def _demand(row: Row) -> str:
    """Demanded ratio, and whether it is reached."""
    return f"{float(row['at_least']):g}: {row['reached']}" if row["at_least"] else ""


_CALIBRATION: Columns = (
    ("CRLB, %", _of("crlb_pct", 2)),
    ("bias / CRLB", _of("bias", 2)),
    ("sd / CRLB", _of("sd", 3)),
    ("robust sd / CRLB", _of("spread", 3)),
    ("held by 95 % intervals, %", _of("covered_pct", 3)),
    ("one-sided, %", _of("one_sided_pct", 2)),
    ("right maximum, %", _of("right_basin_pct", 3)),
)
TABLES: Mapping[str, tuple[str, Columns]] = {
    "diagnosis_effects": (
        "diagnosis_effects.csv",
        (
            ("hidden", _of("label")),
            ("visible", _share("clearly_visible", "runs")),
            ("in the group", _of("in_group")),
            ("right location", _of("location_right")),
            ("one effect too many", _of("surplus")),
            ("sizes in their 95 % intervals", _share("sizes_held", "sizes")),
            ("CPU seconds, median", _of("seconds_median", 2)),
        ),
    ),
    "diagnosis_nulls": (
        "diagnosis_nulls.csv",
        (
            ("data", _of("label")),
            ("adequate", _share("adequate", "runs")),
            ("false alarms", _of("false_alarms")),
            ("95 % interval", _interval("false_alarms_pct_low", "false_alarms_pct_high")),
            ("CPU seconds, median", _of("seconds_median", 2)),
        ),
    ),
    "coverage": (
        "coverage.csv",
        (
            ("parameter", _of("parameter")),
            ("data", _of("measurement.kind")),
            ("noise", lambda row: "known" if row["measurement.noise_known"] == "True" else "estimated"),
            *_CALIBRATION,
        ),
    ),
    "efficiency": ("efficiency.csv", (("parameter", _of("parameter")), ("method", _of("label")), *_CALIBRATION)),
    "benchmarks": (
        "benchmarks.csv",
        (
            ("computation", lambda row: f"{row['row']}, {row['size']} {row['size_of']}" if row["size"] else row["row"]),
            ("compared with", _of("contestant")),
            ("time ratio (quartiles)", _ratio),
            ("relative difference", _of("difference", 2)),
            ("demanded", _demand),
        ),
    ),
}
KEEP: Mapping[str, Callable[[Row], bool]] = {
    "benchmarks": lambda row: bool(row["ratio"]) and not row["contestant"].startswith("here: "),
}

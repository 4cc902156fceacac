"""What data would tell about the unknowns, in sentences, and a table of how other data would change it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.records import read_records
from bench.plan.columns import place_columns, run_columns
from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.identifiability_figure import identifiability_figure
from bench.reports.tables import csv_text
from ksmea.show.alike import ALIKE, alike_text
from ksmea.show.style import png
from ksmea.show.text import aligned
from ksmea.units import MICROMETRE, RPM

Record = Mapping[str, Any]

KNOWN_PCT, TOLD_PCT = 20.0, 100.0  # half-widths up to which an unknown counts as known, and as told at all
PART = 0.1  # smaller parts of a direction are not mentioned
FAR = 1e4  # %; larger half-widths are not printed: they say no more, and rounding is in them
MOST_CELLS = 4  # with a figure and a table of variations each; the file has all
COLUMNS = ("variation", "value", "parameter", "unit", "true", "bound", "bound_pct", "level", "half_width_pct")


@dataclass(frozen=True)
class IdentifiabilityReport(Report):
    study: ClassVar[str] = "identifiability"

    def make(self, plan: Plan, output: Path) -> Made:
        records = read_records(output, RunLine.content)
        runs = plain_runs(plan, records)
        told = told_by_cell(plan, records)
        frame = identifiability_frame(plan, told)
        return Made(
            "\n\n".join(_cell_text(plan, cell, told[cell], place < MOST_CELLS) for place, cell in enumerate(told)),
            {f"{plan.name}.csv": csv_text(frame).encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            lambda: _figures(plan, told),
        )


def plain_runs(plan: Plan, records: Mapping[str, Record]) -> pd.DataFrame:
    """A row per planned run: where it stands and what became of it."""
    return pd.DataFrame([run_columns(plan, run, records.get(run.key)) for run in plan.runs])


def told_by_cell(plan: Plan, records: Mapping[str, Record]) -> dict[int, Record]:
    """The record of each cell that has a result; nothing is random in it, so that the first one says it all."""
    found: dict[int, Record] = {}
    for run in plan.runs:
        record = records.get(run.key)
        if record is not None and record["status"] in RESULTS:
            found.setdefault(run.cell, record)
    return dict(sorted(found.items()))


def identifiability_frame(plan: Plan, told: Mapping[int, Record]) -> pd.DataFrame:
    """Tidy table: a row per cell, variation, value and parameter; `true` and `bound` (1 σ) in the parameter's unit,
    `half_width_pct` that of the interval at `level`. The data as they are are the variation 'present'."""
    rows = []
    for cell, record in told.items():
        for variation, value, bounds in cases(record):
            for parameter, bound in zip(record["parameters"], bounds):
                pct = bound_pct(bound, parameter["true"])
                row = (
                    *(variation, value, parameter["name"], parameter["unit"]),
                    *(parameter["true"] / parameter["si_per_unit"], bound / parameter["si_per_unit"]),
                    *(pct, record["level"], record["sigmas"] * pct),
                )
                rows.append({"cell": cell, **place_columns(plan, plan.cells[cell]), **dict(zip(COLUMNS, row))})
    return pd.DataFrame(rows, columns=None if rows else ["cell", *plan.axes, *COLUMNS])


def cases(record: Record) -> Iterator[tuple[str, str, np.ndarray]]:
    """Variation, value in words and 1-σ bounds (d,), SI, infinite where the record has null: the present data first."""
    yield "present", "", _bounds([parameter["bound"] for parameter in record["parameters"]])
    for entry in record["variations"]:
        yield entry["variation"], value_text(entry["variation"], entry["value"]), _bounds(entry["bound"])


def value_text(variation: str, value: Any) -> str:
    if variation == "band":
        return f"{value[0] / RPM:.0f}–{value[1] / RPM:.0f} rpm"
    if variation == "position":
        return f"{value:.4g} m"
    return f"× {value:g}" if variation == "noise" else str(value)


def bound_pct(bound: float, true: float) -> float:
    """In per cent of the value; of 0 there is none."""
    return 100 * bound / abs(true) if true else np.nan


def _bounds(values: list[float | None]) -> np.ndarray:
    return np.array([np.inf if value is None else value for value in values])


def _figures(plan: Plan, told: Mapping[int, Record]) -> dict[str, bytes]:
    """One for each of the first cells whose data were varied."""
    drawn = [cell for cell, record in told.items() if record["variations"]][:MOST_CELLS]
    names = [f"{plan.name}{'' if place == 0 else f'_{place + 1}'}.png" for place in range(len(drawn))]
    return {name: png(identifiability_figure(_title(plan, cell), told[cell])) for name, cell in zip(names, drawn)}


def _title(plan: Plan, cell: int) -> str:
    problem = plan.cells[cell].settings["problem"]["name"]
    return problem if len(plan.cells) == 1 else f"{problem}: {cell_name(plan, plan.cells[cell])}"


def _cell_text(plan: Plan, cell: int, record: Record, with_table: bool) -> str:
    lines = [_title(plan, cell), *_sentences(record)]
    if with_table and record["variations"]:
        lines += ["", _variations_text(record)]
    return "\n".join(lines)


def _sentences(record: Record) -> Iterator[str]:
    parameters, sigmas = record["parameters"], record["sigmas"]
    _, _, bounds = next(cases(record))
    widths = [sigmas * bound_pct(bound, item["true"]) for item, bound in zip(parameters, bounds)]
    yield f"With {_data_text(record['data'])}"
    classes: dict[str, list[str]] = {}
    for parameter, width in zip(parameters, widths):
        # a value of 0 has no per cent: it is measured by the bounds of its search
        measure = width if parameter["true"] else 100 * _half_width(record, parameter) / _reach(parameter)
        is_known = "you will know" if measure <= KNOWN_PCT else "only roughly" if measure <= TOLD_PCT else "not told"
        classes.setdefault(is_known, []).append(_known_text(record, parameter, width))
    level = f"{100 * record['level']:g} %"
    if "you will know" in classes:
        yield f"you will know ({level}): {', '.join(classes['you will know'])}"
    if "only roughly" in classes:
        yield f"you will know only roughly: {', '.join(classes['only roughly'])}"
    if "not told" in classes:
        yield f"cannot be told: {', '.join(classes['not told'])}"
    alike = alike_text(record["correlation"], [parameter["name"] for parameter in record["parameters"]])
    yield f"hard to tell apart (correlation beyond ± {ALIKE}): {alike}"
    yield _least_text(record)
    if record["data"]["floor"] == 0 and any(entry["variation"] == "position" for entry in record["variations"]):
        yield (
            "the noise has no floor, so that a probe that sees next to nothing counts as precise; if yours has one, say"
            " measurement.floor=… (µm)"
        )


def _data_text(data: Mapping[str, Any]) -> str:
    n_speed, n_channel = data["n_speed"], len(data["channels"])
    speeds = f"{n_speed} speeds from {data['speed_from'] / RPM:.0f} to {data['speed_to'] / RPM:.0f} rpm"
    if n_speed == 1:
        speeds = f"1 speed of {data['speed_from'] / RPM:.0f} rpm"
    channels = f"{n_channel} channel{'s' if n_channel > 1 else ''} ({', '.join(data['channels'])})"
    values = {"amplitude": "amplitudes", "complex": "complex values"}[data["kind"]]
    parts = [f"{100 * data['relative']:g} %"] if data["relative"] else []
    parts += [f"{data['floor'] / MICROMETRE:g} µm"] if data["floor"] else []
    unknown_level = "" if data["noise_known"] else " of unknown level"
    return f"{speeds}, {channels}, {values} and {' + '.join(parts)} noise{unknown_level}"


def _known_text(record: Record, parameter: Mapping[str, Any], width: float) -> str:
    half_width = _half_width(record, parameter) / parameter["si_per_unit"]
    if width > 1000 or not np.isfinite(half_width):
        return f"{parameter['name']} (± more than 1000 %)"
    in_pct = f" (± {width:.2g} %)" if parameter["true"] and width < 100 else f" (± {width:.0f} %)"
    if not parameter["true"]:
        in_pct = ""
    return f"{parameter['name']} to ± {_number(half_width)} {parameter['unit']}{in_pct}"


def _half_width(record: Record, parameter: Mapping[str, Any]) -> float:
    return np.inf if parameter["bound"] is None else record["sigmas"] * parameter["bound"]


def _reach(parameter: Mapping[str, Any]) -> float:
    return parameter["upper"] - parameter["lower"]


def _least_text(record: Record) -> str:
    """The direction of relative change that the data tell least, its largest part positive."""
    direction = np.array(record["least_told"]["direction"])
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    order = [index for index in np.argsort(-np.abs(direction)) if abs(direction[index]) >= PART]
    parts = [f"{direction[index]:+.2f} {record['parameters'][index]['name']}" for index in order]
    bound = record["least_told"]["bound"]
    width = np.inf if bound is None else 100 * record["sigmas"] * bound
    known = "not at all" if width > 1000 else f"to ± {width:.2g} %" if width < 100 else f"to ± {width:.0f} %"
    return f"told least: a joint relative change of {' '.join(parts)}, known {known}"


def _variations_text(record: Record) -> str:
    """Half-widths in per cent; for a true value of 0 in its unit. A star marks the data as they are."""
    names = [parameter["name"] for parameter in record["parameters"]]
    units = ["%" if parameter["true"] else parameter["unit"] for parameter in record["parameters"]]
    present = {text for variation, text in _present(record["data"])}
    lines, before = [], None
    for variation, value, bounds in cases(record):
        widths = [
            record["sigmas"]
            * (bound_pct(bound, parameter["true"]) if parameter["true"] else bound / parameter["si_per_unit"])
            for parameter, bound in zip(record["parameters"], bounds)
        ]
        first = variation if variation != before else ""
        star = " *" if variation != "present" and f"{variation} {value}" in present else "  "
        lines.append([first, value + star, *map(_number, widths)])
        before = variation
    head = ["±", f"{100 * record['level']:g} %  ", *(f"{name} {unit}" for name, unit in zip(names, units))]
    table = aligned(head, lines)
    return table + ("\n* the data as they are" if any(line[1].endswith("*") for line in lines) else "")


def _present(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What each variation's value is in the data as they are, in words."""
    band = value_text("band", [data["speed_from"], data["speed_to"]])
    yield "speeds", f"speeds {data['n_speed']}"
    yield "band", f"band {band}"
    if len(data["positions"]) == 1:
        yield "position", f"position {value_text('position', data['positions'][0])}"
    yield "noise", f"noise {value_text('noise', 1.0)}"
    yield "kind", f"kind {data['kind']}"


def _number(value: float) -> str:
    """Two digits, whole from 100 on."""
    if not value <= FAR:
        return "> 10⁴" if np.isfinite(value) else "∞"
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"

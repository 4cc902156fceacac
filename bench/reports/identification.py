"""One measurement's identification in plain sentences: values with intervals, what the data cannot tell, the noise, and
how well the fit explains the data; the figure shows data, fit and residuals over speed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from bench.jobs.records import RESULTS, read_records
from bench.plan.columns import place_columns
from bench.plan.naming import cell_name
from bench.plan.plan import Plan, Run
from bench.plan.report import Made, Report
from bench.reports.fit_figure import fit_figure
from bench.reports.tables import csv_text, runs_frame
from ksmea.show.alike import ALIKE, alike_text
from ksmea.show.style import png
from ksmea.units import MICROMETRE, RPM

Record = Mapping[str, Any]

MOST_BLOCKS = 4  # runs with sentences and a figure; the tables have all
SLIGHT = 0.1  # parts of the noise below this part of the whole everywhere are not mentioned
CSV_COLUMNS = ("parameter", "unit", "value", "low", "high", "kind", "bound", "at_bound")


@dataclass(frozen=True)
class IdentificationReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        records = read_records(output)
        runs = runs_frame(plan, output)
        found = {run: records[run.key] for run in plan.runs if records.get(run.key, {}).get("status") in RESULTS}
        frame = identification_frame(plan, found)
        shown = dict(list(found.items())[:MOST_BLOCKS])
        blocks = ["\n".join(_sentences(plan, run, record)) for run, record in shown.items()]
        if len(found) > len(shown):
            blocks.append(f"and {len(found) - len(shown)} more in {plan.name}.csv")
        return Made(
            "\n\n".join(blocks) or "nothing was identified",
            {f"{plan.name}.csv": csv_text(frame).encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            lambda: _figures(plan, shown),
        )


def identification_frame(plan: Plan, found: Mapping[Run, Record]) -> pd.DataFrame:
    """A row per run and parameter, in the parameter's unit; `low` and `high` are empty where the data leave a side open,
    `kind` says how the interval was made, `bound` (1 σ) is the Cramér–Rao bound at the identified values."""
    rows = []
    for run, record in found.items():
        place = place_columns(plan, plan.cells[run.cell])
        for parameter in record["parameters"]:
            in_unit = {name: _in_unit(parameter, name) for name in ("identified", "low", "high", "bound")}
            facts = (parameter["name"], parameter["unit"], *in_unit.values())
            name, unit, value, low, high, bound = facts
            row = (name, unit, value, low, high, parameter.get("interval"), bound, parameter["at_bound"])
            rows.append({**dict(zip(CSV_COLUMNS, row)), "cell": run.cell, "repetition": run.repetition, **place})
    return pd.DataFrame(rows, columns=None if rows else [*CSV_COLUMNS, "cell", "repetition", *plan.axes])


def _in_unit(parameter: Mapping[str, Any], name: str) -> float:
    value = parameter.get(name)
    return np.nan if value is None else value / parameter["si_per_unit"]


def _figures(plan: Plan, shown: Mapping[Run, Record]) -> dict[str, bytes]:
    drawn = [(run, record) for run, record in shown.items() if "fit" in record]
    names = [f"{plan.name}{'' if place == 0 else f'_{place + 1}'}.png" for place in range(len(drawn))]
    return {name: png(fit_figure(_title(plan, run, record), record)) for name, (run, record) in zip(names, drawn)}


def _title(plan: Plan, run: Run, record: Record) -> str:
    """For example 'three_disk, run.csv', and what tells the run from the others."""
    parts = [plan.cells[run.cell].settings["problem"]["name"]]
    parts += [record["data"]["source"]] if "data" in record else []
    parts += [cell_name(plan, plan.cells[run.cell])] if len(plan.cells) > 1 else []
    parts += [f"repetition {run.repetition}"] if any(other.repetition for other in plan.runs) else []
    return ", ".join(parts)


def _sentences(plan: Plan, run: Run, record: Record) -> Iterator[str]:
    yield (
        f"{_title(plan, run, record)}: {_data_text(record['data'])}" if "data" in record else _title(plan, run, record)
    )
    yield from (f"  note: {remark}" for remark in record.get("data", {}).get("remarks", ()))
    for parameter in record["parameters"]:
        yield f"  {_value_text(record, parameter)}"
    if "error" in record.get("interval", {}):
        yield f"no intervals: {record['interval']['error']}"
    yield from _noise_text(record)
    yield f"hard to tell apart (correlation beyond ± {ALIKE}): {_alike_text(record)}"
    yield from _verdict(record)


def _data_text(data: Mapping[str, Any]) -> str:
    n_channel = len(data["channels"])
    kind = {"amplitude": "amplitudes", "complex": "amplitudes and phases"}[data["kind"]]
    return (
        f"{data['n_speed']} speeds from {data['speed_from'] / RPM:.0f} to {data['speed_to'] / RPM:.0f} rpm,"
        f" {n_channel} channel{'s' if n_channel > 1 else ''} ({', '.join(data['channels'])}), {kind}"
    )


def _value_text(record: Record, parameter: Mapping[str, Any]) -> str:
    """For example 'kxx = 50.03 MN/m, 95 % interval [49.92, 50.14]'."""
    name, unit = parameter["name"].replace("_", " "), parameter["unit"]
    value, low, high = (_in_unit(parameter, end) for end in ("identified", "low", "high"))
    digits = _decimals(value, low, high)
    kind, level = parameter.get("interval"), f"{100 * record.get('interval', {}).get('level', 0.95):g} %"
    best = f"{_number(value, digits)} {unit}"
    if kind is None:
        text = f"{name} = {best}"
    elif kind == "not identifiable":
        return f"{name}: not identifiable from these data: any value of the search fits about as well"
    elif np.isnan(low):
        text = f"{name}: at most {_number(high, digits)} {unit} ({level}; best fit {best})"
    elif np.isnan(high):
        text = f"{name}: at least {_number(low, digits)} {unit} ({level}; best fit {best})"
    else:
        text = f"{name} = {best}, {level} interval [{_number(low, digits)}, {_number(high, digits)}]"
        likely = _in_unit(parameter, "likely")
        if abs(likely - value) > SLIGHT * (high - low):
            text += f", most likely {_number(likely, digits)}"
    return text + ("; best fit at a bound of its search (problem.limits)" if parameter["at_bound"] else "")


def _decimals(value: float, low: float, high: float) -> int:
    """Decimals that show an interval's width to two digits, or a value to four."""
    ends = [end for end in (value, low, high) if np.isfinite(end)]
    width = max(ends) - min(ends)
    if width > 0:
        return int(np.clip(1 - np.floor(np.log10(width)), 0, 9))
    return int(np.clip(3 - np.floor(np.log10(abs(value))), 0, 9)) if value else 3


def _number(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}"


def _noise_text(record: Record) -> Iterator[str]:
    """The noise in words: estimated, or as stated."""
    interval = record.get("interval", {})
    if "noise" not in interval:
        return
    noise = interval["noise"]
    if not noise["estimated"]:
        if noise["relative"] == 0:
            yield f"noise as stated datum by datum: {_two_digits(noise['floor'] / MICROMETRE)} µm (rms)"
        else:
            yield f"noise as stated: {_noise_parts(noise['relative'], noise['floor'])}"
        return
    relative, floor = _telling_parts(record, noise["relative"], noise["floor"])
    yield f"noise estimated: {_noise_parts(relative, floor)}"


def _telling_parts(record: Record, relative: float, floor: float) -> tuple[float, float]:
    """The two parts of the noise, zero for one that is next to nothing beside the other at every speed."""
    if "fit" not in record:
        return relative, floor
    amplitude = np.array(record["fit"]["fitted"]["amplitude"])
    if relative * amplitude.max() < SLIGHT * floor:
        return 0.0, floor
    return relative, 0.0 if floor < SLIGHT * relative * amplitude.min() else floor


def _noise_parts(relative: float, floor: float) -> str:
    parts = [f"{_two_digits(100 * relative)} %"] if relative else []
    parts += [f"{_two_digits(floor / MICROMETRE)} µm"] if floor else []
    return " + ".join(parts) or "none"


def _two_digits(value: float) -> str:
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"


def _alike_text(record: Record) -> str:
    if "correlation" not in record:
        return "not computed, without noise"
    names = [parameter["name"].replace("_", " ") for parameter in record["parameters"]]
    return alike_text(record["correlation"], names)


def _verdict(record: Record) -> Iterator[str]:
    """Whether the model explains the data within their noise, as the record's lack-of-fit test has it:
    {"p": float, "statistic": str, "rejected": bool}."""
    if (test := record.get("lack_of_fit")) is None:
        return
    said = f"({test['statistic']}, p = {test['p']:.2g})"
    if test["rejected"]:
        yield f"the model does not explain the data within their noise {said}; +experiment=diagnose looks for the cause"
    else:
        yield f"the model explains the data within their noise {said}"

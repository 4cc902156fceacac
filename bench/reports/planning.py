"""Plans of measurements in plain sentences, with the bounds before and after, and what each candidate alone would gain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.records import read_records
from bench.plan.naming import cell_name, telling_axes
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.tables import csv_text
from ksmea.show.style import OURS, PAPER, REFERENCE, png
from ksmea.show.text import aligned
from ksmea.units import DEGREE, GRAM_MILLIMETRE, RPM, SI_PER_UNIT

ANGLES = SI_PER_UNIT["angle"]  # their values have no size that a bound could be a part of
FAMILIES = ("speeds", "probes", "trial run")
UNPLANNED = {
    "speeds": "as many spread evenly over the present band",
    "probes": "as many data by repeating the present run",
    "trial run": "repeating the present run",
}
MOST_RANGES = 100  # a bound this many times what the search bounds say is no number worth reading
MOST_ROWS = 6  # cells in one figure; more would be a poster
MOST_PHASES = 8  # lines in one panel
CHOSEN = {"marker": "o", "markersize": 8, "markerfacecolor": "none", "markeredgecolor": PAPER, "markeredgewidth": 1.6}
DIRECTION_STYLES = {"x": {"color": OURS}, "y": {"color": "#6a9a3b", "linestyle": "--"}}


@dataclass(frozen=True)
class PlanReport(Report):
    study: ClassVar[str] = "plan"

    def make(self, plan: Plan, output: Path) -> Made:
        records = read_records(output, RunLine.content)
        runs = pd.DataFrame([_run_row(plan, run, records.get(run.key)) for run in plan.runs])
        found = _by_cell(plan, records)
        frame = pd.DataFrame([row for cell, record in found.items() for row in _rows(plan, cell, record)])
        text = "\n\n".join(_text(plan, cell, record) for cell, record in found.items())
        files = {f"{plan.name}.csv": csv_text(frame).encode(), "runs.csv": csv_text(runs).encode()}
        return Made(text, files, runs, lambda: {f"{plan.name}.png": png(plan_figure(plan, found))} if found else {})


def _run_row(plan: Plan, run: Any, record: Mapping[str, Any] | None) -> dict[str, Any]:
    record = record or {"status": "not run"}
    return {
        "key": run.key,
        "cell": run.cell,
        **_place(plan, run.cell),
        "seed": plan.cells[run.cell].seed,
        "repetition": run.repetition,
        "status": record["status"],
        "error": record.get("error", ""),
    }


def _by_cell(plan: Plan, records: Mapping[str, dict[str, Any]]) -> dict[int, dict[str, Any]]:
    """The first result of each cell; nothing is drawn, so that all its repetitions say the same."""
    found: dict[int, dict[str, Any]] = {}
    for run in plan.runs:
        record = records.get(run.key)
        if record is not None and record["status"] in RESULTS:
            found.setdefault(run.cell, record)
    return dict(sorted(found.items()))


def _place(plan: Plan, cell: int) -> dict[str, str | float | None]:
    """Where a cell stands on the axes that tell it from others."""
    place = {axis: plan.cells[cell].place.get(axis) for axis in telling_axes(plan)}
    place = {axis: str(value) if isinstance(value, (list, dict)) else value for axis, value in place.items()}
    return {axis: value for axis, value in place.items() if axis != "samples" or value is not None}


def _rows(plan: Plan, cell: int, record: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """A row per addition and unknown, and one for all unknowns together where they all are the target; bounds in the
    unknown's unit after this and all earlier additions of the family, infinite where nothing is known."""
    for family in record["families"]:
        for order, step in enumerate(family["steps"], start=1):
            start = {
                **_place(plan, cell),
                "target": record["target"] or "all",
                "family": family["family"],
                "order": order,
                "speed_rpm": _over(step.get("speed"), RPM),
                "position_m": step.get("position"),
                "direction": step.get("direction"),
                "unbalance_g_mm": _over(step.get("magnitude"), GRAM_MILLIMETRE),
                "phase_deg": _over(step.get("phase"), DEGREE),
            }
            for index, parameter in enumerate(record["parameters"]):
                before, after, unplanned = (
                    _bound(bounds[index]) for bounds in (record["bound"], step["bound"], step["unplanned_bound"])
                )
                unit, value = parameter["si_per_unit"], abs(parameter["true"])
                yield {
                    **start,
                    "parameter": parameter["name"],
                    "unit": parameter["unit"],
                    "value": parameter["true"] / unit,
                    "before": before / unit,
                    "after": after / unit,
                    "unplanned": unplanned / unit,
                    "before_pct": 100 * before / value if value else None,
                    "after_pct": 100 * after / value if value else None,
                    "unplanned_pct": 100 * unplanned / value if value else None,
                    "gain_pct": _gain(before, after),
                    "unplanned_gain_pct": _gain(before, unplanned),
                }
            if record["target"] is None:
                gains = {key: step[key] for key in ("gain_pct", "unplanned_gain_pct")}
                yield {**start, "parameter": "all", **gains}


def _text(plan: Plan, cell: int, record: Mapping[str, Any]) -> str:
    lines = [f"{cell_name(plan, plan.cells[cell])}:"] if len(plan.cells) > 1 else []
    lines += [_opening(record), *(f"- {_sentence(record, family)}" for family in record["families"])]
    lines += ["", _table(record), ""]
    lines += [f"note: {remark}" for remark in [*record["remarks"], *_outside(record)]]
    lines.append("note: this holds near the values above; bounds are 1 σ of an estimate that uses all the data tell")
    return "\n".join(lines)


def _outside(record: Mapping[str, Any]) -> list[str]:
    """A warning where speeds are to be added beyond the present band."""
    lowest, highest, _ = record["speed"]
    speeds = [step["speed"] for family in record["families"] for step in family["steps"] if "speed" in step]
    if all(lowest <= speed <= highest for speed in speeds):
        return []
    return [
        f"some of these speeds lie outside the present {_rpm(lowest)} to {_rpm(highest)} rpm; study.band=[1,1] stays inside"
    ]


def _opening(record: Mapping[str, Any]) -> str:
    if record["target"] is None:
        hidden = _unknown(record, record["bound"])
        untold = f"; the present data do not tell {', '.join(hidden)}" if hidden else ""
        return f"To know all unknowns better together{untold}:"
    parameter, index = _target(record)
    if record["target"] in _unknown(record, record["bound"]):
        return f"To know {parameter['name']}, which the present data do not tell:"
    return f"To know {parameter['name']} better, its bound being {_sized(record['bound'][index], parameter)} now:"


def _unknown(record: Mapping[str, Any], bounds: Sequence[float | None]) -> list[str]:
    """The unknowns that data tell less of than the bounds of the search do."""
    return [
        parameter["name"]
        for parameter, bound in zip(record["parameters"], bounds)
        if _bound(bound) > parameter["range_sd"]
    ]


def _sentence(record: Mapping[str, Any], family: Mapping[str, Any]) -> str:
    """For example 'add these 2 speeds: 900, 3610 rpm: its bound falls from 21 % to 9.8 % (−54 %); as many …: −9 %'."""
    last, count = family["steps"][-1], len(family["steps"])
    if record["target"] in _unknown(record, last["bound"]):
        many = f"the best {count} {family['family']} leave it unknown"
        none = "no trial run makes it known" if family["family"] == "trial run" else many
        return f"{none}: its bound stays wider than the search bounds"
    effect = _joint_effect if record["target"] is None else _effect
    planned = effect(record, last["bound"], last["gain_pct"])
    unplanned = effect(record, last["unplanned_bound"], last["unplanned_gain_pct"], brief=True)
    return f"{_what(family['steps'])}: {planned}; {UNPLANNED[family['family']]}: {unplanned}"


def _effect(record: Mapping[str, Any], bounds: Sequence[float | None], gain: float | None, brief: bool = False) -> str:
    """What becomes of the target."""
    parameter, index = _target(record)
    before, after = _sized(record["bound"][index], parameter), _sized(bounds[index], parameter)
    if record["target"] in _unknown(record, bounds):
        return "still unknown"
    if record["target"] in _unknown(record, record["bound"]):
        return f"known to {after}" if brief else f"it becomes known to {after}"
    return _change(gain) if brief else f"its bound falls from {before} to {after} ({_change(gain)})"


def _joint_effect(
    record: Mapping[str, Any], bounds: Sequence[float | None], gain: float | None, brief: bool = False
) -> str:
    """What becomes of all unknowns together."""
    still = _unknown(record, bounds)
    told = [name for name in _unknown(record, record["bound"]) if name not in still]
    axis = [] if gain is None else [f"{'' if brief else 'mean half axis of their confidence region '}{_change(gain)}"]
    known = [f"{', '.join(told)} become{'s' * (len(told) == 1)} known"] if told else []
    return ", ".join([*known, *axis]) or "more is told, but too little"


def _what(steps: Sequence[Mapping[str, Any]]) -> str:
    """The additions in words."""
    first = steps[0]
    if "speed" in first:
        speeds = ", ".join(_rpm(speed) for speed in sorted(step["speed"] for step in steps))
        return f"add {f'these {len(steps)} speeds:' if len(steps) > 1 else 'the speed'} {speeds} rpm"
    if "direction" in first:
        probes = " and ".join(f"in {step['direction']} at {step['position']:.4g} m" for step in steps)
        return f"add {'a probe' if len(steps) == 1 else f'{len(steps)} probes,'} {probes}"
    return f"add a second run with {_trial(first)}"


def _rpm(speed: float) -> str:
    return f"{speed / RPM:.{0 if speed > 100 * RPM else 2}f}"


def _trial(step: Mapping[str, Any]) -> str:
    magnitude, phase = step["magnitude"] / GRAM_MILLIMETRE, step["phase"] / DEGREE
    return f"{magnitude:.4g} g mm at {step['position']:.4g} m, {phase:.4g}°"


def _table(record: Mapping[str, Any]) -> str:
    """A line per unknown: its bound now, with each family's choice, and with as many data without a plan."""
    families = [family["family"] for family in record["families"]]
    last = [family["steps"][-1] for family in record["families"]]
    heads = [f"+ {len(family['steps'])} {family['family']}" for family in record["families"]]
    head = ["unknown", "value", "bound now"]
    for name, title in zip(families, heads):
        head += [title if name != "trial run" else "+ trial run", "without plan"]
    lines = []
    for index, parameter in enumerate(record["parameters"]):
        value = parameter["true"] / parameter["si_per_unit"]
        line = [parameter["name"], f"{value:.4g} {parameter['unit']}", _sized(record["bound"][index], parameter)]
        for step in last:
            line += [_sized(step[key][index], parameter) for key in ("bound", "unplanned_bound")]
        lines.append(line)
    return aligned(head, lines)


def _target(record: Mapping[str, Any]) -> tuple[Mapping[str, Any], int]:
    index = [parameter["name"] for parameter in record["parameters"]].index(record["target"])
    return record["parameters"][index], index


def _sized(bound: float | None, parameter: Mapping[str, Any]) -> str:
    """A bound (SI) in per cent of the value; of an angle, and of a value of 0, in its unit."""
    if bound is None or bound > MOST_RANGES * parameter["range_sd"]:
        return "unknown"
    if _is_without_size(parameter):
        return f"{_short(bound / parameter['si_per_unit'])} {parameter['unit']}"
    return f"{_short(100 * bound / abs(parameter['true']))} %"


def _is_without_size(parameter: Mapping[str, Any]) -> bool:
    return parameter["unit"] in ANGLES or not parameter["true"]


def _short(value: float) -> str:
    """Two digits, no exponent: 0.098, 21, 4100."""
    return f"{float(f'{value:.1e}'):.12g}"


def _change(gain: float | None) -> str:
    """A gain as the change of the bound: '−54 %', and 'to 1/250' where per cents would all read 100."""
    if gain is None:
        return "becomes known"
    if gain > 95:
        return f"to 1/{_short(1 / (1 - gain / 100))}"
    if gain < 0.05:
        return "no change"
    return f"−{gain:.2g} %" if gain < 10 else f"−{gain:.0f} %"


def _bound(value: float | None) -> float:
    return math.inf if value is None else value


def _gain(before: float, after: float) -> float | None:
    """How many per cent a bound falls; None where what was not known at all becomes known."""
    if math.isinf(before):
        return 0.0 if math.isinf(after) else None
    return 100 * (1 - after / before)


def _over(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit


def plan_figure(plan: Plan, found: Mapping[int, Mapping[str, Any]]) -> Figure:
    """What each candidate gains if it alone is added: speeds, probes over position, trial unbalances over position; the
    chosen ones are marked. A row per cell. Of a target that is not known yet, the bound with that candidate."""
    cells = list(found)[:MOST_ROWS]
    figure = Figure(figsize=(13, 3.3 * len(cells) + 0.8), layout="constrained")
    panels = figure.subplots(len(cells), 3, squeeze=False)
    for row, cell in zip(panels, cells):
        record = found[cell]
        families = {family["family"]: family for family in record["families"]}
        for panel, name, draw in zip(row, FAMILIES, (_draw_speeds, _draw_probes, _draw_trial_runs)):
            if name in families:
                draw(panel, families[name], record)
                _finish(panel, record)
            else:
                panel.set_axis_off()
                panel.text(0.5, 0.5, f"no {name} considered", ha="center", fontsize=9, transform=panel.transAxes)
        where = f"{cell_name(plan, plan.cells[cell])}\n" if len(plan.cells) > 1 else ""
        figure_label = f"{where}{_quantity(record)}"
        next((panel for panel in row if panel.axison), row[0]).set_ylabel(figure_label, fontsize=9)
    left_out = f" ({len(found) - len(cells)} more cells are not shown)" if len(found) > len(cells) else ""
    figure.suptitle(f"{plan.name}: what each candidate gives by itself, the chosen ones marked{left_out}", fontsize=11)
    return figure


def _shows_bounds(record: Mapping[str, Any]) -> bool:
    """Whether the target is not known yet, so that there is no gain to show."""
    return record["target"] is not None and record["target"] in _unknown(record, record["bound"])


def _counts_prior(record: Mapping[str, Any]) -> bool:
    """Whether gains have to count the choice's weak prior, as some of the unknowns are not known at all."""
    return record["target"] is None and None in record["bound"]


def _quantity(record: Mapping[str, Any]) -> str:
    if record["target"] is None:
        return f"fall of the mean half axis{', with prior' if _counts_prior(record) else ''} (%)"
    if not _shows_bounds(record):
        return f"fall of the bound of {record['target']} (%)"
    parameter, _ = _target(record)
    return f"bound of {record['target']} with one ({parameter['unit'] if _is_without_size(parameter) else '%'})"


def _shown(record: Mapping[str, Any], family: Mapping[str, Any]) -> np.ndarray:
    """What is drawn for each candidate."""
    columns = family["candidates"]
    if record["target"] is None:
        return np.array(columns["criterion_gain_pct" if _counts_prior(record) else "gain_pct"])
    if not _shows_bounds(record):
        return np.array(columns["gain_pct"])
    parameter, _ = _target(record)
    size = parameter["si_per_unit"] if _is_without_size(parameter) else abs(parameter["true"]) / 100
    return np.array([math.nan if bound is None else bound / size for bound in columns["bound"]])


def _draw_speeds(panel: Axes, family: Mapping[str, Any], record: Mapping[str, Any]) -> None:
    speed, shown = np.array(family["candidates"]["speed"]) / RPM, _shown(record, family)
    lowest, highest, _ = record["speed"]
    panel.axvspan(lowest / RPM, highest / RPM, color=REFERENCE, alpha=0.08, linewidth=0, label="present band")
    panel.plot(speed, shown, color=OURS, linewidth=1.3)
    _mark(panel, speed, shown, family)
    panel.set_xlabel("added speed (rpm)")


def _draw_probes(panel: Axes, family: Mapping[str, Any], record: Mapping[str, Any]) -> None:
    position, shown = np.array(family["candidates"]["position"]), _shown(record, family)
    direction = np.array(family["candidates"]["direction"])
    for name, style in DIRECTION_STYLES.items():
        is_so = direction == name
        panel.plot(position[is_so], shown[is_so], marker=".", linewidth=1.3, **style, label=f"in {name}")
    _mark(panel, position, shown, family)
    _draw_unplanned(panel, family, record, "as many data again")
    panel.set_xlabel("position of an added probe (m)")


def _draw_trial_runs(panel: Axes, family: Mapping[str, Any], record: Mapping[str, Any]) -> None:
    columns, shown = family["candidates"], _shown(record, family)
    position, phase = np.array(columns["position"]), np.array(columns["phase"])
    phases = list(dict.fromkeys(columns["phase"]))[:MOST_PHASES]
    for index, value in enumerate(phases):
        blend = index / max(1, len(phases) - 1)
        colour = (0.17 + 0.6 * blend, 0.42 + 0.2 * blend, 0.64 - 0.5 * blend)  # from blue to ochre
        panel.plot(
            position[phase == value],
            shown[phase == value],
            ".-",
            color=colour,
            linewidth=1.1,
            label=f"{value / DEGREE:.4g}°",
        )
    _mark(panel, position, shown, family)
    _draw_unplanned(panel, family, record, "present run again")
    panel.set_xlabel(f"position of a trial unbalance of {columns['magnitude'][0] / GRAM_MILLIMETRE:.4g} g mm (m)")


def _mark(panel: Axes, places: np.ndarray, shown: np.ndarray, family: Mapping[str, Any]) -> None:
    """Rings round the chosen candidates."""
    chosen = [step["candidate"] for step in family["steps"]]
    panel.plot(places[chosen], shown[chosen], linestyle="none", **CHOSEN, label="chosen")


def _draw_unplanned(panel: Axes, family: Mapping[str, Any], record: Mapping[str, Any], label: str) -> None:
    gain = family["steps"][0]["unplanned_gain_pct"]
    if gain is not None and not _shows_bounds(record) and not _counts_prior(record):
        panel.axhline(gain, color=REFERENCE, linestyle=":", label=label)


def _finish(panel: Axes, record: Mapping[str, Any]) -> None:
    if _shows_bounds(record):
        if not any(np.any(np.isfinite(line.get_ydata())) for line in panel.get_lines()):
            panel.text(0.5, 0.5, "still unknown", ha="center", fontsize=9, transform=panel.transAxes)
            panel.set_xticks([])
            panel.set_yticks([])
            return
        panel.set_yscale("log")
        for axis in (panel.yaxis.set_major_formatter, panel.yaxis.set_minor_formatter):
            axis(LogFormatter(minor_thresholds=(2, 0.5)))
        panel.tick_params(which="minor", labelsize=7)
    else:
        panel.set_ylim(bottom=0, top=max(panel.get_ylim()[1], 1e-3) * 1.1)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)
    panel.legend(fontsize=7, ncols=2, loc="best")

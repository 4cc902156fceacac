"""Sections on what data would tell before they are measured: how well unknowns would be known, and what to add."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from bench.plan.page import Block, Folded, Page, Plot, Prose, Section, Table
from bench.reports.plots.traces import ORANGE, axis, layout, line, points, styles
from ksmea.measurement.channel import named
from ksmea.records.identifiability import IdentifiabilityRecord, Variation
from ksmea.records.planning import Family, PlanningRecord
from ksmea.show import identifiability_text, planning_text
from ksmea.show.figures.identifiability_figure import half_widths, label
from ksmea.units import DEGREE, RPM

VARIED = {
    "speeds": "number of speeds in the band",
    "band": "band (rpm), with as many speeds",
    "position": "position of one measuring plane (m)",
    "noise": "noise, times the present",
    "kind": "kind of data",
}
MOST_PCT = 1e4  # half-widths beyond are drawn there


def identifiability_page(
    found: Mapping[str, IdentifiabilityRecord],
    stills: Sequence[str],
    table: pd.DataFrame,
    file: str,
    following: Sequence[Block] = (),
) -> Page:
    """A section for each record, by its title; `following` is what to do next."""
    sections = []
    for number, (title, record) in enumerate(found.items()):
        still = stills[number] if number < len(stills) else ""
        plots = tuple(_variation_plots(record, still))
        sections.append(Section(title or "Result", (Prose(identifiability_text.text(record)), *plots)))
    sections.append(Section("Table", (Folded("All rows", (Table(table, file=file),)),)))
    sections[1:1] = [Section("What to do next", tuple(following))] if following else []
    first = next(iter(found.values()), None)
    return Page("no run has a result" if first is None else _warned(first, _in_short(first)), tuple(sections))


def _warned(record: IdentifiabilityRecord | PlanningRecord, said: str) -> str:
    """A headline, with the lack of fit of the model that it holds for."""
    is_rejected = record.lack_of_fit is not None and record.lack_of_fit.rejected
    start = "The model does not explain the data: diagnose it before you rely on this. With the model as it is: "
    return f"{start}{said}" if is_rejected else said


def _in_short(record: IdentifiabilityRecord) -> str:
    """The sentences that say which unknowns would be known."""
    return "; ".join([*identifiability_text.sentences(record)][1:3])


def _variation_plots(record: IdentifiabilityRecord, still: str) -> Iterator[Plot]:
    by_name: dict[str, list[Variation]] = {}
    for entry in record.variations:
        by_name.setdefault(entry.variation, []).append(entry)
    for number, (name, entries) in enumerate(by_name.items()):
        traces = []
        x = [_abscissa(entry) for entry in entries]
        widths = np.minimum(half_widths([entry.crlb_si for entry in entries], record), MOST_PCT)
        labels = list(map(label, record.parameters))
        for shown, (unknown, (colour, dash)) in zip(widths.T, styles(labels).items()):
            style = {"color": colour, "dash": dash, "width": 1.8}
            traces.append(line(x, shown, unknown, colour, mode="lines+markers", line=style))
        is_number = isinstance(_abscissa(entries[0]), float)
        made = layout(VARIED.get(name, name), f"± {100 * record.level:g} % (% of the value)", y_log=True)
        made["xaxis"] = axis(VARIED.get(name, name), type="linear" if is_number else "category")
        said = f"Half-width of the {100 * record.level:g} % interval of each unknown against the {VARIED.get(name, name)}; above {MOST_PCT:g} % drawn there."
        yield Plot(
            f"With other {name}" if name == "speeds" else f"With another {name}",
            said,
            {"data": traces, "layout": made},
            still if number == 0 else "",
            height=340,
        )


def _abscissa(entry: Variation) -> float | str:
    if isinstance(entry.value, tuple):
        return f"{entry.value[0] / RPM:.0f}–{entry.value[1] / RPM:.0f}"
    return entry.value if isinstance(entry.value, str) else float(entry.value)


def plan_page(
    found: Sequence[tuple[str, str, PlanningRecord]],
    following: Sequence[Block],
    table: pd.DataFrame,
    file: str,
    still: str,
) -> Page:
    """Sections of each plan, by its title and text."""
    sections = []
    for number, (title, text, record) in enumerate(found):
        plots = tuple(
            _family_plot(record, family, still if number + order == 0 else "")
            for order, family in enumerate(record.families)
        )
        sections.append(Section(title or "What to add", (Prose(text), *plots)))
    sections[1:1] = [Section("What to do next", tuple(following))] if following else []
    sections.append(Section("Table", (Folded("All rows", (Table(table, file=file),)),)))
    first = found[0][2] if found else None
    return Page("no run has a result" if first is None else _warned(first, _first_addition(first)), tuple(sections))


def _first_addition(record: PlanningRecord) -> str:
    """The plan's first recommendation in words."""
    lines = planning_text.text(record).splitlines()
    return next((said.removeprefix("- ") for said in lines if said.startswith("- ")), lines[0])


def _family_plot(record: PlanningRecord, family: Family, still: str) -> Plot:
    """What each candidate gives by itself."""
    candidates = family.candidates
    reduction = np.array(candidates.criterion_reduction_pct, dtype=float)
    own = np.array(candidates.reduction_pct, dtype=float)
    shown = own if np.isfinite(own).any() else reduction
    if candidates.speed is not None:
        x, title, groups = np.array(candidates.speed) / RPM, "added speed (rpm)", [""] * len(shown)
    else:
        x, title = np.array(candidates.position), "position (m)"
        phases = [f"{phase / DEGREE:.0f}°" for phase in candidates.phase or ()]
        groups = list(map(named, candidates.direction or ())) or phases or [""] * len(shown)
    traces: list[dict[str, Any]] = []
    for name, (colour, dash) in styles(list(dict.fromkeys(groups))).items():
        mine = np.array([group == name for group in groups])
        style = {"color": colour, "dash": dash, "width": 1.6}
        traces.append(
            line(
                x[mine],
                shown[mine],
                name or family.family,
                colour,
                mode="lines+markers",
                marker={"size": 4},
                line=style,
            )
        )
    chosen = list(family.chosen)
    ring = {"symbol": "circle-open", "size": 13, "line": {"width": 2.5}}
    traces.append(points(x[chosen], shown[chosen], "chosen", ORANGE, marker=ring))
    target = record.target or "all unknowns together"
    made = layout(title, f"CRLB of {target} falls by (%)")
    said = f"By how many per cent the CRLB of {target} falls with each candidate alone; rings: what the plan chooses."
    return Plot(family.family.capitalize(), said, {"data": traces, "layout": made}, still, height=340)

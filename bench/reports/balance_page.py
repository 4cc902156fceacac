"""Sections on a balancing: corrections, the response with and without them, influence coefficients, runs that stand out."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle

import numpy as np

from bench.plan.page import Block, Control, Folded, Page, Plot, Prose, Section, Table
from bench.reports.plots.traces import BLUE, COLOURS, GREEN, ORANGE, axis, layout, level, line, points
from ksmea.records.balancing import BalanceRecord, EntryRecord, PolarRecord
from ksmea.show.balance_text import frame, left_out_frame, text
from ksmea.show.charts.response_charts import AMPLITUDE
from ksmea.units import DEGREE, RPM

SMALLEST_P = 1e-16  # drawn


def balance_page(record: BalanceRecord) -> Page:
    """The page of a balancing."""
    sections = [Section("What was found", (Prose(text(record)),)), Section("Response", (_response_plot(record),))]
    sections.append(Section("Influence coefficients", tuple(_coefficients(record))))
    if record.weights:
        sections.append(Section("Unknown weights", (Table(left_out_frame(record.weights), file="weights.csv"),)))
    if record.runs and (runs := tuple(_run_plots(record))):
        sections.append(Section("Runs in the order of time", runs))
    return Page(headline(record), tuple(sections))


def headline(record: BalanceRecord) -> str:
    """The correction weights in a line."""
    found = record.correction
    weights = [
        f"{weight.size:.4g} g mm at {weight.angle:.0f}° at {position:g} m"
        for position, weight in zip(found.position, found.weight)
    ]
    return f"Correction: {'; '.join(weights)}"


def _name(entry: EntryRecord) -> str:
    return f"{entry.speed / RPM:.0f} rpm, {entry.channel}"


def _response_plot(record: BalanceRecord) -> Plot:
    names, found = [_name(entry) for entry in record.entries], record.correction
    traces = [
        {
            "type": "bar",
            "name": state,
            "x": names,
            "y": [each.size for each in values],
            "marker": {"color": colour},
            "error_y": _bars(values),
        }
        for state, values, colour in (("bare", found.bare, ORANGE), ("with the correction", found.left, BLUE))
    ]
    made = layout("", AMPLITUDE, barmode="group")
    said = (
        "Amplitude of the bare rotor at each speed and channel, and what the correction weights are expected to leave."
    )
    return Plot("Before and after the correction", said, {"data": traces, "layout": made}, "balance.png")


def _bars(values: tuple[PolarRecord, ...]) -> dict[str, object]:
    up = [0.0 if each.high is None else each.high - each.size for each in values]
    down = [0.0 if each.low is None else each.size - each.low for each in values]
    return {"type": "data", "symmetric": False, "array": up, "arrayminus": down, "thickness": 1.2}


def _coefficients(record: BalanceRecord) -> Iterator[Block]:
    """Each plane's coefficients in the complex plane, and their table."""
    planes = [f"{plane.position:g} m" for plane in record.planes]
    names = [_name(entry) for entry in record.entries]
    traces = []
    for plane, place, colour in zip(record.planes, planes, cycle(COLOURS)):
        values = np.array([each.size * np.exp(1j * each.angle * DEGREE) for each in plane.coefficients])
        words = [
            f"{place}, {name}: {each.size:.4g} µm/(g mm) at {each.angle:.1f}°"
            for name, each in zip(names, plane.coefficients)
        ]
        traces.append(
            points(
                values.real,
                values.imag,
                place,
                colour,
                meta={"plane": place},
                text=words,
                hovertemplate="%{text}<extra></extra>",
            )
        )
    made = layout("real part (µm/(g mm))", "imaginary part (µm/(g mm))")
    made["yaxis"] |= {"scaleanchor": "x", "zeroline": True, "constrain": "domain"}
    made["xaxis"] |= {"zeroline": True, "constrain": "domain"}
    controls = (Control("plane", "plane", tuple(planes)),) if len(planes) > 1 else ()
    said = "Influence coefficients of each plane, one dot for each speed and channel; size and angle show on touch or hover."
    yield Plot("In the complex plane", said, {"data": traces, "layout": made}, controls=controls)
    yield Folded("The bare response and all coefficients", (Table(frame(record), file="coefficients.csv"),))


def _run_plots(record: BalanceRecord) -> Iterator[Plot]:
    runs = list(record.runs)
    if record.drift:
        traces = [
            line(
                runs,
                part,
                f"{_name(each.entry)}, {said}",
                colour,
                line={"color": colour, "dash": dash, "width": 1.4},
                meta={"entry": _name(each.entry)},
            )
            for each, colour in zip(record.drift, cycle(COLOURS))
            for part, said, dash in ((each.real, "real", "solid"), (each.imaginary, "imaginary", "dot"))
        ]
        entries = tuple(_name(each.entry) for each in record.drift)
        said = "Drift of the response over the runs: real parts (lines) and imaginary parts (dotted)."
        controls = (Control("entry", "speed and channel", entries, chosen=entries[0]),) if len(entries) > 1 else ()
        yield Plot("Drift", said, {"data": traces, "layout": layout("run", "drift (µm)")}, controls=controls)
    if record.method == "free" and record.run_p:
        p = np.maximum(record.run_p, SMALLEST_P)
        made = layout(
            "run",
            "p of the run's weights",
            y_log=True,
            shapes=[level(record.level / max(record.n_run, 1), dash="dash")],
        )
        made["xaxis"] = axis("run", type="category")
        said = (
            "p of each run's response being that of its known weights; below the dashed line a run does not fit them."
        )
        yield Plot("Runs that do not fit", said, {"data": [points(runs, p, "run", GREEN)], "layout": made}, height=320)

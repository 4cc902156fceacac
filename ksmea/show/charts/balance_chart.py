"""Charts of a balancing: bare response with and without the correction, drift, and misfits.

Drift is over the runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.records.balancing import BalanceRecord, EntryRecord, PolarRecord
from ksmea.show.charts.chart import Axis, Bars, Chart, Choice, Element, Level, Line, Panel, Points, Words, one_panel
from ksmea.show.charts.colours import INTERVAL, MODEL, PAPER, category, symbol
from ksmea.show.charts.response_charts import AMPLITUDE
from ksmea.units import DEGREE, RPM

SMALLEST_P = 1e-16  # drawn
FAR_APART = 20  # largest to smallest amplitude, from which on the axis is logarithmic
MOST_NAMES = 12  # speeds and channels whose names stand below the axis
PAUSE = 10  # times the usual time between runs


def balance_chart(record: BalanceRecord) -> Chart:
    """The response, with drift and runs below it if they exist."""
    panels = [_responses(record)]
    panels += [_drift(record)] if record.drift else []
    panels += [_runs(record)] if record.method == "free" and record.run_p else []
    said = (
        "Amplitude of the bare rotor at each speed and channel, and what the correction weights are expected to leave."
    )
    said += (
        " Drift of the response over the runs: real parts (lines) and imaginary parts (dotted); dashed: a pause."
        if record.drift
        else ""
    )
    if record.method == "free" and record.run_p:
        said += " p of each run's response with its known weights; below the dashed line a run does not fit them."
    return Chart(
        "Before and after the correction", said, tuple((panel,) for panel in panels),
        choices=_choices("entry", "speed and channel", [entry_name(each.entry) for each in record.drift]),
    )  # fmt: skip


def _choices(key: str, label: str, options: Sequence[str]) -> tuple[Choice, ...]:
    return (Choice(key, label, tuple(options)),) if len(options) > 1 else ()


def entry_name(entry: EntryRecord) -> str:
    return f"{entry.speed / RPM:.0f} rpm, {entry.channel}"


def _responses(record: BalanceRecord) -> Panel:
    found, at = record.correction, np.arange(len(record.entries), dtype=float)
    sizes = [each.size for each in (*found.bare, *found.left) if each.size > 0]
    is_log = bool(sizes) and max(sizes) > FAR_APART * min(sizes)  # what is left could not be seen beside what was there
    low = 0.5 * min(sizes) if is_log else None
    bars = [
        _bars(record, values, at + offset, name, colour, low)
        for values, offset, name, colour in (
            (found.bare, -0.2, "bare", PAPER),
            (found.left, 0.2, "with the correction", MODEL),
        )
    ]
    step = 1 + len(at) // MOST_NAMES
    words = {
        float(place): "\n".join([f"{each.speed / RPM:.0f}", *each.channel.split(" at ")])
        for place, each in enumerate(record.entries)
    }
    ticks = {place: words[place] for place in list(words)[::step]}
    return Panel(
        tuple(bars), Axis(ticks=ticks), Axis(AMPLITUDE, "log" if is_log else "linear", low, better="low"), height=2.4
    )


def _bars(
    record: BalanceRecord, values: tuple[PolarRecord, ...], at: np.ndarray, name: str, colour: str, base: float | None
) -> Bars:
    size = np.array([each.size for each in values])
    low, high = (
        np.array([each.size if getattr(each, end) is None else getattr(each, end) for each in values])
        for end in ("low", "high")
    )
    said = [f"{entry_name(entry)}, {name}: {each.size:.3g} µm" for entry, each in zip(record.entries, values)]
    from_base = None if base is None else np.full(len(size), base)
    length = size if from_base is None else size - from_base
    return Bars(at, length, from_base, width=0.4, low=low, high=high, name=name, colour=colour, said=said)


def _drift(record: BalanceRecord) -> Panel:
    """Real parts drawn through, imaginary parts dotted, over the runs in the order of time."""
    at = np.arange(len(record.runs), dtype=float)
    elements: list[Element] = []
    for index, each in enumerate(record.drift):
        colour, name = category(index), entry_name(each.entry)
        for part, values, dash in (("real", each.real, "solid"), ("imaginary", each.imaginary, "dot")):
            said = [f"{run}: {name}, {part} part {value:.3g} µm" for run, value in zip(record.runs, values)]
            elements.append(Line(at, values, dash, 1.0, name=name, colour=colour, said=said, tags={"entry": name}))
    gaps = np.diff(record.run_time)
    for pause in np.flatnonzero(gaps > PAUSE * np.median(gaps)):
        elements.append(Level(at=float(pause) + 0.5, along="x", dash="dash", width=0.6))
    return Panel(
        tuple(elements),
        Axis("run in the order of time", is_whole=True),
        Axis("drift (µm)\nline: real, dotted: imaginary"),
        height=2.4,
    )


def _runs(record: BalanceRecord) -> Panel:
    p, limit = np.maximum(record.run_p, SMALLEST_P), record.level / max(record.n_run, 1)
    points = Points(
        np.arange(len(p), dtype=float),
        p,
        size=3.5,
        colour=INTERVAL,
        said=[f"{run}: p = {each:.2g}" for run, each in zip(record.runs, p)],
    )
    elements: list[Element] = [points, Level(at=limit, dash="dash", width=0.8)]
    for index in np.flatnonzero(p < limit).tolist():
        elements.append(Words(x=index, y=p[index], text=record.runs[index], size=7, offset=(4, 0), side="left"))
    x = Axis("run in the order of time; below the line: a misfit", is_whole=True)
    return Panel(tuple(elements), x, Axis("p of the run's weights", "log"), height=2.4)


def coefficients_chart(record: BalanceRecord) -> Chart:
    """Influence coefficients of each plane in the complex plane."""
    names = [entry_name(entry) for entry in record.entries]
    elements: list[Element] = [
        Level(at=0.0, dash="solid", width=0.6),
        Level(at=0.0, along="x", dash="solid", width=0.6),
    ]
    for index, plane in enumerate(record.planes):
        values = np.array([each.size * np.exp(1j * each.angle * DEGREE) for each in plane.coefficients])
        place = f"{plane.position:g} m"
        said = [
            f"{place}, {name}: {each.size:.4g} µm/({plane.unit}) at {each.angle:.1f}°"
            for name, each in zip(names, plane.coefficients)
        ]
        elements.append(
            Points(
                values.real,
                values.imag,
                symbol(index),
                name=place,
                colour=category(index),
                said=said,
                tags={"plane": place},
            )
        )
    units = sorted({plane.unit for plane in record.planes})
    unit = f"µm/({units[0]})" if len(units) == 1 else "µm per unit of each plane's weights"
    return one_panel(
        elements, Axis(f"real part ({unit})"), Axis(f"imaginary part ({unit})"), "In the complex plane",
        "Influence coefficients of each plane, one dot for each speed and channel; size and angle show on touch or hover.", is_to_scale=True,
        choices=_choices("plane", "plane", [f"{plane.position:g} m" for plane in record.planes]),
    )  # fmt: skip

"""Charts of a balancing: bare response with and without the correction, drift, and misfits.

Drift is over the runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.measurement.notation import LAG, Notation
from ksmea.records.balancing import BalanceRecord, PolarRecord
from ksmea.show.balance_units import entry_name, in_units, influence_unit
from ksmea.show.charts.chart import Axis, Chart, Choice, Element, Level, Line, Panel, Points, Words, one_panel
from ksmea.show.charts.colours import INTERVAL, MODEL, PAPER, category, symbol
from ksmea.show.charts.parts.polar import phase_in_words
from ksmea.show.readings import PLAIN, amplitude_label, deviation_unit, speed_digits, speed_label, speed_unit
from ksmea.units import DEGREE

SMALLEST_P = 1e-16  # drawn
FAR_APART = 20  # largest to smallest amplitude, from which on the axis is logarithmic
MOST_NAMES = 12  # speeds and channels whose names stand below the axis
PAUSE = 10  # times the usual time between runs


def balance_chart(record: BalanceRecord) -> Chart:
    """The response, with drift and runs below it if they exist, in the notation of the data."""
    record = in_units(record, record.notation)
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
    if record.drift and record.notation.phase == LAG:
        said += " Both parts are of phase leads."
    if record.method == "free" and record.run_p:
        said += " p of each run's response with its known weights; below the dashed line a run does not fit them."
    return Chart(
        "Before and after the correction", said, tuple((panel,) for panel in panels),
        choices=_choices("entry", "speed and channel", [entry_name(each.entry, record.notation) for each in record.drift]),
    )  # fmt: skip


def _choices(key: str, label: str, options: Sequence[str]) -> tuple[Choice, ...]:
    return (Choice(key, label, tuple(options)),) if len(options) > 1 else ()


def _responses(record: BalanceRecord) -> Panel:
    found, at = record.correction, np.arange(len(record.entries), dtype=float)
    sizes = [each.size for each in (*found.bare, *found.left) if each.size > 0]
    is_log = bool(sizes) and max(sizes) > FAR_APART * min(sizes)  # what is left could not be seen beside what was there
    low = 0.5 * min(sizes) if is_log else None
    dots = [
        _dots(record, values, at + offset, name, symbol, colour)
        for values, offset, name, symbol, colour in (
            (found.bare, -0.1, "bare", "diamond", PAPER),
            (found.left, 0.1, "with the correction", "circle", MODEL),
        )
    ]
    step = 1 + len(at) // MOST_NAMES
    words = {
        float(place): "\n".join([_speed(each.speed, record.notation), *each.channel.split(" at ")])
        for place, each in enumerate(record.entries)
    }
    ticks = {place: words[place] for place in list(words)[::step]}
    return Panel(
        tuple(dots),
        Axis("" if record.notation.speed == PLAIN.speed else speed_label(record.notation), ticks=ticks),
        Axis(amplitude_label(record.notation), "log" if is_log else "linear", low, better="low"),
        height=2.4,
    )


def _speed(speed: float, notation: Notation) -> str:
    return speed_digits(speed / speed_unit(notation), notation)


def _dots(
    record: BalanceRecord, values: tuple[PolarRecord, ...], at: np.ndarray, name: str, symbol: str, colour: str
) -> Points:
    size = np.array([each.size for each in values])
    low, high = (
        np.array([each.size if getattr(each, end) is None else getattr(each, end) for each in values])
        for end in ("low", "high")
    )
    names = [f"{entry_name(entry, record.notation)}, {name}" for entry in record.entries]
    said = [f"{each}: {value.size:.3g} {deviation_unit(record.notation)}" for each, value in zip(names, values)]
    return Points(at, size, symbol, 6.0, low=low, high=high, name=name, colour=colour, said=said)


def _drift(record: BalanceRecord) -> Panel:
    """Real parts drawn through, imaginary parts dotted, over the runs in the order of time."""
    at = np.arange(len(record.runs), dtype=float)
    elements: list[Element] = []
    unit = deviation_unit(record.notation)
    for index, each in enumerate(record.drift):
        colour, name = category(index), entry_name(each.entry, record.notation)
        for part, values, dash in (("real", each.real, "solid"), ("imaginary", each.imaginary, "dot")):
            said = [f"{run}: {name}, {part} part {value:.3g} {unit}" for run, value in zip(record.runs, values)]
            elements.append(Line(at, values, dash, 1.0, name=name, colour=colour, said=said, tags={"entry": name}))
    gaps = np.diff(record.run_time)
    for pause in np.flatnonzero(gaps > PAUSE * np.median(gaps)):
        elements.append(Level(at=float(pause) + 0.5, along="x", dash="dash", width=0.6))
    return Panel(
        tuple(elements),
        Axis("run in the order of time", is_whole=True),
        Axis(f"drift ({unit})\nline: real, dotted: imaginary"),
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
    """Influence coefficients of each plane in the complex plane, in the notation of the data.

    Points stand at phase leads, as in a polar plot.
    """
    notation, shown = record.notation, in_units(record, record.notation)
    names = [entry_name(entry, notation) for entry in shown.entries]
    elements: list[Element] = [
        Level(at=0.0, dash="solid", width=0.6),
        Level(at=0.0, along="x", dash="solid", width=0.6),
    ]
    lag = f" {LAG}" if notation.phase == LAG else ""
    for index, plane in enumerate(record.planes):
        lead = np.array([each.angle for each in plane.coefficients]) * DEGREE
        coefficients = shown.planes[index].coefficients
        values = np.array([each.size for each in coefficients]) * np.exp(1j * lead)
        place = f"{plane.position:g} m"
        said = [
            f"{place}, {name}: {each.size:.4g} {influence_unit(plane.unit, notation)} at {each.angle:.1f}°{lag}"
            for name, each in zip(names, coefficients)
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
    own = f"{deviation_unit(notation)} per unit of each plane's weights"
    unit = influence_unit(units[0], notation) if len(units) == 1 else own
    turning = f"; {phase_in_words(notation)}" if lag else ""
    return one_panel(
        elements, Axis(f"real part ({unit})"), Axis(f"imaginary part ({unit})"), "In the complex plane",
        f"Influence coefficients of each plane, one dot for each speed and channel; size and angle show on touch or hover{turning}.", is_to_scale=True,
        choices=_choices("plane", "plane", [f"{plane.position:g} m" for plane in record.planes]),
    )  # fmt: skip

"""Half-widths of the intervals with other data.

There is a panel per variation, a line per unknown, or a row of symbols for each value that has a name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.records.identifiability import IdentifiabilityRecord, Unknown, Value, Variation
from ksmea.show.charts.chart import Axis, Chart, Element, Level, Line, Panel, Points, Span, named_rows
from ksmea.show.charts.colours import CONTEXT, styles, symbol
from ksmea.units import RPM

HEADINGS = {
    "speeds": "number of speeds in the band",
    "band": "band (rpm), with as many speeds",
    "position": "position of one measuring plane (m)",
    "noise": "noise, times the present",
    "kind": "kind of data",
    "numbers": "number that is exact",
}
LEAST_PCT, MOST_PCT = 1e-3, 1e4  # what lies beyond is an arrow at the edge


def identifiability_chart(record: IdentifiabilityRecord, title: str = "") -> Chart:
    """Half-widths of the intervals in per cent of the values, with other data.

    They are in per cent of the range of its search for a value of 0 and for an angle, as the legend states. For a
    record without variations, they are with the data as they are.
    """
    by_name: dict[str, list[Variation]] = {}
    unseen = record.least_variations
    for entry in record.variations:
        if entry not in unseen:
            by_name.setdefault(entry.variation, []).append(entry)
    drawn = [_with_other_data(record, name, entries) for name, entries in by_name.items()] or [_as_they_are(record)]
    across = min(len(drawn), 2)
    return Chart(
        f"{title}: how well the unknowns can be known" if title else "How well the unknowns can be known",
        f"Half-widths of the {100 * record.level:g} % intervals; dotted: the data as they are; grey: not even the size is known; arrows:"
        f" above {MOST_PCT:g} %.",
        tuple((panel,) for panel in drawn), across, 4.1 * across + 0.4,
    )  # fmt: skip


def half_widths(crlbs: Sequence[Array], record: IdentifiabilityRecord) -> Array:
    """Half-widths (n, d), %, of CRLBs (n, d), SI."""
    measure = [abs(item.base) or item.upper - item.lower for item in record.parameters]
    widths: Array = 100 * record.sigmas * np.array(crlbs) / measure
    return widths


def label(parameter: Unknown) -> str:
    """Its name, and what its per cent are of where that is not its value."""
    return parameter.name if parameter.base else f"{parameter.name} (% of its range)"


def _with_other_data(record: IdentifiabilityRecord, name: str, entries: Sequence[Variation]) -> Panel:
    """A panel for a variation: rows if its values have names, else lines."""
    return (_rows if name in ("band", "kind", "numbers") else _lines)(record, name, entries)


def _rows(record: IdentifiabilityRecord, name: str, entries: Sequence[Variation]) -> Panel:
    """A row for each value of a variation, with a symbol for each unknown."""
    widths = half_widths([entry.crlb_si for entry in entries], record)
    present = half_widths([record.crlb_si], record)[0]
    elements = list[Element]()
    for number, (unknown, (colour, _)) in enumerate(_styles(record).items()):
        y = np.arange(len(entries), dtype=float) + 0.6 * ((number + 0.5) / len(present) - 0.5)
        x, said = np.minimum(widths[:, number], MOST_PCT), f"{unknown}: ± {{x:.3g}} %"
        elements.append(Points(x, y, symbol(number), name=unknown, colour=colour, said=said))
        elements += _beyond(y, widths[:, number], colour, in_rows=True)
        elements.append(Level(at=min(present[number], MOST_PCT), along="x", colour=colour, opacity=0.7))
    axis = named_rows(_in_words(entry.value) for entry in entries)
    return _panel(record, elements, axis, HEADINGS[name], has_rows=True)


def _lines(record: IdentifiabilityRecord, name: str, entries: Sequence[Variation]) -> Panel:
    """A line for each unknown over the values of a variation."""
    x = np.array([entry.value for entry in entries], dtype=float)
    widths = half_widths([entry.crlb_si for entry in entries], record)
    present = half_widths([record.crlb_si], record)[0]
    elements = list[Element]()
    for number, (unknown, (colour, dash)) in enumerate(_styles(record).items()):
        y, said = np.minimum(widths[:, number], MOST_PCT), f"{unknown}: ± {{y:.3g}} %"
        elements.append(Line(x, y, dash, symbol=symbol(number), name=unknown, colour=colour, said=said))
        elements += _beyond(x, widths[:, number], colour)
        elements.append(Level(at=min(present[number], MOST_PCT), colour=colour, opacity=0.7))
    ticks = None if name == "position" else dict(zip(x.tolist(), (_in_words(entry.value) for entry in entries)))
    scale = Axis("", "log" if name in ("speeds", "noise") else "linear", ticks=ticks)
    return _panel(record, elements, scale, HEADINGS[name])


def _in_words(value: Value) -> str:
    if isinstance(value, tuple):
        return f"{value[0] / RPM:.0f}–{value[1] / RPM:.0f}"
    return value if isinstance(value, str) else f"{value:g}"


def _as_they_are(record: IdentifiabilityRecord) -> Panel:
    """A symbol per unknown."""
    elements = list[Element]()
    for number, (width, (colour, _)) in enumerate(
        zip(half_widths([record.crlb_si], record)[0], _styles(record).values())
    ):
        if width <= MOST_PCT:
            elements.append(Points([number], [width], symbol(number), 7, colour=colour))
        elements += _beyond(np.array([number]), np.array([width]), colour)
    return _panel(record, elements, Axis(ticks=dict(enumerate(_styles(record)))), "the data as they are")


def _beyond(at: Array, widths: Array, colour: str, in_rows: bool = False) -> Iterator[Points]:
    """Arrows where widths (n,) are larger than what is drawn."""
    beyond = widths > MOST_PCT
    if beyond.any():
        ends = np.full(beyond.sum(), MOST_PCT)
        x, y, arrow = (ends, at[beyond], "arrow right") if in_rows else (at[beyond], ends, "arrow up")
        yield Points(x, y, arrow, 8, colour=colour)


def _panel(
    record: IdentifiabilityRecord, elements: Sequence[Element], other: Axis, title: str, has_rows: bool = False
) -> Panel:
    """A panel with the half-widths of the whole chart, upwards or, of rows, to the right."""
    crlbs = [record.crlb_si, *(entry.crlb_si for entry in record.variations)]
    every = half_widths(crlbs, record).clip(LEAST_PCT, MOST_PCT)
    low, high = 0.6 * float(every.min()), 1.7 * max(100.0, float(every.max()))
    unknown = Span(low=100.0, high=10 * MOST_PCT, along="x" if has_rows else "y", colour=CONTEXT)
    widths = Axis(f"± (%), {100 * record.level:g} % interval", "log", low, high, group="widths")
    x, y = (widths, other) if has_rows else (other, widths)
    return Panel((unknown, *elements), x, y, title, max(2.7, 0.3 * len(other.ticks or ()) + 0.8) if has_rows else 2.7)


def _styles(record: IdentifiabilityRecord) -> Mapping[str, tuple[str, str]]:
    """Colour and dash of each unknown, by its label."""
    return styles(list(map(label, record.parameters)))

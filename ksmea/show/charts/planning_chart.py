"""Gain of each candidate of a plan by itself, the chosen ones marked.

A panel per family, over speed or position, or with a row for each number of the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.channel import named
from ksmea.records.planning import Family, PlanningRecord, Unknown, infinite_where_none
from ksmea.show.charts.chart import Along, Axis, Chart, Element, Level, Line, Panel, Points, Span, Words, named_rows
from ksmea.show.charts.colours import CATEGORIES, CONTEXT, DASHES, PAPER
from ksmea.units import DEGREE, GRAM_MILLIMETRE, RPM, SI_PER_UNIT

ANGLES = SI_PER_UNIT["angle"]  # their values have no size that a CRLB could be a part of
MOST_LINES = 8  # in a panel
ACROSS, MOST_CELLS = 3, 6  # plans side by side, and in one picture
HEIGHT = 2.5  # inches, of a panel
COLOURS = (CATEGORIES[0], *CATEGORIES[2:])  # of lines; the one left out is that of the rings
UNPLANNED = {  # what is compared
    "probes": "as many data again",
    "trial run": "present run again",
    "numbers": "present run again",
}
MOST_NUMBERS = 12  # in a panel, the best ones
ROW = 0.24  # inches
EXACT = "number that is exact"


def planning_chart(found: Mapping[str, PlanningRecord], title: str = "") -> Chart:
    """Reduction of the CRLB by each candidate alone.

    If a target is not known yet, its CRLB with that candidate is shown. There is a stack of panels for each plan, below
    the name of its cell.
    """
    stacks = tuple(tuple(_panels(record, name)) or (Panel((), title=name),) for name, record in found.items())
    across = min(len(stacks), ACROSS)
    return Chart(
        f"{title}: what each candidate gives by itself, the chosen ones marked" if title else "What each candidate gives by itself",
        "By how many per cent the CRLB falls if a candidate alone is added, or what it then is where the target is not known yet."
        " Rings: what the plan chooses. Dotted: as many data without a plan.",
        stacks, across, 4.4 * across if across > 1 else 8.0, of_stacks="cell", most=MOST_CELLS,
    )  # fmt: skip


def is_without_size(parameter: Unknown) -> bool:
    """Whether per cent of its value say nothing: of an angle, and of a value of 0."""
    return parameter.unit in ANGLES or not parameter.true


def _panels(record: PlanningRecord, name: str) -> Iterator[Panel]:
    """A panel for each family, the first one titled."""
    n_drawn = 0
    for family in record.families:
        shown = _shown(record, family)
        if not np.isfinite(shown).any():
            none = Axis(low=0, high=1, ticks={})
            yield Panel((Words(x=0.5, y=0.5, text="still unknown"),), none, none, name, HEIGHT)
        elif family.candidates.number is not None:
            yield _of_numbers(record, family, shown, name)
        else:
            yield _over_place(record, family, shown, name, n_drawn)
            n_drawn += len(_lines(family))
        name = ""


def _over_place(record: PlanningRecord, family: Family, shown: Array, title: str, n_drawn: int) -> Panel:
    """A line for each kind of candidate over speed or position; `n_drawn` lines are drawn above."""
    x, axis = _abscissa(family)
    elements: list[Element] = []
    if family.family == "speeds":
        elements.append(
            Span(low=record.speed_from / RPM, high=record.speed_to / RPM, along="x", colour=CONTEXT, opacity=0.1)
        )
    for number, (line, own) in enumerate(_lines(family).items(), start=n_drawn):
        style: dict[str, Any] = {
            "colour": COLOURS[number % len(COLOURS)],
            "dash": DASHES[number // len(COLOURS) % len(DASHES)],
        }
        said = f"{line or 'speed'}: {{y:.3g}} at {{x:.5g}}"
        elements.append(Line(x[own], shown[own], symbol="point" if line else "", name=line, said=said, **style))
    chosen = list(family.chosen)
    elements.append(Points(x[chosen], shown[chosen], "circle", 8, True, name="chosen", colour=PAPER))
    elements += _without_plan(record, family, "y")
    return Panel(tuple(elements), axis, _gain(record, family, shown), title, HEIGHT)


def _of_numbers(record: PlanningRecord, family: Family, shown: Array, title: str) -> Panel:
    """A row for each of the best numbers and of the chosen ones, the best one first."""
    order = [int(index) for index in np.argsort(shown if _is_unknown(record) else -shown, kind="stable")]
    best = [index for index in order if np.isfinite(shown[index])][:MOST_NUMBERS]
    drawn = [index for index in order if index in best or index in family.chosen]
    words = [(family.candidates.number or ())[index] for index in drawn]
    row, size = np.arange(len(drawn), dtype=float), shown[drawn]
    chosen = np.isin(drawn, family.chosen)
    elements = (
        Points(
            size, row, name=EXACT, said=[f"{word}: {each:.3g}" for word, each in zip(words, size)], colour=COLOURS[0]
        ),
        Points(size[chosen], row[chosen], "circle", 8, True, name="chosen", colour=PAPER),
        *_without_plan(record, family, "x"),
    )
    return Panel(
        elements, _gain(record, family, shown), named_rows(words), title or EXACT, max(HEIGHT, ROW * len(drawn) + 0.8)
    )


def _without_plan(record: PlanningRecord, family: Family, along: Along) -> list[Element]:
    unplanned = None if _is_unknown(record) else _unplanned(record, family)
    return [] if unplanned is None else [Level(at=unplanned, along=along, label=UNPLANNED[family.family])]


def _gain(record: PlanningRecord, family: Family, shown: Array) -> Axis:
    """The axis of what candidates give."""
    if _is_unknown(record):
        return Axis(_quantity(record), "log")
    top = max(float(np.nanmax(shown, initial=_unplanned(record, family) or 0.0)), 1e-3)
    return Axis(_quantity(record), low=0, high=1.1 * top)


def _abscissa(family: Family) -> tuple[Array, Axis]:
    """Abscissae of candidates (n,), and their axis."""
    candidates = family.candidates
    if candidates.speed is not None:
        return np.array(candidates.speed) / RPM, Axis("added speed (rpm); grey: the present band")
    if candidates.magnitude is None:
        return np.array(candidates.position), Axis("position of an added probe (m)")
    magnitude = candidates.magnitude[0] / GRAM_MILLIMETRE
    return np.array(candidates.position), Axis(f"position of a trial unbalance of {magnitude:.4g} g mm (m)")


def _lines(family: Family) -> dict[str, Array]:
    """Which candidates (n,) each line of a panel joins, by its name."""
    candidates = family.candidates
    if candidates.direction is not None:
        names = [f"probe in {named(direction)}" for direction in candidates.direction]
    elif candidates.phase is not None:
        names = [f"trial at {phase / DEGREE:.4g}°" for phase in candidates.phase]
    else:
        names = [""] * len(candidates.reduction_pct)
    return {name: np.array(names) == name for name in list(dict.fromkeys(names))[:MOST_LINES]}


def _is_unknown(record: PlanningRecord) -> bool:
    """Whether the target is not known yet, so that a reduction cannot be shown."""
    return record.target is not None and record.target in record.unknown_with(record.crlb)


def _counts_prior(record: PlanningRecord) -> bool:
    """Whether reductions have to count the choice's weak prior.

    They do if some of the unknowns are not known at all.
    """
    return record.target is None and None in record.crlb


def _quantity(record: PlanningRecord) -> str:
    target = record.target_unknown
    if target is None:
        return f"reduction of the mean half axis{', with prior' if _counts_prior(record) else ''} (%)"
    if not _is_unknown(record):
        return f"reduction of the CRLB of {target.name} (%)"
    return f"CRLB of {target.name} with one ({target.unit if is_without_size(target) else '%'})"


def _shown(record: PlanningRecord, family: Family) -> Array:
    """Value drawn for each candidate, NaN if it has none."""
    candidates, target = family.candidates, record.target_unknown
    if target is None and _counts_prior(record):
        return np.array(candidates.criterion_reduction_pct)
    if target is None or candidates.crlb is None or not _is_unknown(record):
        return np.array(candidates.reduction_pct, dtype=float)
    size = target.si_per_unit if is_without_size(target) else abs(target.true) / 100
    crlb = infinite_where_none(candidates.crlb)
    return np.where(np.isinf(crlb), np.nan, crlb / size)


def _unplanned(record: PlanningRecord, family: Family) -> float | None:
    """The reduction by as many data without a plan, %; None if it is not drawn."""
    return family.steps[0].unplanned_reduction_pct if family.family in UNPLANNED and not _counts_prior(record) else None

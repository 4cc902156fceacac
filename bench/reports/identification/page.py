"""Sections on one identification.

They have the findings in words, unknowns with intervals, response, and course of the search.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from bench.plan.page import Block, Drawn, Folded, Page, Prose, Section, Table
from bench.reports.identification.finding import finding
from bench.reports.response_blocks import response_blocks
from ksmea.records.curves import as_array
from ksmea.records.estimate import Shown
from ksmea.records.identification import IdentificationRecord
from ksmea.records.inputs import InputRecord
from ksmea.show import inputs_text
from ksmea.show.charts.chart import Axis, Chart, Line, one_panel
from ksmea.show.charts.colours import category
from ksmea.show.charts.inputs_chart import budget_chart, inputs_chart
from ksmea.show.charts.intervals_chart import intervals_chart
from ksmea.show.charts.responses import of_fit
from ksmea.show.identification_text import identification_chart, table, text, value_table

LEAST_STEPS = 2  # updating steps that make a curve


def identification_page(
    identifications: Sequence[tuple[str, IdentificationRecord, str]], following: Sequence[Block]
) -> Page:
    """The page of identifications, each with its title and the name of its figure as PNG.

    `following` is what to do next.
    """
    if not identifications:
        return Page("nothing was identified")
    record = identifications[0][1]
    sections = [section for each in identifications for section in _sections(*each, several=len(identifications) > 1)]
    sections[1:1] = [Section("What to do next", tuple(following))] if following else []
    return Page(
        finding(record)
        if len(identifications) == 1
        else f"{len(identifications)} identifications, the first: {finding(record)}",
        tuple(sections),
    )


def _sections(title: str, record: IdentificationRecord, still: str, several: bool) -> Iterator[Section]:
    of_which = f": {title}" if several else ""
    yield Section(f"Unknowns{of_which}", tuple(unknowns_blocks(record)))
    yield Section(f"Noise and fit{of_which}", (Prose(text(record, title, with_values=False)),))
    if record.inputs:
        drawn = (Drawn(budget_chart(record.parameters)), *inputs_blocks(record.inputs))
        yield Section(f"Numbers known to a tolerance{of_which}", drawn)
    if record.fit is not None:
        response = of_fit(record.fit, notation=record.notation)
        blocks = response_blocks(response, identification_chart(record, title), still)
        yield Section(f"Response{of_which}", tuple(blocks))
    if len(record.history) >= LEAST_STEPS:
        yield Section(f"Search{of_which}", (Drawn(steps_chart(record)),))


def inputs_blocks(inputs: Sequence[InputRecord]) -> Iterator[Block]:
    """Numbers that the data see, as a plot and a table."""
    if any(each.is_seen for each in inputs):
        yield Drawn(inputs_chart(inputs))
        yield Folded("All numbers that the data see", (Table(inputs_text.table(inputs)),))


def unknowns_blocks(record: IdentificationRecord) -> Iterator[Block]:
    """The table of unknowns, their intervals as a plot, and all that is known of them.

    A rejected model has values alone; intervals with an unknown force are of a model that holds.
    """
    test = record.lack_of_fit
    is_rejected = test is not None and test.rejected
    if is_rejected:
        yield Prose("Values of a model that the data reject have no interval: it would mislead.")
    yield Table(value_table(record))
    beside = {} if record.location is None else {each.name: each.over_sites for each in record.location.coefficients}
    unknowns: dict[str, dict[str, Shown]] = {}
    for part in record.parameters:
        shown = {} if is_rejected else {"identified": part.shown}
        if (other := beside.get(part.name)) is not None:
            shown["with an unknown force"] = other.shown
        unknowns |= {part.name: shown} if shown else {}
    truth = {part.name: part.in_unit(part.true) for part in record.parameters}
    if any(each.has_interval for of in unknowns.values() for each in of.values()):
        crosses = "; crosses: true values" if any(map(math.isfinite, truth.values())) else ""
        caption = f"The interval of each unknown relative to its value{crosses}."
        yield Drawn(intervals_chart(unknowns, truth, caption))
    of_which = ", with intervals as if the model were right" if is_rejected else ""
    yield Folded(f"All columns, and the identification as text{of_which}", (Table(table(record)), Prose(text(record))))


def steps_chart(record: IdentificationRecord) -> Chart:
    """Misfit of the true model at each updating step of the surrogate."""
    steps = list(range(1, len(record.history) + 1))
    lines = [
        Line(steps, as_array(misfits), name=name, colour=category(number), symbol="circle")
        for number, (name, misfits) in enumerate(
            {
                "true model": [update.misfit for update in record.history],
                "surrogate": [update.predicted_misfit for update in record.history],
            }.items()
        )
    ]
    return one_panel(
        lines, Axis("updating step", is_whole=True), Axis("misfit", "log", better="low"), "Updating steps",
        "Misfit at the surrogate's optimum of each updating step, as the surrogate predicts it and as the true model has it.", height=2.6,
    )  # fmt: skip

"""Sections on one diagnosis: verdict, what to do next, effects, response before and after, unknowns, location."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from bench.plan.page import Block, Drawn, Folded, Page, Prose, Section, Table
from bench.reports.diagnosis.location_page import location_blocks
from bench.reports.identification.page import inputs_blocks
from bench.reports.response_blocks import response_blocks
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.show.charts.intervals_chart import intervals_chart
from ksmea.show.charts.ranking_chart import ranking_chart
from ksmea.show.charts.responses import of_diagnosis
from ksmea.show.diagnosis_tables import trials_table, unknowns_table
from ksmea.show.diagnosis_text import diagnosis_chart, text, why_without
from ksmea.show.verdict import headline

RESIDUALS, EFFECTS, LOCATION = "residuals.png", "effects.png", "location.png"


def diagnosis_page(record: DiagnosisRecord, following: Sequence[Block]) -> Page:
    """The page of a diagnosis; `following` is what to do next."""
    sections = [Section("What was found", (Prose(text(record)),))]
    sections += [Section("What to do next", tuple(following))] if following else []
    if record.ranking:
        fits = Folded(f"All {len(record.ranking)} fits, the highest ΔBIC first", (Table(trials_table(record.ranking)),))
        sections.append(Section("Effects", (Drawn(partial(ranking_chart, record), EFFECTS), fits)))
    if (response := of_diagnosis(record)) is not None:
        sections.append(Section("Response", tuple(response_blocks(response, diagnosis_chart(record), RESIDUALS))))
    sections.append(Section("Unknowns", tuple(_unknowns(record))))
    if record.inputs:
        sections.append(Section("Numbers known to a tolerance", tuple(inputs_blocks(record.inputs))))
    if record.location is not None:
        sections.append(
            Section("Without the library", tuple(location_blocks(record.location, LOCATION, why_without(record))))
        )
    return Page(headline(record), tuple(sections))


def _unknowns(record: DiagnosisRecord) -> Iterator[Block]:
    has_after = any(row.after is not None for row in record.coefficients)
    title = "Unknowns as the model is given (before)" + (
        " and with what explains the data (after)" if has_after else ""
    )
    yield Table(unknowns_table(record), title)
    averaged = {} if record.averaged is None else {each.name: each for each in record.averaged.coefficients}
    own = [row for row in record.coefficients if row.before is not None]
    by_series = {
        "before": {row.name: row.before for row in own},
        "after": {row.name: row.after for row in own},
        "averaged": {row.name: averaged.get(row.name) for row in own},
    }
    unknowns = {
        row.name: {series: each.shown for series, of in by_series.items() if (each := of[row.name]) is not None}
        for row in own
    }
    if unknowns:
        without = ", with and without what explains the data" if has_after else ""
        said = f"The intervals of the unknowns of the model as given{without}, relative to the value of the accepted model."
        yield Drawn(intervals_chart(unknowns, {}, said))

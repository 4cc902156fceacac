"""The page of one diagnosis: finding, certainty, two pictures, next steps, other explanations, values.

The evidence is folded.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from bench.plan.page import Block, Command, Drawn, Folded, Grid, Numbers, Page, Prose, Section, Steps, Table
from bench.reports.diagnosis.location_page import location_blocks
from bench.reports.identification.page import inputs_blocks
from bench.reports.response_blocks import response_blocks
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.show import diagnosis_findings as findings
from ksmea.show.charts.cause_charts import cause_chart, others_chart, response_chart
from ksmea.show.charts.chart import Chart
from ksmea.show.charts.intervals_chart import intervals_chart
from ksmea.show.charts.ranking_chart import ranking_chart
from ksmea.show.charts.responses import AS_GIVEN, WITH_CAUSE, of_diagnosis
from ksmea.show.diagnosis_notes import notes
from ksmea.show.diagnosis_tables import trials_table, unknowns_table
from ksmea.show.diagnosis_text import diagnosis_chart, evidence, why_without
from ksmea.show.diagnosis_values import value_table

RESIDUALS, EFFECTS, LOCATION = "residuals.png", "effects.png", "location.png"
FINDING, CAUSE = "finding.png", "cause.png"
PICTURES = (RESIDUALS, EFFECTS, LOCATION, FINDING, CAUSE)
MOST_STEPS = 3


def diagnosis_page(record: DiagnosisRecord, following: Sequence[Block]) -> Page:
    """The page of a diagnosis; `following` are further measurements and commands."""
    notation = record.notation
    sure = Numbers(tuple(findings.certainty(record, notation)))
    remarks = [Prose(said)] if (said := notes(record)) else []
    sections = [Section("", (Prose(findings.meaning(record, notation)), sure, *remarks))]
    if pictures := tuple(_pictures(record)):
        sections.append(Section("", (Grid(pictures, is_wide=True),)))
    if steps := _steps(record, following):
        sections.append(Section("Do next", (Steps(steps),)))
    if others := tuple(_others(record)):
        sections.append(Section("What else it could be", others))
    if not (table := value_table(record)).empty:
        sections.append(Section("Bearings and unbalance", (Table(table, _of_values(record)),)))
    sections.append(Section("Evidence", tuple(_evidence(record))))
    return Page(findings.title(record, notation), tuple(sections), findings.file_line(record, notation))


def pictures_of(record: DiagnosisRecord) -> set[str]:
    """Names of the pictures that the page of a record has."""
    return set(diagnosis_page(record, ()).charts())


def _pictures(record: DiagnosisRecord) -> Iterator[Drawn]:
    charts: dict[str, Chart | None] = {
        FINDING: response_chart(record, record.notation), CAUSE: cause_chart(record, record.notation)
    }  # fmt: skip
    for file, chart in charts.items():
        if chart is not None:
            yield Drawn(chart, file)


def _steps(record: DiagnosisRecord, following: Sequence[Block]) -> tuple[Prose | Command, ...]:
    advice = [Prose(each) for each in findings.checks(record)]
    commands = [each for each in following if isinstance(each, (Prose, Command))]
    return (*advice[: max(1, MOST_STEPS - len(commands))], *commands)[:MOST_STEPS]


def _others(record: DiagnosisRecord) -> Iterator[Block]:
    if (chart := others_chart(record)) is not None:
        yield Drawn(chart, EFFECTS)
    if said := "\n".join(findings.look_alikes(record)):
        yield Prose(said)


def _of_values(record: DiagnosisRecord) -> str:
    if findings.beside(record):
        return "Beside what is located, whatever it is"
    if record.verdict in (findings.LOCATED, findings.UNKNOWN):
        return "Of the model as given, which is rejected"
    if record.averaged is not None:
        return "Averaged over the explanations"
    return "With the cause taken into account" if record.is_explained else ""


def _evidence(record: DiagnosisRecord) -> Iterator[Folded]:
    yield Folded("The diagnosis as text", (Prose(evidence(record)),))
    if record.ranking:
        fits = Table(trials_table(record.ranking))
        ranking = () if others_chart(record) is not None else (Drawn(partial(ranking_chart, record), EFFECTS),)
        yield Folded(f"All {len(record.ranking)} fits, the highest ΔBIC first", (*ranking, fits))
    if (response := of_diagnosis(record, record.notation)) is not None:
        blocks = tuple(response_blocks(response, diagnosis_chart(record), RESIDUALS))
        yield Folded("Response and residuals of all channels", blocks)
    yield Folded("All unknowns, as given and with the cause", tuple(_unknowns(record)))
    if record.inputs:
        yield Folded("Numbers known to a tolerance", tuple(inputs_blocks(record.inputs)))
    if record.location is not None:
        blocks = tuple(location_blocks(record.location, LOCATION, why_without(record)))
        yield Folded("Location without the library", blocks)


def _unknowns(record: DiagnosisRecord) -> Iterator[Block]:
    yield Table(unknowns_table(record))
    averaged = {} if record.averaged is None else {each.name: each for each in record.averaged.coefficients}
    own = [row for row in record.coefficients if row.before is not None]
    by_series = {
        AS_GIVEN: {row.name: row.before for row in own if not record.is_rejected},
        WITH_CAUSE: {row.name: row.after for row in own if record.is_explained},
        "averaged": {row.name: averaged.get(row.name) for row in own},
    }
    unknowns = {
        row.name: {series: each.shown for series, of in by_series.items() if (each := of.get(row.name)) is not None}
        for row in own
    }
    if any(unknowns.values()):
        said = "Intervals of the unknowns of models that are not rejected, relative to the accepted value."
        yield Drawn(intervals_chart(unknowns, {}, said))

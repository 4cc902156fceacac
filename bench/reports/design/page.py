"""Sections on what data would tell before they are measured.

How well unknowns would be known, and what to add.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import pandas as pd

from bench.plan.page import Block, Drawn, Folded, Page, Prose, Section, Table
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.records.planning import PlanningRecord
from ksmea.show import identifiability_text, planning_text
from ksmea.show.charts.identifiability_chart import identifiability_chart
from ksmea.show.charts.planning_chart import planning_chart
from ksmea.show.text import capital, fit_warning


def identifiability_page(
    found: Mapping[str, IdentifiabilityRecord],
    pictures: Sequence[str],
    table: pd.DataFrame,
    file: str,
    following: Sequence[Block] = (),
) -> Page:
    """A section for each record, by its title; `following` is what to do next.

    The headline has the precision that the first record states.
    """
    sections = []
    for number, (title, record) in enumerate(found.items()):
        picture = pictures[number] if number < len(pictures) else ""
        sections.append(Section(title or "Result", tuple(_of_record(record, title, picture))))
    first = next(iter(found.values()), None)
    in_short = "" if first is None else identifiability_text.finding(first)
    return _page(first, in_short, sections, following, table, file)


def _of_record(record: IdentifiabilityRecord, title: str, picture: str) -> Iterator[Block]:
    said = identifiability_text.sentences(record)
    yield Prose("\n".join(map(capital, [*fit_warning(record.lack_of_fit, "the intervals"), *said])))
    if record.variations:
        yield Drawn(partial(identifiability_chart, record, title), picture)
        yield Folded("Half-widths with other data, %", (Prose(identifiability_text.variations_text(record)),))


def plan_page(
    found: Sequence[tuple[str, str, PlanningRecord]],
    following: Sequence[Block],
    table: pd.DataFrame,
    name: str,
) -> Page:
    """Page of all plans, by title, text and record, with a chart; `name`: of the experiment and files."""
    sections = [Section(title or "What to add", (Prose(text),)) for title, text, _ in found]
    if found:
        chart = partial(planning_chart, {title: record for title, _, record in found}, name)
        sections.append(Section("Candidates", (Drawn(chart, f"{name}.png"),)))
    first = found[0][2] if found else None
    in_short = "" if first is None else planning_text.best_addition(first)
    return _page(first, in_short, sections, following, table, f"{name}.csv")


def _page(
    first: IdentifiabilityRecord | PlanningRecord | None,
    in_short: str,
    sections: Sequence[Section],
    following: Sequence[Block],
    table: pd.DataFrame,
    file: str,
) -> Page:
    """The page with what to do next behind its first section.

    Its headline has the lack of fit of the model that it holds for.
    """
    next_steps = [Section("What to do next", tuple(following))] if following else []
    rows = Section("Table", (Folded("All rows", (Table(table, file=file),)),))
    test = None if first is None else first.lack_of_fit
    is_rejected = test is not None and test.rejected
    start = "The model does not explain the data: diagnose it before you rely on this. With the model as it is: "
    said = f"{start if is_rejected else ''}{in_short}" if first is not None else "no run has a result"
    return Page(said, (*sections[:1], *next_steps, *sections[1:], rows))

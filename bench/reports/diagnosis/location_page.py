"""Sections on a location: shaft with all sites tried, action at the best site, and unknowns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from bench.plan.page import Block, Drawn, Folded, Page, Prose, Section, Table
from ksmea.records.location import LocationRecord
from ksmea.show.charts.intervals_chart import intervals_chart
from ksmea.show.charts.location_chart import location_chart
from ksmea.show.location_text import sites_table, text
from ksmea.show.location_words import headline


def location_page(record: LocationRecord, following: Sequence[Block]) -> Page:
    """The page of a location alone."""
    sections = [Section("What was found", (Prose(text(record)),))]
    sections += [Section("What to do next", tuple(following))] if following else []
    return Page(headline(record), (*sections, Section("Sites", tuple(location_blocks(record, "location.png")))))


def location_blocks(record: LocationRecord, file: str = "", about_others: Sequence[str] = ()) -> Iterator[Block]:
    """Shaft and sites, and of a local cause its force over speed and the unknowns.

    `about_others` says why values of the same model elsewhere on the page are others.
    """
    yield Drawn(partial(location_chart, record), file)
    if record.candidates:
        accepted = ["yes" if site.accepted else "no" for site in record.candidates]
        table = Table(sites_table(record, record.candidates).assign(accepted=accepted), file="sites.csv")
        yield Folded(f"All {len(record.candidates)} sites that were tried", (table,))
    unknowns = {
        each.name: {
            name: estimate.shown
            for name, estimate in (
                ("without", each.plain),
                ("beside it", each.best if each.over_sites is None else None),
                ("over all sites", each.over_sites),  # its value is that beside the best site
            )
            if estimate is not None
        }
        for each in record.coefficients
    }
    is_told = record.is_local or bool(about_others)  # of a spread cause only where its values are explained
    if is_told and record.force is not None and unknowns:
        said = "Unknowns without what acts there, and beside it: values at the best site, intervals over all sites."
        yield Drawn(intervals_chart(unknowns, {}, " ".join([said, *about_others])))

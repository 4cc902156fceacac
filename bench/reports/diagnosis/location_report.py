"""A location in plain sentences, as `location.json`, as the extended model's file and as a figure.

For several runs it states how much of the shaft was accepted.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from bench.jobs.lines import RunLine
from bench.jobs.records import read_records
from bench.plan.page import Page, Prose, Section
from bench.plan.plan import Cell, Plan
from bench.plan.report import Made, Report
from bench.reports.by_cell import only_result, result_runs
from bench.reports.diagnosis.location_page import location_page
from bench.reports.tables import csv_text
from ksmea.extended_model import located_yaml
from ksmea.records.location import NONE, NOTHING, LocationRecord
from ksmea.show.json_units import with_units
from ksmea.show.location_text import about_extension, frame, text
from ksmea.show.text import aligned, number

NO_RESULT = "no run has a result"
OF_THE_BENCH = ("hidden", "seconds")  # fields that location.json does not show
WITHOUT_SITE = {NONE: "unexplained", NOTHING: "with nothing missing"}  # kinds that are no site, in words
OF_ONE_RUN = ("location.json", "extended.yaml", "sites.csv", "location.png")


@dataclass(frozen=True)
class LocationReport(Report):
    study: ClassVar[str] = "locate"

    def make(self, plan: Plan, output: Path) -> Made:
        lines = read_records(output, plan=plan)
        runs = location_runs(plan, lines)
        files: dict[str, bytes] = {"runs.csv": csv_text(runs).encode()}
        if (found := only_result(plan, lines, LocationRecord)) is None:
            text_of_all = _summary(runs)
            page = Page(counts_line(runs), (Section("Result", (Prose(text_of_all),)),))
            return Made(text_of_all, files, runs, outdated=OF_ONE_RUN, page=lambda: page)
        cell, record = found[0], found[1].shown_in(plan.units)
        public = {name: value for name, value in with_units(record).items() if name not in OF_THE_BENCH}
        files["location.json"] = (json.dumps(public, indent=1) + "\n").encode()
        chosen, settings = cell.chosen("problem"), cell.settings["problem"]
        if extended := located_yaml(chosen, settings, record, about_extension(record)):
            files["extended.yaml"] = extended.encode()
        files["sites.csv"] = csv_text(frame(record)).encode()
        return Made(
            f"{text(record)}\n\nwritten: {', '.join(name for name in OF_ONE_RUN if extended or name != 'extended.yaml')}",
            files,
            runs,
            outdated=() if extended else ("extended.yaml",),
            page=lambda: location_page(record, ()),
        )


def location_runs(plan: Plan, lines: Mapping[str, RunLine]) -> pd.DataFrame:
    """A row per planned run: what was found, what was hidden, and the unknowns next to it."""
    return result_runs(plan, lines, LocationRecord, _row)


def _row(record: LocationRecord, _: Cell) -> dict[str, Any]:
    sites = record.sites
    return {
        "kind": record.kind,
        "plain_p": record.plain.p,
        "plain_chi2": record.plain.chi2,
        "best": str(sites[0]) if sites else "",
        "accepted": "; ".join(map(str, sites)),
        "n_accepted": len(sites),
        "n_tried": len(record.candidates),
        "seconds": record.seconds,
        "hidden": "; ".join(f"{effect.effect} ({effect.location})" for effect in record.hidden),
        **{
            f"{each.name}{suffix}": None if estimate is None else getattr(estimate, part)
            for each in record.coefficients
            for suffix, estimate, part in (
                ("_plain", each.plain, "value"),
                ("", each.best, "value"),
                ("_low", each.over_sites, "low"),
                ("_high", each.over_sites, "high"),
            )
        },
    }


def counts_line(runs: pd.DataFrame) -> str:
    """For example 'located: 2 unexplained, 1 force, 1 with nothing missing'."""
    counts = runs["kind"].value_counts() if "kind" in runs else {}
    counted = ", ".join(f"{count} {WITHOUT_SITE.get(outcome, outcome)}" for outcome, count in counts.items())
    return f"located: {counted}" if counted else NO_RESULT


def _summary(runs: pd.DataFrame) -> str:
    """How many runs ended with each kind, and how many sites they accepted."""
    if "kind" not in runs:
        return NO_RESULT
    groups = runs.groupby("kind")
    lines = [
        [str(outcome), str(len(mine)), number(mine["n_accepted"].median()), number(mine["seconds"].median(), 3)]
        for outcome, mine in groups
    ]
    return aligned(["kind", "runs", "accepted (median)", "CPU seconds (median)"], lines)

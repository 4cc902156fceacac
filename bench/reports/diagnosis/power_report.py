"""Power of a diagnosis as tables, figures and a page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.jobs.records import read_records
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.by_cell import result_runs
from bench.reports.diagnosis.power import (
    CLEARLY_VISIBLE,
    DATA,
    EFFECT,
    confusion,
    false_alarms,
    of_right_models,
    power_frame,
    power_row,
    rates,
    with_places,
)
from bench.reports.diagnosis.power_page import power_page
from bench.reports.diagnosis.report import diagnosis_runs
from bench.reports.tables import csv_text, rate
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.show.text import aligned, number

TABLE_NAMES = {"in_set": "in reported set", "sizes_held": "in their intervals", "surplus": "one too many"}


@dataclass(frozen=True)
class DiagnosisPowerReport(Report):
    study: ClassVar[str] = "diagnose"

    def make(self, plan: Plan, output: Path) -> Made:
        lines = read_records(output, plan=plan)
        runs = diagnosis_runs(plan, lines)
        facts = result_runs(plan, lines, DiagnosisRecord, power_row)
        with_effect = with_places(plan, runs.merge(facts[["key", *facts.columns.difference(runs.columns)]], on="key"))
        if with_effect.empty:
            return Made(f"{plan.name}: no result yet", {"runs.csv": csv_text(runs).encode()}, runs)
        right = of_right_models(plan, runs)
        by_effect, by_data = (in_words(rates(with_effect, by)) for by in (EFFECT, DATA))
        shares = confusion(with_effect)
        files = {
            f"{plan.name}.csv": csv_text(power_frame(with_effect)).encode(),
            "confusion.csv": csv_text(shares.rename_axis(EFFECT).reset_index()).encode(),
            "false_alarms.csv": csv_text(false_alarms(right)).encode(),
            "runs.csv": csv_text(runs).encode(),
        }
        tables = {f"By {EFFECT}": by_effect, f"By {DATA}": by_data, "Right models": alarms_in_words(right)}
        tables = {title: table for title, table in tables.items() if not table.empty}
        said = about(with_effect, right, runs)
        text = "\n\n".join([said, *map(_as_text, tables.values())])
        return Made(text, files, runs, page=lambda: power_page(seen(with_effect), said, tables, with_effect, shares))


def about(with_effect: pd.DataFrame, right: pd.DataFrame, runs: pd.DataFrame) -> str:
    """Sentences on the contents of the tables."""
    seconds = pd.concat([with_effect["seconds"], right["seconds"]])
    return (
        f"{len(seconds)} of {len(runs)} runs have a result, {len(right)} of them of right models; tables by effect and kind count draws that"
        f" are expected to leave a deviance of {CLEARLY_VISIBLE:g} or more, rates are with their 95 % intervals."
        " If a limit or the loss of stability comes first, the size is the largest possible one, which leaves less, and"
        " fewer are detected. A data set takes"
        f" {seconds.median():.1f} CPU seconds (median), {seconds.quantile(0.9):.1f} s at most for nine of ten."
    )


def seen(with_effect: pd.DataFrame) -> str:
    """How many draws were detected and how many of these report what is hidden, in a line."""
    every = rates(with_effect, EFFECT).iloc[-1]
    if not every["draws"]:
        return f"No effect is clearly visible in the {len(with_effect)} draws so far"
    return (
        f"{every['detected']} of {every['draws']} clearly visible effects are detected ({every['expected']:.0f} expected);"
        f" {every['in_set']} of these are in the reported set"
    )


def in_words(counts: pd.DataFrame) -> pd.DataFrame:
    """Counts as a table for people: of those detected, shares with their intervals."""
    rows = []
    for row in counts.to_dict("records"):
        by = next(iter(row))
        n = int(row["detected"])
        rows.append(
            {
                by: str(row[by]),
                "draws": str(row["draws"]),
                "detected": f"{n} ({row['expected']:.0f} expected)",
                **{TABLE_NAMES.get(name, name): rate(int(row[name]), n) for name in ("in_set", "first")},
                TABLE_NAMES["surplus"]: str(row["surplus"]),
                "sizes": str(row["sizes"]),
                TABLE_NAMES["sizes_held"]: rate(int(row["sizes_held"]), int(row["sizes"])),
                "s": number(row["seconds"], 2),
            }
        )
    return pd.DataFrame(rows)


def alarms_in_words(right: pd.DataFrame) -> pd.DataFrame:
    """False alarms as a table for people; empty if no run hides nothing."""
    if right.empty:
        return pd.DataFrame()
    found = false_alarms(right)
    words = [rate(int(alarms), int(n)) for _, n, alarms in found.itertuples(index=False)]
    return pd.DataFrame({DATA: found[DATA], "draws": found["draws"].astype(str), "called wrong": words})


def _as_text(table: pd.DataFrame) -> str:
    return aligned(list(table.columns), table.to_numpy().tolist())

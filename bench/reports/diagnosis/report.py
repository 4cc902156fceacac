"""A diagnosis in plain sentences, as `diagnosis.json`, as the extended model's file and as figures.

For several runs it states how often each verdict was reached and whether hidden effects were found.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.records import NOT_FAILED, read_records
from bench.plan.fleet import is_of_fleet
from bench.plan.naming import cell_name, place_columns
from bench.plan.plan import Cell, Plan
from bench.plan.report import Made, Report
from bench.reports.by_cell import hidden_by_cell, hidden_paragraph, only_result, result_runs
from bench.reports.design.next_measurement import CAMPAIGN_FILE, Next, from_here, next_measurement
from bench.reports.design.next_steps import after_diagnosis
from bench.reports.diagnosis.first_names import first_names
from bench.reports.diagnosis.page import PICTURES, diagnosis_page, pictures_of
from bench.reports.diagnosis.power_page import VERDICTS, diagnoses_page
from bench.reports.fleet.report import fleet_report
from bench.reports.fleet.rows import diagnosed
from bench.reports.tables import csv_text, interval
from ksmea.extended_model import extended_yaml
from ksmea.problem.parameters import name_at
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.records.extension import ExplanationRecord
from ksmea.records.hidden import HiddenEffect
from ksmea.show.diagnosis_text import about_extension, text
from ksmea.show.json_units import with_units
from ksmea.show.location_words import in_short
from ksmea.show.text import HIDDEN_COLUMN, aligned, hidden_in_one_line, number

CLEARLY_VISIBLE = 60.0  # deviance drop that the true model makes
SHORT = 1.0  # of a deviance drop that misses this much of it
COLLINEAR = 0.95  # collinearity from which two effects count as one
EXTENDED_FILE = "extended.yaml"
OF_ONE_RUN = ("diagnosis.json", EXTENDED_FILE, CAMPAIGN_FILE, *PICTURES)
OF_THE_BENCH = ("curves", "hidden", "hidden_deviance_drop")  # fields that are no part of what was found


@dataclass(frozen=True)
class DiagnosisReport(Report):
    study: ClassVar[str] = "diagnose"

    def make(self, plan: Plan, output: Path) -> Made:
        lines = read_records(output, plan=plan)
        runs = diagnosis_runs(plan, lines)
        if is_of_fleet(plan):
            return fleet_report(
                plan, runs, lines, DiagnosisRecord, diagnosed, values_in_text=False, outdated=OF_ONE_RUN
            )
        files: dict[str, bytes] = {
            f"{plan.name}.csv": csv_text(summary(plan, runs)).encode(),
            "runs.csv": csv_text(runs).encode(),
        }
        if (found := only_result(plan, lines, DiagnosisRecord)) is None:
            text_of_all = _summary_text(plan, runs)
            return Made(
                text_of_all,
                files,
                runs,
                outdated=OF_ONE_RUN,
                page=lambda: diagnoses_page(plan, text_of_all, summary(plan, runs), runs),
            )
        cell, record = found
        record = record.shown_in(plan.units)
        following = next_measurement(plan, cell, record.split.run if record.split else "", output)
        files["diagnosis.json"] = (json.dumps(public(record, following), indent=1) + "\n").encode()
        chosen, settings = cell.chosen("problem"), cell.settings["problem"]
        if text_of_extension := extended_yaml(chosen, settings, record, about_extension(record)):
            files[EXTENDED_FILE] = text_of_extension.encode()
        files |= following.files if following else {}
        shown = pictures_of(record)
        extended = from_here(output / EXTENDED_FILE) if EXTENDED_FILE in files else None
        next_blocks = list(after_diagnosis(plan, cell, record, following, extended))
        written = f"written: {', '.join(name for name in files if not name.endswith('.csv'))}"
        return Made(
            "\n\n".join([text(record), written, *([following.text] if following else [])]),
            files,
            runs,
            outdated=tuple(name for name in OF_ONE_RUN if name not in files and name not in shown),
            page=lambda: diagnosis_page(record, next_blocks),
        )


def public(record: DiagnosisRecord, following: Next | None = None) -> dict[str, Any]:
    """Content of diagnosis.json: findings, next step and, as last field, the effects hidden in the data."""
    data = with_units(record)
    found = {name: value for name, value in data.items() if name not in OF_THE_BENCH}
    found |= {"next": following.to_data()} if following else {}
    return found | ({"hidden": data["hidden"]} if record.hidden else {})


def diagnosis_runs(plan: Plan, lines: Mapping[str, RunLine]) -> pd.DataFrame:
    """Table of diagnoses, a row per planned run: verdict, evidence, and whether a hidden effect was found."""
    return result_runs(plan, lines, DiagnosisRecord, _row)


def _row(record: DiagnosisRecord, cell: Cell) -> dict[str, Any]:
    best, after, gain = next(iter(record.ranking), None), record.lack_of_fit.after, record.predictive_gain
    return {
        "verdict": record.verdict,
        "named": " ".join(record.named),
        "ambiguity_group": " ".join(record.ambiguity_group),
        "first": "" if best is None else best.effect,
        "deviance_drop": None if best is None else best.deviance_drop,
        "delta_bic": None if best is None else best.delta_bic,
        "p": None if best is None else best.p,
        "lack_of_fit_p": record.lack_of_fit.before.p,
        "lack_of_fit_p_after": None if after is None else after.p,
        "elpd_difference": None if gain is None else gain.elpd_difference,
        "located": "" if record.location is None else in_short(record.location),
        "seconds": record.seconds,
        **coefficients(record, cell),
        "hidden": " ".join(effect.effect for effect in record.hidden),
        **(_found(record) | {HIDDEN_COLUMN: hidden_in_one_line(record.hidden)} if record.hidden else {}),
    }


def coefficients(record: DiagnosisRecord, cell: Cell) -> dict[str, Any]:
    """Numbers of reported intervals of unknowns with a known true value, and of intervals that hold it.

    Intervals are of the extended model if an effect is named, of the model as given if it is not rejected, and averaged
    if several effects explain the data and an average was requested; a location counts its own.
    """
    reported: Sequence[EstimateRecord | None] = ()
    if record.averaged is not None:
        reported = record.averaged.coefficients
    elif record.verdict == "named":
        reported = [row.after for row in record.coefficients]
    elif record.verdict in ("adequate", "not observable"):
        reported = [row.before for row in record.coefficients]
    intervals = {each.name: each for each in reported if each is not None}
    true = {facts.name: facts.truth / facts.si_per_unit for facts in cell.parameters if facts.truth is not None}
    held = [intervals[name].holds(value) for name, value in true.items() if name in intervals]
    return {"coefficients_compared": len(held), "coefficients_held": sum(held)} if true else {}


def _found(record: DiagnosisRecord) -> dict[str, Any]:
    """Facts on a hidden effect: ambiguity group, deviance drop and sizes.

    They are whether it is in the group and first in it, how far the deviance drops in its own fit, and whether its
    sizes lie in their intervals.
    """
    names = [effect.effect for effect in record.hidden]
    times = Counter(names)  # an effect may be hidden at two places
    own = [trial for trial in record.ranking if trial.effect in names]
    hidden = {(effect.effect, effect.location) for effect in record.hidden}
    located = [trial for trial in own if (trial.effect, trial.location) in hidden]
    intervals = {row.name: row.after for row in record.coefficients if row.after is not None}
    found = (
        (found_name(part.name, effect.location, intervals), part)
        for effect in record.hidden
        for part in effect.parameters
    )
    held = [intervals[name].holds(part.value) for name, part in found if name in intervals]
    drops = [trial.deviance_drop for trial in located or own]
    return {
        "hidden_deviance_drop": record.hidden_deviance_drop,
        "own_deviance_drop": max(drops, default=np.nan) if len(names) == 1 else np.nan,
        "in_group": all(
            name in record.ambiguity_group and (n == 1 or times_in_one(record.explanations, name) >= n)
            for name, n in times.items()
        ),
        "surplus": max(len(record.named) - len(names), 0),
        "location_right": bool(own) and all(_is_located(record, effect) for effect in record.hidden),
        "is_first": all(
            record.named.count(name) >= n or (n == 1 and _is_collinear(record, name)) for name, n in times.items()
        ),
        "sizes_compared": len(held),
        "sizes_held": sum(held),
        **({"named_first": first_names(record) == tuple(sorted(names))} if record.inputs else {}),
    }


def found_name(hidden: str, location: str, names: Container[str]) -> str:
    """The name in the extended model of an unknown that is hidden at a location.

    For an effect at two places it depends on which one was found first.
    """
    own = hidden.removesuffix(name_at("", location))
    return at_place if (at_place := name_at(own, location)) in names else own


def times_in_one(explanations: Sequence[ExplanationRecord], name: str) -> int:
    """The most places at which one explanation has an effect."""
    return max((sum(each.name == name for each in own.effects) for own in explanations), default=0)


def _is_located(record: DiagnosisRecord, effect: HiddenEffect) -> bool:
    """Whether an effect is applied, or its first trial is, at the location where it is hidden."""
    first = next((trial for trial in record.ranking if trial.effect == effect.effect), None)
    is_applied = (effect.effect, effect.location) in [(each.name, each.location) for each in record.applied]
    return is_applied or (first is not None and first.location == effect.location)


def _is_collinear(record: DiagnosisRecord, name: str) -> bool:
    """Whether an effect is reported and does what the first one does."""
    return name in record.ambiguity_group and record.collinearity.get(name, 0.0) >= COLLINEAR


def summary(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """Summary, a row per cell: frequency of each verdict, and share of visible hidden effects found.

    With numbers known to a tolerance, `named_first` counts diagnoses that put a hidden effect first, however visible (`first_names`).
    `fit_short` counts fits that stopped before the maximum that the true values lead to, `surplus` diagnoses that name
    an effect too many.
    """
    rows = []
    hidden = hidden_by_cell(runs)
    for index, _ in enumerate(plan.cells):
        mine = runs[runs["cell"] == index]
        results = mine[mine["status"].isin(RESULTS)]
        verdicts: Mapping[Any, int] = dict(results["verdict"].value_counts()) if "verdict" in results else {}
        row = {
            "cell": index,
            **place_columns(plan, plan.cells[index]),
            "runs": len(results),
            "failed": int((~mine["status"].isin(NOT_FAILED)).sum()),
        }
        row |= {name: int(verdicts.get(name, 0)) for name in VERDICTS}
        if "named_first" in results:
            row |= {"named_first": int(results["named_first"].sum())}
        if "in_group" in results and results["in_group"].notna().any():
            visible = results[results["hidden_deviance_drop"] >= CLEARLY_VISIBLE]
            short = visible["own_deviance_drop"] < visible["hidden_deviance_drop"] - SHORT
            row |= {
                "clearly_visible": len(visible),
                "fit_short": int(short.sum()),
                "in_group": int(visible["in_group"].sum()),
                "is_first": int(visible["is_first"].sum()),
                "surplus": int((visible["surplus"] > 0).sum()),
                "location_right": int(visible["location_right"].sum()),
                "sizes": int(visible["sizes_compared"].sum()),
                "sizes_held": int(visible["sizes_held"].sum()),
                "coefficients": int(visible["coefficients_compared"].sum()),
                "coefficients_held": int(visible["coefficients_held"].sum()),
            }
        elif len(results) and any(
            facts.truth is not None for facts in plan.cells[index].parameters
        ):  # nothing is hidden
            alarms = len(results) - row["adequate"] - row["not observable"]
            low, high = interval(alarms, len(results))
            row |= {"false_alarms": alarms, "false_alarms_pct_low": 100 * low, "false_alarms_pct_high": 100 * high}
        if index in hidden:
            row[HIDDEN_COLUMN] = hidden[index]
        row["seconds_median"] = results["seconds"].median() if "seconds" in results else np.nan
        rows.append(row)
    return pd.DataFrame(rows)


def _summary_text(plan: Plan, runs: pd.DataFrame) -> str:
    frame = summary(plan, runs)
    names = [cell_name(plan, cell) for cell in plan.cells]
    place = place_columns(plan, plan.cells[0])
    unreached = {verdict for verdict in VERDICTS if not frame[verdict].any()}
    columns = [name for name in frame.columns if name not in ("cell", HIDDEN_COLUMN, *place, *unreached)]
    lines = [[name, *(number(row[column]) for column in columns)] for name, row in zip(names, frame.to_dict("records"))]
    head = ["cell", *(name.replace("_pct", " %").replace("_", " ") for name in columns)]
    return "\n\n".join(filter(None, [aligned(head, lines), hidden_paragraph(plan, runs, "diagnosis")]))

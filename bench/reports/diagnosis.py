"""A diagnosis in plain sentences, as `diagnosis.json`, as the extended model's file and as figures; of several runs, how
often each verdict was reached and whether what was hidden was found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.records import read_records
from bench.plan.columns import place_columns, run_columns
from bench.plan.naming import cell_name
from bench.plan.plan import Cell, Plan
from bench.plan.report import Made, Report
from bench.reports.diagnosis_figure import residual_figure, trials_figure
from bench.reports.tables import csv_text
from ksmea import registry
from ksmea.show.style import png
from ksmea.show.text import aligned, number
from ksmea.units import RPM

MOST_RANKED = 6  # effects that the text lists
PLAIN_TO_SEE = 60.0  # fall of the deviance that the true model makes
SHORT = 1.0  # of a fall that misses this much of it
ALIKE = 0.95  # likeness from which two effects are of one class
OF_ONE_RUN = ("diagnosis.json", "extended.yaml", "residuals.png", "effects.png")
INTERNAL = ("status", "curves", "elapsed", "schema", "event", "key", "question", "session", "hidden", "hidden_fall")


@dataclass(frozen=True)
class DiagnosisReport(Report):
    study: ClassVar[str] = "diagnose"

    def make(self, plan: Plan, output: Path) -> Made:
        records = read_records(output, RunLine.content)
        runs = diagnosis_runs(plan, records)
        files: dict[str, bytes] = {
            f"{plan.name}.csv": csv_text(summary(plan, runs)).encode(),
            "runs.csv": csv_text(runs).encode(),
        }
        done = [run for run in plan.runs if run.key in records and records[run.key]["status"] in RESULTS]
        if len(plan.runs) != 1 or not done:
            return Made(_summary_text(plan, runs), files, runs, outdated=OF_ONE_RUN)
        cell, record = plan.cells[done[0].cell], records[done[0].key]
        files["diagnosis.json"] = (json.dumps(public(record), indent=1) + "\n").encode()
        if record["applied"] and record["verdict"] in ("named", "ambiguous"):
            files["extended.yaml"] = extended_yaml(cell, record).encode()
        figures = {"residuals.png": residual_figure, "effects.png": trials_figure}
        return Made(
            f"{sentences(record)}\n\nwritten: {', '.join(name for name in files if not name.endswith('.csv'))}",
            files,
            runs,
            lambda: {name: png(draw(record)) for name, draw in figures.items()},
            outdated=tuple(name for name in ("diagnosis.json", "extended.yaml") if name not in files),
        )


def public(record: Mapping[str, Any]) -> dict[str, Any]:
    """What diagnosis.json holds: all of a record but what the bench needs for itself, and what was hidden."""
    return {name: value for name, value in record.items() if name not in INTERNAL}


def diagnosis_runs(plan: Plan, records: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """A row per planned run: the verdict, what stands behind it, and where something was hidden whether it was found."""
    rows = []
    for run in plan.runs:
        record = records.get(run.key)
        row = run_columns(plan, run, record)
        if record is not None and record["status"] in RESULTS:
            row |= _row(record)
        rows.append(row)
    return pd.DataFrame(rows)


def _row(record: Mapping[str, Any]) -> dict[str, Any]:
    best = record["ranking"][0]
    after = record["lack_of_fit"]["after"]
    hidden = [effect["effect"] for effect in record["hidden"]]
    return {
        "verdict": record["verdict"],
        "named": " ".join(record["named"]),
        "class": " ".join(record["class"]),
        "first": best["effect"],
        "fall": best["fall"],
        "delta_bic": best["delta_bic"],
        "p": best["p"],
        "lack_of_fit_p": record["lack_of_fit"]["before"]["p"],
        "lack_of_fit_p_after": None if after is None else after["p"],
        "log_score": None if record["gain"] is None else record["gain"]["log_score"],
        "seconds": record["seconds"],
        "hidden": " ".join(hidden),
        **(_found(record, hidden) if hidden else {}),
    }


def _found(record: Mapping[str, Any], hidden: list[str]) -> dict[str, Any]:
    """Whether what was hidden is in the reported set and first in it, what its own fit is worth, and whether its sizes
    lie in their intervals."""
    own = [trial for trial in record["ranking"] if trial["effect"] in hidden]
    sizes = {part["name"]: part["value"] for effect in record["hidden"] for part in effect["parameters"]}
    placed = [
        trial
        for trial in own
        if any(trial["effect"] == effect["effect"] and trial["place"] == effect["place"] for effect in record["hidden"])
    ]
    intervals = {row["name"]: row["after"] for row in record["coefficients"] if row["after"] is not None}
    compared = [intervals[name] for name in sizes if name in intervals]
    held = [_holds(intervals[name], size) for name, size in sizes.items() if name in intervals]
    return {
        "hidden_fall": record["hidden_fall"],
        "own_fall": max((trial["fall"] for trial in placed or own), default=np.nan) if len(hidden) == 1 else np.nan,
        "in_set": all(name in record["class"] for name in hidden),
        "surplus": max(len(record["named"]) - len(hidden), 0),
        "place_right": bool(own) and all(_place_of(record, effect) for effect in record["hidden"]),
        "is_first": all(name in record["named"] or _is_same_class(record, name) for name in hidden),
        "sizes_compared": len(compared),
        "sizes_held": sum(held),
    }


def _place_of(record: Mapping[str, Any], effect: Mapping[str, Any]) -> bool:
    """Whether the first trial of an effect is at the place where it is hidden."""
    first = next((trial for trial in record["ranking"] if trial["effect"] == effect["effect"]), None)
    return first is not None and first["place"] == effect["place"]


def _is_same_class(record: Mapping[str, Any], name: str) -> bool:
    """Whether an effect is reported and does what the first one does."""
    return name in record["class"] and record["likeness"].get(name, 0.0) >= ALIKE


def _holds(interval: Mapping[str, Any], size: float) -> bool:
    low = -np.inf if interval["low"] is None else interval["low"]
    high = np.inf if interval["high"] is None else interval["high"]
    return bool(low <= size <= high)


def summary(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """A row per cell: how often each verdict, and of what was hidden plain to see how much was found; `fit_short` counts
    searches that stopped before the maximum that the true values lead to, `surplus` diagnoses that name an effect too many."""
    rows = []
    for index, _ in enumerate(plan.cells):
        mine = runs[runs["cell"] == index]
        results = mine[mine["status"].isin(RESULTS)]
        verdicts = results["verdict"].value_counts() if "verdict" in results else {}
        row = {
            "cell": index,
            **place_columns(plan, plan.cells[index]),
            "runs": len(results),
            "failed": len(mine) - len(results),
        }
        row |= {
            name: int(verdicts.get(name, 0)) for name in ("adequate", "named", "ambiguous", "unknown", "not observable")
        }
        if "in_set" in results and results["in_set"].notna().any():
            plain = results[results["hidden_fall"] >= PLAIN_TO_SEE]
            row |= {
                "plain_to_see": len(plain),
                "fit_short": int((plain["own_fall"] < plain["hidden_fall"] - SHORT).sum()),
                "in_set": int(plain["in_set"].sum()),
                "is_first": int(plain["is_first"].sum()),
                "surplus": int((plain["surplus"] > 0).sum()),
                "place_right": int(plain["place_right"].sum()),
                "sizes": int(plain["sizes_compared"].sum()),
                "sizes_held": int(plain["sizes_held"].sum()),
            }
        row["seconds_median"] = results["seconds"].median() if "seconds" in results else np.nan
        rows.append(row)
    return pd.DataFrame(rows)


def _summary_text(plan: Plan, runs: pd.DataFrame) -> str:
    frame = summary(plan, runs)
    columns = [name for name in frame.columns if name != "cell" and name not in place_columns(plan, plan.cells[0])]
    lines = [
        [cell_name(plan, plan.cells[row["cell"]]), *(number(row[column]) for column in columns)]
        for row in frame.to_dict("records")
    ]
    return aligned(["cell", *columns], lines)


def extended_yaml(cell: Cell, record: Mapping[str, Any]) -> str:
    """The file of the extended model, with the values that were identified as its reference."""
    values = {row["name"]: row["after"]["value"] for row in record["coefficients"] if row["after"] is not None}
    effects = [
        (effect["name"], registry.create("effect", effect["name"], effect["settings"])) for effect in record["applied"]
    ]
    problem = cell.settings["problem"]
    extended = registry.plugin_class("problem", "extended")
    return extended.document(problem["name"], problem, effects, values, "phase_origin" in values)


def sentences(record: Mapping[str, Any]) -> str:
    """The diagnosis as an engineer would say it."""
    blocks = [_what_is_wrong(record), _cause(record), _worth(record), _detectable(record)]
    return "\n\n".join(block for block in blocks if block)


def _what_is_wrong(record: Mapping[str, Any]) -> str:
    before = record["lack_of_fit"]["before"]
    if before["p"] >= record["lack_of_fit"]["level"]:
        yet = "; yet an effect explains the data better" if record["applied"] else ""
        return f"What the model leaves over could be noise (p = {before['p']:.2g}){yet}.\n{_noise_text(record)}"
    said = f"p = {before['p']:.2g}, by {before['statistic']}"
    lines = [f"The model does not fit: what it leaves is no noise ({said}), strongest {_where(before)}."]
    for position, (forward, backward) in before["whirl"].items():
        if max(forward, backward) > 2 * min(forward, backward):
            kind = "forward" if forward > backward else "backward"
            ratio = np.sqrt(max(forward, backward) / max(min(forward, backward), 1e-12))
            lines.append(f"At {position} m it is {kind} whirl, {ratio:.2g} times as large as the other.")
    return "\n".join([*lines, _noise_text(record)])


def _where(quality: Mapping[str, Any]) -> str:
    low, high = (speed / RPM for speed in quality["band"])
    return f"at {low:.0f}–{high:.0f} rpm in {quality['channel']}"


def _noise_text(record: Mapping[str, Any]) -> str:
    """The noise under the model that the verdict believes."""
    if record["noise"]["by_datum"]:
        return "Noise: as stated datum by datum."
    is_explained = record["verdict"] in ("named", "ambiguous")
    noise = record["noise"]["after" if is_explained else "before"]
    said = "known" if record["noise"]["known"] else "estimated"
    return f"Noise ({said}): {100 * noise['relative']:.3g} % of each value and {noise['floor'] * 1e6:.3g} µm."


def _cause(record: Mapping[str, Any]) -> str:
    verdict, applied = record["verdict"], record["applied"]
    names = " and ".join(f"{effect['name']} ({effect['place']})" for effect in applied)
    lines = [f"Verdict: {verdict}" + (f": {names}" if verdict in ("named", "ambiguous") else "")]
    if len(record["places"]) > 1:
        lines.append(f"The place is not certain: {' or '.join(record['places'])}.")
    if verdict == "ambiguous":
        lines.append(f"These explain the data about as well: {', '.join(record['class'])}.")
        split = record["split"]
        lines.append(
            f"{split['measurement']} would tell them apart (expected Δχ² {split['then']:.3g}, now {split['now']:.3g})."
            if split
            else "None of the measurements that were considered would tell them apart."
        )
    if verdict == "unknown" and not applied:
        lines.append("The model is wrong, and no effect that is known speaks for itself.")
    elif verdict == "unknown":
        after = record["lack_of_fit"]["after"]
        lines.append(
            "The model is wrong, and neither one of the known effects nor the best pairs of them leave noise behind."
        )
        lines.append(
            f"The nearest is {names}; what it leaves (p = {after['p']:.2g}, by {after['statistic']}) is strongest"
            f" {_where(after)}."
        )
    else:
        lines += [f"  {name} can look like it: {text}" for name, text in record["aliases"].items()]
        lines += [
            f"  {part['name']} lies on its physical bound: another cause is likely"
            for part in record["ranking"][0]["parameters"]
            if part["at_bound"] and applied
        ]
    return "\n".join([*lines, "", _ranking(record)])


def _ranking(record: Mapping[str, Any]) -> str:
    """The best place of each of the most promising effects."""
    best: dict[str, Mapping[str, Any]] = {}
    for trial in record["ranking"]:
        best.setdefault(trial["effect"], trial)
    lines = [
        [
            trial["effect"],
            trial["place"],
            f"{trial['delta_bic']:.1f}",
            f"{trial['p']:.2g}",
            ", ".join(_with_interval(parameter) for parameter in trial["parameters"]),
        ]
        for trial in list(best.values())[:MOST_RANKED]
    ]
    return aligned(["effect", "place", "ΔBIC", "p", "size"], lines)


def _with_interval(parameter: Mapping[str, Any]) -> str:
    ends = ", ".join("–" if parameter[end] is None else number(parameter[end], 3) for end in ("low", "high"))
    return f"{parameter['name']} {number(parameter['value'], 3)} [{ends}] {parameter['unit']}"


def _worth(record: Mapping[str, Any]) -> str:
    gain = record["gain"]
    if gain is None:
        return ""
    proven = "more than two standard errors" if gain["is_proven"] else "not more than two standard errors: not proven"
    rmse = f"{gain['rmse_before'] * 1e6:.3g} to {gain['rmse_after'] * 1e6:.3g} µm"
    score = f"{gain['log_score']:+.3g} ± {gain['standard_error']:.2g} against the plain one's ({proven})"
    blocks = f"better in {sum(block > 0 for block in gain['by_block'])} of {len(gain['by_block'])} of them"
    score = f"the extended model's log score is {score}, {blocks}; the rms error goes from {rmse}."
    lines = [f"On blocks of speeds left out {score}"]
    rows = [row for row in record["coefficients"] if row["after"] is not None]
    table = [[row["name"], *(_cell(row[when]) for when in ("before", "after")), row["after"]["unit"]] for row in rows]
    return "\n".join([*lines, "", aligned(["unknown", "before", "after", "unit"], table)])


def _cell(value: Mapping[str, Any] | None) -> str:
    if value is None:
        return "–"
    ends = ", ".join("–" if value[end] is None else number(value[end]) for end in ("low", "high"))
    return f"{number(value['value'])} [{ends}]"


def _detectable(record: Mapping[str, Any]) -> str:
    if record["verdict"] not in ("adequate", "not observable"):
        return ""
    lines = []
    for name, parts in record["min_detectable"].items():
        for part in parts:
            size = "–" if part["size"] is None else f"{number(part['size'], 3)} {part['unit']}"
            remark = (
                "" if part["observable"] else f"beyond what is physical ({number(part['largest'], 3)} {part['unit']})"
            )
            lines.append([name, part["place"], part["parameter"], size, remark])
    head = "What would have been found in nine of ten cases, had it been there:"
    return f"{head}\n{aligned(['effect', 'place', 'unknown', 'from', ''], lines)}"

"""Quality of estimates and intervals over many noise realisations.

Spread against the CRLB, coverage, and how often a method ends in the basin of the likelihood where the truth lies.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import ClassVar

import numpy as np
import pandas as pd
import scipy

from bench.jobs.lines import RESULTS
from bench.jobs.records import NOT_FAILED
from bench.plan.naming import cell_name, naming_axes, place_columns, place_text, telling_axes
from bench.plan.page import Page
from bench.plan.plan import Cell, ParameterFacts, Plan
from bench.plan.report import Made, Report
from bench.reports.accuracy.calibration_page import calibration_page
from bench.reports.runs import FITTED_INPUTS, runs_frame
from bench.reports.tables import csv_text, ended_short_pct
from ksmea.show.text import aligned, number

# Two maxima of the likelihood with deviances that differ by less than this are one and the same: searches for a maximum
# end where the deviance falls by less than 1e-7, and no two basins are found to be as equal.
SAME_MAXIMUM = 1e-3
NORMAL_IQR = 2 * scipy.stats.norm.ppf(0.75)  # interquartile range of a normal distribution with unit variance


@dataclass(frozen=True)
class CalibrationReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        runs = runs_frame(plan, output)
        frame = calibration_frame(plan, runs)
        files = {f"{plan.name}.csv": csv_text(frame).encode(), "runs.csv": csv_text(runs).encode()}
        return Made(
            _text(plan, frame),
            files,
            runs,
            page=lambda: _page(plan, frame, runs),
        )


def _page(plan: Plan, frame: pd.DataFrame, runs: pd.DataFrame) -> Page:
    names = [_short_name(plan, cell) or f"cell {index}" for index, cell in enumerate(plan.cells)]
    names = names if len(set(names)) == len(names) else [cell_name(plan, cell) for cell in plan.cells]
    errors = {
        name: [_relative_errors(cell, name, runs[runs["cell"] == index]) for index, cell in enumerate(plan.cells)]
        for name in dict.fromkeys(frame["parameter"])
    }
    named = frame.assign(cell_name=[names[index] for index, cell in enumerate(plan.cells) for _ in cell.parameters])
    levels = sorted({_level(cell) for cell in plan.cells})
    n_draw = int(runs.groupby("cell").size().max())
    return calibration_page(
        f"{plan.name}: {n_draw} noise draws", _text(plan, frame), named, names, errors, levels, plan.name
    )


def calibration_frame(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """A row per cell and parameter.

    Errors are in units of the CRLB (with numbers as the cell takes them, as stated or to a tolerance): bias, standard
    deviation, a robust one from the quartiles (`spread`), and the standard deviation over the runs in the right basin;
    `covered_pct` counts all runs, an open side holding everything.
    """
    rows = []
    for index, cell in enumerate(plan.cells):
        mine = runs[runs["cell"] == index]
        results = mine[mine["status"].isin(RESULTS)]
        shares = basin_shares(results)
        for facts in cell.parameters:
            rows.append(
                {
                    "parameter": facts.name,
                    **place_columns(plan, cell),
                    "crlb_pct": np.nan
                    if facts.crlb is None or not facts.truth
                    else 100 * facts.crlb / abs(facts.truth),
                    **_errors(results, facts),
                    **_intervals(results, facts, _level(cell)),
                    **shares,
                    "ended_short_pct": ended_short_pct(results),
                    "runs": len(results),
                    "failed": int((~mine["status"].isin(NOT_FAILED)).sum()),
                }
            )
    return pd.DataFrame(rows)


def basin_shares(results: pd.DataFrame) -> dict[str, float]:
    """Per cent of the runs by their nearest maximum of the likelihood; NaN if not known.

    The right maximum is the one nearest to the true values; another one is lower (wrong), or higher if the noise makes
    it more likely.
    """
    if "basin_excess" not in results or results["basin_excess"].isna().all():
        return {"right_basin_pct": np.nan, "wrong_basin_pct": np.nan, "higher_elsewhere_pct": np.nan}
    excess = results["basin_excess"].dropna()
    return {
        "right_basin_pct": 100 * (excess.abs() <= SAME_MAXIMUM).mean(),
        "wrong_basin_pct": 100 * (excess > SAME_MAXIMUM).mean(),
        "higher_elsewhere_pct": 100 * (excess < -SAME_MAXIMUM).mean(),
    }


def _errors(results: pd.DataFrame, facts: ParameterFacts) -> dict[str, float]:
    names = ("bias", "sd", "spread", "sd_right_basin")
    if facts.crlb is None or facts.name not in results or results.empty:
        return dict.fromkeys(names, np.nan)
    errors = (_estimates(results, facts.name) * facts.si_per_unit - facts.truth) / facts.crlb
    right = errors[results["basin_excess"].abs() <= SAME_MAXIMUM] if "basin_excess" in results else errors
    spread = np.subtract(*np.percentile(errors, [75, 25])) / NORMAL_IQR
    return dict(zip(names, (errors.mean(), errors.std(ddof=0), spread, right.std(ddof=0))))


def _sigmas(level: float) -> float:
    """Half-width of a normal interval of this confidence, in standard deviations."""
    return float(scipy.stats.norm.ppf((1 + level) / 2))


def _level(cell: Cell) -> float:
    return float((cell.settings.get("study") or {}).get("level", 0.95))


def _intervals(results: pd.DataFrame, facts: ParameterFacts, level: float) -> dict[str, float]:
    """Coverage with its standard error, half-width relative to a CRLB interval, and shares by basis."""
    name = facts.name
    if f"{name}_interval" not in results or results.empty:
        return {}
    covered = results[f"{name}_covered"].dropna().astype(float)
    bases = results[f"{name}_interval"].dropna()
    width = (results[f"{name}_high"] - results[f"{name}_low"]).dropna() * facts.si_per_unit
    share = covered.mean()
    return {
        "covered_pct": 100 * share,
        "covered_se": 100 * np.sqrt(share * (1 - share) / max(len(covered), 1)),
        "width": np.nan if facts.crlb is None or width.empty else width.median() / 2 / (_sigmas(level) * facts.crlb),
        "one_sided_pct": 100 * bases.isin(["lower limit", "upper limit"]).mean(),
        "not_identifiable_pct": 100 * (bases == "not identifiable").mean(),
    }


def _text(plan: Plan, frame: pd.DataFrame) -> str:
    """The table in the form it is printed in."""
    axes = telling_axes(plan)
    columns = {
        "CRLB %": "crlb_pct",
        "bias": "bias",
        "sd": "sd",
        "spread": "spread",
        "sd, right basin": "sd_right_basin",
        "covers %": "covered_pct",
        "± ": "covered_se",
        "width": "width",
        "one-sided %": "one_sided_pct",
        "open %": "not_identifiable_pct",
    }
    columns = {head: column for head, column in columns.items() if column in frame}
    lines = [
        [
            row["parameter"],
            *(place_text(None if pd.isna(row[axis]) else row[axis]) for axis in axes),
            *(number(row[column], 3) for column in columns.values()),
            str(row["runs"]),
            str(row["failed"]),
        ]
        for _, row in frame.iterrows()
    ]
    table = aligned(["parameter", *axes, *columns, "runs", "failed"], lines)
    remark = "bias, sd, spread (from the quartiles) and half-width of the intervals (width) are in units of the CRLB"
    return "\n".join([table, "", remark, *_basin_lines(plan, frame)])


def _basin_lines(plan: Plan, frame: pd.DataFrame) -> list[str]:
    first = frame.drop_duplicates(list(plan.axes))
    if first["right_basin_pct"].isna().all():
        return []
    names = [_short_name(plan, cell) for cell in plan.cells]
    return ["", "runs that end in the basin of the likelihood that the truth lies in:"] + [
        f"  {name}: {row.right_basin_pct:.1f} %; in a less likely one {row.wrong_basin_pct:.1f} %;"
        f" in a more likely one {row.higher_elsewhere_pct:.1f} %; the search ended short in {row.ended_short_pct:.1f} %"
        for name, row in zip(names, first.itertuples())
    ]


def _short_name(plan: Plan, cell: Cell) -> str:
    """A cell's place with the groups of its settings and the folders of files left out."""
    parts = [(axis.rpartition(".")[2], cell.place.get(axis)) for axis in naming_axes(plan)]
    given = [(axis, value) for axis, value in parts if value is not None]
    shown = ((axis, PurePath(value).name if axis == "file" else place_text(value)) for axis, value in given)
    return ", ".join(text if axis in ("label", "kind", "file") else f"{axis} {text}" for axis, text in shown)


def _relative_errors(cell: Cell, name: str, runs: pd.DataFrame) -> np.ndarray:
    facts = {parameter.name: parameter for parameter in cell.parameters}.get(name)
    if facts is None or facts.crlb is None or name not in runs:
        return np.array([])
    estimates = _estimates(runs, name).dropna()
    return ((estimates * facts.si_per_unit - facts.truth) / facts.crlb).to_numpy(float)


def _estimates(runs: pd.DataFrame, name: str) -> pd.Series:
    """The method's values, or the joint fit's for runs with numbers known to a tolerance."""
    if FITTED_INPUTS not in runs or f"{name}_most_likely" not in runs:
        return runs[name]
    return runs[name].where(runs[FITTED_INPUTS].isna(), runs[f"{name}_most_likely"])

"""Table of an experiment: medians of each cell with the paper's values; counted rates with intervals."""

from __future__ import annotations

import re
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd
import scipy

from bench.jobs.lines import RESULTS
from bench.jobs.records import NOT_FAILED
from bench.plan.naming import place_columns, place_text, telling_axes
from bench.plan.plan import Cell, ParameterFacts, Plan
from bench.storage.own_files import PAPER
from ksmea.errors import SettingError, unknown
from ksmea.show.text import aligned, number

FORMULA = ("=", "+", "-", "@", "\t", "\r")  # how a cell begins that a spreadsheet computes
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
ALIKE_PCT = 10.0  # shares that are said together
MOST_CELLS = 4  # of which a share is said by itself
LONGEST_CELL = 2000  # characters; Excel takes 32767, nobody reads them
EFFORT = {"updates": "", "model_evaluations": "", "time": "s"}  # rows of a table below the parameters, and their units
LEAST_PCT = 1e-3  # smaller errors are not counted
EXACT = {"exact": "%", "updates_to_exact": ""}  # where exactness is asked for
FEWEST_OF_BOX = 5  # values of which a box is drawn; fewer are dots

OF_LIKELIHOOD = ("most_likely", "low", "high", "covered_pct")  # columns that are of the data, whatever method was run
OF_SEARCH = ("ended_short_pct", "excess_deviance", "beyond_pct")  # where searches ended, relative to that


def summary_frame(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """Tidy table: a row per parameter (then updates, evaluations, time) and cell.

    Median, quartiles, failures.

    `error_pct_median` is the median of the absolute errors, `crlb_pct` the CRLB. If the true values are not known, the
    CRLB is evaluated at the identified values, and errors are NaN. `most_likely`, `low` and `high` are medians of the
    maximum of the likelihood and of the ends of the interval around it, empty if that side is open in most of them;
    `covered_pct` says how many of the intervals hold the reference, `ended_short_pct` how many searches stopped
    elsewhere than at that maximum, `excess_deviance` by how much (median), and `beyond_pct` how many beyond the joint
    95 % region. For `exact`, a share of the runs, the median is their mean.
    """
    printed = _printed_values(plan.report.paper)
    rows = [
        row
        for parameter in _row_names(plan)
        for index, cell in enumerate(plan.cells)
        for row in [_summary_row(plan, cell, parameter, runs[runs["cell"] == index], printed)]
        if row is not None
    ]
    return pd.DataFrame(rows)


def has_truth(plan: Plan) -> bool:
    """Whether the true values of some unknowns are known in all cells."""
    return all(any(facts.truth for facts in cell.parameters) for cell in plan.cells)


def _row_names(plan: Plan) -> list[str]:
    names = dict.fromkeys(parameter.name for cell in plan.cells for parameter in cell.parameters)
    return [*names, *EFFORT, *(EXACT if plan.report.exact is not None else {})]


def _summary_row(
    plan: Plan, cell: Cell, name: str, runs: pd.DataFrame, printed: dict[tuple[str, Any], tuple[float, float]]
) -> dict[str, Any] | None:
    facts = {parameter.name: parameter for parameter in cell.parameters}
    if name not in facts and name not in EFFORT | EXACT:
        return None
    results = runs[runs["status"].isin(RESULTS)]
    values = results[name].dropna().to_numpy(dtype=float) if name in results else np.array([])
    quartiles = np.percentile(values, [25, 50, 75]) if len(values) else np.full(3, np.nan)
    if name == "exact" and len(values):
        quartiles[:] = np.mean(values)
    reference = _reference(facts.get(name))
    paper, paper_error = printed.get((name, _printed_column(plan, cell)), (np.nan, np.nan))
    return {
        "parameter": name,
        "unit": facts[name].unit if name in facts else (EFFORT | EXACT)[name],
        "reference": reference,
        **place_columns(plan, cell),
        "paper": paper,
        "paper_error_pct": paper_error,
        "median": quartiles[1],
        "q1": quartiles[0],
        "q3": quartiles[2],
        "error_pct_median": np.median(np.abs(values / reference - 1)) * 100 if len(values) and reference else np.nan,
        "crlb_pct": _crlb_pct(facts.get(name), results),
        **_interval_summary(results, name, len(facts)),
        "runs": len(values),
        "failed": int((~runs["status"].isin(NOT_FAILED)).sum()),
    }


def _reference(facts: ParameterFacts | None) -> float:
    """The true value in the parameter's unit; NaN if it is not known."""
    return np.nan if facts is None or facts.truth is None else facts.truth / facts.si_per_unit


def _crlb_pct(facts: ParameterFacts | None, results: pd.DataFrame) -> float:
    if facts is not None and facts.truth is None and f"{facts.name}_crlb" in results:
        return float((100 * results[f"{facts.name}_crlb"] / results[facts.name].abs()).median())
    return np.nan if facts is None or facts.crlb is None or not facts.truth else 100 * facts.crlb / abs(facts.truth)


def _interval_summary(results: pd.DataFrame, name: str, n_unknown: int) -> dict[str, float]:
    """Medians of the most likely values and of the ends of their intervals.

    Not a number where that side is open in most of them.
    """
    if f"{name}_interval" not in results:
        return dict.fromkeys([*OF_LIKELIHOOD, *OF_SEARCH], np.nan)
    low = results[f"{name}_low"].fillna(-np.inf).median()
    high = results[f"{name}_high"].fillna(np.inf).median()
    covered = results[f"{name}_covered"].dropna().astype(float)
    return {
        "most_likely": results[f"{name}_most_likely"].median(),
        "low": low if np.isfinite(low) else np.nan,
        "high": high if np.isfinite(high) else np.nan,
        "covered_pct": 100 * covered.mean() if len(covered) else np.nan,
        "ended_short_pct": ended_short_pct(results),
        **dict(zip(("excess_deviance", "beyond_pct"), beyond_joint_region(results, n_unknown))),
    }


def ended_short_pct(results: pd.DataFrame) -> float:
    """Per cent of the runs whose method stopped elsewhere than at the maximum of its interval."""
    return 100 * results["ended_short"].dropna().astype(float).mean() if "ended_short" in results else np.nan


def _printed_values(paper: str | None) -> dict[tuple[str, Any], tuple[float, float]]:
    """The paper's value and printed error by parameter and column: a number of samples, or a method."""
    if paper is None:
        return {}
    known = [path.stem for path in PAPER.glob("table*.csv")]
    if paper not in known:
        raise unknown("table of the paper", paper, known)
    table = pd.read_csv(PAPER / f"{paper}.csv")
    if "error_pct_printed" not in table:
        raise SettingError(f"paper={paper}: expected a table of identified values, got another; choose table3")
    column = "method" if "method" in table else "samples"
    return {
        (row["parameter"], row[column]): (row["identified"], row["error_pct_printed"]) for _, row in table.iterrows()
    }


def _printed_column(plan: Plan, cell: Cell) -> Any:
    """Column of the paper's table for a cell: its label in table 6, else its number of samples."""
    return cell.place.get("label") if plan.report.paper == "table6" else cell.place.get("samples")


def slips(paper: str | None) -> pd.DataFrame:
    """Slips in print of one of the paper's tables."""
    known = pd.read_csv(PAPER / "slips.csv")
    return known[known["table"] == paper]


def csv_text(frame: pd.DataFrame) -> str:
    """A table as CSV that a spreadsheet may open: no cell is a formula, and a message of megabytes is cut."""
    shown = frame.copy()
    shown.columns = [_harmless(name) for name in frame.columns]
    for at, (_, column) in enumerate(frame.items()):
        if pd.api.types.is_object_dtype(column) or pd.api.types.is_string_dtype(column):
            shown.isetitem(at, column.map(_harmless))
    return shown.to_csv(index=False, float_format="%.10g", lineterminator="\n")


def _harmless(value: Any) -> Any:
    """Text that no spreadsheet takes for a formula, with an apostrophe before it if needed.

    Numbers and probes at angles (-45) are unchanged. Source: OWASP, CSV injection.

    >>> [_harmless(each) for each in ("=1+2", "@x", "-45", "-a", "DE", 3.0)]
    ["'=1+2", "'@x", '-45', "'-a", 'DE', 3.0]
    """
    if not isinstance(value, str):
        return value
    text = value if len(value) <= LONGEST_CELL else value[:LONGEST_CELL] + "…"
    return f"'{text}" if text.startswith(FORMULA) and not NUMBER.fullmatch(text) else text


def as_text(plan: Plan, summary: pd.DataFrame) -> str:
    """The table in the form it is printed in: a line per parameter and cell, ours next to the paper's."""
    axes = telling_axes(plan)
    has_paper = plan.report.paper is not None
    has_crlb, has_interval = summary["crlb_pct"].notna().any(), has_intervals(summary)
    head = ["parameter", "unit", "reference", *axes, "median", "[q1, q3]", "error %"]
    head += ["CRLB %"] if has_crlb else []
    head += ["most likely", f"{_level_pct(plan)} % interval", "covers %"] if has_interval else []
    head += ["paper", "paper error %"] if has_paper else []
    head += ["runs", "failed"]
    lines = []
    for _, row in summary.iterrows():
        line = [
            row["parameter"].replace("_", " ") if row["parameter"] in EFFORT | EXACT else row["parameter"],
            row["unit"],
            number(row["reference"]),
            *(place_text(None if pd.isna(row[axis]) else row[axis]) for axis in axes),
        ]
        line += [
            number(row["median"]),
            "–" if pd.isna(row["q1"]) else f"[{number(row['q1'])}, {number(row['q3'])}]",
            number(row["error_pct_median"], 3),
        ]
        if has_crlb:
            line.append(number(row["crlb_pct"], 3))
        if has_interval:
            line += [number(row["most_likely"]), _interval_text(row), number(row["covered_pct"], 3)]
        if has_paper:
            line += [number(row["paper"]), number(row["paper_error_pct"])]
        lines.append([*line, str(row["runs"]), str(row["failed"])])
    marked = ["most likely, interval, covers: of the likelihood, whatever the method"] if has_interval else []
    return "\n".join([aligned(head, lines), *marked, *search_lines(plan, summary)])


def search_lines(plan: Plan, summary: pd.DataFrame) -> list[str]:
    """Sentence on the ends of searches relative to the maximum of the likelihood.

    Over all cells, by the level of the one axis that decides, or of the worst cells.
    """
    known = summary.dropna(subset="beyond_pct").drop_duplicates(list(plan.axes) or None)
    if not (known["ended_short_pct"] > 0).any():
        return []
    head = "end of the search against the maximum of the likelihood (median excess deviance; share beyond the joint 95 % region)"
    return [f"{head}: {'; '.join(_by_level(plan, known))}"]


def _by_level(plan: Plan, known: pd.DataFrame) -> list[str]:
    if len(known) == 1 or known["beyond_pct"].nunique() == 1:
        return [f"{_excess(known)} in all cells" if len(known) > 1 else _excess(known)]
    for axis in telling_axes(plan):
        groups = known.groupby(known[axis].astype(str), sort=False)
        if len(groups) < len(known) and (groups["beyond_pct"].agg(np.ptp) <= ALIKE_PCT).all():
            return [f"{axis} {place_text(level)} {_excess(mine)}" for level, mine in groups]
    worst = known.sort_values("beyond_pct", ascending=False).head(MOST_CELLS)
    more = f"{len(known) - len(worst)} more cells are lower" if len(known) > len(worst) else ""
    return [
        *(f"{_excess(row.to_frame().T)}{_of_cell(plan, row)}" for _, row in worst.iterrows()),
        *filter(None, [more]),
    ]


def _excess(rows: pd.DataFrame) -> str:
    """'3.1, 24 %'"""
    return f"{number(float(rows['excess_deviance'].astype(float).median()), 2)}, {float(rows['beyond_pct'].astype(float).median()):.0f} %"


def beyond_joint_region(results: pd.DataFrame, n_unknown: int) -> tuple[float, float]:
    """Median excess deviance of search ends, and share of runs beyond the joint 95 % region, per cent.

    The excess is over the maximum of the likelihood. The region is of χ² with as many degrees of freedom as unknowns;
    NaN if nothing is known.
    """
    if "search_excess" not in results or not (excess := results["search_excess"].dropna().astype(float)).size:
        return np.nan, np.nan
    return float(excess.median()), float(100 * (excess > scipy.special.chdtri(n_unknown, 1 - LEVEL)).mean())


def _of_cell(plan: Plan, row: pd.Series) -> str:
    parts = [f"{axis}={place_text(None if pd.isna(row[axis]) else row[axis])}" for axis in telling_axes(plan)]
    return f" ({', '.join(parts)})" if parts else ""


def has_intervals(summary: pd.DataFrame) -> bool:
    return bool(summary[["low", "high", "covered_pct"]].notna().any(axis=None))


def lacks_interval(rows: pd.DataFrame) -> pd.Series:
    """Whether a row has no interval at all, as without noise; one that is open on both sides is one."""
    return rows["covered_pct"].isna() & rows["reference"].notna()


def _level_pct(plan: Plan) -> str:
    """The confidence level of the cells' intervals in per cent."""
    levels = {f"{100 * (cell.settings.get('study') or {}).get('level', 0.95):g}" for cell in plan.cells}
    return "/".join(sorted(levels))


def _interval_text(row: pd.Series) -> str:
    """'[49.9, 50.1]', '> 0.3', '< 0.9'; '?' if both ends are open, '–' without an interval."""
    if lacks_interval(row.to_frame().T).item() or row["parameter"] in EFFORT | EXACT:
        return "–"
    low, high = row["low"], row["high"]
    if pd.isna(low):
        return "?" if pd.isna(high) else f"< {number(high)}"
    return f"> {number(low)}" if pd.isna(high) else f"[{number(low)}, {number(high)}]"


def slips_text(found: pd.DataFrame) -> str:
    """Slips as footnotes."""
    return "\n".join(
        f"slip in print: {row.parameter}, {row.at}: {row.printed}; {row.reason}" for row in found.itertuples()
    )


LEVEL = 0.95


def interval(count: int, n: int) -> tuple[float, float]:
    """Wilson's interval of a rate of `count` in n draws, 0 to 1 (J. Am. Stat. Assoc. 22 (1927) 209–212)."""
    if not n:
        return 0.0, 1.0
    z2 = NormalDist().inv_cdf((1 + LEVEL) / 2) ** 2
    middle, half = count + z2 / 2, float(np.sqrt(z2 * (count * (n - count) / n + z2 / 4)))
    return (middle - half) / (n + z2), (middle + half) / (n + z2)


def rate(count: int, n: int) -> str:
    """For example '19, 95 % (76–99)'."""
    if not n:
        return "–"
    low, high = interval(count, n)
    return f"{count}, {100 * count / n:.0f} % ({100 * low:.0f}–{100 * high:.0f})"

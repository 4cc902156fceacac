"""Audit of the paper: each printed error against the CRLB, under every reading of its print.

The *chance* of a printed error e, rounding r, is the probability that an efficient unbiased estimate is as near:
P(|N(0, b)| ≤ e + r) with the Cramér–Rao lower bound (CRLB) b; r is half the last digit of the error or of the value,
whichever is more. The *blind chance* is the chance of a point drawn evenly between the search limits. The verdict on
a value:

- `possible`: its chance is at least 5 %, or its blind chance is, or it lies at a limit of the search. A value far off
  is always possible, for any method can do worse than the CRLB;
- `lucky`: its chance is below 5 %;
- `impossible`: its chance is below 0.1 %: the data do not hold what was printed.

The row `together` is of all values of one column that are not possible blindly or at a limit of the search: the chance
that the joint normal errors of an efficient estimate, with its correlations, are all as small as printed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from bench.plan.plan import Cell, Plan
from bench.plan.report import Made, Report
from bench.reports.accuracy.audit_page import audit_page
from bench.reports.by_cell import first_results, plain_runs, run_lines
from bench.reports.tables import PAPER, csv_text
from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.records.identifiability import IdentifiabilityRecord, Unknown
from ksmea.show.identifiability_text import capped
from ksmea.show.text import aligned

LUCKY, IMPOSSIBLE = 0.05, 0.001  # chances below which a value is called so
VERDICTS = ("possible", "lucky", "impossible")
AUDITED = ("table3", "table4", "table6", "table8")  # Table 2 is without noise, Table 5 without results
DAMPING = {1: "kN s/m", 1000: "kN s/mm"}  # by the size of the true damping in kN s/m per printed number
TOGETHER = "together"
N_DRAW = 400_000  # of joint errors: a chance of 0.1 % is good to 5 % of itself
ASSUMED = "assumed"  # where no reference damping is printed
COLUMNS = (
    *("table", "reading", "damping", "kind", "parameter", "column", "identified", "error_pct_printed", "rounding_pct"),
    *("at_search_limit", "crlb_pct", "chance", "chance_blind", "verdict", "slip"),
)


@dataclass(frozen=True)
class AuditReport(Report):
    study: ClassVar[str] = "identifiability"

    def make(self, plan: Plan, output: Path) -> Made:
        for cell in plan.cells:
            if cell.place.get("label") not in AUDITED:
                raise SettingError(
                    f"table=audit: expected cells with label={'|'.join(AUDITED)}, got {cell.place.get('label')};"
                    " run +experiment=audit"
                )
        lines = run_lines(plan, output)
        runs = plain_runs(plan, lines)
        frame = audit_frame(plan, first_results(plan, lines, IdentifiabilityRecord))
        return Made(
            audit_text(frame),
            {f"{plan.name}.csv": csv_text(frame).encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            page=lambda: audit_page(audit_text(frame), frame, f"{plan.name}.csv", f"{plan.name}.png"),
        )


def audit_frame(plan: Plan, found: Mapping[int, IdentifiabilityRecord]) -> pd.DataFrame:
    """A row per printed error and reading, and one per column of a table for all its errors together."""
    rows: list[dict[str, Any]] = []
    for cell, record in found.items():
        of_cell = list(_rows(plan.cells[cell], record))
        rows += [*of_cell, *_joint_rows(of_cell, record)]
    frame = pd.DataFrame(rows, columns=list(COLUMNS))
    return frame.sort_values("table", kind="stable", ignore_index=True)


def chance(error_pct: float, crlb_pct: float) -> float:
    """P(|N(0, CRLB)| ≤ error), both in per cent; 0 where the CRLB is infinite."""
    return 0.0 if np.isinf(crlb_pct) else 2 * NormalDist(0, crlb_pct).cdf(error_pct) - 1


def chance_blind(error_pct: float, true: float, lower: float, upper: float) -> float:
    """Share of the search interval that lies within the error of the true value."""
    reach = true * error_pct / 100
    return max(0.0, min(upper, true + reach) - max(lower, true - reach)) / (upper - lower)


def verdict(chance: float, chance_blind: float, at_search_limit: bool) -> str:
    if at_search_limit or max(chance, chance_blind) >= LUCKY:
        return "possible"
    return "impossible" if chance < IMPOSSIBLE else "lucky"


def joint_chance(largest: Array, correlation: Array) -> float:
    """Probability P(|z_i| ≤ largest_i for all i) of unit normal z (d,) with a correlation (d, d).

    It is simulated with fixed draws.
    """
    values, vectors = np.linalg.eigh(correlation)
    draws = np.random.default_rng(0).standard_normal((N_DRAW, len(largest)))
    z = draws @ (vectors * np.sqrt(np.maximum(values, 0))).T
    return float(np.mean(np.all(np.abs(z) <= largest, axis=1)))


def rounding_pct(error: str, value: str, reference: float) -> float:
    """Half the last printed digit, in per cent, of an error or of its value, whichever is more."""
    return max(_half_digit(error), 100 * _half_digit(value) / reference)


def _half_digit(printed: str) -> float:
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])


def _rows(cell: Cell, record: IdentifiabilityRecord) -> Iterator[dict[str, Any]]:
    table = cell.place["label"]
    printed = pd.read_csv(PAPER / f"{table}.csv", dtype=str, keep_default_na=False)
    slips = pd.read_csv(PAPER / "slips.csv", dtype=str)
    column = "method" if "method" in printed else "samples"
    facts = {parameter.name: parameter for parameter in record.parameters}
    reading = {
        "table": table,
        "reading": cell.settings["problem"].get("reading", "rpm").replace("rad_s", "rad/s"),
        "damping": _damping(printed, facts),
        "kind": cell.settings["measurement"]["kind"],
    }
    for row in printed[printed["error_pct_printed"] != ""].to_dict("records"):
        fact, error, reference = facts[row["parameter"]], float(row["error_pct_printed"]), float(row["reference"])
        rounding = rounding_pct(row["error_pct_printed"], row["identified"], reference)
        identified = float(row["identified"]) * fact.true / reference  # SI, in the reading of its unit
        stuck = bool(np.isclose(identified, [fact.lower, fact.upper], rtol=1e-9).any())
        efficient = chance(error + rounding, fact.crlb_pct)
        blind = chance_blind(error + rounding, fact.true, fact.lower, fact.upper)
        yield reading | {
            "parameter": row["parameter"],
            "column": row[column],
            "identified": float(row["identified"]),
            "error_pct_printed": error,
            "rounding_pct": rounding,
            "at_search_limit": stuck,
            "crlb_pct": fact.crlb_pct,
            "chance": efficient,
            "chance_blind": blind,
            "verdict": verdict(efficient, blind, stuck),
            "slip": _slip(slips, table, row["parameter"], row[column]),
        }


def _joint_rows(rows: list[dict[str, Any]], record: IdentifiabilityRecord) -> Iterator[dict[str, Any]]:
    """Claims of each printed column as a whole; a column that claims nothing has no row."""
    correlation = np.array(record.correlation, dtype=float)
    for column in dict.fromkeys(row["column"] for row in rows):
        of_column = [row for row in rows if row["column"] == column]
        claims = [row for row in of_column if not row["at_search_limit"] and row["chance_blind"] < LUCKY]
        if not claims:
            continue
        largest = np.array([(row["error_pct_printed"] + row["rounding_pct"]) / row["crlb_pct"] for row in claims])
        indices = [record.names.index(row["parameter"]) for row in claims]
        together = joint_chance(largest, correlation[np.ix_(indices, indices)])
        blind = float(np.prod([row["chance_blind"] for row in claims]))
        facts = {key: of_column[0][key] for key in ("table", "reading", "damping", "kind", "column")}
        result = {"chance": together, "chance_blind": blind, "verdict": verdict(together, blind, False)}
        yield {**facts, "parameter": TOGETHER, "at_search_limit": False, "slip": "", **result}


def _damping(printed: pd.DataFrame, facts: Mapping[str, Unknown]) -> str:
    """How the printed unit of damping is read, by the true value that the CRLBs were taken at."""
    reference = printed.loc[printed["parameter"] == "cxx", "reference"].iloc[0]
    if reference == "":
        return ASSUMED
    return DAMPING[round(facts["cxx"].true / facts["cxx"].si_per_unit / float(reference))]


def _slip(slips: pd.DataFrame, table: str, parameter: str, column: str) -> str:
    """Known misprints of a value, without misprinted units, which the readings cover."""
    return "; ".join(
        f"{slip.printed}: {slip.reason}"
        for slip in slips[slips["table"] == table].itertuples()
        if not slip.printed.startswith("unit")
        and parameter in _listed(slip.parameter, parameter)
        and column in _listed(slip.at.removesuffix(" samples"), column)
    )


def _listed(text: str, everything: str) -> list[str]:
    return [everything] if text == "all" else text.split(" and ")


def audit_text(frame: pd.DataFrame) -> str:
    """Text of the audit, a line per table and reading.

    It has the CRLB of each parameter, and how many values are possible, lucky, impossible.
    """
    if frame.empty:
        return "nothing to compare: no run has a result"
    single = frame[frame["parameter"] != TOGETHER]
    names = list(dict.fromkeys(single["parameter"]))
    lines = []
    for (table, reading, damping, kind), rows in frame.groupby(["table", "reading", "damping", "kind"], sort=False):
        cells = [_count_text(rows[rows["parameter"] == name]) for name in names]
        lines.append(
            [table, reading, damping, kind, *cells, _counts(rows.loc[rows["parameter"] == TOGETHER, "verdict"])]
        )
    head = ["table", "speeds in", "damping in", "data", *names, TOGETHER]
    slips = frame.loc[frame["slip"] != "", ["table", "parameter", "column", "slip"]].drop_duplicates()
    notes = [
        f"slip in print: {table}, {_distinct(rows['parameter'])}, {_distinct(rows['column'])}: {slip}"
        for (table, slip), rows in slips.groupby(["table", "slip"], sort=False)
    ]
    key = (
        f"lucky: the chance of an efficient estimate is below {100 * LUCKY:g} %; impossible: below"
        f" {100 * IMPOSSIBLE:g} %; as near as {100 * LUCKY:g} % of blind draws, or at a limit of the search: possible"
    )
    return "\n".join(
        [
            "printed errors against the Cramér–Rao lower bound (CRLB, 1 σ, %): possible/lucky/impossible",
            aligned(head, lines),
            key,
            f"{TOGETHER}: the columns of the table, each by the joint chance of all its errors",
            *notes,
        ]
    )


def _count_text(rows: pd.DataFrame) -> str:
    return "–" if rows.empty else f"{capped(rows['crlb_pct'].iloc[0])}: {_counts(rows['verdict'])}"


def _counts(verdicts: pd.Series) -> str:
    return "/".join(str(int((verdicts == name).sum())) for name in VERDICTS)


def _distinct(values: pd.Series) -> str:
    return ", ".join(dict.fromkeys(values))

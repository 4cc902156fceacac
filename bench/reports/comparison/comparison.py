"""Agreement of two results: differences of unknowns in units of their joint uncertainty.

Of an unknown with values a and b the difference is (b − a) / √(s_a² + s_b²), where s is the half-width of the interval on the
side that faces the other value, divided by the normal quantile of its level. That is right for two measurements that are
independent; of two identifications of the same data, whose noise is the same, the difference is expected to be smaller than
it says.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd

from bench.reports.comparison.sides import Side
from bench.reports.fleet.rows import EXPLAINED, NOT_EXPLAINED
from bench.reports.pages.made_by import OF_CODE
from ksmea.errors import shortened
from ksmea.records.estimate import Shown
from ksmea.show.text import aligned, capital, in_columns, number, of_chances, with_ends

AGREE = 2.0  # combined standard deviations up to which two values are said to agree
YES, NO = ANSWERS = "yes", "no"
NOT_KNOWN = "not known"  # of an unknown that one side leaves open towards the other
SAID = {
    "adequate": "the model explains the data",
    EXPLAINED: "the model explains the data",
    NOT_EXPLAINED: "the model does not explain the data",
    "unknown": "a cause that is not known",
    "misread": "data that are misread",
    "not observable": "nothing that the data show",
}  # verdicts, in words
ONLY = "only in {}"  # of an unknown that the other side's model has not
OF_CHANCE = "lack-of-fit p"  # how facts begin that are chances
ABSENT = "–"  # in the place of a setting that one side has not
LONGEST = 60  # characters of a setting in the terminal; the page has all
DATA = (
    "measurement",
    "measurement_fingerprint",
    "problem",
    "seed",
    "repetition",
)  # settings that say which data they are
SAME_DATA = (
    "note: both results use the same data with the same noise: expect differences below σ, which assumes two"
    " independent measurements"
)


@dataclass(frozen=True)
class Comparison:
    """Two sides, their unknowns in a table, the settings and facts in which they differ."""

    first: Side
    second: Side
    unknowns: pd.DataFrame
    settings: pd.DataFrame
    facts: pd.DataFrame

    @property
    def is_of_same_data(self) -> bool:
        """Whether no setting of the rotor and the measurement differs."""
        return not any(name.partition(".")[0] in DATA for name in self.settings["setting"])

    @property
    def verdict(self) -> str:
        """Whether the verdicts agree, and then whether the unknowns that both have do."""
        return "; ".join(filter(None, [self._of_verdicts, self.of_unknowns]))

    @property
    def _of_verdicts(self) -> str:
        """Whether two results of one study find the same; of different studies nothing is said."""
        first, second = self.first, self.second
        if first.study != second.study:
            return ""
        if first.finding == second.finding:
            return f"the findings are the same: {in_words(first.finding)}"
        return f"the findings differ: {in_words(first.finding)} in a, {in_words(second.finding)} in b"

    @property
    def of_unknowns(self) -> str:
        comparable = self.unknowns[self.unknowns["agrees"].isin(ANSWERS)]
        apart = comparable[comparable["agrees"] == NO]
        if comparable.empty:
            return "no parameter has an interval in both: whether they agree is not known"
        if apart.empty:
            return f"all {len(comparable)} parameters with intervals in both agree within {AGREE:g} combined standard deviations"
        names = ", ".join(f"{row.unknown} ({row.difference_sigma:+.3g})" for row in apart.itertuples())
        return f"{len(apart)} of {len(comparable)} parameters differ by more than {AGREE:g} combined standard deviations: {names}"


def in_words(finding: str) -> str:
    """A finding without the names of verdicts and without doubts, which the page states with it.

    >>> in_words("named – unequal_bearings (stiffness of bearing 2)"), in_words("adequate")
    ('unequal bearings (stiffness of bearing 2)', 'the model explains the data')
    """
    verdict, _, cause = finding.partition(";")[0].partition(" – ")
    said = cause.replace("_", " ")
    match verdict:
        case "named" | "located" if said:
            return said
        case "ambiguous" if said:
            return f"{said} or another cause"
        case _:
            return SAID.get(verdict, verdict) + (f", {said}" if said else "")


def compared(first: Side, second: Side) -> Comparison:
    """Comparison of two results."""
    return Comparison(first, second, _unknowns(first, second), _settings(first, second), _facts(first, second))


def difference(one: Shown, other: Shown, levels: tuple[float, float] = (0.95, 0.95)) -> float:
    """The difference of two estimates in combined standard deviations.

    Not a number where one is open on the side of the other.

    >>> round(difference(Shown(10.0, 8.04, 11.96, "N"), Shown(13.0, 11.04, 14.96, "N")), 3)
    2.121
    """
    up = other.value >= one.value
    sides = ((one.high - one.value, other.value - other.low), (one.value - one.low, other.high - other.value))
    widths = sides[0] if up else sides[1]
    sds = [width / NormalDist().inv_cdf((1 + level) / 2) for width, level in zip(widths, levels)]
    combined = math.hypot(*sds)
    if combined > 0:
        return (other.value - one.value) / combined
    return 0.0 if other.value == one.value else np.nan


def _unknowns(first: Side, second: Side) -> pd.DataFrame:
    rows = []
    for name in dict.fromkeys([*first.unknowns, *second.unknowns]):
        one, other = first.unknowns.get(name), second.unknowns.get(name)
        is_comparable = one is not None and other is not None and one.unit == other.unit
        apart = difference(one, other, (first.level, second.level)) if one and other and is_comparable else np.nan
        rows.append(
            {
                "unknown": name,
                "unit": " or ".join(dict.fromkeys(each.unit for each in (one, other) if each)),
                **_columns("a", one),
                **_columns("b", other),
                "difference_sigma": apart,
                "agrees": _agrees(one, other, apart),
            }
        )
    columns = [*("unknown", "unit", "a", "a_low", "a_high", "b", "b_low", "b_high"), "difference_sigma", "agrees"]
    return pd.DataFrame(rows, columns=columns)


def _agrees(one: Shown | None, other: Shown | None, apart: float) -> str:
    if one is None or other is None:
        return ONLY.format("b" if one is None else "a")
    return NOT_KNOWN if np.isnan(apart) else YES if abs(apart) <= AGREE else NO


def _columns(side: str, shown: Shown | None) -> dict[str, float]:
    value, low, high = (np.nan,) * 3 if shown is None else (shown.value, shown.low, shown.high)
    return {side: value, f"{side}_low": low, f"{side}_high": high}


def _settings(first: Side, second: Side) -> pd.DataFrame:
    names = [name for name in dict.fromkeys([*first.settings, *second.settings]) if name != OF_CODE]
    rows = [(name, first.settings.get(name, ABSENT), second.settings.get(name, ABSENT)) for name in names]
    return pd.DataFrame([row for row in rows if row[1] != row[2]], columns=["setting", "a", "b"])


def _facts(first: Side, second: Side) -> pd.DataFrame:
    names = dict.fromkeys([*first.facts, *second.facts])
    rows = [(name, *(_said(name, side.facts.get(name)) for side in (first, second))) for name in names]
    return pd.DataFrame(rows, columns=["what", "a", "b"])


def _said(name: str, value: str | float | None) -> str:
    if value is None or value == "":
        return "–"
    if isinstance(value, str):
        return value
    return of_chances(value) if name.startswith(OF_CHANCE) else number(value, 5)


def text(comparison: Comparison) -> str:
    """The comparison in the terminal."""
    first, second = comparison.first, comparison.second
    said = comparison.verdict
    head = [
        f"a: {first.name}: {first.verdict}",
        f"b: {second.name}: {second.verdict}",
        f"{capital(said)}.",
    ]
    blocks = ["\n".join(head), in_columns(unknowns_table(comparison)), in_columns(comparison.facts)]
    return "\n\n".join([*blocks, *_settings_text(comparison)])


def unknowns_table(comparison: Comparison) -> pd.DataFrame:
    """The unknowns of both as text and pages show them."""
    rows = [
        [
            *(row["unknown"], _interval(row, "a"), _interval(row, "b"), row["unit"]),
            *(number(row["difference_sigma"], 3), row["agrees"]),
        ]
        for row in comparison.unknowns.to_dict("records")
    ]
    return pd.DataFrame(rows, columns=["parameter", "a", "b", "unit", "(b − a) / σ", "agree"])


def _settings_text(comparison: Comparison) -> list[str]:
    """Settings that both have and that differ.

    Other settings, of different studies or plugins, are counted.
    """
    table = comparison.settings
    is_of_both = (table["a"] != ABSENT) & (table["b"] != ABSENT)
    rows = [[shortened(cell, LONGEST) for cell in row] for row in table[is_of_both].to_numpy()]
    lines = (
        ["Settings that differ:\n" + aligned([*table.columns], rows)]
        if rows
        else ["No setting that both have differs."]
    )
    left = len(table) - len(rows)
    lines += [f"{left} settings more are of one alone: see the page"] if left else []
    return lines + ([SAME_DATA] if comparison.is_of_same_data else [])


def _interval(row: Mapping[Hashable, Any], side: str) -> str:
    """For example '50.03 [49.99, 50.06]'."""
    value, low, high = row[side], row[f"{side}_low"], row[f"{side}_high"]
    if np.isnan(value):
        return "–"
    return number(value) if np.isnan([low, high]).all() else with_ends(value, low, high)

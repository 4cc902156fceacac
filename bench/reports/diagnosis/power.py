"""Power of a diagnosis, counted over draws: detection against size, confusion, and coverage.

A draw counts as detected if the verdict says that the model is wrong. The chance of that follows from the deviance that
the effect is expected to leave: a noncentral χ² with as many degrees of freedom as the effect has unknowns, against the
quantile that the level leaves to each candidate.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import scipy
from scipy.optimize import brentq

from bench.jobs.lines import RESULTS
from bench.plan.naming import place_columns
from bench.plan.plan import Cell, Plan
from ksmea.records.diagnosis import DiagnosisRecord

EFFECT, DROP, DATA = "effect", "expected_drop", "kind of data"
UNSEEN = ("adequate", "not observable")  # verdicts that say nothing against a model
SIZES = (0.5, 1, 2, 4, 8)  # at the axis of figures, in units of the smallest detectable one
CERTAIN = 0.9  # chance of detection of the smallest detectable size
CLEARLY_VISIBLE = 60.0  # deviance that is expected to be left


def power_row(record: DiagnosisRecord, _: Cell) -> dict[str, Any]:
    """Columns of a record: unknowns of the hidden effects, candidates tried, ambiguity group."""
    return {
        "unknowns": sum(len(effect.parameters) for effect in record.hidden),
        "candidates": len(record.ranking),
        "group": " ".join(record.ambiguity_group),
    }


def with_places(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """Runs with a result and a hidden effect, with facts of their cell and the chance of detection.

    The facts are the effect, the kind of data and the deviance.
    """
    finished = _with_facts(plan, runs)
    with_effect = finished[finished[EFFECT] != ""].copy()
    if with_effect.empty:
        return with_effect
    with_effect["predicted"] = [
        chance(*row) for row in with_effect[[DROP, "unknowns", "candidates", "level"]].itertuples(index=False)
    ]
    with_effect["size"] = [
        np.sqrt(drop / detectable_drop(*row))
        for drop, *row in with_effect[[DROP, "unknowns", "candidates", "level"]].itertuples(index=False)
    ]
    return with_effect


def of_right_models(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """Runs that have a result and hide nothing, with the kind of data that their cell is about."""
    finished = _with_facts(plan, runs)
    return finished[finished[EFFECT] == ""]


def _with_facts(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """Runs with a result, with facts of their cell and whether the verdict rejects the model."""
    facts = pd.DataFrame([_facts(plan, index) for index in range(len(plan.cells))])
    finished = runs[runs["status"].isin(RESULTS)].drop(columns=[DATA, EFFECT, DROP], errors="ignore")
    finished = finished.merge(facts, on="cell").copy()
    if not finished.empty:
        finished["detected"] = ~finished["verdict"].isin(UNSEEN)
    return finished


def _facts(plan: Plan, index: int) -> dict[str, Any]:
    cell = plan.cells[index]
    settings, place = cell.settings, place_columns(plan, cell)
    return {
        "cell": index,
        DATA: place.get("label") or settings["measurement"]["kind"],
        EFFECT: " ".join(settings["measurement"].get("hidden", [])),
        DROP: settings["measurement"].get("expected_drop") or np.nan,
        "level": settings["study"]["level"] / 2,
    }


def chance(drop: float, unknowns: int, candidates: int, level: float) -> float:
    """Probability of detecting an effect of `unknowns` unknowns with an expected deviance drop of `drop`.

    `level` is the significance level of all candidates together.
    """
    critical = scipy.stats.chi2.isf(level / candidates, unknowns)
    return float(scipy.stats.ncx2.sf(critical, unknowns, drop))


def detectable_drop(unknowns: int, candidates: int, level: float) -> float:
    """The deviance of the smallest detectable size."""
    return float(brentq(lambda drop: chance(drop, unknowns, candidates, level) - CERTAIN, 1e-3, 1e4))


def power_frame(with_effect: pd.DataFrame) -> pd.DataFrame:
    """A row per kind of data, effect and deviance.

    Draws, how many were detected and how many were expected to be, and of these how many report what is hidden, and
    hold its sizes.
    """
    return pd.DataFrame(
        [
            {DATA: data, EFFECT: effect, DROP: drop, **_counts(mine)}
            for (data, effect, drop), mine in with_effect.groupby([DATA, EFFECT, DROP], sort=False)
        ]
    )


def rates(with_effect: pd.DataFrame, by: str) -> pd.DataFrame:
    """Counts of clearly visible effects: a row per effect or kind of data, and one for all."""
    visible = with_effect[with_effect[DROP] >= CLEARLY_VISIBLE]
    rows = [{by: name, **_counts(mine)} for name, mine in visible.groupby(by, sort=False)]
    return pd.DataFrame([*rows, {by: "all", **_counts(visible)}])


def _counts(mine: pd.DataFrame) -> dict[str, Any]:
    detected = mine[mine["detected"]]
    return {
        "draws": len(mine),
        "detected": len(detected),
        "expected": float(mine["predicted"].sum()),
        "in_set": int(detected["in_group"].sum()),
        "first": int(detected["is_first"].sum()),
        "surplus": int((detected["surplus"] > 0).sum()),
        "sizes": int(detected["sizes_compared"].sum()),
        "sizes_held": int(detected["sizes_held"].sum()),
        "seconds": mine["seconds"].median(),
    }


def false_alarms(right: pd.DataFrame) -> pd.DataFrame:
    """Draws and false alarms for data that hide nothing, by kind of data and in total."""
    rows = [(data, len(mine), int(mine["detected"].sum())) for data, mine in right.groupby(DATA, sort=False)]
    rows.append(("all", len(right), sum(alarms for _, _, alarms in rows)))
    return pd.DataFrame(rows, columns=[DATA, "draws", "false_alarms"])


def confusion(with_effect: pd.DataFrame) -> pd.DataFrame:
    """Share of clearly visible draws of an effect (rows) whose reported set holds each effect (columns).

    Two further columns: draws that are detected but not named, and draws that are not detected.
    """
    visible = with_effect[with_effect[DROP] >= CLEARLY_VISIBLE]
    hidden = list(dict.fromkeys(with_effect[EFFECT]))
    reported = {name for group in visible["group"].fillna("") for name in group.split()}
    columns = [*hidden, *sorted(reported - set(hidden))]
    return pd.DataFrame([_shares(visible[visible[EFFECT] == name], columns) for name in hidden], index=hidden)


def _shares(mine: pd.DataFrame, columns: list[str]) -> Mapping[str, float]:
    groups = [group.split() for group in mine["group"].fillna("")]
    unnamed = [verdict if not group else "" for verdict, group in zip(mine["verdict"], groups)]
    n = max(len(mine), 1)
    found = {name: sum(name in group for group in groups) / n for name in columns}
    seen = {"no name": sum(bool(verdict) and verdict not in UNSEEN for verdict in unnamed) / n}
    return found | seen | {"not seen": sum(verdict in UNSEEN for verdict in unnamed) / n}

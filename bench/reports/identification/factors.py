"""Factors of a sweep: axes of its cells, their influence all else equal, and cells with shared runs.

Cells whose runs have the same keys answer one question: the axis between them has no influence there, and they are counted once. The
strength of a factor is the median, over the combinations of all others, of the worst level's score over the best level's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.jobs.records import NOT_FAILED, UNFINISHED
from bench.plan.naming import place_columns, place_text, telling_axes
from bench.plan.plan import Plan
from bench.reports.tables import has_truth
from ksmea.show.text import LEAST_WHOLE, capital

SIGMA, PERCENT = "rms error / σ", "rms error, %"
ALLOWED = 2.0  # σ: errors up to this are as small as the data allow
TIE = 1.05  # of the best score: medians of few runs differ by more than this


@dataclass(frozen=True)
class Cell:
    """One merged cell: its level of each factor, its score, and what became of its runs."""

    levels: Mapping[str, Any]
    score: float  # median over its runs; NaN without one
    n_result: int
    n_run: int
    outcome: str  # of its runs without a result, in a word; '' if all have one

    @property
    def words(self) -> str:
        """Its score in a heat map: '1.8', '1.8 (2 of 20 failed)', 'timeout'."""
        if not self.n_result:
            return self.outcome or "missing"
        said = two_figures(self.score)
        lacking = self.n_run - self.n_result
        return f"{said} ({lacking} of {self.n_run} {self.outcome})" if lacking else said


@dataclass(frozen=True)
class Sweep:
    """Factors with their levels, strongest first, the cells that differ, and axes that change nothing."""

    factors: Mapping[str, tuple[Any, ...]]
    cells: tuple[Cell, ...]
    quantity: str  # of the score
    merged: tuple[str, ...]  # a sentence for each axis that changes nothing
    n_run: int
    n_result: int

    @cached_property
    def strength(self) -> dict[str, float]:
        """Worst over best level of each factor, all else equal; NaN where no combination has two scores."""
        return {name: _strength(self.by_combination(name)) for name in self.factors}

    def by_combination(self, factor: str) -> list[dict[Any, float]]:
        """For each combination of the other factors, the score of each level that has one."""
        others = [name for name in self.factors if name != factor]
        keyed = sorted(self.cells, key=lambda cell: [_rank(cell.levels[name]) for name in others])
        groups = (list(group) for _, group in groupby(keyed, key=lambda cell: [cell.levels[name] for name in others]))
        return [{cell.levels[factor]: cell.score for cell in group if np.isfinite(cell.score)} for group in groups]

    def typical(self, factor: str) -> dict[Any, float]:
        """Median score of each level over the combinations."""
        found = self.by_combination(factor)
        scores = {level: [each[level] for each in found if level in each] for level in self.factors[factor]}
        return {level: float(np.median(values)) for level, values in scores.items() if values}

    @property
    def best(self) -> float:
        """The lowest score; NaN without one."""
        scores = [cell.score for cell in self.cells if np.isfinite(cell.score)]
        return min(scores, default=np.nan)

    def is_best(self, cell: Cell) -> bool:
        return bool(cell.score <= TIE * self.best)


def sweep_of(plan: Plan, runs: pd.DataFrame) -> Sweep | None:
    """The factors of a plan; None without any, or with nothing to score."""
    axes = [axis for axis in telling_axes(plan) if len({_key(cell.place.get(axis)) for cell in plan.cells}) > 1]
    if not axes or "label" in axes or not has_truth(plan):
        return None
    scores, quantity = _scores(plan, runs)
    groups = _same_runs(plan)
    merged = [_cell(plan, runs, scores, group, axes) for group in groups]
    idle = [axis for axis in axes if len({_key(cell.levels[axis]) for cell in merged}) == 1]
    said = tuple(_idle(plan, axis, merged) for axis in idle)
    factors = {axis: _levels(plan, axis) for axis in axes if axis not in idle}
    if not factors:
        return None
    cells = tuple(replace(cell, levels={name: cell.levels[name] for name in factors}) for cell in merged)
    found = Sweep(factors, cells, quantity, said, len(runs), int(runs["status"].isin(RESULTS).sum()))
    order = sorted(factors, key=lambda name: -np.nan_to_num(found.strength[name], nan=0.0))
    return replace(found, factors={name: _ordered(found, name) for name in order})


def without_twins(plan: Plan, summary: pd.DataFrame) -> pd.DataFrame:
    """Drop the rows of cells that share their runs with an earlier cell."""
    twins = {_place(place_columns(plan, plan.cells[index]), plan) for group in _same_runs(plan) for index in group[1:]}
    return summary[[_place(row, plan) not in twins for _, row in summary.iterrows()]] if twins else summary


def _place(of: Mapping[str, Any] | pd.Series, plan: Plan) -> tuple[str, ...]:
    """Levels of a cell or its row on the axes, as comparable text: 40 and 40.0 are one level."""
    return tuple(f"{value:g}" if isinstance(value := of[axis], (int, float)) else str(value) for axis in plan.axes)


def headline(sweep: Sweep) -> str:
    """The finding: which factor matters most, and the best level of each."""
    (strongest, strength), *others = sorted(sweep.strength.items(), key=lambda each: -np.nan_to_num(each[1]))
    if not np.isfinite(strength):
        return f"{sweep.n_result} of {sweep.n_run} runs have a result"
    typical = sweep.typical(strongest)
    best, worst = min(typical, key=typical.__getitem__), max(typical, key=typical.__getitem__)
    unit = "σ" if sweep.quantity == SIGMA else "%"
    ratios = ", ".join(f"{short(name)} {value:.1f}" for name, value in others if np.isfinite(value))
    said = (
        f"{short(strongest)} matters most: typical error {two_figures(typical[best])} {unit} with {place_text(best)},"
        f" {two_figures(typical[worst])} {unit} with {place_text(worst)}"
    )
    return capital(said) + f" (worst over best level {strength:.1f} times{f'; {ratios}' if ratios else ''})"


def cells_finding(sweep: Sweep) -> str:
    """The best cell with its levels, and how many cells are worse than the data allow."""
    known = [cell for cell in sweep.cells if np.isfinite(cell.score)]
    if not known:
        return f"No cell has a result; {sweep.quantity}"
    best = min(known, key=lambda cell: cell.score)
    unit = "σ" if sweep.quantity == SIGMA else "%"
    where = ", ".join(f"{short(name)} {place_text(best.levels[name])}" for name in sweep.factors)
    beyond = sum(cell.score > ALLOWED for cell in known)
    counted = f"{beyond} of {len(known)} cells are above {ALLOWED:g} σ; " if unit == "σ" else ""
    return capital(f"{counted}best: {two_figures(best.score)} {unit} with {where}")


def two_figures(score: float) -> str:
    """Two figures, the last one also if it is 0.

    >>> two_figures(0.9), two_figures(1.234), two_figures(250.0), two_figures(12.0)
    ('0.90', '1.2', '250', '12')
    """
    return f"{score:#.2g}".rstrip(".") if score < LEAST_WHOLE else f"{score:.0f}"


def short(axis: str) -> str:
    """The last part of a setting's name.

    'relative' of measurement.relative is 'noise' to nobody, so two parts stay.

    >>> short("optimizer"), short("measurement.relative")
    ('optimizer', 'relative noise')
    """
    return {"measurement.relative": "relative noise", "problem.mesh": "mesh"}.get(axis, axis.rpartition(".")[2])


def _scores(plan: Plan, runs: pd.DataFrame) -> tuple[pd.Series, str]:
    """The rms error of each run over its unknowns.

    They are in σ of the Cramér–Rao bound, or in per cent if a cell has no bound.
    """
    has_bound = all(facts.crlb for cell in plan.cells for facts in cell.parameters if facts.truth)
    found = pd.Series(np.nan, index=runs.index)
    for index, cell in enumerate(plan.cells):
        own = runs.index[(runs["cell"] == index) & runs["status"].isin(RESULTS)]
        errors = []
        for facts in cell.parameters:
            if facts.truth is None or facts.name not in runs or not facts.truth:
                continue
            scale = facts.crlb if has_bound and facts.crlb else abs(facts.truth) / 100
            errors.append((runs.loc[own, facts.name].astype(float) * facts.si_per_unit - facts.truth) / scale)
        if errors:
            found[own] = np.sqrt(np.mean(np.square(errors), axis=0))
    return found, SIGMA if has_bound else PERCENT


def _same_runs(plan: Plan) -> list[list[int]]:
    """Cells in groups whose runs have the same keys."""
    keys: dict[int, list[str]] = {index: [] for index in range(len(plan.cells))}
    for run in plan.runs:
        keys[run.cell].append(run.key)
    groups: dict[tuple[str, ...], list[int]] = {}
    for index, mine in keys.items():
        groups.setdefault(tuple(mine), []).append(index)
    return list(groups.values())


def _cell(plan: Plan, runs: pd.DataFrame, scores: pd.Series, group: Sequence[int], axes: Sequence[str]) -> Cell:
    first = plan.cells[group[0]]
    levels = {axis: first.place.get(axis) for axis in axes}
    mine = runs[runs["cell"] == group[0]]
    known = scores[mine.index].dropna()
    lacking = mine[~mine["status"].isin(RESULTS)]["status"]
    outcome = ""
    if len(lacking):
        is_failed = (~lacking.isin(NOT_FAILED)).any()
        outcome = (
            str(lacking.mode().iloc[0])
            if is_failed
            else "missing"
            if lacking.isin(UNFINISHED).any()
            else str(lacking.iloc[0])
        )
    median = float(known.median()) if len(known) else np.nan
    return Cell({axis: _plain(level) for axis, level in levels.items()}, median, len(known), len(mine), outcome)


def _idle(plan: Plan, axis: str, merged: Sequence[Cell]) -> str:
    """An axis that changes no run."""
    n_run = sum(cell.n_run for cell in merged)
    levels = ", ".join(place_text(each) for each in _levels(plan, axis))
    return f"{short(axis)} ({levels}): no influence; {n_run} runs serve {len(plan.cells)} cells"


def _levels(plan: Plan, axis: str) -> tuple[Any, ...]:
    return tuple(dict.fromkeys(_plain(cell.place.get(axis)) for cell in plan.cells))


def _ordered(sweep: Sweep, name: str) -> tuple[Any, ...]:
    """Numbers in order, names by result."""
    levels = sweep.factors[name]
    if all(isinstance(each, (int, float)) for each in levels):
        return tuple(sorted(levels))
    typical = sweep.typical(name)
    return tuple(sorted(levels, key=lambda level: typical.get(level, np.inf)))


def _strength(combinations: Sequence[Mapping[Any, float]]) -> float:
    ratios = [
        max(each.values()) / min(each.values()) for each in combinations if len(each) > 1 and min(each.values()) > 0
    ]
    return float(np.median(ratios)) if ratios else np.nan


def _plain(level: Any) -> Any:
    """A level as it can be compared: lists and mappings as text."""
    return level if isinstance(level, (int, float, str)) or level is None else str(level)


def _key(level: Any) -> str:
    return str(level)


def _rank(level: Any) -> tuple[int, float, str]:
    is_number = isinstance(level, (int, float))
    return (0 if is_number else 1, float(level) if is_number else 0.0, str(level))

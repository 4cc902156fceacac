"""Errors of all runs in standard deviations of the Cramér–Rao bound, next to the paper's values.

A panel for each unknown, a row for each cell. What lies beyond the axis is counted at its end, so that no outlier sets the scale.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import place_text, telling_axes
from bench.plan.plan import ParameterFacts, Plan
from ksmea.arrays import Array
from ksmea.plugins.identification import at_limit
from ksmea.show.charts.chart import Axis, Chart, Element, Level, Line, Panel, Points, Span, Words, named_rows
from ksmea.show.charts.colours import MODEL, PAPER
from ksmea.show.text import number

FAR = 6.0  # σ, the end of the axis
NEAR = 2.0  # σ, shaded
MOST_ROWS = 24  # cells of a chart; a table has all
LANES = 4  # heights of the dots of a row
PAPER_BELOW = 0.3  # of a row, by which the paper's value lies below its middle
FEWEST = 3  # runs that have a median
ROW = 0.5  # inches


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of one unknown in one cell, in σ of the bound there."""

    ours: Array  # (n_run,)
    is_at_limit: Array  # (n_run,) bool
    paper: float  # NaN without a value of the paper


def has_bounds(plan: Plan) -> bool:
    """Whether the plan has true values and bounds, and data that determine some unknowns."""
    return has_true_values(plan) and bool(determined(plan))


def has_true_values(plan: Plan) -> bool:
    """Whether all cells have the same unknowns, each with a true value and a bound."""
    names = {tuple(facts.name for facts in cell.parameters) for cell in plan.cells}
    known = (facts.truth is not None and facts.crlb for cell in plan.cells for facts in cell.parameters)
    return len(names) == 1 and all(known)


def determined(plan: Plan, *, in_any: bool = False) -> list[str]:
    """Unknowns whose bound is below the value itself in all cells, or in any of them.

    Within a larger one any value would lie.
    """
    enough = any if in_any else all
    return [
        facts.name
        for facts in plan.cells[0].parameters
        if enough(
            each.crlb and each.truth and each.crlb < abs(each.truth)
            for cell in plan.cells
            for each in cell.parameters
            if each.name == facts.name
        )
    ]


def error_finding(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> str:
    """The share of errors within 2 σ, of a plan that `has_bounds`."""
    return _finding(_by_unknown(plan, runs, summary))


def error_chart(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> Chart:
    """Chart of a plan that `has_bounds`; its title is `error_finding`."""
    found = _by_unknown(plan, runs, summary)
    cells = _named(plan, summary)
    has_paper = any(np.isfinite(each.paper) for of in found.values() for each in of)
    panels = [_panel(plan, name, each[:MOST_ROWS], cells, has_paper=has_paper) for name, each in found.items()]
    has_open = any(each.is_at_limit.any() for of in found.values() for each in of)
    dots = "Dots: runs (open: at a search limit)" if has_open else "Dots: runs"
    parts = [dots, "line: their median", *(["diamonds: paper"] if has_paper else [])]
    counts = f"grey: ± {NEAR:g} σ; numbers at the ends: runs beyond {FAR:g} σ"
    first = f"; first {MOST_ROWS} of {len(plan.cells)} cells" if len(plan.cells) > MOST_ROWS else ""
    others = [facts.name for facts in plan.cells[0].parameters if facts.name not in found]
    first += f"; without {', '.join(others)}, which the data do not determine" if others else ""
    caption = f"{'; '.join(parts)}; {counts}{first}. 1 σ is the Cramér–Rao bound: no unbiased method errs less."
    return Chart(_finding(found), caption, tuple((panel,) for panel in panels), len(panels), 11.0, most=len(panels))


def _by_unknown(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> dict[str, list[Errors]]:
    return {name: _errors(plan, runs, summary, name) for name in determined(plan)}


def _errors(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame, name: str) -> list[Errors]:
    """Errors of one unknown, cell by cell."""
    printed = summary.loc[summary["parameter"] == name, "paper"].to_numpy(float)
    results = runs[runs["status"].isin(RESULTS)]
    found = []
    for index, (cell, paper) in enumerate(zip(plan.cells, printed, strict=True)):
        facts = next(each for each in cell.parameters if each.name == name)
        mine = results[results["cell"] == index]
        mine = mine[mine[name].notna()] if name in mine else mine[:0]
        values = mine[name].to_numpy(float) if len(mine) else np.empty(0)
        of_paper = float(_in_sigma(np.array(paper), facts))
        found.append(Errors(_in_sigma(values, facts), at_limits(values, facts), of_paper))
    return found


def at_limits(values: Array, facts: ParameterFacts) -> Array:
    """Which values lie at a search limit; none without limits in the plan."""
    if facts.lower is None or facts.upper is None:
        return np.zeros(len(values), dtype=bool)
    in_cube = (values * facts.si_per_unit - facts.lower) / (facts.upper - facts.lower)
    return np.array(at_limit(in_cube), dtype=bool)


def _in_sigma(values: Array, facts: ParameterFacts) -> Array:
    assert facts.truth is not None and facts.crlb, "an unknown without a bound"
    return np.asarray((values * facts.si_per_unit - facts.truth) / facts.crlb)


def _finding(found: dict[str, list[Errors]]) -> str:
    ours = np.concatenate([each.ours for of in found.values() for each in of])
    paper = np.array([each.paper for of in found.values() for each in of])
    paper = paper[np.isfinite(paper)]
    if not len(ours):
        return "No run has a result"
    share = 100 * np.mean(np.abs(ours) <= NEAR)
    said = f"{share:.0f} % of the {len(ours)} values found lie within {NEAR:g} σ of the true ones"
    return f"{said}; of the paper's, {np.sum(np.abs(paper) <= NEAR)} of {len(paper)}" if len(paper) else said


def _panel(plan: Plan, name: str, errors: list[Errors], cells: Sequence[str], *, has_paper: bool) -> Panel:
    elements: list[Element] = [Span(low=-NEAR, high=NEAR, along="x"), Level(at=0.0, along="x", dash="solid")]
    for at, each in enumerate(errors):
        elements += _row(float(at) - (PAPER_BELOW / 2 if has_paper else 0.0), each)
        if np.isfinite(each.paper):
            elements += _of_paper(float(at) + PAPER_BELOW, each.paper)
    x = Axis("error (σ)", low=-FAR, high=FAR, ticks={-4.0: "−4", -2.0: "−2", 0.0: "0", 2.0: "2", 4.0: "4"})
    y = named_rows(cells, group="cells")
    return Panel(tuple(elements), x, y, f"{name}\n{_scale(plan, name)}", ROW * len(errors) + 0.6)


def _scale(plan: Plan, name: str) -> str:
    """True value and bound of an unknown, as far as they are common to all cells."""
    facts = [each for cell in plan.cells for each in cell.parameters if each.name == name]
    said = []
    if len({each.truth for each in facts}) == 1 and facts[0].truth is not None:
        said.append(f"{number(facts[0].truth / facts[0].si_per_unit)} {facts[0].unit}".rstrip())
        shares = [100 * each.crlb / abs(facts[0].truth) for each in facts if each.crlb and facts[0].truth]
        if shares and max(shares) < 1.01 * min(shares):
            said.append(f"1 σ = {number(shares[0], 2)} %")
    return " · ".join(said)


def _row(y: float, errors: Errors) -> Iterator[Element]:
    """Dots of one cell in lanes, their median and the counts beyond both ends."""
    order = np.argsort(errors.ours, kind="stable")
    values, is_open = errors.ours[order], errors.is_at_limit[order]
    lanes = y + 0.07 * (np.arange(len(values)) % LANES - (LANES - 1) / 2)
    within = np.abs(values) <= FAR
    for open_too in (False, True):
        chosen = within & (is_open == open_too)
        if chosen.any():
            name = "runs at a search limit" if open_too else "runs"
            yield Points(values[chosen], lanes[chosen], size=3.5, is_open=open_too, name=name, said="{x:.2f} σ")
    if len(values) >= FEWEST and abs(median := float(np.median(values))) <= FAR:
        yield Line([median, median], [y - 0.22, y + 0.22], width=2.2, colour=MODEL)
    below, above = int(np.sum(values < -FAR)), int(np.sum(values > FAR))
    if below:
        yield Words(x=-FAR, y=y, text=f"◂ {below}", side="left", offset=(2.0, 0.0), colour=MODEL)
    if above:
        yield Words(x=FAR, y=y, text=f"{above} ▸", side="right", offset=(-2.0, 0.0), colour=MODEL)


def _of_paper(y: float, error: float) -> Iterator[Element]:
    if abs(error) <= FAR:
        yield Points([error], [y], "diamond", 6.0, name="paper", colour=PAPER, said="paper: {x:.1f} σ")
        return
    if error > 0:
        yield Words(x=FAR, y=y, text=f"{error:.0f} σ ▸", side="right", offset=(-2.0, 0.0), colour=PAPER)
    else:
        yield Words(x=-FAR, y=y, text=f"◂ −{-error:.0f} σ", side="left", offset=(2.0, 0.0), colour=PAPER)


def _named(plan: Plan, summary: pd.DataFrame) -> list[str]:
    """Names of the cells, with the median number of updates where they have any."""
    updates = summary[summary["parameter"] == "updates"].reset_index(drop=True)
    axes = telling_axes(plan)
    names = []
    for at, cell in enumerate(plan.cells[:MOST_ROWS]):
        name = " / ".join(place_text(cell.place.get(axis)) for axis in axes) or plan.name
        if axes == ("samples",):
            name += "\u00a0samples"
        if len(updates) == len(plan.cells) and updates["median"].iloc[at] > 0:
            paper = updates["paper"].iloc[at]
            printed = f" (paper {number(paper)})" if np.isfinite(paper) else ""
            name += f"\n+ {number(updates['median'].iloc[at])} updates{printed}".replace(" ", "\u00a0")
        names.append(name)
    return names

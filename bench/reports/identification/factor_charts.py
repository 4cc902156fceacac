"""Charts of a sweep: influence of each factor all else equal, and a heat map of all cells.

The strongest factor is first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from bench.plan.naming import place_text
from bench.reports.identification.factors import (
    ALLOWED,
    SIGMA,
    Cell,
    Sweep,
    cells_finding,
    headline,
    short,
    two_figures,
)
from ksmea.show.charts.chart import Along, Axis, Chart, Element, Heat, Line, Panel, Points, Span, Words, named_rows
from ksmea.show.charts.colours import CONTEXT, INK, MODEL

ROOM = 1.4  # times the least and largest score: ends of their axis
MOST_ACROSS = 4  # panels side by side
MOST_ROWS = 24  # of a heat map; a table has all
ROW = 0.36  # inches of a heat map
TALL = 2.8  # inches of a panel


def factors_chart(sweep: Sweep) -> Chart:
    """A panel for each factor: grey, one combination of all others; blue, the typical level.

    All have one logarithmic axis.
    """
    scores = [cell.score for cell in sweep.cells if np.isfinite(cell.score) and cell.score > 0] or [1.0]
    score = Axis(sweep.quantity, "log", min(scores) / ROOM, max(scores) * ROOM, group="score", better="low")
    stacks = tuple((_factor(sweep, name, score),) for name in sweep.factors)
    allowed = f"; shaded: within {ALLOWED:g} σ, as good as the data allow" if sweep.quantity == SIGMA else ""
    lines = "lines join the levels of one combination where these are numbers"
    caption = (
        f"Grey: one combination of all other factors ({lines}); blue: median over them{allowed}. {_counted(sweep)}"
    )
    across = min(MOST_ACROSS, len(stacks))
    return Chart(headline(sweep), caption, stacks, across, max(2.6 * across, 4.5), most=len(stacks))


def _factor(sweep: Sweep, name: str, score: Axis) -> Panel:
    """Numbers as levels from left to right, with lines; names one below the other."""
    levels = sweep.factors[name]
    is_ordered = all(isinstance(level, (int, float)) for level in levels)
    along: Along = "y" if is_ordered else "x"  # the axis of the scores
    elements: list[Element] = []
    if sweep.quantity == SIGMA and score.low is not None and score.low < ALLOWED:
        elements.append(Span(low=score.low, high=ALLOWED, along=along))

    def placed(scores: Mapping[Any, float]) -> tuple[list[float], list[float]]:
        at = [float(number) for number, level in enumerate(levels) if level in scores]
        values = [scores[level] for level in levels if level in scores]
        return (at, values) if is_ordered else (values, at)

    for scores in sweep.by_combination(name):
        x, y = placed(scores)
        if is_ordered and len(x) == len(levels):  # a line breaks at what is missing
            elements.append(Line(x, y, width=0.8, colour=CONTEXT, opacity=0.5))
        elements.append(Points(x, y, size=3.5, colour=CONTEXT, opacity=0.6, said=f"{{{along}:.3g}}"))
    typical = sweep.typical(name)
    known = [level for level in levels if level in typical]
    x, y = placed(typical)
    if is_ordered and len(x) == len(levels):
        elements.append(Line(x, y, width=1.8, colour=MODEL))
    said = [f"{place_text(level)}: {typical[level]:.3g}" for level in known]
    elements.append(Points(x, y, "diamond", 8.0, colour=MODEL, said=said))
    for number, level in enumerate(known):
        beside: dict[str, Any] = {"offset": (0.0, 7.0), "edge": "bottom"}
        if is_ordered and number in (0, len(known) - 1):
            is_first = number == 0 and len(known) > 1
            beside = {"offset": (-8.0 if is_first else 8.0, 0.0), "side": "right" if is_first else "left"}
        text = two_figures(typical[level])
        elements.append(Words(x=x[number], y=y[number], text=text, size=9.0, has_ground=True, **beside))
    ticks = {float(number): place_text(level) for number, level in enumerate(levels)}
    strength = sweep.strength[name]
    title = f"{short(name)}: worst {strength:.2g} × best" if np.isfinite(strength) else short(name)
    if is_ordered:
        return Panel(tuple(elements), Axis(low=-0.5, high=len(levels) - 0.5, ticks=ticks), score, title, TALL)
    return Panel(tuple(elements), score, named_rows(ticks.values(), group=f"levels of {name}"), title, TALL)


def cells_chart(sweep: Sweep) -> Chart:
    """The score of each cell in a table.

    The strongest factor makes blocks, the second columns, all others rows.
    """
    blocks, columns, rows = _laid_out(sweep)
    of_rows = [*product(*(sweep.factors[name] for name in rows))][:MOST_ROWS]
    by_levels = {tuple(cell.levels[name] for name in sweep.factors): cell for cell in sweep.cells}
    stacks = []
    for block in sweep.factors[blocks] if blocks else (None,):
        cells = [
            [
                _found(sweep, by_levels, {blocks: block, columns: column, **dict(zip(rows, of_row))})
                for column in sweep.factors[columns]
            ]
            for of_row in of_rows
        ]
        stacks.append((_heat(sweep, cells, block if blocks else None, blocks, columns, rows, of_rows),))
    across = min(len(stacks), MOST_ACROSS)
    most = f"; first {MOST_ROWS} rows" if len(of_rows) == MOST_ROWS else ""
    caption = f"{sweep.quantity}, median of each cell; the stronger the blue, the larger; framed: best, with all within 5 %{most}. {_counted(sweep)}"
    width = max(1.1 * len(sweep.factors[columns]) * across + 1.6, 4.5)
    return Chart(cells_finding(sweep), caption, tuple(stacks), across, min(width, 12.0), most=len(stacks))


def _laid_out(sweep: Sweep) -> tuple[str, str, list[str]]:
    """The factors of blocks ('' without), columns and rows; of two the stronger one makes the columns."""
    names = list(sweep.factors)
    if len(names) < 3:
        return "", names[0], names[1:]
    return names[0], names[1], names[2:]


def _found(sweep: Sweep, by_levels: dict[tuple[Any, ...], Cell], levels: dict[str, Any]) -> Cell | None:
    return by_levels.get(tuple(levels[name] for name in sweep.factors))


def _heat(
    sweep: Sweep, cells: Sequence[Sequence[Cell | None]], block: Any, blocks: str, columns: str, rows: Sequence[str], of_rows: Sequence[tuple[Any, ...]]
) -> Panel:  # fmt: skip
    shares = np.array([[_darkness(sweep, cell) for cell in row] for row in cells])
    words = tuple(tuple("" if cell is None else cell.words for cell in row) for row in cells)
    best = [
        (x, y) for y, row in enumerate(cells) for x, cell in enumerate(row) if cell is not None and sweep.is_best(cell)
    ]
    elements: list[Element] = [Heat(shares, words)]
    elements += [
        Line(
            [x - 0.46, x + 0.46, x + 0.46, x - 0.46, x - 0.46],
            [y - 0.44, y - 0.44, y + 0.44, y + 0.44, y - 0.44],
            width=1.6,
            colour=INK,
        )
        for x, y in best
    ]
    across = {float(at): place_text(level) for at, level in enumerate(sweep.factors[columns])}
    down = (", ".join(map(place_text, levels)) for levels in of_rows)
    return Panel(
        tuple(elements),
        Axis(short(columns), low=-0.5, high=len(across) - 0.5, ticks=across),
        named_rows(down, ", ".join(map(short, rows)), "rows", beyond=0.5),
        f"{short(blocks)} {place_text(block)}" if blocks else "",
        ROW * len(of_rows) + 0.3,
    )


def _darkness(sweep: Sweep, cell: Cell | None) -> float:
    """0 to 1 over the decades from the best score to the worst."""
    scores = [each.score for each in sweep.cells if np.isfinite(each.score) and each.score > 0]
    if cell is None or not scores or not np.isfinite(cell.score) or cell.score <= 0:
        return 0.0
    low, high = np.log(min(scores)), np.log(max(scores))
    return float(0.75 * (np.log(cell.score) - low) / max(high - low, 1e-9))


def _counted(sweep: Sweep) -> str:
    lacking = sweep.n_run - sweep.n_result
    runs = f"{sweep.n_result} of {sweep.n_run} runs have a result" if lacking else f"{sweep.n_run} runs"
    return " ".join([f"{runs}.", *(f"{said}." for said in sweep.merged)])

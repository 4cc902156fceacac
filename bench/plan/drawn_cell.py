"""Cell of an experiment whose responses are drawn, repetition by repetition."""
# Shorter than 40 lines: the one choice that jobs and reports share.

from __future__ import annotations

from bench.plan.plan import Plan

PAPER_SAMPLES = {"table2": 100, "table3": 100, "table8": 200}  # of the cell that the paper draws


def drawn_cell(plan: Plan) -> int:
    """The cell that the paper draws; of other experiments, the first."""
    samples = PAPER_SAMPLES.get(plan.report.paper or "")
    found = (number for number, cell in enumerate(plan.cells) if cell.place.get("samples") == samples)
    return next(found, 0)

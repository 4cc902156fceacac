"""What the synthetic data of an experiment's runs hide, apart from what was found in them."""

from __future__ import annotations

import pandas as pd

from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from ksmea.show.text import HIDDEN_COLUMN, hidden_text


def hidden_by_cell(runs: pd.DataFrame) -> dict[int, str]:
    """By cell, names, locations and values, of cells with one run: of several, each draws its own."""
    told = runs[runs[HIDDEN_COLUMN].notna()] if HIDDEN_COLUMN in runs else runs[:0]
    return {int(str(cell)): str(mine[HIDDEN_COLUMN].item()) for cell, mine in told.groupby("cell") if len(mine) == 1}


def hidden_paragraph(plan: Plan, runs: pd.DataFrame, study: str) -> str:
    """The same as text below a table, and where to find what each of several runs drew; empty where nothing is hidden."""
    told = hidden_by_cell(runs)
    if not told and HIDDEN_COLUMN in runs and runs[HIDDEN_COLUMN].notna().any():
        return hidden_text([f"drawn by each run: {HIDDEN_COLUMN} in runs.csv"], study)
    names = {cell: f"{cell_name(plan, plan.cells[cell])}: " if len(plan.cells) > 1 else "" for cell in told}
    return hidden_text([names[cell] + text for cell, text in told.items()], study)

"""Size of an experiment: number of runs of its grid and repetitions.

It is known before any of them is planned or written.

A plan of 100 000 runs takes 20 s and 40 MB to write. More than that is usually a slip (`repetitions=1000000000000`) and needs
`force=true`. A plan is read as a whole, so that ten million runs, a few GB, are the most that one experiment can have.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bench.command_line.grid import Block, n_point
from bench.plan.plan import Plan
from ksmea.errors import SettingError

UNFORCED = 100_000  # runs
MOST = 10_000_000
MANY = 1000  # runs from which on their number is printed before they are begun


def require_size(
    blocks: Sequence[Block], swept: Mapping[str, tuple[Any, ...]], fixed: set[str], repetitions: int, is_forced: bool
) -> None:
    """Raise `SettingError` if an experiment has more runs than allowed, or than anyone is likely to mean."""
    n_cell = n_point(blocks, swept, fixed)
    n_run = n_cell * max(repetitions, 1)
    if n_run <= (MOST if is_forced else UNFORCED):
        return
    cure = "give fewer, in several experiments" if n_run > MOST else "give fewer, or force=true if all are meant"
    raise SettingError(
        f"repetitions: expected at most {MOST if n_run > MOST else UNFORCED} runs, got {_counted(n_run)}"
        f" ({_counted(n_cell)} cells × {_counted(repetitions)} repetitions); {cure}"
    )


def size_line(plan: Plan) -> str:
    """How many runs a large plan has; '' for a small one."""
    if len(plan.runs) < MANY:
        return ""
    repetitions = len(plan.runs) // max(len(plan.cells), 1)
    return f"{plan.name}: {len(plan.runs)} runs ({len(plan.cells)} cells × {repetitions} repetitions)"


def _counted(number: int) -> str:
    return f"{number:.4g}" if number >= 10**9 else str(number)

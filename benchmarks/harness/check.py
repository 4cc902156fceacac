"""Whether something has become slower by accident: the ratios of a short run beside the committed ones.

Only ratios of contestants that do the same on any machine can be compared, and those still depend on the processor: what is
said is a line to look at, not an error.
"""

from __future__ import annotations

import pandas as pd

from benchmarks.harness.report import number, title_of
from benchmarks.harness.table import KEY

FALLEN = 2 / 3  # of the committed ratio


def slower(now: pd.DataFrame, committed: pd.DataFrame) -> list[str]:
    """A line for each ratio whose third quartile now is below two thirds of the committed median."""
    both = _both(now, committed)
    fallen = both[both["ratio_q3_now"] < FALLEN * both["ratio"]]
    return [
        f"slower: {title_of(line)}, {line['contestant']}: {number(line['ratio_now'])} × here, {number(line['ratio'])} × committed"
        for _, line in fallen.iterrows()
    ]


def compared(now: pd.DataFrame, committed: pd.DataFrame) -> int:
    """How many ratios both tables have."""
    return len(_both(now, committed))


def _both(now: pd.DataFrame, committed: pd.DataFrame) -> pd.DataFrame:
    """Ratios that both tables have; a row without a size meets one without."""
    measured = now.loc[now["ratio"].notna(), [*KEY, "ratio", "ratio_q3"]]
    known = committed[committed["ratio"].notna()]
    without = {"size": -1.0}
    both = known.fillna(without).merge(measured.fillna(without), on=KEY, suffixes=("", "_now"))
    return both.assign(size=both["size"].where(both["size"] >= 0))

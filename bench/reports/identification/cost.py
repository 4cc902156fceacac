"""Cost of a method against the cost of an FE evaluation, and the break-even of a surrogate.

A run takes N evaluations of the model and an overhead of its own (surrogate, search): total = N · t + overhead, with t
the cost of one evaluation. Two methods break even at t = (overhead₁ − overhead₂) / (N₂ − N₁).
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from bench.storage.own_files import PAPER
from ksmea.numerics.meter import JACOBIAN_AS_EVALUATIONS
from ksmea.show.charts.chart import Axis, Chart, Element, Level, Line, Points, Words, one_panel
from ksmea.show.charts.colours import PAPER as PRINTED
from ksmea.show.charts.colours import category
from ksmea.show.text import two_digits

COSTS = np.logspace(-6, np.log10(3600), 200)  # s per evaluation: from a microsecond to an hour


def cost_frame(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """A row per method (cell of the plan).

    Medians of evaluations and times, and the break-even with the first method.
    """
    rows = []
    for index, cell in enumerate(plan.cells):
        done = runs[(runs["cell"] == index) & runs["status"].isin(RESULTS)]
        if done.empty:
            continue
        evaluations = done["model_evaluations"] + JACOBIAN_AS_EVALUATIONS * done["model_jacobians"]
        rows.append(
            {
                "method": cell_name(plan, cell),
                "model_evaluations": done["model_evaluations"].median(),
                "model_jacobians": done["model_jacobians"].median(),
                "evaluations": evaluations.median(),
                "model_s": done["time_model"].median(),
                "overhead_s": (done["time"] - done["time_model"]).median(),
                "total_s": done["time"].median(),
                "runs": len(done),
            }
        )
    frame = pd.DataFrame(rows)
    first = frame.iloc[0]
    fewer = frame["evaluations"] - first["evaluations"]
    frame["break_even_s"] = np.where(
        fewer > 0, (first["overhead_s"] - frame["overhead_s"]) / fewer.where(fewer > 0), np.nan
    )
    frame["break_even_s"] = frame["break_even_s"].clip(lower=0)
    return frame


def paper_cost() -> tuple[float, pd.DataFrame]:
    """Seconds per FE evaluation that the paper's Table 3 implies, and its printed times by method.

    They are the slope of its times over samples + updates, by least squares.
    """
    table3 = pd.read_csv(PAPER / "table3.csv")
    updates = table3[table3["parameter"] == "updates"].set_index("samples")["identified"]
    seconds = table3[table3["parameter"] == "time"].set_index("samples")["identified"]
    slope = np.polyfit(updates.index + updates, seconds, 1)[0]
    table6 = pd.read_csv(Path(PAPER) / "table6.csv")
    return float(slope), table6[table6["parameter"] == "time"][["method", "identified"]]


def cost_chart(frame: pd.DataFrame) -> Chart:
    """Total time against the cost of one evaluation, a line per method; diamonds are the paper's times."""
    elements: list[Element] = []
    for number, row in enumerate(frame.itertuples()):
        colour, name = category(number), f"{row.method}: {row.evaluations:.0f} evaluations + {row.overhead_s:.2g} s"
        elements.append(Line(COSTS, row.evaluations * COSTS + row.overhead_s, name=name, colour=colour))
        if np.isfinite(row.break_even_s) and row.break_even_s > 0:
            elements.append(
                Points([row.break_even_s], [row.evaluations * row.break_even_s + row.overhead_s], colour=colour)
            )
    cost, times = paper_cost()
    elements.append(
        Points([cost] * len(times), times["identified"].to_numpy(), "diamond", name="paper, Table 6", colour=PRINTED)
    )
    is_surrogate = times["method"] == "KSMEA"
    for methods, is_right in ((times[~is_surrogate], True), (times[is_surrogate], False)):
        names, middle = ", ".join(methods["method"]), float(np.exp(np.log(methods["identified"]).mean()))
        side: Literal["left", "right"] = "left" if is_right else "right"
        offset = (9.0 if is_right else -9.0, 0.0)
        elements.append(Words(x=cost, y=middle, text=names, offset=offset, side=side, has_ground=True))
    direct = frame.loc[frame["evaluations"].idxmax()]
    elements.append(Level(at=float(direct["model_s"] / direct["evaluations"]), along="x", label="one evaluation here"))
    return one_panel(
        elements, Axis("cost of one FE evaluation (s)", "log"), Axis("time of one identification (s)", "log", better="low"),
        _finding(frame),
        "Dots: break-even with the first method. The paper's cost is what its Table 3 implies.", height=4.2, width=8.5,
    )  # fmt: skip


def _finding(frame: pd.DataFrame) -> str:
    """Cost of an evaluation from which on the first method is the fastest, and its gain at 1 s.

    The gain is against the method with the most evaluations.
    """
    first, other = frame.iloc[0], frame.loc[frame["evaluations"].idxmax()]
    if not np.isfinite(other["break_even_s"]):
        return "Time of one identification against the cost of one evaluation"
    times = [row["evaluations"] + row["overhead_s"] for row in (other, first)]
    return (
        f"{first['method']} is faster than {other['method']} if an evaluation costs more than {_seconds(other['break_even_s'])};"
        f" {two_digits(times[0] / times[1])} times at 1 s"
    )


def _seconds(value: float) -> str:
    """Seconds in a unit of their size.

    >>> _seconds(5.2e-5), _seconds(0.02), _seconds(3.0)
    ('52 µs', '20 ms', '3 s')
    """
    unit, name = next(((unit, name) for unit, name in ((1.0, "s"), (1e-3, "ms")) if value >= unit), (1e-6, "µs"))
    return f"{two_digits(value / unit)} {name}"

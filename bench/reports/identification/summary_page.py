"""Sections on a table of medians: the table beside the paper's values, box plots of the same numbers, and curves of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import cell_name, place_text, telling_axes
from bench.plan.page import Block, Control, Folded, Grid, Page, Plot, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.identification.figures import cells_with
from bench.reports.plots.boxes import box_plot
from bench.reports.plots.traces import BLUE, OCHRE, ORANGE, PALE, PURPLE, band, layout, level, line, points, styles
from bench.reports.tables import has_intervals, lacks_interval
from ksmea.records.curves import ResponseCurves, as_array
from ksmea.records.identification import UpdateRecord
from ksmea.show.figures.response_lines import AMPLITUDE
from ksmea.show.figures.style import broken
from ksmea.show.text import two_digits
from ksmea.units import MICROMETRE, RPM

LEAST_EXCESS = 1e-3  # of a deviance, drawn as this: the data see no smaller difference
FEW_LINES = 3  # are told apart without being seen through
MOST_LINES = 40  # repetitions in one plot


def summary_page(
    plan: Plan,
    text: str,
    runs: pd.DataFrame,
    summary: pd.DataFrame,
    curves: Mapping[int, ResponseCurves],
    histories: Mapping[str, Sequence[UpdateRecord]],
    reached: pd.DataFrame | None,
) -> Page:
    """The page of a table; `reached` says what was reached at which cost."""
    sections = [
        Section(
            "Table",
            (
                Prose(text),
                Folded("All columns", (Table(summary.dropna(axis="columns", how="all"), file=f"{plan.name}.csv"),)),
            ),
        ),
        Section("Spread over the repetitions", (Grid(tuple(box_plots(plan, runs, summary))),)),
    ]
    curve_blocks: list[Block] = []
    if histories and any(histories.values()):
        curve_blocks.append(updates_plot(plan, histories, f"{plan.name}_updates.png"))
    if curves:
        curve_blocks.append(response_plot(plan, curves, f"{plan.name}_response.png"))
    if reached is not None and len(reached):
        curve_blocks += [
            anytime_plot(plan, reached, column, f"{plan.name}_trace.png" if column == "excess" else "")
            for column in LABELS
        ]
    sections += [Section("Curves", tuple(curve_blocks))] if curve_blocks else []
    return Page(headline(plan, runs, summary), tuple(sections))


def headline(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> str:
    """The range of the median absolute errors over all cells, parameter by parameter."""
    with_error = summary.dropna(subset="error_pct_median")
    ranges = [
        f"{name} {_range(rows['error_pct_median'])} %" for name, rows in with_error.groupby("parameter", sort=False)
    ]
    done = int(runs["status"].isin(RESULTS).sum())
    errors = f"; median absolute errors: {', '.join(ranges)}" if ranges else ""
    return f"{done} of {len(runs)} runs have a result{errors}"


def _range(values: pd.Series) -> str:
    low, high = (two_digits(value) for value in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def box_plots(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> list[Plot]:
    """A box plot for each row of the table."""
    results = runs[runs["status"].isin(RESULTS)]
    made = []
    x = " / ".join(telling_axes(plan))
    for name, unit in dict.fromkeys(zip(summary["parameter"], summary["unit"])):
        rows = summary[(summary["parameter"] == name) & (summary["unit"] == unit)]
        cells = cells_with(plan, name, unit)
        values = [
            results.loc[results["cell"] == cell, name].dropna().tolist() if name in results else [] for cell in cells
        ]
        marks = {mark: rows[column].tolist() for mark, column in (("reference", "reference"), ("paper", "paper"))}
        ends = (
            [
                None if lacks else (low, high)
                for lacks, low, high in zip(lacks_interval(rows), rows["low"], rows["high"])
            ]
            if has_intervals(rows)
            else None
        )
        is_log = name == "time" or _is_wide(values, marks["paper"])
        title = f"{name} ({unit})" if unit else name.replace("_", " ")
        made.append(
            box_plot(title, unit, [_label(plan, cell) for cell in cells], values, marks, ends, x=x, y_log=is_log)
        )
    return made


def _is_wide(values: Sequence[Sequence[float]], marks: Sequence[float]) -> bool:
    every = np.array([each for of in [*values, marks] for each in of], dtype=float)
    every = every[np.isfinite(every)]
    return bool(len(every) and every.min() > 0 and every.max() > 50 * every.min())


def _label(plan: Plan, cell: int) -> str:
    return " / ".join(place_text(plan.cells[cell].place.get(axis)) for axis in telling_axes(plan)) or str(cell)


def updates_plot(plan: Plan, histories: Mapping[str, Sequence[UpdateRecord]], still: str) -> Plot:
    """Misfit of the true model at each updating step, a line for each repetition."""
    names = [cell_name(plan, cell) for cell in plan.cells]
    traces = []
    for name, (colour, dash) in styles(names).items():
        cell = names.index(name)
        mine = [histories.get(run.key, ()) for run in plan.runs if run.cell == cell and run.repetition < MOST_LINES]
        xs: list[float | None] = []
        ys: list[float | None] = []
        for history in filter(None, mine):
            xs += [*range(1, len(history) + 1), None]
            ys += [*(update.misfit for update in history), None]
        traces.append(
            line(
                xs,
                ys,
                name,
                colour,
                line={"color": colour, "width": 1.6, "dash": dash},
                meta={"cell": name},
                opacity=0.7 if len(mine) > FEW_LINES else 1.0,
            )
        )
    return Plot(
        "Updating steps",
        "Misfit of the true model at the surrogate's optimum of each updating step, a line for each repetition.",
        {"data": traces, "layout": layout("updating step", "misfit", y_log=True)},
        still,
        _cell_control(names),
    )


def response_plot(plan: Plan, curves: Mapping[int, ResponseCurves], still: str) -> Plot:
    """Amplitude over speed of the first repetition of each cell: measured, identified, and true where it is known."""
    names = {cell: cell_name(plan, plan.cells[cell]) for cell in curves}
    traces = []
    channels: dict[str, None] = {}
    for cell, of in curves.items():
        for column, channel in enumerate(of.channels):
            channels[channel] = None
            meta = {"cell": names[cell], "channel": channel}
            speed = as_array(of.speed) / RPM
            for curve, (colour, drawn) in _drawn_curves(of).items():
                values = drawn[:, column] / MICROMETRE
                name = IN_WORDS[curve]
                if curve == "measured":
                    traces.append(points(speed, values, name, colour, meta=meta, marker={"size": 5}))
                else:
                    x, y = broken(speed, of.breaks), broken(values, of.breaks)
                    style = {"color": colour, "width": WIDTHS[curve], "dash": DASHES[curve]}
                    traces.append(line(x, y, name, colour, meta=meta, line=style))
    chosen_among = {"cell": tuple(dict.fromkeys(names.values())), "channel": tuple(channels)}
    controls = tuple(
        Control(key, key, options, with_all=False, chosen=options[0])
        for key, options in chosen_among.items()
        if len(options) > 1
    )
    return Plot(
        "Response curves",
        "Amplitude at the measured speeds, in the first repetition: measured, identified, the surrogate's prediction and the model"
        " at its last optimum, and the truth behind synthetic data. Surrogates know the measured speeds alone, so that peaks between"
        " them are cut off.",
        {"data": traces, "layout": layout("speed (rpm)", AMPLITUDE, y_log=True)},
        still,
        controls,
    )


# From the widest line, which lies below, to the narrowest, so that curves that are alike can all be seen.
WIDTHS = {"true": 7.0, "identified": 3.6, "modelled": 1.8, "predicted": 1.4}
DASHES = {"true": "solid", "identified": "solid", "modelled": "dash", "predicted": "dot"}
CURVE_COLOURS = {"true": PALE, "identified": BLUE, "modelled": OCHRE, "predicted": PURPLE, "measured": ORANGE}
IN_WORDS = {
    "true": "truth", "identified": "identified", "measured": "measured",
    "predicted": "surrogate at its last optimum", "modelled": "model at that optimum",
}  # fmt: skip


def _drawn_curves(of: ResponseCurves) -> dict[str, tuple[str, np.ndarray]]:
    """Colour and values of each curve that there is, in the order in which they are drawn."""
    drawn = {name: getattr(of, name) for name in CURVE_COLOURS}
    return {name: (colour, as_array(drawn[name])) for name, colour in CURVE_COLOURS.items() if drawn[name] is not None}


LABELS = {"excess": "misfit above its least", "error": "rms error of the unknowns (CRLB)"}


def anytime_plot(plan: Plan, frame: pd.DataFrame, column: str, still: str) -> Plot:
    """Excess or error of the best point so far against the cost: medians and quartiles of each cell."""
    names = [cell_name(plan, cell) for cell in plan.cells]
    traces = []
    for name, (colour, dash) in styles(names).items():
        rows = frame[frame["cell"] == names.index(name)]
        low, middle, high = (_seen(rows[f"{column}_{quartile}"], column) for quartile in ("q1", "median", "q3"))
        more = {"meta": {"cell": name}}
        step = {"color": colour, "dash": dash, "width": 1.8, "shape": "hv"}
        traces += band(rows["cost"].to_numpy(), low, high, name, colour, showlegend=False, **more)
        traces.append(line(rows["cost"].to_numpy(), middle, name, colour, legendgroup=name, line=step, **more))
    price = " or ".join(map(str, sorted(set(frame["jacobian_price"]))))
    made = layout(
        f"evaluations of the true model, a Jacobian as {price}",
        LABELS[column],
        x_log=True,
        y_log=True,
        shapes=[level(1.0)],
    )
    return Plot(
        LABELS[column].capitalize(),
        f"{LABELS[column].capitalize()} of the best point so far: medians over the runs, quartiles as bands.",
        {"data": traces, "layout": made},
        still,
        _cell_control(names),
    )


def _seen(values: pd.Series, column: str) -> np.ndarray:
    shown = values.to_numpy(float)
    shown = np.maximum(shown, LEAST_EXCESS) if column == "excess" else shown
    return np.where(np.isfinite(shown), shown, np.nan)


def _cell_control(names: Sequence[str]) -> tuple[Control, ...]:
    return (Control("cell", "cell", tuple(names)),) if len(names) > 1 else ()

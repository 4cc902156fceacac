"""Pages of many diagnoses and their charts.

How often each verdict was reached in each cell, detection against size, and what each hidden effect is called.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import cell_name
from bench.plan.page import Block, Drawn, Folded, Page, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.diagnosis.power import DROP, EFFECT, SIZES, chance, detectable_drop
from bench.reports.tables import interval
from ksmea.show.charts.chart import (
    Axis,
    Chart,
    Element,
    Level,
    Line,
    Panel,
    Points,
    Words,
    named_rows,
    one_panel,
    stacked_bars,
)
from ksmea.show.charts.colours import CONTEXT, PAPER, REFERENCE, category
from ksmea.show.text import number

VERDICTS = ("adequate", "named", "ambiguous", "located", "unknown", "not observable")
COLUMNS = 5  # of panels
ROW = 0.36  # inches: of a bar, or a row of dots
SAID = 0.1  # share from which on a wrong name is written
UNNAMED, UNSEEN = "no name", "not seen"


def diagnoses_page(plan: Plan, text: str, frame: pd.DataFrame, runs: pd.DataFrame) -> Page:
    """Verdicts of each cell, in a table and as bars."""
    counts = (
        runs.loc[runs["status"].isin(RESULTS), "verdict"].value_counts() if "verdict" in runs else pd.Series(dtype=int)
    )
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "no run has a result"
    said = _rate_of(frame)
    table = Section("Table", (Prose(text), Folded("All columns", (Table(frame, file=f"{plan.name}.csv"),))))
    names = [cell_name(plan, cell) or f"cell {number}" for number, cell in enumerate(plan.cells)]
    drawn = Section("Verdicts", (Drawn(verdicts_chart(names, frame)),))
    return Page(said or verdicts, (drawn, table), verdicts if said else "")


def _rate_of(frame: pd.DataFrame) -> str:
    """False alarms without an effect, and reported sets that hold a hidden one, with an interval.

    '' without either.
    """
    said = []
    if counts := _counted(frame, "in_group", "clearly_visible"):
        said.append(
            f"Hidden effect in the reported set in {counts[0]} of {counts[1]} clearly visible draws{_interval(*counts)}"
        )
    if counts := _counted(frame, "false_alarms", "runs"):
        alarms = "No false alarm" if not counts[0] else f"{counts[0]} false alarm{'s' * (counts[0] > 1)}"
        said.append(f"{alarms} in {counts[1]} {'diagnoses' if counts[1] > 1 else 'diagnosis'}{_interval(*counts)}")
    return "; ".join(said)


def _counted(frame: pd.DataFrame, column: str, of: str) -> tuple[int, int] | None:
    """How many of how many, over the cells that have such counts; None without any."""
    if column not in frame or not (n_run := int(frame.loc[frame[column].notna(), of].sum())):
        return None
    return int(frame[column].sum()), n_run


def _interval(count: int, n_run: int) -> str:
    low, high = (number(100 * end, 2) for end in interval(count, n_run))
    return f" ({low} to {high} %)"


def power_page(
    seen: str, about: str, tables: dict[str, pd.DataFrame], with_effect: pd.DataFrame, shares: pd.DataFrame
) -> Page:
    """Rates by effect and by kind of data, detection against size, and what each effect is called.

    `seen` is that in a line.
    """
    sections = (
        Section("Rates", (Prose(about), *(Table(table, title) for title, table in tables.items()))),
        Section("Detection", tuple(_detections(with_effect))),
        *(
            [Section("Names", (Drawn(partial(confusion_chart, shares), "confusion.png"),))]
            if shares.to_numpy().any()
            else []
        ),
    )
    return Page(seen, sections)


def _detections(with_effect: pd.DataFrame) -> Iterator[Block]:
    """Detection against size, of draws whose smallest detectable size is known."""
    if with_effect["size"].notna().any():
        yield Drawn(partial(detection_chart, with_effect), "detection.png")
    else:
        yield Prose("No draw has a size that the data are expected to show.")


def verdicts_chart(names: Sequence[str], frame: pd.DataFrame) -> Chart:
    """How often each verdict was reached in each cell (n): bars that stand on each other."""
    at = np.arange(len(names), dtype=float)
    counts = {verdict: (frame[verdict].to_numpy(float), category(number)) for number, verdict in enumerate(VERDICTS)}
    bars = stacked_bars(at, {verdict: (sizes, colour) for verdict, (sizes, colour) in counts.items() if sizes.any()})
    return one_panel(
        bars, Axis("runs", is_whole=True), named_rows(names), "Verdicts", "How often each verdict was reached in each cell.", height=ROW * (len(names) + 1),
    )  # fmt: skip


def detection_chart(with_effect: pd.DataFrame) -> Chart:
    """The share of draws that are detected against size, per effect.

    1 is the smallest detectable size, which nine of ten draws are expected to show.
    """
    effects = list(dict.fromkeys(with_effect[EFFECT]))
    across = min(COLUMNS, len(effects))
    sizes = np.geomspace(min(0.5, with_effect["size"].min()), max(2.0, with_effect["size"].max()), 60)
    panels = [_detection(effect, with_effect[with_effect[EFFECT] == effect], sizes) for effect in effects]
    return Chart(
        _detection_finding(with_effect),
        "Share of the draws of each effect that are detected, with 95 % intervals, and the share that is expected (line)."
        " 1 is the smallest detectable size.",
        tuple(tuple(panels[column::across]) for column in range(across)), across, max(2.5 * across + 0.6, 4.0),
    )  # fmt: skip


def _detection_finding(with_effect: pd.DataFrame) -> str:
    """Draws that are detected, of detectable and of smaller sizes."""
    is_large = with_effect["size"] >= 1
    large, small = with_effect.loc[is_large, "detected"], with_effect.loc[~is_large, "detected"]
    said = [f"{large.sum()} of {len(large)} effects of a detectable size are detected"] if len(large) else []
    said += [f"{small.sum()} of {len(small)} smaller ones"] if len(small) else []
    return (
        ", ".join(said)
        if len(large)
        else f"{small.sum()} of {len(small)} effects below the detectable size are detected"
    )


def _detection(effect: str, mine: pd.DataFrame, sizes: np.ndarray) -> Panel:
    unknowns, candidates, level = (mine[name].iloc[0] for name in ("unknowns", "candidates", "level"))
    needed = detectable_drop(unknowns, candidates, level)
    expected = [100 * chance(size**2 * needed, unknowns, candidates, level) for size in sizes]
    draws = [of for _, of in mine.groupby(DROP)]
    counts = [(int(of["detected"].sum()), len(of)) for of in draws]
    low, high = 100 * np.array([interval(seen, n) for seen, n in counts]).T
    detected = Points(
        [of["size"].median() for of in draws], [100 * seen / n for seen, n in counts], low=low, high=high,
        name="detected", said=[f"{seen} of {n}" for seen, n in counts],
    )  # fmt: skip
    x = Axis("size / detectable size", "log", ticks={size: f"{size:g}" for size in SIZES}, group="size")
    y = Axis("detected (%)", low=-5, high=105, group="share")
    line = Line(sizes, expected, width=1.0, name="expected", colour=REFERENCE, said="{y:.0f} % expected")
    return Panel((line, detected, Level(at=1.0, along="x")), x, y, _words(effect), 1.6)


def confusion_chart(shares: pd.DataFrame) -> Chart:
    """Share of the clearly visible draws of each hidden effect that report its name, another, or none."""
    every = {name: 100 * shares.loc[name].astype(float) for name in shares.index}
    wrong = [
        (at, str(name), share)
        for at, (hidden, of) in enumerate(every.items())
        for name, share in of.drop([hidden, UNNAMED, UNSEEN], errors="ignore").items()
        if share > 0
    ]
    none = [(at, share) for at, of in enumerate(every.values()) if (share := of.get(UNNAMED, 0) + of.get(UNSEEN, 0))]
    own = [of[hidden] for hidden, of in every.items()]
    elements: list[Element] = []
    if none:
        places, missed = [float(at) for at, _ in none], [share for _, share in none]
        elements.append(
            Points(missed, places, is_open=True, name="no name, or not seen", colour=CONTEXT, said="{x:.0f} %")
        )
    if wrong:
        said = [f"{_words(name)}: {share:.0f} %" for _, name, share in wrong]
        other = Points(
            [share for *_, share in wrong], [float(at) for at, *_ in wrong], "diamond", name="another name", colour=PAPER, said=said,
        )  # fmt: skip
        elements.append(other)
    elements.append(Points(own, np.arange(len(own), dtype=float), name="its own name", said="{x:.0f} %"))
    elements += _wrong_names(wrong)
    y = named_rows(map(_words, every), "hidden")
    caption = (
        "Share of the clearly visible draws of each hidden effect whose reported set holds its own name, another name, or"
        f" none. Written: the other name most often reported, from {100 * SAID:g} % on; confusion.csv has all."
    )
    x = Axis("of clearly visible draws (%)", low=-4, high=104)
    return one_panel(elements, x, y, _confusion_finding(own, wrong, list(every)), caption, height=ROW * (len(own) + 1))


def _wrong_names(wrong: Sequence[tuple[int, str, float]]) -> Iterator[Words]:
    """The most frequent wrong name of each row, next to its mark."""
    most: dict[int, tuple[str, float]] = {}
    for at, name, share in wrong:
        if share >= 100 * SAID and share > most.get(at, ("", 0.0))[1]:
            most[at] = (name, share)
    for at, (name, share) in most.items():
        is_left = share > 50
        yield Words(
            x=share, y=at, text=_words(name), colour=PAPER, side="right" if is_left else "left",
            offset=(-6.0 if is_left else 6.0, 0.0),
        )  # fmt: skip


def _confusion_finding(own: Sequence[float], wrong: Sequence[tuple[int, str, float]], hidden: Sequence[str]) -> str:
    said = f"On average over the effects, {np.mean(own):.0f} % of the clearly visible draws report the right name"
    if not wrong:
        return said
    at, name, share = max(wrong, key=lambda each: each[2])
    return f"{said}; another name most often: {_words(name)} for {_words(hidden[at])}, in {share:.0f} %"


def _words(name: str) -> str:
    return str(name).replace("_", " ")

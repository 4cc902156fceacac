"""A table of times as text, and as a page with its figure."""

from __future__ import annotations

import math

import pandas as pd

from bench.plan.page import Block, Page, Picture, Prose, Section, Table
from bench.reports.pages.document import document
from benchmarks.harness.machine import LINE, MACHINE
from benchmarks.harness.row import CPU, WALL
from benchmarks.harness.table import PART
from ksmea.errors import visible_lines

ABOUT = (
    "Times are medians over turns in which all contestants ran, one after the other, each with one thread. A ratio is their time over"
    " that of a row's first line, paired turn by turn, with quartiles: above 1, the first line is faster. Difference: the largest"
    " difference of the values from those of the first line, over their largest."
)
HEAD = ("time", "ratio", "quartiles", "difference", "quality", "demand")
FIGURE = "benchmarks.png"
INDENT = "\u2003"


def text(frame: pd.DataFrame) -> str:
    """The table as a terminal shows it: a block for each row, why a line has no time behind its name."""
    said = []
    for title, block in _blocks(frame):
        said.append(title)
        name_width = block["contestant"].str.len().max()
        cells = [_cells(line) for _, line in block.iterrows()]
        widths = [max(map(len, column)) for column in zip(*(each for each in cells if len(each) > 1))]
        for name, each in zip(block["contestant"], cells):
            padded = [cell.rjust(width) for cell, width in zip(each, widths)] if len(each) > 1 else each
            said.append(f"  {name.ljust(name_width)}  {'  '.join(padded)}".rstrip())
    return visible_lines("\n".join(said))


def page(frame: pd.DataFrame, png: bytes) -> bytes:
    """The page of a table: demands, figure, all rows, and where they were measured.

    Nothing from a network.
    """
    machines = frame[list(MACHINE)].drop_duplicates().to_dict("records")
    sections = [
        Section("How it was measured", (Prose("\n".join([ABOUT, *(LINE.format(**each) for each in machines)])),))
    ]
    if len(demands := _demands(frame)):
        sections.append(Section("Demands", (Table(demands),)))
    alternative = "Time of each contestant over ours, with quartiles, on a logarithmic axis, by group."
    sections.append(Section("Ratios", (Picture(FIGURE, alternative),)))
    for group, rows in frame.groupby("group", sort=False):
        blocks: list[Block] = [Table(_page_table(rows), file="benchmarks.csv")]
        exponents = rows[rows["exponent"].notna()].drop_duplicates(["row", "size_of", "contestant"])
        if len(exponents):
            blocks.append(Table(_growth(exponents), "Growth"))
        sections.append(Section(str(group), tuple(blocks)))
    return document("Side by side", Page(), sections, {"benchmarks": True}, {FIGURE: png})


def _page_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Each row's title on a line, its contestants below it."""
    lines = []
    for title, block in _blocks(rows):
        lines.append([title.partition(": ")[2], *[""] * (len(HEAD) + 1)])
        for _, line in block.iterrows():
            cells = ["skipped", *[""] * (len(HEAD) - 1)] if line["skipped"] else _cells(line)
            about = "; ".join(filter(None, [line["skipped"] or line["version"], line["note"]]))
            lines.append([INDENT + line["contestant"], *cells, about])
    return pd.DataFrame(lines, columns=["", *HEAD, "about"])


def _growth(exponents: pd.DataFrame) -> pd.DataFrame:
    grows = exponents["size_of"] + " to the " + exponents["exponent"].map("{:.2f}".format)
    return pd.DataFrame({"": exponents["row"], "contestant": exponents["contestant"], "grows as": grows})


def _demands(frame: pd.DataFrame) -> pd.DataFrame:
    asked = frame[frame["at_least"].notna() | frame["no_more_than"].notna()]
    return pd.DataFrame(
        [[f"{title_of(line)} – {line['contestant']}", *_demanded(line)] for _, line in asked.iterrows()],
        columns=["", "asked", "found", "reached"],
    )


def _demanded(line: pd.Series) -> tuple[str, str, str]:
    reached = "skipped" if line["skipped"] else line["reached"] or "not measured"
    if math.isfinite(line["at_least"]):
        return f"{line['at_least']:g} times", f"{number(line['ratio'])} times", reached
    return f"{line['no_more_than']:g} s", seconds(line["seconds"]), reached


def _cells(line: pd.Series) -> list[str]:
    """As many as `HEAD` has, or the one reason why there is no time."""
    if line["skipped"]:
        return [f"skipped: {line['skipped']}"]
    demand = ""
    if math.isfinite(line["at_least"]) or math.isfinite(line["no_more_than"]):
        asked, _, reached = _demanded(line)
        demand = f"{'≥' if asked.endswith('times') else '≤'} {asked}: {reached}"
    return [
        seconds(line["seconds"]),
        *_ratio(line),
        f"{line['difference']:.1e}" if math.isfinite(line["difference"]) else "",
        _quality(line),
        demand,
    ]


def _quality(line: pd.Series) -> str:
    if not math.isfinite(line["quality"]):
        return ""
    failed = f", failed {line['failed']:.0f} of {line['turns']}" if line["failed"] > 0 else ""
    return f"{line['quality_of']} {line['quality']:.3g}{failed}"


def _ratio(line: pd.Series) -> tuple[str, str]:
    """With its quartiles; of a part, in per cent of the whole."""
    if not math.isfinite(line["ratio"]):
        return "", ""
    if line["note"] == PART:
        return f"{100 * line['ratio']:.0f} %", f"{100 * line['ratio_q1']:.0f} – {100 * line['ratio_q3']:.0f} %"
    return f"{number(line['ratio'])} ×", f"{number(line['ratio_q1'])} – {number(line['ratio_q3'])}"


def title_of(line: pd.Series) -> str:
    """A row's name with its size, as `benchmarks.harness.row.Row.title`."""
    size = f", {line['size']:g} {line['size_of']}".rstrip() if math.isfinite(line["size"]) else ""
    return f"{line['group']}: {line['row']}{size}"


def _blocks(frame: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """The lines of each row under its title, with the clock and the unit that times are of."""
    clock = frame["clock"].map({CPU: "CPU time", WALL: "wall time"})
    titles = frame.apply(title_of, axis=1) + "; " + clock + " per " + frame["unit"]
    return list(frame.groupby(titles, sort=False))


def seconds(value: float) -> str:
    """With a unit that suits.

    >>> [seconds(value) for value in (12.3, 0.0123, 4.56e-6, 7e-9)]
    ['12.3 s', '12.3 ms', '4.56 µs', '7 ns']
    """
    if not math.isfinite(value):
        return "–"
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if value * factor >= 1:
            return f"{value * factor:.3g} {unit}" if value * factor < 1000 else f"{value * factor:.0f} {unit}"
    return f"{value * 1e9:.3g} ns"


def number(value: float) -> str:
    """Three digits, with a space in thousands.

    >>> [number(value) for value in (0.987, 31.42, 13929.9)]
    ['0.987', '31.4', '13 900']
    """
    if not math.isfinite(value):
        return "–"
    if abs(value) < 1000:
        return f"{value:.3g}"
    rounded = round(value, 2 - math.floor(math.log10(abs(value))))
    return f"{rounded:,.0f}".replace(",", " ")

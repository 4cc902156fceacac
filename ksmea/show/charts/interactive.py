"""A chart as a plot of a page, in the form that plotly.js draws.

Traces, and a layout for wide and one for narrow pages.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from textwrap import wrap

import numpy as np

from ksmea.show.charts import chart as of
from ksmea.show.charts.chart import Axis, Chart, Panel, ends_of
from ksmea.show.charts.colours import LIGHT
from ksmea.show.charts.ticks import symlog_ticks
from ksmea.show.charts.traces import CLEAR, Layout, PanelTraces, Trace, place_on

SPACE = 2.0  # times as high as others is a panel in space
INCH = 92  # px of a panel's height
TOP, BOTTOM, LEFT, RIGHT = 40, 54, 66, 14  # px around all panels
STACKED, APART, BESIDE = 16, 74, 0.07  # px between panels of a stack and between stacks; part of the width
PLAIN_FROM, PLAIN_TO = 1e-4, 1e6  # between which numbers of a logarithmic axis have no powers of ten
BARE = 0.03  # part of the width between panels that have no words of their own between them
CHARACTER = 0.006  # part of the width, of a word beside an axis
HEADING = 22  # px, for the title of a panel
PLAIN_EXPONENT = 6  # numbers up to 10 to this power are written out on axes
STANDOFF = 6  # px between the numbers of an axis and its title
LEAST_LOG, MANY_LOG, MOST_LOG = (
    4.0,
    100.0,
    1e6,
)  # end over beginning of a logarithmic axis: from which on its ticks are 1, 2, 5 or powers
LOG_TICKS = 5  # of a logarithmic axis at most: over 1.5 decades and more they stand at 1, 2 and 5 or at powers
ROOM = 0.05  # of what an axis shows, at its ends
FEW = 6  # stacks that a page shows side by side; of more, one at a time, by choice
EYE = {"x": 1.5, "y": -2.3, "z": 1.0}  # from where a panel in space is seen
NARROW_NAME = 22  # characters in a line of a row's name on a narrow page
NAME_LINE = 17  # px of such a line
LEGEND_LINE, SAMPLE, LETTER = 19, 45, 6.5  # px of a line of a legend, of an entry's sample, and of a letter
NARROW_EYE = 1.8  # times as far on a narrow page
MANY_COLUMNS = 4  # of panels, in which a logarithmic axis has no room for 2 and 5
NARROW_WIDTH = 290  # px of a panel there, between its axis and the edge
PALE = "rgba(122,122,122,0.45)"


def plot(chart: Chart) -> Layout:
    """Data and layout of a chart for plotly.

    `layout["narrow"]` goes over it where a page is narrow, with a height of its own.
    """
    is_chosen = _is_chosen(chart)
    stacks = chart.stacks
    traces: list[Trace] = []
    named: set[str] = set()
    shapes: list[Layout] = []
    notes: list[Layout] = []
    numbers = _numbers(stacks, is_chosen)
    for stack, of_stack in zip(stacks, numbers):
        tags = {chart.of_stacks: stack[0].title} if is_chosen and stack else {}
        if is_chosen:
            named = set()
        for panel, number in zip(stack, of_stack):
            drawn = PanelTraces(panel, number)
            for element in panel.elements:
                for trace in drawn.traces(element):
                    name = trace.get("name", "")
                    trace["showlegend"] = bool(name) and name not in named and trace.get("showlegend", True)
                    named |= {name} if trace["showlegend"] else set()
                    trace["meta"] = {**element.tags, **tags}
                    traces.append(trace)
                shapes += [{**shape, "meta": tags} for shape in drawn.shapes(element)]
                notes += [{**note, "meta": tags} for note in drawn.notes(element)]
            if panel.title and not is_chosen:
                notes.append(drawn.heading())
    wide = _layout(chart, 1 if is_chosen else chart.across, numbers)
    narrow = _with_broken_names(_layout(chart, 1, numbers, NARROW_EYE))
    narrow["height"] += LEGEND_LINE * (
        _legend_lines(dict.fromkeys(trace["name"] for trace in traces if trace["showlegend"])) - 1
    )
    base = {
        "paper_bgcolor": CLEAR,
        "plot_bgcolor": CLEAR,
        "font": {"size": 12, "family": "system-ui, sans-serif"},
        "separators": ".",  # thousands have none, as in texts and tables
        "hoverlabel": {"bgcolor": "#1f252b", "bordercolor": "#1f252b", "font": {"color": "white"}, "namelength": -1},
        "bargap": 0.2,
        "barmode": "overlay",
        "boxmode": "overlay",
        "shapes": shapes,
        "annotations": notes,
        "showlegend": any(trace["showlegend"] for trace in traces),
    }
    return {"data": traces, "layout": {**base, **wide, "narrow": narrow}}


def _legend_lines(names: Iterable[str]) -> int:
    """Lines of a legend on a narrow page, at least one: plotly takes their height from the panels."""
    lines, used = 1, 0.0
    for name in names:
        wide = SAMPLE + LETTER * len(name)
        lines, used = (lines + 1, wide) if used and used + wide > NARROW_WIDTH else (lines, used + wide)
    return lines


def _with_broken_names(narrow: Layout) -> Layout:
    """A layout whose names at the left of rows leave room for what is drawn."""
    for key, side in narrow.items():
        if key.startswith("yaxis") and "ticktext" in side:
            side["ticktext"] = ["<br>".join(_lines(name.replace("<br>", "\n"))) for name in side["ticktext"]]
    return narrow


def _lines(name: str) -> list[str]:
    """A row's name as it breaks on a narrow page."""
    return [line for part in name.split("\n") for line in wrap(part, NARROW_NAME, break_long_words=False)]


def choices(chart: Chart) -> tuple[of.Choice, ...]:
    """Choices of a page for a chart, including which of many stacks."""
    if not _is_chosen(chart):
        return chart.choices
    titles = tuple(stack[0].title for stack in chart.stacks if stack)
    return (of.Choice(chart.of_stacks, chart.of_stacks, titles, with_all=False), *chart.choices)


def height(chart: Chart) -> int:
    """px on a wide page."""
    is_chosen = _is_chosen(chart)
    return int(_layout(chart, 1 if is_chosen else chart.across, _numbers(chart.stacks, is_chosen))["height"])


def _is_chosen(chart: Chart) -> bool:
    """Whether one stack is seen at a time; they must have the same axes.

    Spatial charts take much of a browser.
    """
    axes = {tuple((panel.x.label, panel.y.label) for panel in stack) for stack in chart.stacks}
    few = 1 if any(panel.z is not None for panel in chart.panels) else FEW
    return bool(chart.of_stacks) and len(chart.stacks) > few and len(axes) == 1


def _numbers(stacks: Sequence[Sequence[Panel]], is_chosen: bool) -> list[list[int]]:
    """The number of each panel's axes, from 1; stacks of which one is seen at a time have the same."""
    found, first = [], 1
    for stack in stacks:
        found.append([first + index for index in range(len(stack))])
        first += 0 if is_chosen else len(stack)
    return found


def _layout(chart: Chart, across: int, numbers: list[list[int]], far: float = 1.0) -> Layout:
    """Axes with the parts of the whole that their panels take, and its height, px."""
    shown = {number: panel for stack, of_stack in zip(chart.stacks, numbers) for panel, number in zip(stack, of_stack)}
    rows = _rows(numbers, across)
    column = {number: at for row in rows for at, of_stack in enumerate(row) for number in of_stack}
    beside = {
        number: [shown[each] for of_stack in row[at - 1 : at] for each in of_stack]
        for row in rows
        for at, of_stack in enumerate(row)
        for number in of_stack
    }
    tops, down = _tops(shown, rows, NARROW_WIDTH if far > 1 else math.inf)
    inner = max(down - APART, 1.0)
    n_column = max((len(row) for row in rows), default=1)
    words = [
        max(map(len, panel.y.ticks.values()), default=0)
        for number, panel in shown.items()
        if panel.y.ticks and column[number] and not _is_named_beside(panel, beside[number])
    ]
    is_bare = n_column > 1 and all(
        column[number] == 0 or _is_named_beside(shown[number], beside[number]) for number in shown
    )
    gap = (BARE if is_bare else BESIDE) + CHARACTER * max(words, default=0) if n_column > 1 else 0.0
    part = (1 - gap * (n_column - 1)) / n_column
    groups: dict[tuple[str, str], str] = {}
    made: Layout = {"height": int(inner + TOP + BOTTOM), "margin": {"l": LEFT, "r": RIGHT, "t": TOP, "b": BOTTOM}}
    for number, panel in shown.items():
        top, bottom = tops[number]
        left = column[number] * (part + gap)
        domains = {"x": [left, min(left + part, 1.0)], "y": [max(1 - bottom / inner, 0.0), 1 - top / inner]}
        end = "" if number == 1 else str(number)
        if panel.z is not None:
            made[f"scene{end}"] = _scene(panel, far) | {"domain": domains}
            continue
        for side, scale in (("x", panel.x), ("y", panel.y)):
            together = (
                [each for each in chart.panels if _side(each, side).group == scale.group] if scale.group else [panel]
            )
            own = _axis(scale, together, side) | {
                "domain": domains[side],
                "anchor": f"{'y' if side == 'x' else 'x'}{end}",
            }
            first = groups.setdefault((side, scale.group), f"{side}{end}") if scale.group else ""
            own |= {"matches": first} if first not in ("", f"{side}{end}") else {}
            if side == "x" and n_column >= MANY_COLUMNS and own.get("dtick") == "D2":
                own["dtick"] = 1
            if side == "y" and _is_named_beside(panel, beside[number]):
                own |= {"title": {"text": ""}} | ({} if scale.ticks is None else {"showticklabels": False})
            if any(isinstance(each, of.Heat) for each in panel.elements):
                own |= {"showgrid": False}
            if side == "x" and _is_named_below(shown, next(each for each in numbers if number in each), number):
                own |= {"showticklabels": False, "ticks": "", "title": {"text": ""}}
            made[f"{side}axis{end}"] = own
        if panel.is_to_scale:
            made[f"yaxis{end}"] |= {"scaleanchor": f"x{end}", "constrain": "domain"}
            made[f"xaxis{end}"] |= {"constrain": "domain"}
    made["legend"] = {
        "orientation": "h",
        "y": 1 + (HEADING + 6) / inner,
        "yanchor": "bottom",
        "x": 0,
        "xanchor": "left",
    }
    return made


def _rows(numbers: list[list[int]], across: int) -> list[list[list[int]]]:
    """Stacks in rows of so many, each once."""
    stacks = [each for index, each in enumerate(numbers) if each not in numbers[:index]]
    step = max(across, 1)
    return [stacks[first : first + step] for first in range(0, len(stacks), step)]


def _tops(
    shown: dict[int, Panel], rows: list[list[list[int]]], width: float
) -> tuple[dict[int, tuple[float, float]], float]:
    """Upper and lower end of each panel, px below the top of all, and where the next row would begin.

    The height of a panel to scale is limited by its ends at `width` px, which is finite on a narrow page.
    """
    tops: dict[int, tuple[float, float]] = {}
    down = 0.0
    for row in rows:
        ends = []
        for of_stack in row:
            at = down
            for number in of_stack:
                panel = shown[number]
                at += HEADING if panel.title else 0
                tall = min(INCH * panel.height * (1.0 if panel.z is None else SPACE), width * _steepness(panel))
                tall = max(tall, _room_of_names(panel.y) if width < math.inf else 0.0)
                tops[number] = (at, at + tall)
                below = STACKED if _is_named_below(shown, of_stack, number) else APART
                at += tall + below
            ends.append(at)
        down = max(ends, default=down)
    return tops, down


def _room_of_names(rows: Axis) -> float:
    """px that named rows take on a narrow page, so that broken names do not overlap.

    0 of an axis of numbers.
    """
    if not rows.ticks or rows.low is None or rows.high is None:
        return 0.0
    n_line = [len(_lines(name)) for name in rows.ticks.values()]
    apart = max((one + other for one, other in pairwise(n_line)), default=0) / 2
    return NAME_LINE * apart * (rows.high - rows.low) if max(n_line) > 1 else 0.0


def _steepness(panel: Panel) -> float:
    """Height over width of a panel to scale whose ends are given; of all others infinite."""
    ends = (panel.x.low, panel.x.high, panel.y.low, panel.y.high)
    if not panel.is_to_scale or any(end is None for end in ends):
        return math.inf
    left, right, low, high = (float(end) for end in ends if end is not None)
    return (high - low) / (right - left)


def _is_named_below(shown: dict[int, Panel], of_stack: list[int], number: int) -> bool:
    """Whether the next panel of the stack has the words of this one's x axis."""
    if number + 1 not in of_stack:
        return False
    one, other = shown[number].x, shown[number + 1].x
    return one.label == other.label and one.group == other.group != ""


def _is_named_beside(panel: Panel, beside: Sequence[Panel]) -> bool:
    """Whether a panel of the stack on the left has the words of this one's y axis."""
    own = panel.y
    return own.group != "" and any(own.label == each.y.label and own.group == each.y.group for each in beside)


def _side(panel: Panel, side: str) -> Axis:
    return panel.x if side == "x" else panel.y


def _axis(scale: Axis, panels: Sequence[Panel], side: str) -> Layout:
    """One axis of the panels that share it."""
    made: Layout = {
        "title": {"text": scale.label.replace("\n", "<br>"), "standoff": STANDOFF}, "automargin": True, "zeroline": False, "ticks": "outside",
    }  # fmt: skip
    place = place_on(scale)
    if scale.scale == "log":
        low, high = (
            (scale.low, scale.high) if scale.low and scale.high else ends_of(panels, "x" if side == "x" else "y")
        )
        plain = PLAIN_FROM <= low and high <= PLAIN_TO
        of_numbers = {"tickformat": "~g"} if plain else {"exponentformat": "power"}
        made |= {"type": "log", **of_numbers, **_log_ticks(high / low)}
    elif scale.scale == "linear":
        made |= {"type": "linear", "minexponent": PLAIN_EXPONENT}
    else:
        low, high = ends_of(panels, "x" if side == "x" else "y")
        at = symlog_ticks(
            low if scale.low is None else scale.low, high if scale.high is None else scale.high, scale.linear
        )
        made |= {"tickvals": place(at), "ticktext": [f"{each:.12g}".replace("-", "−") for each in at], "tickangle": 0}
    if scale.is_whole and np.ptp(ends_of(panels, "x" if side == "x" else "y")) <= 6:
        made["dtick"] = 1
    if scale.ticks is not None:
        words = [each.replace("\n", "<br>") for each in scale.ticks.values()]
        made |= {"tickmode": "array", "tickvals": place(list(scale.ticks)), "ticktext": words}
        if not scale.ticks:
            made |= {"showticklabels": False, "ticks": "", "showgrid": False}
    if scale.low is not None or scale.high is not None or scale.group:
        ends = _with_room(scale, panels, side)
        made["range"] = ends[::-1] if scale.is_reversed else ends
    elif scale.is_reversed:
        made["autorange"] = "reversed"
    return made


def _log_ticks(ratio: float) -> Layout:
    """Ticks of a logarithmic axis by its end over its beginning.

    They are at 1, 2 and 5, at each power of ten, or at a few of them."""
    if LEAST_LOG < ratio < MANY_LOG:
        return {"dtick": "D2"}
    return {"dtick": 1} if MANY_LOG <= ratio < MOST_LOG else {"nticks": LOG_TICKS}


def _with_room(scale: Axis, panels: Sequence[Panel], side: str) -> list[float]:
    """Ends of an axis as plotly counts them: the given ones, else of all that is drawn, with room."""
    place = np.log10 if scale.scale == "log" else place_on(scale)
    low, high = place(ends_of(panels, "x" if side == "x" else "y"))
    room = ROOM * (high - low) or 0.5
    given = [None if end is None else float(place([end])[0]) for end in (scale.low, scale.high)]
    return [float(low - room) if given[0] is None else given[0], float(high + room) if given[1] is None else given[1]]


def _scene(panel: Panel, far: float) -> Layout:
    style = {
        "color": LIGHT["reference"],
        "gridcolor": PALE,
        "zerolinecolor": PALE,
    }  # styles of the page do not reach into it
    assert panel.z is not None
    ends = ((name, each) for name, each in (("xaxis", panel.x), ("yaxis", panel.y), ("zaxis", panel.z)))
    sides = {
        name: {"title": {"text": each.label}, **style} | ({} if each.low is None else {"range": [each.low, each.high]})
        for name, each in ends
    }
    return {
        **sides,
        "aspectmode": "manual",
        "aspectratio": {"x": 2.2, "y": 1, "z": 1},
        "camera": {"eye": {side: far * at for side, at in EYE.items()}},
    }

"""A chart as a picture, PNG or SVG, drawn by matplotlib without a display."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from ksmea.show.charts import chart as of
from ksmea.show.charts.chart import Axis, Chart, Element, Panel
from ksmea.show.charts.colours import GROUND, INK, LIGHT
from ksmea.show.charts.locators import plain_ticks

DPI, N_COLOUR = 130, 256
LINES: dict[str, Any] = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-."}
MARKERS = {
    "": "", "circle": "o", "square": "s", "diamond": "D", "triangle down": "v", "triangle up": "^", "triangle left": "<", "triangle right": ">",
    "cross": "P", "star": "*", "x": "x", "plus": "+", "bar": "_", "post": "|", "point": ".", "arrow up": "$\\uparrow$",
    "arrow right": "$\\rightarrow$",
}  # fmt: skip
FAINT = 0.15  # opacity of bands
TITLE, TEXT, SMALL, TINY = 11, 9, 8, 6  # points
MOST_LINES_OF_STEPS = 400  # points of a line of which each has a symbol; a longer one has few
HEADER = 0.75  # inches, for title and legend
ALL_ROUND = 0.45  # inches of a panel's row, for words of its axes
ROOM_OF_TICK = 0.6  # inches, of a number below an axis
A_LINE = 11.5  # characters of a title, to an inch
CHARACTER = 0.075  # inches, of a legend


class ShownFigure(Figure):
    """A figure that a notebook shows by itself, whatever its drawing backend."""

    def _repr_png_(self) -> bytes:
        return _png(self)


def png(chart: Chart) -> bytes:
    """A chart as the content of a PNG file, which also says in words what is seen."""
    return _png(figure(chart), {"Title": chart.title, "Description": chart.caption})


def figure(chart: Chart) -> ShownFigure:
    """A chart as a figure of its own."""
    stacks = chart.stacks[: chart.most]
    across = max(min(chart.across, len(stacks)), 1)
    grid: list[list[Panel | None]] = []  # rows, of which those of stacks side by side follow each other
    has_below: list[bool] = []
    for first in range(0, len(stacks), across):
        beside = stacks[first : first + across]
        depth = max(map(len, beside))
        for row in range(depth):
            grid.append(
                [stack[row] if row < len(stack) else None for stack in beside] + [None] * (across - len(beside))
            )
            has_below.append(row + 1 < depth)
    n_row = len(grid)
    heights = [max((each.height for each in panels if each is not None), default=1.0) for panels in grid]
    made = ShownFigure(figsize=(chart.width, sum(heights) + HEADER + ALL_ROUND), layout="constrained")
    cells = made.add_gridspec(n_row, across, height_ratios=heights) if n_row else None
    drawn: dict[tuple[int, int], Axes] = {}
    groups: dict[tuple[str, str], Axes] = {}
    for row, panels in enumerate(grid):
        for column, panel in enumerate(panels):
            if panel is None or cells is None:
                continue
            shared: dict[str, Any] = {f"share{side}": groups.get((side, scale.group)) for side, scale in _sides(panel)}
            axes = made.add_subplot(cells[row, column], projection=None if panel.z is None else "3d", **shared)
            groups |= {(side, scale.group): axes for side, scale in _sides(panel) if scale.group}
            _draw(axes, panel)
            drawn[row, column] = axes
    for (row, column), axes in drawn.items():
        panel = grid[row][column]
        assert panel is not None
        left = grid[row][column - 1] if column else None
        below = grid[row + 1][column] if has_below[row] else None
        _finish(
            axes,
            panel,
            left is not None and _is_same(panel.y, left.y),
            below is not None and _is_same(panel.x, below.x),
        )
        if panel.x.scale == "linear" and panel.x.ticks is None:
            axes.xaxis.set_major_locator(
                MaxNLocator(min(int(chart.width / across / ROOM_OF_TICK), 9), integer=panel.x.is_whole)
            )
    _legend(made, list(drawn.values()), chart.width)
    left_out = len(chart.stacks) - len(stacks)
    title = chart.title + (f" ({left_out} more are not shown)" if left_out else "")
    if title:
        made.suptitle("\n".join(wrap(title, int(chart.width * A_LINE))), fontsize=TITLE)
    return made


def on_axes(chart: Chart, axes: Axes) -> Figure:
    """The main panel of a chart on axes of others, with a legend of its own."""
    panel = chart.panels[chart.main]
    _draw(axes, panel)
    _finish(axes, panel if panel.title else replace(panel, title=chart.panels[0].title))
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(handles, labels, fontsize=SMALL, frameon=False)
    return figure_of(axes)


def drawn(chart: Chart, axes: Axes | None = None) -> Figure:
    """A chart as a figure of its own, or its main panel on given axes."""
    return figure(chart) if axes is None else on_axes(chart, axes)


def figure_of(axes: Axes) -> Figure:
    """The figure that axes belong to."""
    found = axes.get_figure(root=True)
    if found is None:
        raise ValueError("axes: expected axes of a figure, got some that were removed from theirs; make new ones")
    return found


def _png(made: Figure, about: dict[str, str] | None = None) -> bytes:
    """The figure in 256 colours, which takes about a third of the memory and looks alike: it has few hues."""
    pixels, content = io.BytesIO(), io.BytesIO()
    made.savefig(pixels, format="png", dpi=DPI, pil_kwargs={"compress_level": 0})
    words = PngInfo()
    for name, text in (about or {}).items():
        words.add_itxt(name, text)
    flat = Image.open(pixels).convert("RGB").quantize(N_COLOUR, dither=Image.Dither.NONE)
    flat.save(content, format="png", pnginfo=words, dpi=(DPI, DPI))
    return content.getvalue()


def _is_same(one: Axis, other: Axis) -> bool:
    """Whether the words of an axis stand at another panel already."""
    return one.label == other.label and one.group == other.group != ""


def _sides(panel: Panel) -> tuple[tuple[str, Axis], ...]:
    return ("x", panel.x), ("y", panel.y)


def _draw(axes: Axes, panel: Panel) -> None:
    for side, scale in _sides(panel):
        more: dict[str, Any] = {"linthresh": scale.linear} if scale.scale == "symlog" else {}
        getattr(axes, f"set_{side}scale")(scale.scale, **more)
    named: set[str] = set()
    for element in panel.elements:
        label = element.name if element.name not in named else ""
        named.add(element.name)
        _element(axes, element, label or "_nolegend_")


def _finish(axes: Axes, panel: Panel, is_named_beside: bool = False, is_named_below: bool = False) -> None:
    """Ends, ticks and words of a panel's axes, once all that share them are drawn."""
    if panel.is_to_scale:
        axes.set_aspect("equal", adjustable="datalim" if panel.x.high is None else "box")
    for side, scale in _sides(panel):
        _scale(axes, side, scale)
    axes.set_title(panel.title, fontsize=TEXT)
    axes.set_xlabel("" if is_named_below else panel.x.label, fontsize=TEXT)
    axes.set_ylabel("" if is_named_beside else panel.y.label, fontsize=TEXT)
    axes.tick_params(axis="both", labelsize=SMALL)
    axes.set_axisbelow(True)
    if is_named_below:
        axes.tick_params(axis="x", labelbottom=False)
    if is_named_beside and panel.y.ticks is not None:
        axes.tick_params(axis="y", labelleft=False)
    if panel.x.ticks is None or panel.y.ticks is None:
        axes.grid(
            alpha=0.25,
            axis="both" if panel.x.ticks is panel.y.ticks is None else "y" if panel.x.ticks is not None else "x",
        )
    if panel.z is not None:
        _in_space(axes, panel)


def _scale(axes: Axes, side: str, scale: Axis) -> None:
    own = getattr(axes, f"{side}axis")
    if scale.ticks is not None:
        own.set_major_locator(FixedLocator(list(scale.ticks)))
        own.set_ticks(list(scale.ticks), list(scale.ticks.values()))
        own.set_minor_locator(NullLocator())
    elif scale.is_whole:
        own.set_major_locator(MaxNLocator(integer=True))
    elif scale.scale != "linear":
        plain_ticks(own)
    if scale.low is not None or scale.high is not None:
        getattr(axes, f"set_{side}lim")(scale.low, scale.high)
    if scale.is_reversed:
        own.set_inverted(True)


def _in_space(axes: Any, panel: Panel) -> None:
    assert panel.z is not None
    axes.set(yticks=[], zticks=[])
    if panel.z.low is not None:
        axes.set_zlim(panel.z.low, panel.z.high)
    axes.set_xlabel(panel.x.label, fontsize=SMALL, labelpad=-6)
    axes.set_ylabel(panel.y.label, fontsize=SMALL, labelpad=-14)
    axes.set_zlabel(panel.z.label, fontsize=SMALL, labelpad=-14)
    axes.tick_params(axis="x", labelsize=7, pad=-3)
    axes.set_box_aspect((2.2, 1, 1), zoom=1.0)
    axes.view_init(elev=18, azim=-62)


def _legend(made: Figure, panels: Sequence[Axes], width: float) -> None:
    entries: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    if entries:
        fit = int(width / (0.5 + CHARACTER * max(map(len, entries))))
        style: dict[str, Any] = {"ncols": max(min(fit, len(entries)), 1), "fontsize": TEXT, "frameon": False}
        made.legend(list(entries.values()), list(entries), loc="outside lower center", **style)


def _element(axes: Axes, element: Element, label: str) -> None:
    colour = LIGHT[element.colour]
    common: dict[str, Any] = {"color": colour, "alpha": element.opacity}
    labelled = common | {"label": label}
    match element:
        case of.Line():
            _line(axes, element, labelled)
        case of.Points():
            _points(axes, element, labelled)
        case of.Band():
            faint: dict[str, Any] = {"color": colour, "alpha": FAINT * element.opacity, "linewidth": 0, "label": label}
            axes.fill_between(
                element.x, element.low, element.high, step="post" if element.is_stepped else None, **faint
            )
        case of.Boxes():
            _boxes(axes, element, common, label)
        case of.Bars():
            _bars(axes, element, labelled)
        case of.Level():
            _level(axes, element, labelled)
        case of.Span():
            (axes.axhspan if element.along == "y" else axes.axvspan)(element.low, element.high, linewidth=0, **labelled)
        case of.Words():
            _words(axes, element, colour)
        case of.Area():
            axes.fill(
                element.x,
                element.y,
                facecolor=colour,
                edgecolor=LIGHT[element.edge],
                linewidth=0.8,
                alpha=element.opacity,
                label=label,
            )
        case of.Heat():
            _heat(axes, element)
        case of.Space():
            axes.plot(element.x, element.y, element.z, linewidth=element.width, **labelled)
        case _:
            raise TypeError(f"picture: expected an element of a chart, got {type(element).__name__}")


def _line(axes: Axes, element: of.Line, labelled: dict[str, Any]) -> None:
    style: dict[str, Any] = {"linestyle": LINES[element.dash], "linewidth": element.width}
    style |= {"drawstyle": "steps-post"} if element.is_stepped else {}
    every = _every(len(element.x), element.most_symbols)
    axes.plot(element.x, element.y, marker=MARKERS[element.symbol], markersize=4, markevery=every, **style, **labelled)


def _level(axes: Axes, element: of.Level, labelled: dict[str, Any]) -> None:
    is_flat = element.along == "y"
    across = axes.get_yaxis_transform() if is_flat else axes.get_xaxis_transform()
    at, whole = [element.at, element.at], [0.0, 1.0]
    style: dict[str, Any] = {"linestyle": LINES[element.dash], "linewidth": element.width, "transform": across}
    # as axhline does, which fixes the ends anew for each line, with a warning while they are equal
    axes.plot(*((whole, at) if is_flat else (at, whole)), scalex=not is_flat, scaley=is_flat, **style, **labelled)
    if element.label:
        place = (0.01, element.at) if is_flat else (element.at, 0.97)
        style = {"va": "bottom"} if is_flat else {"va": "top", "rotation": 90, "ha": "right"}
        style |= {"bbox": {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.5}, "color": labelled["color"]}
        axes.text(*place, element.label, transform=across, fontsize=SMALL, **style)


def _every(n_point: int, most: int) -> int:
    if most:
        return max(-(-n_point // most), 1)
    return 1 if n_point <= MOST_LINES_OF_STEPS else n_point // 5


def _points(axes: Axes, element: of.Points, labelled: dict[str, Any]) -> None:
    x, y = (np.asarray(each, dtype=float) for each in (element.x, element.y))
    ends: dict[str, Any] = {}
    if element.low is not None and element.high is not None:
        ends["yerr"] = np.clip([y - np.asarray(element.low), np.asarray(element.high) - y], 0, None)
    if element.left is not None and element.right is not None:
        ends["xerr"] = np.clip([x - np.asarray(element.left), np.asarray(element.right) - x], 0, None)
    face = "none" if element.is_open else labelled["color"]
    symbol: dict[str, Any] = {"marker": MARKERS[element.symbol], "markersize": element.size, "markerfacecolor": face}
    if element.symbol in ("bar", "post", "x"):
        symbol["markeredgewidth"] = 1.6
    if ends:
        axes.errorbar(x, y, linestyle="", elinewidth=1.0, **ends, **symbol, **labelled)
    else:
        axes.plot(x, y, linestyle="", **symbol, **labelled)


def _boxes(axes: Axes, element: of.Boxes, common: dict[str, Any], label: str) -> None:
    values = [np.asarray(each, dtype=float)[np.isfinite(np.asarray(each, dtype=float))] for each in element.values]
    style: dict[str, Any] = {part: common for part in ("boxprops", "whiskerprops", "capprops")}
    axes.boxplot(
        values, positions=list(element.at), widths=element.width, whis=element.whiskers, showfliers=False, manage_ticks=False,
        orientation="vertical" if element.along == "y" else "horizontal", medianprops=common | {"linewidth": 2}, **style,
    )  # fmt: skip
    if label != "_nolegend_":
        axes.plot([], [], linewidth=2, label=label, **common)


def _bars(axes: Axes, element: of.Bars, labelled: dict[str, Any]) -> None:
    at, size = (np.asarray(each, dtype=float) for each in (element.at, element.size))
    base = np.zeros_like(size) if element.base is None else np.asarray(element.base, dtype=float)
    ends = None
    if element.low is not None and element.high is not None:
        ends = np.clip(
            np.nan_to_num([base + size - np.asarray(element.low), np.asarray(element.high) - base - size]), 0, None
        )
    if element.along == "y":
        axes.bar(at, size, element.width, bottom=base, yerr=ends, **labelled)
    else:
        axes.barh(at, size, element.width, left=base, xerr=ends, **labelled)


def _words(axes: Axes, element: of.Words, colour: str) -> None:
    style: dict[str, Any] = {}
    if element.has_leader:
        style["arrowprops"] = {"arrowstyle": "-", "linewidth": 0.6}
    if element.has_ground:
        style["bbox"] = {"boxstyle": "round,pad=0.15", "facecolor": LIGHT[GROUND], "alpha": 0.85, "linewidth": 0}
    place: dict[str, Any] = {"ha": element.side, "va": "center" if element.edge == "middle" else element.edge}
    axes.annotate(
        element.text, (element.x, element.y), element.offset, textcoords="offset points", fontsize=element.size, color=colour, **place, **style
    )  # fmt: skip


def _heat(axes: Axes, element: of.Heat) -> None:
    axes.imshow(element.shares, cmap="Blues", vmin=0, vmax=1, aspect="auto", alpha=element.opacity)
    for (row, column), share in np.ndenumerate(element.shares):
        if said := element.written[row][column]:
            colour = LIGHT[GROUND if share > 0.5 else INK]
            axes.text(
                column, row, said, ha="center", va="center", fontsize=TINY if not element.words else SMALL, color=colour
            )

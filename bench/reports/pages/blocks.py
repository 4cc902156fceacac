"""Blocks of a page as HTML."""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.plan.page import (
    Block,
    Command,
    Control,
    Drawn,
    Folded,
    Grid,
    Numbers,
    Orbits,
    Picture,
    Plot,
    Prose,
    Steps,
    Table,
)
from bench.reports.pages import bundle
from bench.reports.pages.prose import prose_html, safe, table_html, unbroken
from ksmea.errors import shortened, visible
from ksmea.show.charts import interactive
from ksmea.show.charts.colours import LIGHT, MEASURED, MODEL
from ksmea.show.text import number

LONGEST_CELL = 300  # characters
MOST_ROWS = 300  # of a table on a page; its file has all
MOST_STILLS = 60_000  # bytes of pictures in place of plots on a page; further ones are files next to it
LEAST_SHARED = 50  # numbers of a list that traces share
MOST_PLAIN = 20_000  # characters of data of a plot that stand in a page as they are
DIGITS = 6  # of numbers in plots: more than a screen shows
TABLE_DIGITS = 5
NONE = "–"  # in place of a value that is not there


class Blocks:
    """Writes blocks one after the other, each plot under a name of its own.

    `drawings` are the report's figures by name. A plot whose title is the page's headline has none of its own.
    """

    def __init__(
        self,
        drawings: Mapping[str, bytes],
        headline: str = "",
        numbers: Iterator[int] | None = None,
        *,
        is_folded: bool = False,
    ) -> None:
        self._drawings = drawings
        self._headline = headline
        self._number = count(1) if numbers is None else numbers
        self._is_folded = is_folded  # plots then have no picture in their place: it would weigh as much as all else
        self._left = MOST_STILLS
        self.has_plots = False

    def html(self, block: Block) -> str:
        match block:
            case Prose():
                return prose_html(block.text)
            case Command():
                return _command(block)
            case Numbers():
                return _numbers(block)
            case Steps():
                return f"<ol>{''.join(f'<li>{self.html(step)}</li>' for step in block.steps)}</ol>"
            case Table():
                return _table(block)
            case Plot():
                return self._plot(block)
            case Drawn():
                try:
                    chart = block.described()
                except Exception:  # told where its picture is written
                    return f"<p>{safe(block.file or 'A plot')} cannot be drawn.</p>"
                controls = interactive.choices(chart)
                about = (chart.title, chart.caption, interactive.plot(chart), block.file)
                return self._plot(Plot(*about, controls, interactive.height(chart)))
            case Orbits():
                return self._orbits(block)
            case Picture():
                return self._picture(block)
            case Grid():
                kind = "grid wide" if block.is_wide else "grid"
                return f'<div class="{kind}">{"".join(map(self.html, block.plots))}</div>'
            case Folded():
                within = Blocks(self._drawings, self._headline, self._number, is_folded=True)
                inside = "".join(map(within.html, block.blocks))
                self.has_plots |= within.has_plots
                return f"<details><summary>{safe(block.title)}</summary>{inside}</details>"

    def _plot(self, plot: Plot) -> str:
        controls = "".join(_select(control) for control in plot.controls)
        buttons = '<button type="button" data-do="reset" hidden>Reset</button>'
        figure = with_shared(plain(inert(plot.figure)))
        return self._figure(plot.title, plot.alternative, figure, f"{controls}{buttons}", plot.height, plot.still)

    def _orbits(self, orbits: Orbits) -> str:
        last = len(orbits.speed) - 1
        slider = (
            f'<label>speed <input type="range" min="0" max="{last}" value="{orbits.first}" step="1" data-orbit></label>'
            ' <output aria-live="polite"></output>'
        )
        units = {"unit": orbits.unit, "speedUnit": orbits.speed_unit, "decimals": orbits.decimals}
        colours = {MEASURED: LIGHT[MEASURED], MODEL: LIGHT[MODEL]}
        spec = {"speed": orbits.speed, "planes": orbits.planes, "colours": colours, **units}
        return self._figure(orbits.title, orbits.alternative, spec, slider, 380, "", plot_type="orbits")

    def _figure(
        self, title: str, alternative: str, spec: Any, controls: str, height: int, still: str, plot_type: str = "plot"
    ) -> str:
        self.has_plots = True
        name = f"{plot_type}-{next(self._number)}"
        instead = self._instead(still, alternative)
        heading = "" if title == self._headline else f"<h3>{safe(title)}</h3>"
        return (
            f'<figure class="plot" id="{name}" data-kind="{plot_type}" data-name="{safe(Path(still).stem or name)}">{heading}'
            f'<div class="controls" hidden>{controls}</div>'
            f'<div class="canvas" role="img" aria-label="{safe(alternative)}" style="height:{height}px" hidden></div>'
            f'<div class="still">{instead}</div>'
            f'<figcaption>{safe(alternative)}</figcaption><p class="save" hidden>Save {SAVE}</p>'
            f"{data_script(spec)}</figure>"
        )

    def _instead(self, still: str, alternative: str) -> str:
        """In place of a plot where no script runs: its picture, or of large or folded ones a link to its file."""
        if still not in self._drawings:
            return "<p>This plot needs JavaScript; its numbers are in the files below.</p>"
        if self._is_folded or len(self._drawings[still]) > self._left:
            return f'<p><a href="{safe(still)}">{safe(still)}</a></p>'
        self._left -= len(self._drawings[still])
        return self._image(still, alternative)

    def _picture(self, picture: Picture) -> str:
        if picture.name not in self._drawings:
            return ""
        heading = f"<h3>{safe(picture.title)}</h3>" if picture.title else ""
        image = self._image(picture.name, picture.alternative)
        box = f'<div class="scroll picture" tabindex="0" role="region" aria-label="{safe(picture.title or "picture")}">{image}</div>'
        return f"<figure>{heading}{box}<figcaption>{safe(picture.alternative)}</figcaption></figure>"

    def _image(self, name: str, alternative: str) -> str:
        data = base64.b64encode(self._drawings[name]).decode()
        return f'<img alt="{safe(alternative)}" src="data:image/png;base64,{data}">'


FORMATS = ("PNG", "SVG", "CSV")  # in which a figure is saved from its page
SAVE = " · ".join(f'<button type="button" data-do="{name.lower()}">{name}</button>' for name in FORMATS)


def with_shared(figure: dict[str, Any]) -> dict[str, Any]:
    """A figure whose traces name equal long lists of x or y by their number in `shared`.

    Panels often show equal speeds.

    >>> x = list(range(60))
    >>> [trace["x"] for trace in with_shared({"data": [{"x": x}, {"x": x}]})["data"]]
    [{'shared': 0}, {'shared': 0}]
    """
    lists: dict[str, int] = {}
    shared: list[Any] = []
    traces = []
    for trace in figure.get("data", ()):
        named = {}
        for side in ("x", "y"):
            values = trace.get(side)
            if isinstance(values, list) and len(values) >= LEAST_SHARED:
                number = lists.setdefault(repr(values), len(shared))
                shared += [values] if number == len(shared) else []
                named[side] = {"shared": number}
        traces.append({**trace, **named})
    return {**figure, "data": traces, "shared": shared} if shared else figure


def data_script(spec: Any) -> str:
    """The element with a plot's data, which are compressed where they are many."""
    text = script_json(spec)
    if len(text) <= MOST_PLAIN:
        return f'<script type="application/json">{text}</script>'
    return f'<script type="text/plain" data-packed>{bundle.in_text(text.encode())}</script>'


def script_json(value: Any) -> str:
    r"""Data inside a `<script>`: nothing in them can end it, nor begin a comment of HTML.

    >>> script_json({"name": "</script><!--", "x": 1 / 3, "y": float("nan")})
    '{"name":"\\u003c/script\\u003e\\u003c!--","x":0.333333,"y":null}'
    """
    text = json.dumps(plain(value), ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def plain(value: Any) -> Any:
    """Numbers, texts, lists and mappings as JSON has them; what is not finite is None."""
    if type(value) is float:  # nearly all that a plot has
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    if isinstance(value, (np.ndarray, pd.Series, pd.Index)):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None
    return None if value is None else str(value)


def inert(figure: Any) -> Any:
    """A figure whose texts do nothing: plotly takes markup in them, of which only what breaks lines stays.

    The key that chooses traces (`meta`) is not shown, and stays as it is.

    >>> inert({"name": "<a href='x'>a</a><br>b & c", "meta": {"channel": "<x>"}})
    {'name': "&lt;a href='x'>a&lt;/a><br>b &amp; c", 'meta': {'channel': '<x>'}}
    """
    if type(figure) is float:
        return figure
    if isinstance(figure, Mapping):
        return {name: each if name == "meta" else inert(each) for name, each in figure.items()}
    if isinstance(figure, (np.ndarray, pd.Series, pd.Index)):
        return inert(figure.tolist())
    if isinstance(figure, (list, tuple)):
        return [inert(each) for each in figure]
    return _MARKUP.sub("&lt;", visible(figure).replace("&", "&amp;")) if isinstance(figure, str) else figure


_MARKUP = re.compile(r"<(?!br>|/?extra>)")


def _select(control: Control) -> str:
    options = [f'<option value="">all</option>'] if control.with_all else []  # noqa: F541
    options += [
        f'<option value="{safe(option)}"{" selected" if option == control.chosen else ""}>{safe(option)}</option>'
        for option in control.options
    ]
    return f'<label>{safe(control.label)} <select data-key="{safe(control.key)}">{"".join(options)}</select></label>'


def _command(command: Command) -> str:
    about = f"<p>{safe(command.about)}</p>" if command.about else ""
    copy = '<button type="button" data-do="copy" hidden>Copy</button>'
    return f'{about}<div class="command"><code>{safe(command.words)}</code>{copy}</div>'


def _numbers(numbers: Numbers) -> str:
    items = "".join(
        f"<div><b>{unbroken(safe(value))}</b><span>{safe(said)}</span></div>" for value, said in numbers.items
    )
    return f'<div class="numbers">{items}</div>' if items else ""


def _table(table: Table) -> str:
    frame = table.frame.head(MOST_ROWS)
    rows = [[_cell(value) for value in row] for row in frame.itertuples(index=False, name=None)]
    html = table_html([*map(str, frame.columns)], rows, table.title)
    left_out = len(table.frame) - len(frame)
    where = f" in {table.file}" if table.file else ""
    more = f"<p>and {left_out} more rows{safe(where)}</p>" if left_out else ""
    heading = f"<h3>{safe(table.title)}</h3>" if table.title else ""
    return f"{heading}{html}{more}"


def _cell(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        return number(value, TABLE_DIGITS)
    return NONE if value is None or value is pd.NA else shortened(str(value), LONGEST_CELL)

"""Page of a report as data: a headline, and sections of texts, tables, plots and commands.

A report supplies the page (`Made.page`); `bench/reports/pages` writes it as HTML. Texts are plain: markup in them is
shown literally and has no effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ksmea.show.charts.chart import Chart, Choice

if TYPE_CHECKING:
    import pandas as pd  # needed when there is something to report

Figure = Mapping[str, Any]  # a plotly figure: {"data": [traces], "layout": {…}}, numbers, texts and None


@dataclass(frozen=True)
class Prose:
    """A text as the terminal prints it.

    Lines are sentences, indented ones a list, aligned columns a table.
    """

    text: str


@dataclass(frozen=True)
class Command:
    """A command to be copied, and what it does."""

    words: str
    about: str = ""


@dataclass(frozen=True)
class Numbers:
    """A row of numbers, each with what it says."""

    items: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Steps:
    """Texts and commands to follow, in order."""

    steps: tuple[Prose | Command, ...]


@dataclass(frozen=True)
class Table:
    """A table of numbers and texts; of a long one the first rows, and the name of the file that has all."""

    frame: pd.DataFrame
    title: str = ""
    file: str = ""


Control = Choice  # of a plot: its traces have the tags as `meta`


@dataclass(frozen=True)
class Plot:
    """A plot of plotly's own, which no chart describes, and in words what it shows.

    `still` names the PNG of the same among the report's figures, which stands in its place where no script runs;
    `height` is in px.
    """

    title: str
    alternative: str
    figure: Figure
    still: str = ""
    controls: tuple[Control, ...] = ()
    height: int = 420


@dataclass(frozen=True)
class Drawn:
    """A chart, or what describes it, which may fail alone.

    `file` is the name of a PNG of it, which is written among the report's figures, and stands in its place where no
    script runs; '' without one.
    """

    chart: Chart | Callable[[], Chart]
    file: str = ""

    def described(self) -> Chart:
        return self._once

    @cached_property
    def _once(self) -> Chart:
        return self.chart if isinstance(self.chart, Chart) else self.chart()


@dataclass(frozen=True)
class Orbits:
    """Orbits of the shaft at a speed to be chosen.

    `speed` is in `speed_unit`, shown with so many `decimals`; of each plane and kind ('measured', 'model') the
    phasors of x and y over speed as (re x, im x, re y, im y) in `unit`. `first` is the number of the speed that is seen
    first."""

    title: str
    alternative: str
    speed: tuple[float, ...]
    planes: Mapping[str, Mapping[str, tuple[tuple[float, float, float, float], ...]]]
    first: int = 0
    unit: str = "µm"
    speed_unit: str = "rpm"
    decimals: int = 0


@dataclass(frozen=True)
class Picture:
    """One of the report's figures as a picture, and in words what it shows."""

    name: str
    alternative: str
    title: str = ""


@dataclass(frozen=True)
class Grid:
    """Small plots side by side where there is room."""

    plots: tuple[Plot | Drawn, ...]
    is_wide: bool = False  # two side by side


@dataclass(frozen=True)
class Folded:
    """Blocks that a click opens."""

    title: str
    blocks: tuple[Block, ...]


Block = Prose | Command | Numbers | Steps | Table | Plot | Drawn | Orbits | Picture | Grid | Folded


@dataclass(frozen=True)
class Section:
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Page:
    """Content of a page.

    `headline` is the finding in a sentence, which the index of all results shows too. `about` says of which data it is.
    A section without a title follows the one before it.
    """

    headline: str = ""
    sections: tuple[Section, ...] = field(default=())
    about: str = ""

    def charts(self) -> dict[str, Callable[[], Chart]]:
        """The charts that are written as pictures, by the names of their files."""
        return {each.file: each.described for section in self.sections for each in _drawn(section.blocks) if each.file}

    def titled(self, words: str) -> Page:
        """This page with words in brackets behind the title of each of its charts and plots."""
        return replace(self, sections=tuple(Section(each.title, _titled(each.blocks, words)) for each in self.sections))


def _drawn(blocks: Iterable[Block]) -> Iterator[Drawn]:
    for block in blocks:
        match block:
            case Drawn():
                yield block
            case Grid():
                yield from _drawn(block.plots)
            case Folded():
                yield from _drawn(block.blocks)


def _titled(blocks: Iterable[Any], words: str) -> tuple[Any, ...]:
    return tuple(_with_title(block, words) for block in blocks)


def _with_title(block: Any, words: str) -> Any:
    match block:
        case Drawn():
            return Drawn(lambda: block.described().titled(words), block.file)
        case Plot():
            return replace(block, title=f"{block.title} ({words})")
        case Grid():
            return replace(block, plots=_titled(block.plots, words))
        case Folded():
            return Folded(block.title, _titled(block.blocks, words))
    return block

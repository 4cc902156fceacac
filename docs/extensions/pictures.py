"""Pictures of boxes and arrows: blocks of `mermaid`, which GitHub draws, as SVG without a script.

A box stands one row above the highest box that it points to. Within its row it stands near its neighbours.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import escape

from docutils import nodes
from sphinx.application import Sphinx

ARROW = re.compile(r"^\s*(\w+) --> (\w+)\s*$", re.MULTILINE)
LETTER, HEIGHT, GAP, ROW = 8, 28, 22, 84  # px: width of a letter, of a box its height, between boxes and rows
SWEEPS = 20  # in which the order of each row follows those above and below

Edges = list[tuple[str, str]]


@dataclass(frozen=True)
class Box:
    name: str
    x: float  # of its centre
    y: float

    @property
    def width(self) -> float:
        return LETTER * len(self.name) + 18


def drawn(text: str) -> str:
    """The SVG of lines like `one --> other`."""
    edges = ARROW.findall(text)
    rows = _ordered(_rows(edges), edges)
    width = max(sum(Box(name, 0, 0).width + GAP for name in row) for row in rows)
    boxes = {box.name: box for number, row in enumerate(rows) for box in _placed(row, number, width)}
    arrows = "".join(_arrow(boxes[one], boxes[other]) for one, other in edges)
    height = ROW * (len(rows) - 1) + HEIGHT + 4
    return (
        f'<svg class="rooms" role="img" aria-label="{escape("; ".join(f"{one} to {other}" for one, other in edges))}"'
        f' viewBox="0 0 {width:.0f} {height}" width="{width:.0f}" height="{height}" xmlns="http://www.w3.org/2000/svg">'
        '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        f'<path d="M0 0 L8 4 L0 8 z"/></marker></defs>{arrows}{"".join(map(_box, boxes.values()))}</svg>'
    )


def _rows(edges: Edges) -> list[list[str]]:
    """Names by the longest way that leads down from them, the top row first."""
    names = list(dict.fromkeys(name for edge in edges for name in edge))
    height = dict.fromkeys(names, 0)
    for _ in names:  # the longest way has no more steps
        for one, other in edges:
            height[one] = max(height[one], height[other] + 1)
    return [[name for name in names if height[name] == row] for row in range(max(height.values()), -1, -1)]


def _ordered(rows: list[list[str]], edges: Edges) -> list[list[str]]:
    """Sort each row by the mean place of its boxes' neighbours, so that few arrows cross."""
    for _ in range(SWEEPS):
        place = {name: (index + 0.5) / len(row) for row in rows for index, name in enumerate(row)}
        joined = {name: [place[a if b == name else b] for a, b in edges if name in (a, b)] for name in place}
        rows = [sorted(row, key=lambda name: sum(joined[name]) / len(joined[name])) for row in rows]
    return rows


def _placed(row: list[str], number: int, width: float) -> list[Box]:
    """The boxes of a row, spread evenly over the width."""
    free = (width - sum(Box(name, 0, 0).width for name in row)) / len(row)
    boxes, left = [], free / 2
    for name in row:
        of_name = Box(name, 0, 0).width
        boxes.append(Box(name, left + of_name / 2, 2 + HEIGHT / 2 + ROW * number))
        left += of_name + free
    return boxes


def _arrow(one: Box, other: Box) -> str:
    start, end = one.y + HEIGHT / 2, other.y - HEIGHT / 2
    middle = (start + end) / 2
    way = f"M{one.x:.0f} {start:.0f} C{one.x:.0f} {middle:.0f} {other.x:.0f} {middle:.0f} {other.x:.0f} {end:.0f}"
    return f'<path d="{way}" marker-end="url(#head)"/>'


def _box(box: Box) -> str:
    return (
        f'<rect x="{box.x - box.width / 2:.1f}" y="{box.y - HEIGHT / 2:.0f}" width="{box.width}" height="{HEIGHT}" rx="5"/>'
        f'<text x="{box.x:.1f}" y="{box.y + 5:.0f}">{escape(box.name)}</text>'
    )


def _draw(app: Sphinx, document: nodes.document) -> None:
    for block in list(document.findall(nodes.literal_block)):
        if block.get("language") == "mermaid":
            block.replace_self(nodes.raw("", drawn(block.astext()), format="html"))


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("doctree-read", _draw)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

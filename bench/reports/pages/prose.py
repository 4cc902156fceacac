"""Texts of the terminal as HTML: sentences, lists, and tables where columns are aligned."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from html import escape
from itertools import groupby

from ksmea.errors import visible

WIDE_LIST = ";  "  # parts of a sentence, set apart by blanks
LONG = 40  # characters
GAP = 2  # blanks between columns (`ksmea.show.text.aligned`)
COLUMNS = re.compile(rf"\S {{{GAP},}}\S")
CHANCE = re.compile(r"\bp (?:[=≤]|&lt;) (?=\d)")  # in one line, as the next
TOGETHER = re.compile(r"[±×] (?=\d)|(?<=\d) %")
NUMBER = re.compile(r"[-+−±~<>≤≥× ]*[\d.]+[⁰¹²³⁴-⁹]*([eE][-+]?\d+)?[ %]*|[-–∞?]|[-+−]?∞|nan|not known|never")


def prose_html(text: str) -> str:
    """A text with its lines and columns.

    >>> prose_html("Found:\\n  a < b")
    '<p>Found:</p><ul><li>a &lt; b</li></ul>'
    """
    return "".join(_block(block.splitlines()) for block in re.split(r"\n\s*\n", text) if block.strip())


def table_html(head: Sequence[str], rows: Sequence[Sequence[str]], label: str = "") -> str:
    """A table in a box of its own, which scrolls where it is wider than the page.

    Numbers to the right, texts to the left.
    """
    right = [is_numeric([row[column] for row in rows]) for column in range(len(head))]
    attributes = [' class="number"' if each else "" for each in right]
    top = "".join(f'<th scope="col"{attribute}>{safe(name)}</th>' for name, attribute in zip(head, attributes))
    body = "".join(
        f"<tr>{''.join(f'<td{attribute or _wrapping(cell)}>{safe(cell)}</td>' for cell, attribute in zip(row, attributes))}</tr>"
        for row in rows
    )
    named = f' role="region" aria-label="{safe(label or "table")}"'
    return f'<div class="scroll" tabindex="0"{named}><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _wrapping(cell: str) -> str:
    """Long texts are broken into lines; short ones stay whole."""
    return ' class="long"' if len(cell) > LONG else ""


def is_numeric(cells: Sequence[str]) -> bool:
    """Whether a column holds numbers and signs that stand for none.

    >>> is_numeric(["1.5", "–", "3e-4"]), is_numeric(["1", "x"]), is_numeric([""])
    (True, False, False)
    """
    filled = [cell for cell in cells if cell.strip()]
    return bool(filled) and all(NUMBER.fullmatch(cell.strip()) for cell in filled)


def safe(text: object) -> str:
    """Any text as HTML shows it: markup does nothing, and what cannot be seen stands as its escape."""
    return escape(visible(str(text)), quote=True)


def columns_of(lines: Sequence[str]) -> list[list[str]]:
    """The cells of aligned lines.

    Columns end where two blanks or more stand one below the other in all of them.

    >>> columns_of(["name  m", "   a  1", "      2"])
    [['name', 'm'], ['a', '1'], ['', '2']]
    """
    width = max(map(len, lines))
    padded = [line.ljust(width) for line in lines]
    is_blank = "".join(" " if all(line[at] == " " for line in padded) else "x" for at in range(width))
    gaps = [found.span() for found in re.finditer(rf" {{{GAP},}}", is_blank.lstrip().rjust(width, "x"))]
    starts = [0, *(end for _, end in gaps if end < width)]
    ends = [*(start for start, _ in gaps if start), width]
    return [[line[start:end].strip() for start, end in zip(starts, ends)] for line in padded]


def _block(lines: Sequence[str]) -> str:
    return "".join(_lines(is_table, list(part)) for is_table, part in groupby(lines, is_aligned))


def is_aligned(line: str) -> bool:
    return COLUMNS.search(line) is not None and WIDE_LIST not in line


def _lines(is_table: bool, lines: list[str]) -> str:
    if is_table and len(lines) > 1:
        head, *rows = columns_of(lines)
        return table_html(head, rows)
    return "".join(_sentences(lines))


def _sentences(lines: Sequence[str]) -> Iterator[str]:
    for is_item, part in groupby(lines, lambda line: line.startswith(("  ", "- "))):
        texts = [CHANCE.sub(_joined, safe(line.strip().removeprefix("- "))) for line in part]
        if is_item:
            yield f"<ul>{''.join(f'<li>{text}</li>' for text in texts)}</ul>"
        else:
            yield "".join(f"<p>{text}</p>" for text in texts)


def unbroken(text: str) -> str:
    """Text whose lines never end between a number and its ±, × or %, nor within 'p = 0.38'.

    >>> unbroken("± 0.1 % of kxx (p = 0.38)").replace("\N{NO-BREAK SPACE}", "_")
    '±_0.1_% of kxx (p_=_0.38)'
    """
    return TOGETHER.sub(_joined, CHANCE.sub(_joined, text))


def _joined(found: re.Match[str]) -> str:
    return found[0].replace(" ", "\N{NO-BREAK SPACE}")

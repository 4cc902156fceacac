"""Text tables with any separator, decimal mark and encoding, as columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from ksmea.errors import SettingError, shortened
from measurements.formats.column_guess import columns_question
from measurements.formats.sheet import Sheet, SheetRows, require_distinct
from measurements.formats.texts import SEPARATORS, rows_of_cells, text_of
from measurements.run_up_rows import MAX_ROWS, REQUIRED

MOST_LINES = 100  # in which headings are looked for, to suggest what they hold


def read_delimited(content: bytes, path: str, headings: Sequence[str], most_rows: int = MAX_ROWS) -> Sheet:
    """The table below the first line that has all of these headings; those of the project's own file where none are given.
    Lines that begin with # are remarks, and what stands above the headings is left alone."""
    text = text_of(content, path)
    for separator in SEPARATORS:
        table = _table(text, separator, path, list(headings), most_rows)
        if table is not None:
            return table
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    said = (
        f"{path}: expected a line with the headings {shortened(', '.join(headings or REQUIRED), 200)}, got none; the first line is"
        f" {shortened(repr(first), 120)}"
    )
    if headings:
        raise SettingError(said)
    raise columns_question(f"{said}; give columns=[role=heading,…]", first_cells(text, path))


def first_cells(text: str, path: str) -> Iterator[list[str]]:
    """The first lines that are no remarks, cut by each separator in turn."""
    for separator in SEPARATORS:
        for _, cells in islice(rows_of_cells(text, separator, path), MOST_LINES):
            if not cells[0].startswith("#"):
                yield cells


def _table(text: str, separator: str, path: str, headings: list[str], most_rows: int) -> Sheet | None:
    if separator not in text and len(headings) != 1:
        return None
    rows: SheetRows | None = None
    for number, cells in rows_of_cells(text, separator, path):
        if cells[0].startswith("#") and not _is_header(cells, headings):
            continue
        if rows is None:
            if _is_header(cells, headings):
                require_distinct(cells, f"{path} line {number}")
                rows = SheetRows(path, cells, most_rows)
            continue
        n = len(rows.names)
        if len(cells) > n and not any(cells[n:]):
            cells = cells[:n]
        if len(cells) != n:
            raise SettingError(f"{path} line {number}: expected {n} cells as in the header, got {len(cells)}")
        rows.add(number, cells)
    if rows is None:
        return None
    if (sheet := rows.sheet()) is None:
        raise SettingError(f"{path}: expected rows below the header, got none")
    return sheet


def _is_header(cells: Sequence[str], headings: Sequence[str]) -> bool:
    lowered = {cell.lower() for cell in cells}
    plain = [each for each in headings if not each.startswith("#")]
    if not plain and headings:  # columns by number alone: the first line that has as many
        return len(cells) >= max(int(each[1:]) for each in headings)
    return {each.lower() for each in plain or REQUIRED} <= lowered

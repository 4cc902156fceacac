"""Text tables with any separator, decimal mark and encoding, as columns."""

from __future__ import annotations

from collections.abc import Sequence

from ksmea.errors import SettingError, shortened
from measurements.formats.sheet import Sheet, unit_row
from measurements.formats.texts import SEPARATORS, rows_of_cells, text_of
from measurements.run_up_rows import MAX_ROWS, REQUIRED


def read_delimited(content: bytes, path: str, headings: Sequence[str], most_rows: int = MAX_ROWS) -> Sheet:
    """The table below the first line that has all of these headings; those of the project's own file where none are given.
    Lines that begin with # are remarks, and what stands above the headings is left alone."""
    text = text_of(content, path)
    for separator in SEPARATORS:
        table = _table(text, separator, path, list(headings), most_rows)
        if table is not None:
            return table
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    raise SettingError(
        f"{path}: expected a line with the headings {shortened(', '.join(headings or REQUIRED), 200)}, got none; the first line is"
        f" {shortened(repr(first), 120)}"
    )


def _table(text: str, separator: str, path: str, headings: list[str], most_rows: int) -> Sheet | None:
    if separator not in text and len(headings) != 1:
        return None
    names: list[str] = []
    lines: list[int] = []
    rows: list[list[str]] = []
    units: dict[str, str] = {}
    for number, cells in rows_of_cells(text, separator, path):
        if cells[0].startswith("#") and not _is_header(cells, headings):
            continue
        if not names:
            if _is_header(cells, headings):
                names = _headings(cells, f"{path} line {number}")
            continue
        if len(cells) > len(names) and not any(cells[len(names) :]):
            cells = cells[: len(names)]
        if len(cells) != len(names):
            raise SettingError(f"{path} line {number}: expected {len(names)} cells as in the header, got {len(cells)}")
        if not rows and not units and (found := unit_row(names, cells)) is not None:
            units = found
            continue
        if len(rows) == most_rows:
            raise SettingError(f"{path} line {number}: expected at most {most_rows} rows, got more; thin them out")
        lines.append(number)
        rows.append(cells)
    if not names:
        return None
    if not rows:
        raise SettingError(f"{path}: expected rows below the header, got none")
    return Sheet(path, lines, {name: [row[index] for row in rows] for index, name in enumerate(names) if name}, units)


def _is_header(cells: Sequence[str], headings: Sequence[str]) -> bool:
    lowered = {cell.lower() for cell in cells}
    plain = [each for each in headings if not each.startswith("#")]
    if not plain and headings:  # columns by number alone: the first line that has as many
        return len(cells) >= max(int(each[1:]) for each in headings)
    return {each.lower() for each in plain or REQUIRED} <= lowered


def _headings(cells: Sequence[str], where: str) -> list[str]:
    for name in cells:
        if name and list(cells).count(name) > 1:
            raise SettingError(f"{where}: expected each heading once, got {shortened(repr(name))} twice; rename one")
    return list(cells)

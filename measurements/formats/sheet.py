"""Table of named columns, with texts or numbers as cells.

Text files with any separator, decimal mark and encoding.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError, shortened, unknown
from measurements.formats.column_guess import columns_question
from measurements.formats.texts import (
    BLANKS,
    SEPARATORS,
    has_decimal_commas,
    is_data,
    number,
    rows_of_cells,
    text_of,
)
from measurements.formats.unit_texts import PHASES, TIMES, amplitude_unit, speed_unit, unit_in_heading
from measurements.run_up_rows import MAX_ROWS, REQUIRED

Cell = str | float
PLAIN_NUMBER = re.compile(r"#([1-9][0-9]{0,4})", re.ASCII)


@dataclass(frozen=True)
class Sheet:
    """Columns by heading, all with a cell for each of `lines`.

    `units` come from a row of their own below the heading. `where` names the sheet in errors.
    """

    where: str
    lines: Sequence[int]
    columns: dict[str, Sequence[Cell] | Array | ComplexArray]
    units: dict[str, str] = field(default_factory=dict)
    has_brackets_in_headings: bool = True  # at their end, with a unit

    def named(self, name: str) -> str:
        """The heading that a name means: itself, itself in other case, or #3 for the third.

        `SettingError` if none is.
        """
        if name in self.columns:
            return name
        alike = [each for each in self.columns if each.lower() == name.strip().lower()]
        if len(alike) == 1:
            return alike[0]
        if found := PLAIN_NUMBER.fullmatch(name):
            place = int(found[1])
            if place <= len(self.columns):
                return list(self.columns)[place - 1]
        raise SettingError(f"{self.where}: {unknown('column', name, [shortened(each) for each in self.columns])}")

    def unit(self, name: str) -> str:
        """The unit of a column as the file spells it; empty if it does not say."""
        heading = self.named(name)
        return self.units.get(heading, "") or unit_in_heading(heading, in_brackets=self.has_brackets_in_headings)

    def texts(self, name: str) -> list[str]:
        return [_as_text(cell) for cell in self.columns[self.named(name)]]

    def numbers(self, name: str) -> Array:
        """A column as numbers, NaN for cells that the file marks as missing."""
        cells = self.columns[self.named(name)]
        if isinstance(cells, np.ndarray):
            if np.iscomplexobj(cells):
                raise SettingError(
                    f"{self.where}: expected real numbers in {shortened(name)}, got complex ones; use response"
                )
            return np.asarray(cells, dtype=float)
        texts = [cell for cell in cells if isinstance(cell, str)]
        comma = has_decimal_commas(texts, f"{self.where} column {shortened(name)}")
        return np.array(
            [
                number(cell, f"{self.where} line {line}", decimal_comma=comma) if isinstance(cell, str) else float(cell)
                for cell, line in zip(cells, self.lines)
            ]
        )

    def complex_numbers(self, name: str) -> ComplexArray:
        cells = self.columns[self.named(name)]
        if isinstance(cells, np.ndarray):
            return np.asarray(cells, dtype=complex)
        raise SettingError(
            f"{self.where}: expected complex numbers in {shortened(name)}, got a text; give real and imag instead"
        )


class SheetRows:
    """Rows below the headings of a table, as they are read one after the other."""

    def __init__(self, where: str, names: Sequence[str], most_rows: int) -> None:
        self.names = names
        self._where, self._most_rows = where, most_rows
        self._units: dict[str, str] = {}
        self._lines: list[int] = []
        self._rows: list[Sequence[Cell]] = []

    def add(self, number: int, cells: Sequence[Cell]) -> None:
        """A row with a cell for each heading, from that line of the file; the first may hold the units."""
        if not self._rows and not self._units and (found := unit_row(self.names, cells)) is not None:
            self._units = found
            return
        if len(self._rows) == self._most_rows:
            raise SettingError(
                f"{self._where} line {number}: expected at most {self._most_rows} rows, got more; thin them out"
            )
        self._lines.append(number)
        self._rows.append(cells)

    def sheet(self) -> Sheet | None:
        """The table; None if no row followed."""
        if not self._rows:
            return None
        columns: dict[str, Sequence[Cell] | Array | ComplexArray] = {
            name: [row[index] for row in self._rows] for index, name in enumerate(self.names) if name
        }
        return Sheet(self._where, self._lines, columns, self._units)


def common_length(columns: Mapping[str, Sized], headings: Sequence[str], path: str, cure: str) -> int:
    """The length of the columns that are named, or of most.

    Raises `SettingError` with the `cure` if named ones differ.
    """
    for heading in headings:
        if heading not in columns:
            continue
        for other in headings:
            if other in columns and len(columns[other]) != len(columns[heading]):
                raise SettingError(
                    f"{path}: expected columns of one length, got {len(columns[heading])} in {shortened(heading)} and"
                    f" {len(columns[other])} in {shortened(other)}; {cure}"
                )
        return len(columns[heading])
    lengths = [len(column) for column in columns.values()]
    return max(set(lengths), key=lambda each: (lengths.count(each), each))


def require_distinct(names: Sequence[str], where: str) -> None:
    """Raise `SettingError` if a heading stands twice."""
    for name in names:
        if name and list(names).count(name) > 1:
            raise SettingError(f"{where}: expected each heading once, got {shortened(repr(name))} twice; rename one")


def unit_row(headings: Sequence[str], cells: Sequence[Cell]) -> dict[str, str] | None:
    """The units of a row below the headings; None if the row holds anything else."""
    texts = [_as_text(cell).strip("[]() ") for cell in cells]
    if not any(texts) or not all(_is_unit(text) for text in texts):
        return None
    return {heading: text for heading, text in zip(headings, texts) if text}


def _is_unit(text: str) -> bool:
    return text.lower() in (*PHASES, *TIMES, "-") or bool(speed_unit(text)) or amplitude_unit(text) is not None


def _as_text(cell: Cell) -> str:
    if isinstance(cell, str):
        return cell.strip()
    return "" if isinstance(cell, float) and math.isnan(cell) else f"{cell:.15g}"


MOST_LINES = 100  # in which headings are looked for, to suggest what they hold


def read_delimited(content: bytes, path: str, headings: Sequence[str], most_rows: int = MAX_ROWS) -> Sheet:
    """The table below the first line that has all of these headings.

    The headings of the project's own file if none are given. Lines that begin with # are remarks, and lines above the
    headings are ignored.
    """
    text = text_of(content, path)
    for separator in (*SEPARATORS, BLANKS):
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
    raise columns_question(
        f"{said}; give columns=[role=heading,…]", first_cells(text, path), is_plain=has_no_headings(text, path)
    )


def has_no_headings(text: str, path: str) -> bool:
    """Whether the first line that is not a remark holds values.

    A logger's file whose columns are known by their number.
    """
    for separator in (*SEPARATORS, BLANKS):
        for _, cells in rows_of_cells(text, separator, path):
            if not cells[0].startswith("#"):
                if len(cells) > 1 and is_data(cells):
                    return True
                break
    return False


def first_cells(text: str, path: str) -> Iterator[list[str]]:
    """The first lines that are no remarks, cut by each separator in turn."""
    for separator in (*SEPARATORS, BLANKS):
        for _, cells in islice(rows_of_cells(text, separator, path), MOST_LINES):
            if not cells[0].startswith("#"):
                yield cells


def _table(text: str, separator: str, path: str, headings: list[str], most_rows: int) -> Sheet | None:
    if separator not in text and len(headings) != 1:
        return None
    rows: SheetRows | None = None
    for line, cells in rows_of_cells(text, separator, path):
        if cells[0].startswith("#") and not _is_header(cells, headings):
            continue
        if rows is None:
            if _is_header(cells, headings) and (separator != BLANKS or is_data(cells) or not _by_number(headings)):
                if not (plain := _by_number(headings) and is_data(cells)):
                    require_distinct(cells, f"{path} line {line}")
                rows = SheetRows(path, [f"#{n}" for n in range(1, len(cells) + 1)] if plain else cells, most_rows)
                if plain:
                    rows.add(line, cells)
            continue
        n = len(rows.names)
        if len(cells) > n and not any(cells[n:]):
            cells = cells[:n]
        if len(cells) != n:
            raise SettingError(f"{path} line {line}: expected {n} cells as in the header, got {len(cells)}")
        rows.add(line, cells)
    if rows is None:
        return None
    if (sheet := rows.sheet()) is None:
        raise SettingError(f"{path}: expected rows below the header, got none")
    return sheet


def _by_number(headings: Sequence[str]) -> bool:
    return bool(headings) and all(PLAIN_NUMBER.fullmatch(each) for each in headings)


def _is_header(cells: Sequence[str], headings: Sequence[str]) -> bool:
    lowered = {cell.lower() for cell in cells}
    plain = [each for each in headings if not each.startswith("#")]
    if not plain and headings:  # columns by number alone: the first line that has as many
        return len(cells) >= max(int(each[1:]) for each in headings)
    return {each.lower() for each in plain or REQUIRED} <= lowered

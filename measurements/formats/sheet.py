"""A table of named columns, whatever file it comes from: cells are texts or numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError, shortened, unknown
from measurements.formats.texts import has_decimal_commas, number
from measurements.formats.unit_texts import PHASES, TIMES, amplitude_unit, speed_unit, unit_in_heading

Cell = str | float
PLAIN_NUMBER = re.compile(r"#([1-9][0-9]{0,4})", re.ASCII)


@dataclass(frozen=True)
class Sheet:
    """Columns by heading, all with a cell for each of `lines`; `units` are those that stand in a row of their own below the
    heading. `where` names it in errors."""

    where: str
    lines: Sequence[int]
    columns: dict[str, Sequence[Cell] | Array | ComplexArray]
    units: dict[str, str] = field(default_factory=dict)
    has_units_in_headings: bool = True  # in brackets at their end

    def named(self, name: str) -> str:
        """The heading that a name means: itself, itself in other case, or #3 for the third. `SettingError` where none is."""
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
        """The unit of a column as the file spells it; empty where it does not say."""
        heading = self.named(name)
        in_heading = unit_in_heading(heading) if self.has_units_in_headings else ""
        return self.units.get(heading, "") or in_heading

    def texts(self, name: str) -> list[str]:
        return [_as_text(cell) for cell in self.columns[self.named(name)]]

    def numbers(self, name: str) -> Array:
        """A column as numbers, NaN where the file says that there is none."""
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
        """The table; None where no row followed."""
        if not self._rows:
            return None
        columns: dict[str, Sequence[Cell] | Array | ComplexArray] = {
            name: [row[index] for row in self._rows] for index, name in enumerate(self.names) if name
        }
        return Sheet(self._where, self._lines, columns, self._units)


def require_distinct(names: Sequence[str], where: str) -> None:
    """Raise `SettingError` where a heading stands twice."""
    for name in names:
        if name and list(names).count(name) > 1:
            raise SettingError(f"{where}: expected each heading once, got {shortened(repr(name))} twice; rename one")


def unit_row(headings: Sequence[str], cells: Sequence[Cell]) -> dict[str, str] | None:
    """The units of a row below the headings; None where the row holds anything else."""
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

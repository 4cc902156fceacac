"""Tables over speed of a rotor file.

Lists in it, or a separate CSV or Excel sheet, whose columns are named with their units.

The units of a sheet stand in its headings, `kxx [lbf/in]`, or in a row of their own below them; they are never guessed.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from ksmea.errors import SettingError, described, shortened, unknown
from ksmea.settings.document import PLAUSIBLE, Block, Units, inside
from ksmea.settings.regular_files import read_input
from ksmea.units import SI_PER_UNIT
from problems.rotor.finite_elements.bearing import COEFFICIENTS, DAMPINGS, MASSES, STIFFNESSES, SpeedTable

QUANTITY_OF = {
    "speed": "speed",
    **dict.fromkeys(STIFFNESSES, "stiffness"),
    **dict.fromkeys(DAMPINGS, "damping"),
    **dict.fromkeys(MASSES, "mass"),
}
MEASURED = tuple(f"{part}_z{entry}" for entry in ("xx", "xy", "yx", "yy") for part in ("re", "im"))
QUANTITY_OF_MEASURED = {"frequency": "speed", **dict.fromkeys(MEASURED, "stiffness")}
REQUIRED_MEASURED = ("re_zxx", "re_zyy")
NUMBER, TEXT = "number", "text"  # columns without a unit
LARGEST = 5 * 10**6  # bytes of a sheet
LARGEST_NUMBER = 1e9  # without a unit
MOST_ROWS, MOST_COLUMNS = 10_000, 100
HEADING = re.compile(r"\s*([A-Za-z_][A-Za-z_ ]*?)\s*(?:[\[(]\s*(.+?)\s*[\])])?\s*")
PLAIN = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?", re.ASCII)
DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+([eE][-+]?[0-9]+)?", re.ASCII)
SPELLINGS = {"³": "3", "²": "2", "^": "", "·": " ", "*": " ", "µ": "u", "μ": "u", "-": " ", "lbf.": "lbf "}


@dataclass(frozen=True)
class RotorSheets:
    """The folder that paths of tables start at, and what was read from there, by path.

    It counts as the rotor file does.
    """

    folder: Path
    read: dict[str, bytes] = field(default_factory=dict)


def read_table(
    block: Block, key: str, units: Units, sheets: RotorSheets, *, measured: bool = False
) -> tuple[SpeedTable, tuple[str, ...]]:
    """Table of a bearing over speed or of a support over frequency, and the columns that it has.

    A bearing has twelve columns, the dynamic stiffness of a support eight; others are 0.
    """
    quantities = QUANTITY_OF_MEASURED if measured else QUANTITY_OF
    first, *others = quantities
    value = block.values[key]
    if not isinstance(value, (str, dict)):
        raise block.error(key, f"expected lists by name, or a file such as bearing.csv, got {described(value)}")
    if isinstance(value, str):
        columns = inside(block, key, lambda: _of_sheet(value, quantities, sheets))
    else:
        columns = _inline(block.block(key), quantities, units)
    required = (first, *(REQUIRED_MEASURED if measured else ()))
    if len(columns) < 2 or not all(name in columns for name in required):
        expected = f"{', '.join(required)} and any of {', '.join(name for name in others if name not in required)}"
        raise block.error(key, f"expected columns {expected}, got {', '.join(columns) or 'none'}")
    names = MEASURED if measured else COEFFICIENTS
    rows = zip(*(columns.get(name, [0.0] * len(columns[first])) for name in names))
    return inside(block, key, lambda: SpeedTable(tuple(columns[first]), tuple(rows))), tuple(columns)


def _inline(block: Block, quantities: Mapping[str, str], units: Units) -> dict[str, list[float]]:
    """Columns in SI of lists in the file, in its units."""
    block.check_keys((), quantities)
    columns = {}
    for name in block.values:
        entries = block.entries(name)
        listed = Block(block.file, block.path, {f"{name}[{n}]": each for n, each in enumerate(entries, start=1)})
        limits = {"at_least": 0} if quantities[name] == "speed" else {}
        columns[name] = [units.quantity(listed, key, quantities[name], **limits) for key in listed.values]
        if len(columns[name]) != len(next(iter(columns.values()))):
            first = next(iter(columns))
            raise block.error(
                name, f"expected {len(columns[first])} numbers, as many as of {first}, got {len(entries)}"
            )
        if limits:
            for number, (before, after) in enumerate(pairwise(entries), start=2):
                if after <= before:
                    raise block.error(f"{name}[{number}]", f"expected a {name} above {before:g}, got {after:g}")
    return columns


def _of_sheet(word: str, quantities: Mapping[str, str], sheets: RotorSheets) -> dict[str, list[float]]:
    """Columns in SI of a file `table.csv`, or of a sheet `book.xlsx#sheet`."""
    return columns_of(sheet_rows(word, sheets), word.partition("#")[0], quantities)[0]


def sheet_rows(word: str, sheets: RotorSheets) -> list[list[str]]:
    """The cells of a file `table.csv`, or of a sheet `book.xlsx#sheet`, as texts."""
    path, _, sheet = word.partition("#")
    content = read_input(
        str(sheets.folder / path),
        "CSV or Excel",
        LARGEST,
        f"expected at most {LARGEST} bytes, got {{}}; a table is smaller".format,
    )
    sheets.read[word] = content
    is_excel = path.lower().endswith((".xlsx", ".xlsm"))
    return _rows_of_excel(content, path, sheet) if is_excel else _rows_of_csv(content, path)


def columns_of(
    rows: Sequence[Sequence[str]], path: str, quantities: Mapping[str, str]
) -> tuple[dict[str, list[float]], dict[str, list[str]]]:
    """Columns in SI of rows of texts, the first of which has the headings, and columns of texts.

    A quantity is one of `SI_PER_UNIT`, `number` without unit, or `text`; columns of other names are refused.
    """
    filled = [(number, row) for number, row in enumerate(rows, start=1) if any(cell.strip() for cell in row)]
    if len(filled) < 2:
        raise SettingError(f"{path}: expected headings and rows of numbers, got {len(filled)} rows")
    names, given = _headings(filled[0][1], path, quantities)
    body = filled[1:]
    if not any(given) and not any(PLAIN.fullmatch(cell.strip()) for cell in body[0][1]):
        given, body = [_spelt(cell.strip("[] ")) for cell in body[0][1]], body[1:]
    if not 0 < len(body) <= MOST_ROWS:
        raise SettingError(f"{path}: expected 1 to {MOST_ROWS} rows of numbers, got {len(body)}")
    units = dict(zip(names, [*given, *[""] * len(names)]))
    numbers = [name for name in names if quantities[name] != TEXT]
    sizes = {name: _unit(name, units[name], path, quantities[name]) for name in numbers}
    found: dict[str, list[float]] = {name: [] for name in numbers}
    texts: dict[str, list[str]] = {name: [] for name in names if quantities[name] == TEXT}
    for number, row in body:
        if any(cell.strip() for cell in row[len(names) :]):
            raise SettingError(
                f"{path}: row {number}: expected {len(names)} cells as in the heading, got {len(row)}; write decimal points, no"
                " commas"
            )
        for place, name in enumerate(names):
            cell = row[place].strip() if place < len(row) else ""
            if name in texts:
                texts[name].append(cell)
                continue
            value = _number(cell, f"{path}: row {number}, {name}", quantities[name], sizes[name])
            if quantities[name] == "speed":
                _require_rising(found[name], value, sizes[name], f"{path}: row {number}, {name}")
            found[name].append(value)
    return found, texts


def _require_rising(before: Sequence[float], value: float, size: float, where: str) -> None:
    if value < 0 or (before and value <= before[-1]):
        above = f"above {before[-1] / size:g}" if before else "of at least 0"
        raise SettingError(f"{where}: expected a number {above}, got {value / size:g}")


def _number(cell: str, where: str, quantity: str, size: float) -> float:
    """A cell in SI, its unit of a size."""
    if not PLAIN.fullmatch(cell):
        hint = "; write decimal points, no commas" if DECIMAL_COMMA.fullmatch(cell) else ""
        raise SettingError(f"{where}: expected a number, got {described(cell or None)}{hint}")
    value = float(cell)
    most = PLAUSIBLE.get(quantity, (0.0, LARGEST_NUMBER))[1]
    if not abs(value) * size <= most:
        raise SettingError(f"{where}: expected a {quantity} of at most {most / size:.3g}, got {value:g}")
    return value * size


def _headings(cells: Sequence[str], path: str, known: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """Names of columns, and the units in their headings."""
    names, given = [], []
    while cells and not cells[-1].strip():  # cells that a spreadsheet leaves behind
        cells = cells[:-1]
    for cell in cells:
        match = HEADING.fullmatch(cell)
        name = match[1].strip().lower().replace(" ", "_") if match else cell.strip()
        if name not in known:
            raise SettingError(f"{path}: {unknown('column', shortened(name), known)}")
        if name in names:
            raise SettingError(f"{path}: expected each column once, got {name} again")
        names.append(name)
        given.append(_spelt(match[2] or "") if match else "")
    return names, given


def _unit(name: str, unit: str, path: str, quantity: str) -> float:
    if quantity == NUMBER:
        return 1.0
    known = SI_PER_UNIT[quantity]
    if not unit:
        example = next(iter(known))
        raise SettingError(f"{path}: {name}: expected its unit in the heading, such as '{name} [{example}]', got none")
    if unit not in known:
        raise SettingError(f"{path}: {name}: {unknown(f'unit of {quantity}', shortened(unit), known)}")
    return known[unit]


def _spelt(unit: str) -> str:
    """A unit as `SI_PER_UNIT` spells it."""
    for letter, own in SPELLINGS.items():
        unit = unit.replace(letter, own)
    return " ".join(unit.split())


def _rows_of_csv(content: bytes, path: str) -> list[list[str]]:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SettingError(f"{path}: expected a CSV text in UTF-8, got other bytes at {error.start}") from error
    head = text.partition("\n")[0]
    delimiter = max(",;\t", key=head.count)
    try:
        return list(csv.reader(io.StringIO(text), delimiter=delimiter))
    except csv.Error as error:
        raise SettingError(f"{path}: expected a CSV text, got {error}") from error


def _rows_of_excel(content: bytes, path: str, sheet: str) -> list[list[str]]:
    try:
        import openpyxl
    except ImportError as error:
        raise SettingError(
            f"{path}: Excel files are read by openpyxl, which is not installed; pip install 'ksmea-bench[formats]', or save it as CSV"
        ) from error
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if (size := sum(entry.file_size for entry in archive.infolist())) > 20 * LARGEST:
                raise SettingError(f"{path}: expected at most {20 * LARGEST} bytes unpacked, got {size}")
        book: Any = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
        names = list(book.sheetnames)
        if not sheet and len(names) != 1:
            listed = shortened(", ".join(names), 100)
            raise SettingError(
                f"{path}: expected the name of one sheet, as in {path}#{names[0]}, got none; there are {listed}"
            )
        if sheet and sheet not in names:
            raise SettingError(f"{path}: {unknown('sheet', sheet, names)}")
        rows = book[sheet or names[0]].iter_rows(values_only=True, max_row=2 * MOST_ROWS, max_col=MOST_COLUMNS)
        return [["" if cell is None else str(cell) for cell in row] for row in rows]
    except SettingError:
        raise
    except Exception as error:  # openpyxl raises whatever a damaged archive makes it meet
        raise SettingError(
            f"{path}: expected an Excel file (.xlsx), got one that cannot be read; save it as CSV"
        ) from error

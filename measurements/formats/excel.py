"""Excel files (.xlsx): one sheet, its headings in the first row that has them all."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from datetime import datetime
from typing import Any

from ksmea.errors import SettingError, shortened, unknown
from measurements.formats.column_guess import columns_question
from measurements.formats.delimited import MOST_LINES
from measurements.formats.sheet import Cell, Sheet, SheetRows, require_distinct
from measurements.run_up_rows import MAX_BYTES, MAX_ROWS, REQUIRED, quoted

MAX_COLUMNS = 1000
ZIP, OLD_EXCEL = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"


def read_excel(content: bytes, path: str, sheet: str, headings: Sequence[str], most_rows: int = MAX_ROWS) -> Sheet:
    """The table of a sheet; `SettingError` where openpyxl is not installed, there are several sheets and none is named, or the
    headings are nowhere."""
    if content.startswith(OLD_EXCEL):
        raise SettingError(
            f"{path}: expected .xlsx, got an older or an encrypted Excel file; save it as .xlsx without password"
        )
    if not content.startswith(ZIP):
        raise SettingError(f"{path}: expected an Excel file (.xlsx), got something else; name the format of the file")
    try:
        import openpyxl
    except ImportError as error:
        raise SettingError(
            f"{path}: Excel files are read by openpyxl, which is not installed; pip install 'ksmea-bench[formats]', or save it as"
            " CSV and give format=csv"
        ) from error
    _require_small(content, path)
    try:
        book: Any = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
        names = list(book.sheetnames)
    except Exception as error:  # openpyxl raises whatever a damaged archive makes it meet
        raise _unreadable(path, error) from error
    try:
        return _table(book, path, _chosen(names, sheet, path), list(headings), most_rows)
    except SettingError:
        raise
    except Exception as error:
        raise _unreadable(path, error) from error
    finally:
        book.close()


def _require_small(content: bytes, path: str) -> None:
    """A zip archive may hold a thousand times its own size."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
    except Exception as error:
        raise _unreadable(path, error) from error
    if size > MAX_BYTES:
        raise SettingError(
            f"{path}: expected at most {MAX_BYTES >> 20} MB unpacked, got {size >> 20} MB; remove other sheets"
        )


def _chosen(names: list[str], sheet: str, path: str) -> str:
    if sheet:
        if sheet not in names:
            raise SettingError(f"{path}: {unknown('sheet', sheet, names)}")
        return sheet
    if len(names) != 1:
        raise SettingError(f"{path}: expected one sheet, got {shortened(', '.join(names), 200)}; give sheet=NAME")
    return names[0]


def _table(book: Any, path: str, sheet: str, headings: list[str], most_rows: int) -> Sheet:
    rows: SheetRows | None = None
    seen: list[list[str]] = []
    wanted = {each.lower() for each in headings if not each.startswith("#")} or set(REQUIRED)
    where = f"{path} sheet {shortened(sheet)}"
    for number, values in enumerate(book[sheet].iter_rows(values_only=True, max_col=MAX_COLUMNS), start=1):
        cells = [_cell(value) for value in values]
        if not any(cell != "" for cell in cells):
            continue
        if rows is None:
            names = [str(cell).strip() for cell in cells]
            if len(seen) < MOST_LINES:
                seen.append(names)
            if wanted <= {name.lower() for name in names}:
                require_distinct(names, f"{where} line {number}")
                rows = SheetRows(where, names, most_rows)
            continue
        n = len(rows.names)
        rows.add(number, cells[:n] + [""] * (n - len(cells)))
    if rows is None:
        said = f"{where}: expected a row with the headings {shortened(', '.join(sorted(wanted)), 200)}, got none"
        raise SettingError(said) if headings else columns_question(f"{said}; give columns=[role=heading,…]", seen)
    if (found := rows.sheet()) is None:
        raise SettingError(f"{where}: expected rows below the headings, got none")
    return found


def _cell(value: object) -> Cell:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, (int, float)):
        try:
            return float(value)
        except OverflowError:
            return str(value)
    if isinstance(value, datetime):
        return value.isoformat(" ")
    return str(value).strip()


def _unreadable(path: str, error: Exception) -> SettingError:
    return SettingError(f"{path}: expected an Excel file that can be read, got {quoted(error)}; save it again")

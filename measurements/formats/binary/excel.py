"""Excel files (.xlsx, and .xls by `old_excel`).

One sheet, its headings in the first row that has them all.
"""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Iterator, Sequence
from datetime import datetime
from itertools import islice
from typing import Any

from ksmea.errors import SettingError, shortened, unknown
from measurements.formats.binary.old_excel import old_book
from measurements.formats.column_guess import Guess, columns_question, guessed_columns
from measurements.formats.questions import OpenQuestion
from measurements.formats.sheet import MOST_LINES, Cell, Sheet, SheetRows, require_distinct
from measurements.run_up_rows import MAX_BYTES, MAX_ROWS, REQUIRED, quoted

MAX_COLUMNS = 1000
EXCEL = ZIP, OLD_EXCEL = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"


def read_excel(content: bytes, path: str, sheet: str, headings: Sequence[str], most_rows: int = MAX_ROWS) -> Sheet:
    """The table of a sheet.

    Raises `SettingError` if openpyxl is not installed, there are several sheets and none is named, or the headings are
    nowhere.
    """
    with _book(content, path) as book:
        return _table(book, path, _chosen(book, sheet, path, headings, guessed_columns), list(headings), most_rows)


def first_rows(content: bytes, path: str, sheet: str, guess: Guess) -> list[list[str]]:
    """The first rows of a sheet, in which headings are looked for.

    If several sheets are there and none is named, `guess`, a guess of the columns, suggests one in the question.
    """
    with _book(content, path) as book:
        return [_texts(cells) for _, cells in islice(_rows(book, _chosen(book, sheet, path, (), guess)), MOST_LINES)]


@contextlib.contextmanager
def _book(content: bytes, path: str) -> Iterator[Any]:
    """The open file. Whatever a damaged one makes openpyxl raise, also later, is a `SettingError`."""
    if not content.startswith(EXCEL):
        raise SettingError(
            f"{path}: expected an Excel file (.xlsx, .xls), got something else; name the format of the file"
        )
    try:
        book: Any = old_book(content, path) if content.startswith(OLD_EXCEL) else _new_book(content, path)
    except SettingError:
        raise
    except Exception as error:  # openpyxl and xlrd raise whatever a damaged file makes them meet
        raise _unreadable(path, error) from error
    try:
        yield book
    except SettingError:
        raise
    except Exception as error:
        raise _unreadable(path, error) from error
    finally:
        book.close()


def _new_book(content: bytes, path: str) -> Any:
    try:
        import openpyxl
    except ImportError as error:
        raise SettingError(
            f"{path}: Excel files are read by openpyxl, which is not installed; pip install 'ksmea-bench[formats]', or save it as"
            " CSV and give format=csv"
        ) from error
    _require_small(content, path)
    return openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)


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


def _chosen(book: Any, sheet: str, path: str, headings: Sequence[str], guess: Guess) -> str:
    names = list(book.sheetnames)
    if sheet:
        if sheet not in names:
            raise SettingError(f"{path}: {unknown('sheet', sheet, names)}")
        return sheet
    if len(names) != 1:
        raise _which_sheet(book, names, path, headings, guess)
    return names[0]


def _which_sheet(book: Any, names: list[str], path: str, headings: Sequence[str], guess: Guess) -> OpenQuestion:
    """The question which sheet is read.

    If just one looks like a table of vibration, it is suggested; otherwise the first of several lets the rest be asked.
    """
    fitting = [name for name in names if _fits(book, name, headings, guess)]
    said = f"{path}: expected one sheet, got {shortened(', '.join(names), 200)}; give sheet=NAME"
    if len(fitting) == 1:
        return OpenQuestion(
            f"{said}; its headings suggest {shortened(fitting[0])}, check it", "sheet", (fitting[0],), fitting[0]
        )
    if not fitting:
        return OpenQuestion(said, "sheet", ("SHEET",), None)
    return OpenQuestion(
        f"{said}; the other questions are about {shortened(fitting[0])}", "sheet", ("SHEET",), fitting[0]
    )


def _fits(book: Any, name: str, headings: Sequence[str], guess: Guess) -> bool:
    """Whether one of the first rows has the headings, or suggests what its columns hold."""
    wanted = _wanted(headings)
    for _, cells in islice(_rows(book, name), MOST_LINES):
        texts = _texts(cells)
        if wanted <= {text.lower() for text in texts} or (not headings and guess(texts)):
            return True
    return False


def _texts(cells: Sequence[Cell]) -> list[str]:
    return [str(cell).strip() for cell in cells]


def _wanted(headings: Sequence[str]) -> set[str]:
    return {each.lower() for each in headings if not each.startswith("#")} or set(REQUIRED)


def _rows(book: Any, sheet: str) -> Iterator[tuple[int, list[Cell]]]:
    """The rows of a sheet that are not empty, by number from 1; none of a sheet of charts."""
    iterate = getattr(book[sheet], "iter_rows", None)
    for number, values in enumerate(iterate(values_only=True, max_col=MAX_COLUMNS) if iterate else (), start=1):
        cells = [_cell(value) for value in values]
        if any(cell != "" for cell in cells):
            yield number, cells


def _table(book: Any, path: str, sheet: str, headings: list[str], most_rows: int) -> Sheet:
    rows: SheetRows | None = None
    seen: list[list[str]] = []
    wanted = _wanted(headings)
    where = f"{path} sheet {shortened(sheet)}"
    for number, cells in _rows(book, sheet):
        if rows is None:
            names = _texts(cells)
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

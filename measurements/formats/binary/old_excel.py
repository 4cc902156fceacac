"""Excel files before 2007 (.xls), by xlrd, as the book of sheets that `excel` reads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ksmea.errors import SettingError

INSTALL = "pip install 'ksmea-bench[formats]', or save it as .xlsx or CSV"


class OldBook:
    """The sheets of a file by name; values are numbers, texts and dates."""

    def __init__(self, book: Any) -> None:
        self._book = book
        self.sheetnames: list[str] = book.sheet_names()

    def __getitem__(self, name: str) -> OldSheet:
        return OldSheet(self._book.sheet_by_name(name), self._book.datemode)

    def close(self) -> None:
        self._book.release_resources()


class OldSheet:
    """The rows of one sheet."""

    def __init__(self, sheet: Any, datemode: int) -> None:
        self._sheet, self._datemode = sheet, datemode

    def iter_rows(self, *, values_only: bool, max_col: int) -> Iterator[list[Any]]:
        """The values of each row, up to a column."""
        assert values_only, "cells are values"
        for row in self._sheet.get_rows():
            yield [self._value(cell) for cell in row[:max_col]]

    def _value(self, cell: Any) -> Any:
        import xlrd

        if cell.ctype == xlrd.XL_CELL_DATE:
            return xlrd.xldate_as_datetime(cell.value, self._datemode)
        if cell.ctype in (xlrd.XL_CELL_EMPTY, xlrd.XL_CELL_BLANK, xlrd.XL_CELL_ERROR):
            return None
        return bool(cell.value) if cell.ctype == xlrd.XL_CELL_BOOLEAN else cell.value


def old_book(content: bytes, path: str) -> OldBook:
    """The open file.

    Raises `SettingError` if xlrd is not installed; whatever xlrd raises on a damaged one.
    """
    try:
        import xlrd
    except ImportError as error:
        raise SettingError(
            f"{path}: Excel files before 2007 are read by xlrd, which is not installed; {INSTALL}"
        ) from error
    try:
        # what it has to say of a damaged file goes nowhere
        return OldBook(xlrd.open_workbook(file_contents=content, logfile=_Nowhere()))
    except xlrd.XLRDError as error:
        if "Workbook" in str(error) or "ncrypted" in str(error):
            raise SettingError(
                f"{path}: expected an Excel file without password, got one that is encrypted or holds no sheets; save it without"
            ) from error
        raise


class _Nowhere:
    def write(self, text: str) -> int:
        return len(text)

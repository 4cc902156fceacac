"""Text files of instruments: their encodings, separators, decimal marks and numbers."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence

from ksmea.errors import SettingError
from measurements.run_up_rows import quoted

BYTE_ORDER_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
SEPARATORS = (";", "\t", "|", ",")
BLANKS = " "  # any number of blanks between two cells, which have none inside
POINT = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eEdD][-+]?[0-9]+)?", re.ASCII)
COMMA = re.compile(r"[-+]?([0-9]+,[0-9]*|,[0-9]+)([eE][-+]?[0-9]+)?", re.ASCII)
VALUE = re.compile(r"[-+.,]?[0-9][-+0-9.,:/TZEe ]*", re.ASCII)  # a number, a date or a clock time
MISSING = {"", "-", "--", "---", "n/a", "na", "nan", "null", "none", "invalid", "#n/a", "*", "inf", "-inf", "+inf"}
LONGEST_LINE = 100_000  # characters
HEAD = 100_000  # bytes, even for UTF-16: headings stand at the beginning


def text_of(content: bytes, path: str) -> str:
    """Content as text, by its byte order mark or a guess.

    The guess is UTF-16 if every other byte is 0, else UTF-8, else Windows-1252.
    """
    encodings = [name for mark, name in BYTE_ORDER_MARKS.items() if content.startswith(mark)]
    if not encodings:
        head = content[:1000]
        odd, even = head[1::2].count(0), head[::2].count(0)
        wide = max(odd, even) > len(head) // 4  # half of a Latin text in UTF-16 is 0
        encodings = ["utf-16-le" if odd >= even else "utf-16-be"] if wide else ["utf-8", "cp1252"]
    for encoding in encodings:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise SettingError(
        f"{path}: expected a text in UTF-8, UTF-16 or Windows-1252, got binary data; name the format of the file"
    )


def beginning_of(content: bytes, path: str) -> str:
    """First lines of a text, in which headings stand.

    They are also read from a file that is too long to be searched.
    """
    head = content[:HEAD]
    if len(content) > HEAD and 0 not in head:  # in UTF-16 every cut at an even place is one between characters
        head = head[: head.rfind(b"\n") + 1] or head
    return text_of(head, path)


def rows_of_cells(text: str, separator: str, path: str) -> Iterator[tuple[int, list[str]]]:
    """Number and stripped cells of each line that holds something."""
    for number, line in enumerate(io.StringIO(text, newline=None), start=1):
        if not line.strip(separator + " \t\n"):
            continue
        if len(line) > LONGEST_LINE:
            raise SettingError(f"{path} line {number}: expected cells of a table, got a line of {len(line)} characters")
        if separator == BLANKS:
            yield number, line.split()
            continue
        try:
            (cells,) = csv.reader([line.strip("\n")], delimiter=separator, strict=True)
        except (csv.Error, ValueError) as error:
            raise SettingError(f"{path} line {number}: expected cells of a table, got {quoted(error)}") from error
        yield number, [cell.strip() for cell in cells]


def is_data(cells: Sequence[str]) -> bool:
    """Whether a line holds values and no headings.

    Numbers, and nothing else but times and signs for a value that is missing.

    >>> is_data(["0.001", "-2,5"]), is_data(["12:00:01", "3", "n/a"]), is_data(["t", "KPH"]), is_data(["12 May", "rig"])
    (True, True, False, False)
    """
    has_number = any(POINT.fullmatch(cell) or COMMA.fullmatch(cell) for cell in cells)
    return has_number and all(cell.lower() in MISSING or VALUE.fullmatch(cell) for cell in cells)


def has_decimal_commas(cells: Sequence[str], where: str) -> bool:
    """Whether numbers are written with commas.

    `SettingError` if some are and some have points: one of them may be a mark of thousands.
    """
    comma = next((cell for cell in cells if COMMA.fullmatch(cell)), None)
    point = next((cell for cell in cells if "." in cell and POINT.fullmatch(cell)), None)
    if comma is not None and point is not None:
        raise SettingError(
            f"{where}: expected one decimal mark, got {quoted(comma)} and {quoted(point)}; write all numbers alike, without marks"
            " of thousands"
        )
    return comma is not None


def number(cell: str, where: str, *, decimal_comma: bool = False) -> float:
    """A cell as a number; NaN if it is marked as missing. `SettingError` if it is something else."""
    if cell.lower() in MISSING:
        return math.nan
    if decimal_comma and COMMA.fullmatch(cell):
        cell = cell.replace(",", ".")
    if not POINT.fullmatch(cell):
        raise SettingError(f"{where}: expected a number, got {quoted(cell)}; correct it, or remove the row")
    return float(cell.lower().replace("d", "e"))

"""MATLAB files up to version 7.

Each numeric variable is a column, of a matrix each column, of a structure each field.

A vector `n` is called n, the second column of a matrix `q` is q[2], a field is S.n. Cell arrays are columns, too: `c{2}` of vectors is
c[2], and a column below a text `rpm` is c.rpm. Tables, timetables, dates and strings are objects that MATLAB alone reads: a refusal
has the lines that make numbers of them.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatlabOpaque

from ksmea.errors import SettingError
from measurements.formats.sheet import Sheet, common_length
from measurements.run_up_rows import MAX_BYTES, quoted

HEADER = 128  # bytes; the last two say in which order those of a number stand
ENDIAN = {b"IM": "<", b"MI": ">"}
MATRIX, COMPRESSED = 14, 15
ELEMENTS = (MATRIX, COMPRESSED)  # what the file consists of
HDF5 = b"\x89HDF\r\n\x1a\n"
MAX_COLUMNS = 1000
MOST_UNPACKED = 8 * MAX_BYTES  # of all variables together
BLOCK = 2**20  # bytes that are unpacked at a time
DEEPEST = 3  # structures within each other
SAVE = "save('run.mat', '-struct', 's', '-v7')"
# What MATLAB alone reads, and the lines that make numbers of it there.
OPAQUE = {
    "table": f"the table {{name}}: s = table2struct({{name}}, 'ToScalar', true); {SAVE}",
    "timetable": "the timetable {name}: s = table2struct(timetable2table({name}), 'ToScalar', true); f = fieldnames(s);"
    f" t = s.(f{{{{1}}}}); s.(f{{{{1}}}}) = seconds(t - t(1)); {SAVE}",
    "datetime": "the dates {name}: {name} = seconds({name} - {name}(1))",
    "duration": "the durations {name}: {name} = seconds({name})",
    "string": "the strings {name}: {name} = double({name}) if they are numbers",
}
OTHER = "{name}, of the class {kind}: take out its numbers"
CELLS = (
    "the cell array {name} with no column of numbers: {name} = cell2mat({name}(2:end, :)), its rows without headings"
)


def read_mat(content: bytes, path: str, headings: Sequence[str]) -> Sheet:
    """The columns of a .mat file that are as long as the one that is named first, or as most are."""
    if HDF5 in content[:1024] or content[:20].startswith(b"MATLAB 7.3"):
        raise SettingError(
            f"{path}: expected a .mat file of version 7 or before, got 7.3; save it by save('run.mat', …, '-v7') in MATLAB"
        )
    _require_whole(content, path)
    file: Any = io.BytesIO(content)  # which loadmat takes, though its stubs do not say so
    try:
        variables: dict[str, Any] = loadmat(file, squeeze_me=False, verify_compressed_data_integrity=True)
    except NotImplementedError as error:
        raise SettingError(
            f"{path}: expected a .mat file of version 7 or before, got another; save it by save('run.mat', …, '-v7')"
        ) from error
    except MemoryError as error:
        raise SettingError(f"{path}: expected a .mat file, got one whose sizes make no sense; save it again") from error
    except Exception as error:  # whatever a damaged file makes scipy meet
        raise SettingError(
            f"{path}: expected a .mat file that can be read, got {quoted(error)}; save it again"
        ) from error
    columns: dict[str, np.ndarray] = {}
    n_number = 0
    for name, column in _columns(variables):
        if len(columns) == MAX_COLUMNS:
            raise SettingError(f"{path}: expected at most {MAX_COLUMNS} columns, got more; save what is needed alone")
        n_number += column.size
        if n_number > MOST_UNPACKED // 8:
            raise SettingError(
                f"{path}: expected at most {MOST_UNPACKED >> 20} MB of numbers, got more; save what is needed alone"
            )
        columns[name] = column if column.dtype.kind == "c" else column.astype(float)
    _require_read(_unread(variables), columns, headings, path)
    if not columns:
        raise SettingError(f"{path}: expected numeric variables, got none")
    length = common_length(columns, headings, path, "cut them in MATLAB")
    chosen: dict[str, Any] = {name: column for name, column in columns.items() if len(column) == length}
    return Sheet(path, range(1, length + 1), chosen, has_brackets_in_headings=False)


def _require_whole(content: bytes, path: str) -> None:
    """Refuse a version-5 file whose elements are cut or do not decompress.

    Loadmat of SciPy 1.17 crashes on a stream that ends early.

    An element has a tag of its type and its number of bytes, uint32 each (MathWorks, MAT-File Format, 2023).
    """
    order = ENDIAN.get(content[HEADER - 2 : HEADER])
    if order is None:  # version 4 has no such header
        return
    start, left = HEADER, MOST_UNPACKED
    while start + 8 <= len(content):
        kind, size = struct.unpack_from(f"{order}II", content, start)
        body = content[start + 8 : start + 8 + size]
        if kind not in ELEMENTS or len(body) < size:
            raise SettingError(
                f"{path}: expected a .mat file that can be read, got one that is cut or damaged; save it again"
            )
        if kind == COMPRESSED:
            left -= _unpacked_size(body, left, path)
        start += 8 + size


def _unpacked_size(body: bytes, most: int, path: str) -> int:
    """Bytes of a compressed variable, of which no more than a block is held at once.

    Raises `SettingError` if they are more than `most` or end early.
    """
    stream = zlib.decompressobj()
    size, pending = 0, body
    try:
        while not stream.eof and size <= most:
            unpacked = stream.decompress(pending, BLOCK)
            pending = stream.unconsumed_tail
            if not unpacked and not pending:
                break
            size += len(unpacked)
    except zlib.error as error:
        raise SettingError(
            f"{path}: expected a .mat file that can be read, got {quoted(error)}; save it again"
        ) from error
    if not stream.eof or size > most:
        got = "more" if size > most else "a variable that ends early"
        raise SettingError(
            f"{path}: expected whole variables of at most {MOST_UNPACKED >> 20} MB, got {got}; save what is needed again"
        )
    return size


def _columns(variables: dict[str, Any], prefix: str = "", depth: int = 1) -> Iterator[tuple[str, np.ndarray]]:
    for name, value in variables.items():
        if name.startswith("__") or not isinstance(value, np.ndarray) or isinstance(value, MatlabOpaque):
            continue
        if value.dtype.names and value.size == 1 and depth < DEEPEST:
            record = value.reshape(-1)[0]
            yield from _columns({each: record[each] for each in value.dtype.names}, f"{prefix}{name}.", depth + 1)
        elif value.dtype.kind in "iufc" and value.ndim == 2:
            yield from _of_matrix(f"{prefix}{name}", value)
        elif _is_cells(value):
            yield from _of_cells(f"{prefix}{name}", value)


def _of_matrix(name: str, matrix: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    if 1 in matrix.shape:
        yield name, matrix.reshape(-1)
    elif matrix.shape[1] <= MAX_COLUMNS:
        for column in range(matrix.shape[1]):
            yield f"{name}[{column + 1}]", matrix[:, column]


def _is_cells(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind == "O" and not value.dtype.names and value.ndim == 2


def _of_cells(name: str, cells: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """The columns of a cell array.

    Cells hold a vector each, or rows of numbers, headed by texts or not.
    """
    numbers = [_numbers(each) for each in cells.reshape(-1)]
    if 1 in cells.shape and all(each is not None and len(each) > 1 for each in numbers):
        yield from ((f"{name}[{at + 1}]", each) for at, each in enumerate(numbers) if each is not None)
        return
    texts = [_text(each) for each in cells[0]]
    has_head = len(cells) > 1 and all(texts)
    body = cells[1:] if has_head else cells
    for column in range(min(body.shape[1], MAX_COLUMNS)):
        values = [_numbers(each) for each in body[:, column]]
        if all(each is not None and len(each) == 1 for each in values):
            named = f"{name}.{texts[column]}" if has_head else f"{name}[{column + 1}]" if body.shape[1] > 1 else name
            yield named, np.concatenate([each for each in values if each is not None])


def _numbers(cell: Any) -> np.ndarray | None:
    """The numbers of a cell; None if it holds anything else."""
    array = np.asarray(cell)
    if array.dtype.kind not in "iufc" or not array.size or max(array.shape) != array.size:
        return None
    return np.asarray(array.reshape(-1) if array.dtype.kind == "c" else array.reshape(-1).astype(float))


def _text(cell: Any) -> str:
    array = np.asarray(cell)
    return str(array.reshape(-1)[0]).strip() if array.dtype.kind == "U" and array.size == 1 else ""


def _unread(variables: dict[str, Any]) -> dict[str, str]:
    """Variables that no program but MATLAB reads, and cell arrays without numbers.

    Each has the words to type there before saving it.
    """
    found = {}
    for name, value in variables.items():
        if isinstance(value, MatlabOpaque):
            record = value.reshape(-1)[0]
            own, kind = (_decoded(record[key]) for key in ("s0", "s2"))
            found[own or name] = OPAQUE.get(kind, OTHER).format(name=own or name, kind=kind or "object")
        elif _is_cells(value) and not any(True for _ in _of_cells(name, value)):
            found[name] = CELLS.format(name=name)
    return found


def _decoded(text: Any) -> str:
    return text.decode("latin-1") if isinstance(text, bytes) else str(text)


def _require_read(unread: dict[str, str], columns: dict[str, np.ndarray], headings: Sequence[str], path: str) -> None:
    """Raise `SettingError` if a column is of an unreadable variable, or nothing else is there."""
    for name, cure in unread.items():
        if not columns or any(heading == name or heading.startswith((f"{name}.", f"{name}[")) for heading in headings):
            raise SettingError(f"{path}: expected numeric variables, got {cure}; save it as numbers, in MATLAB")

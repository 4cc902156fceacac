"""MATLAB files up to version 7: each numeric variable is a column, of a matrix each column, of a structure each field.

A vector `n` is called n, the second column of a matrix `q` is q[2], a field is S.n.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.io import loadmat

from ksmea.errors import SettingError, shortened
from measurements.formats.sheet import Sheet
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
    if not columns:
        raise SettingError(f"{path}: expected numeric variables, got none")
    length = _length(columns, headings, path)
    chosen: dict[str, Any] = {name: column for name, column in columns.items() if len(column) == length}
    return Sheet(path, range(1, length + 1), chosen, has_units_in_headings=False)


def _require_whole(content: bytes, path: str) -> None:
    """Refuse a version-5 file whose elements are cut or do not decompress: loadmat of SciPy 1.17 crashes on a stream that ends early.

    An element has a tag of its type and its number of bytes, uint32 each (MathWorks, MAT-File Format, 2023)."""
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
    """Bytes of a compressed variable, of which no more than a block is held at once; `SettingError` if they are more than `most` or end
    early."""
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


def _length(columns: dict[str, np.ndarray], headings: Sequence[str], path: str) -> int:
    """The common length of the columns that are named."""
    for heading in headings:
        if heading not in columns:
            continue
        for other in headings:
            if other in columns and len(columns[other]) != len(columns[heading]):
                raise SettingError(
                    f"{path}: expected columns of one length, got {len(columns[heading])} in {shortened(heading)} and"
                    f" {len(columns[other])} in {shortened(other)}; cut them in MATLAB"
                )
        return len(columns[heading])
    lengths = [len(column) for column in columns.values()]
    return max(set(lengths), key=lambda each: (lengths.count(each), each))


def _columns(variables: dict[str, Any], prefix: str = "", depth: int = 1) -> Iterator[tuple[str, np.ndarray]]:
    for name, value in variables.items():
        if name.startswith("__") or not isinstance(value, np.ndarray):
            continue
        if value.dtype.names and value.size == 1 and depth < DEEPEST:
            record = value.reshape(-1)[0]
            yield from _columns({each: record[each] for each in value.dtype.names}, f"{prefix}{name}.", depth + 1)
        elif value.dtype.kind in "iufc" and value.ndim == 2:
            if 1 in value.shape:
                yield f"{prefix}{name}", value.reshape(-1)
            elif value.shape[1] <= MAX_COLUMNS:
                for column in range(value.shape[1]):
                    yield f"{prefix}{name}[{column + 1}]", value[:, column]

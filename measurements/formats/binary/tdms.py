"""TDMS files of LabVIEW and its kin, by npTDMS: each channel is a column.

A channel is called by its name, or GROUP/CHANNEL if several groups have it. Its unit is its property `unit_string`. Waveform channels
state their step `wf_increment`, from which the column `time` is made (s), unless the file has one.
"""

from __future__ import annotations

import contextlib
import io
import logging
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ksmea.errors import SettingError, shortened, visible
from measurements.formats.sheet import Sheet, common_length
from measurements.run_up_rows import quoted

MAGIC = b"TDSm"
TIME = "time"
MAX_COLUMNS = 1000


def read_tdms(content: bytes, path: str, headings: Sequence[str]) -> Sheet:
    """The channels of a file that are as long as the one that is named first, or as most are."""
    if not content.startswith(MAGIC):
        raise SettingError(f"{path}: expected a TDMS file, got something else; name the format of the file")
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise SettingError(
            f"{path}: TDMS files are read by npTDMS, which is not installed; pip install 'ksmea-bench[formats]', or save it as CSV"
        ) from error
    try:
        with io.BytesIO(content) as stream, _without_warnings():
            file = TdmsFile.read(stream)
            channels: list[Any] = [each for group in file.groups() for each in group.channels()]
            values = {id(each): each[:] for each in channels}
    except Exception as error:  # whatever a damaged file makes npTDMS meet
        raise SettingError(
            f"{path}: expected a TDMS file that can be read, got {quoted(error)}; save it again"
        ) from error
    if file.file_status.incomplete_final_segment:
        raise SettingError(f"{path}: expected a whole TDMS file, got one whose last segment ends early; save it again")
    filled = [each for each in channels if len(values[id(each)])]
    if not filled or len(filled) > MAX_COLUMNS:
        raise SettingError(
            f"{path}: expected 1 to {MAX_COLUMNS} channels with values, got {len(filled)}; save what is needed alone"
        )
    count = Counter(each.name for each in filled)
    names = [visible(each.name if count[each.name] == 1 else f"{each.group_name}/{each.name}") for each in filled]
    columns = {name: _column(values[id(each)]) for name, each in zip(names, filled)}
    length = common_length(columns, headings, path, "save channels of one length")
    chosen: dict[str, Any] = {name: column for name, column in columns.items() if len(column) == length}
    units = {
        name: str(each.properties.get("unit_string", "")).strip() for name, each in zip(names, filled) if name in chosen
    }
    steps = {float(each.properties.get("wf_increment", 0)) for name, each in zip(names, filled) if name in chosen}
    if TIME not in chosen and len(steps) == 1 and (step := steps.pop()) > 0:
        chosen[TIME] = step * np.arange(length)
    elif len(steps) > 1 and TIME in headings and TIME not in chosen:
        raise SettingError(
            f"{path}: expected channels that were sampled together, got steps of {shortened(', '.join(f'{s:g}' for s in sorted(steps)))}"
            " s; save one rate alone, or name the channel of the time"
        )
    return Sheet(path, range(1, length + 1), chosen, {name: unit for name, unit in units.items() if unit})


@contextlib.contextmanager
def _without_warnings() -> Iterator[None]:
    """npTDMS without its lines on the terminal, of a file that is damaged: an error says that."""
    from nptdms.log import log_manager

    before = log_manager.log_level
    log_manager.set_level(logging.CRITICAL)
    try:
        yield
    finally:
        log_manager.set_level(before)


def _column(values: Any) -> Any:
    """Numbers as floats, time stamps as seconds from the first, texts as they are."""
    array = np.asarray(values)
    if array.dtype.kind == "M":
        return (array - array[0]) / np.timedelta64(1, "ns") * 1e-9
    if array.dtype.kind in "iufb":
        return array.astype(float)
    return array.astype(complex) if array.dtype.kind == "c" else [str(each) for each in array]

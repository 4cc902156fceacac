"""The format that a file seems to have, by its headings or else by its name: a proposal to be checked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from ksmea.errors import SettingError
from ksmea.units import TURN
from measurements.formats.adre import is_adre
from measurements.formats.binary.mat import read_mat
from measurements.formats.binary.tdms import read_tdms
from measurements.formats.column_guess import guessed_unmarked, guessed_waveforms
from measurements.formats.sheet import MOST_LINES, Sheet
from measurements.formats.system1 import is_system1
from measurements.formats.texts import SEPARATORS, beginning_of, rows_of_cells
from measurements.formats.unit_texts import SPEED_UNITS, TIMES, seconds_per, speed_unit, unit_in_heading
from measurements.formats.user_answers import OWN
from measurements.run_up_rows import REQUIRED

ENDINGS = {
    ".csv": "csv",
    ".txt": "csv",
    ".xlsx": "excel",
    ".xls": "excel",
    ".tdms": "tdms",
    ".mat": "mat",
    ".uff": "uff",
    ".unv": "uff",
}
CHANNELS = {"tdms": read_tdms, "mat": read_mat}
MOST_OF_A_TURN = 0.25  # from one sample to the next
LONGEST_STEP = 0.025  # s from one sample to the next: a quarter of a turn at 600 rpm
BY_HEADINGS, BY_NAME = "its headings suggest", "its name suggests"


class Suggested(NamedTuple):
    """A format, and the words that say why."""

    name: str
    because: str


def suggested_format(path: str, content: bytes) -> Suggested | None:
    """None if neither headings nor name suggest any."""
    try:
        text = beginning_of(content, path)
    except SettingError:  # no text
        text = ""
    if is_adre(text):
        return Suggested("adre", BY_HEADINGS)
    if is_system1(text):
        return Suggested("system1", BY_HEADINGS)
    if _is_own(text):
        return Suggested(OWN, BY_HEADINGS)
    if _is_waveform(text):
        return Suggested("waveform", BY_HEADINGS)
    likely = ENDINGS.get(Path(path).suffix.lower())
    if (
        _is_sampled(text, path)
        or _is_timed(text, path)
        or (likely in CHANNELS and _has_keyphasor(path, content, CHANNELS[likely]))
    ):
        return Suggested("waveform", BY_HEADINGS)
    return None if likely is None else Suggested(likely, BY_NAME)


def _is_waveform(text: str) -> bool:
    """Whether one of the first lines names a keyphasor together with other columns."""
    lines = [line for line in text.splitlines()[:MOST_LINES] if not line.startswith("#")]
    return any(
        guessed_waveforms([cell.strip(' "') for cell in line.split(separator)])
        for line in lines
        for separator in SEPARATORS
        if separator in line
    )


def _has_keyphasor(path: str, content: bytes, read: Callable[[bytes, str, Sequence[str]], Sheet]) -> bool:
    """Whether the variables of a file that a library reads are a keyphasor and waveforms."""
    try:
        return bool(guessed_waveforms(list(read(content, path, ()).columns)))
    except SettingError:  # which reading it says
        return False


def _is_sampled(text: str, path: str) -> bool:
    """Whether rows with a time and a speed are samples of a turn, and not vectors of many turns.

    Several within a turn.
    """
    for separator in SEPARATORS:
        rows = (cells for _, cells in islice(rows_of_cells(text, separator, path), MOST_LINES) if len(cells) > 2)
        columns: dict[str, str] = {}
        names: list[str] = []
        turns = []
        try:
            for cells in rows:
                if columns:
                    at = dict(zip(names, (cell.replace(",", ".") for cell in cells)))
                    speed = (
                        float(at[columns["speed"]])
                        * SPEED_UNITS[speed_unit(unit_in_heading(columns["speed"])) or "rpm"]
                    )
                    turns.append(
                        (float(at[columns["time"]]) * seconds_per(_time_unit(columns["time"]), path), speed / TURN)
                    )
                elif any(each.startswith("speed=") for each in guessed_unmarked(cells)):
                    columns = dict(each.split("=", 1) for each in guessed_unmarked(cells))
                    names = cells
        except (ValueError, KeyError):  # SettingError too
            continue
        if len(turns) > 2 and abs(turns[-1][0] - turns[0][0]) * turns[0][1] < MOST_OF_A_TURN * (len(turns) - 1):
            return True
    return False


def _is_timed(text: str, path: str) -> bool:
    """Whether rows are samples by their times alone: next to signals there is neither a speed nor a phase."""
    for separator in SEPARATORS:
        rows = (cells for _, cells in islice(rows_of_cells(text, separator, path), MOST_LINES) if len(cells) > 1)
        heading, at, times = "", 0, []
        try:
            for cells in rows:
                if heading:
                    times.append(float(cells[at].replace(",", ".")) * seconds_per(_time_unit(heading), path))
                elif (columns := guessed_unmarked(cells)) and not any(each.startswith("speed=") for each in columns):
                    heading = columns[0].removeprefix("time=")
                    at = cells.index(heading)
        except (ValueError, IndexError):  # SettingError too
            continue
        if len(times) > 2 and 0 < (times[-1] - times[0]) / (len(times) - 1) < LONGEST_STEP:
            return True
    return False


def _time_unit(heading: str) -> str:
    unit = unit_in_heading(heading)
    return unit if unit.lower() in TIMES else ""


def _is_own(text: str) -> bool:
    lines = (line.strip() for line in text.splitlines())
    first = next((line for line in lines if line and not line.startswith("#")), "")
    return set(REQUIRED) <= {cell.strip() for cell in first.split(",")}

"""The format that a file seems to have, by its headings or else by its name: a proposal to be checked."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ksmea.errors import SettingError
from measurements.formats.adre import is_adre
from measurements.formats.column_guess import guessed_waveforms
from measurements.formats.sheet import MOST_LINES
from measurements.formats.system1 import is_system1
from measurements.formats.texts import SEPARATORS, beginning_of
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
BY_HEADINGS, BY_NAME = "its headings suggest", "its name suggests"


class Suggested(NamedTuple):
    """A format, and the words that say why."""

    name: str
    because: str


def suggested_format(path: str, content: bytes) -> Suggested | None:
    """None where neither headings nor name suggest any."""
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
    return None if likely is None else Suggested(likely, BY_NAME)


def _is_waveform(text: str) -> bool:
    """Whether one of the first lines names a keyphasor beside other columns."""
    lines = [line for line in text.splitlines()[:MOST_LINES] if not line.startswith("#")]
    return any(
        guessed_waveforms([cell.strip(' "') for cell in line.split(separator)])
        for line in lines
        for separator in SEPARATORS
        if separator in line
    )


def _is_own(text: str) -> bool:
    lines = (line.strip() for line in text.splitlines())
    first = next((line for line in lines if line and not line.startswith("#")), "")
    return set(REQUIRED) <= {cell.strip() for cell in first.split(",")}

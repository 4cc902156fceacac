"""Raw waveforms beside a keyphasor, from a text table, an Excel or .mat file or a universal file, by `columns`:

    columns=[time=t,keyphasor=KPH,signal.1X=probe A,signal.1Y=probe B]

Without `time` the `sampling` rate is needed. Vectors are those of `order_tracking`: zero to peak, a phase that leads.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, shortened, unknown
from ksmea.units import RPM
from measurements.formats.column_guess import columns_question, guessed_waveforms
from measurements.formats.curve import Curve
from measurements.formats.excel import ZIP, first_rows, read_excel
from measurements.formats.lazy_file import Opened
from measurements.formats.mat import HDF5, read_mat
from measurements.formats.questions import OpenQuestion
from measurements.formats.sheet import Sheet, first_cells, read_delimited
from measurements.formats.texts import beginning_of
from measurements.formats.uff import waveforms_of_uff
from measurements.formats.user_answers import Answers
from measurements.formats.waveforms.clock import clock_of
from measurements.formats.waveforms.keyphasor import mark_of
from measurements.formats.waveforms.order_tracking import Tracked, tracked

TIME, KEYPHASOR, SIGNAL = "time", "keyphasor", "signal"
MOST_BYTES = 256 * 2**20  # of a file: five million samples of four channels in text
MAX_SAMPLES = 5_000_000  # rows of a text or an Excel sheet
ANY_RATE = 1000.0  # Hz, with which the rest of a file can be looked at
PLACEHOLDERS = ("time=HEADING", "keyphasor=HEADING", "signal.NAME=HEADING")
UNIVERSAL = re.compile(rb"^ *-1 *\r?\n", re.MULTILINE)


def read_waveform(opened: Opened, answers: Answers) -> list[Curve]:
    """The probes of a file with waveforms, each at each harmonic that is asked for."""
    if answers.phase in ("lag", "lead"):
        raise SettingError(
            f"phase: expected none with format=waveform, whose phases are computed here, got {answers.phase}"
        )
    if not answers.columns:
        raise _which_columns(opened.content(MOST_BYTES), answers)
    columns = _columns(answers.columns)
    headings = tuple(columns.values())
    sheet = opened.once(
        "sheet", ("waveform", answers.sheet, *headings), lambda: _sheet(opened.content(MOST_BYTES), answers, headings)
    )
    return opened.once(
        "tracked",
        (
            tuple(answers.columns),
            answers.sheet,
            answers.sampling,
            tuple(answers.harmonics),
            answers.revolutions,
            answers.keyphasor_edge,
        ),
        lambda: _tracked(sheet, columns, answers),
    )


def _tracked(sheet: Sheet, columns: dict[str, str], answers: Answers) -> list[Curve]:
    time, remark = _time(sheet, columns.get(TIME), answers)
    names = [role.removeprefix(f"{SIGNAL}.") for role in columns if role.startswith(f"{SIGNAL}.")]
    headings = [columns[f"{SIGNAL}.{name}"] for name in names]
    signals = np.stack([_complete(sheet, heading) for heading in headings], axis=1)
    mark = mark_of(time, _complete(sheet, columns[KEYPHASOR]), answers.keyphasor_edge)
    found = tracked(time, signals, mark.time, tuple(answers.harmonics), answers.revolutions)
    units = {name: sheet.unit(heading) for name, heading in zip(names, headings)}
    return _curves(found, sheet, units, answers.harmonics, tuple(filter(None, (remark, mark.remark, _gaps(found)))))


def _gaps(found: Tracked) -> str:
    return (
        f"{found.n_gap} of {found.n_gap + len(found.time)} windows left out: samples are missing in them"
        if found.n_gap
        else ""
    )


def _which_columns(content: bytes, answers: Answers) -> OpenQuestion:
    """The question which columns are what, as far as the file tells their headings."""
    said = f"{answers.path}: expected to be told which column is the keyphasor and which are waveforms, got nothing; give columns"
    said += "=[time=heading,keyphasor=heading,signal.NAME=heading,…] (without time where a sampling rate is given)"
    path = answers.path
    lines: Iterable[Sequence[str]]
    if content.startswith(ZIP):
        lines = first_rows(content, path, answers.sheet, guessed_waveforms)
    elif content.startswith(b"MATLAB") or HDF5 in content[:1024]:
        lines = [list(read_mat(content, path, ()).columns)]
    elif UNIVERSAL.match(content):
        lines = [list(waveforms_of_uff(content, path).columns)]
    else:
        lines = first_cells(beginning_of(content, path), path)
    return columns_question(said, lines, guessed_waveforms, PLACEHOLDERS)


def _columns(texts: Sequence[str]) -> dict[str, str]:
    """Headings by role."""
    found: dict[str, str] = {}
    for text in texts:
        role, separator, heading = text.partition("=")
        role = role.strip()
        if not separator or not heading.strip():
            raise SettingError(f"columns: expected role=heading, such as keyphasor=KPH, got {shortened(repr(text))}")
        if role not in (TIME, KEYPHASOR) and not re.fullmatch(rf"{SIGNAL}\.\S.*", role):
            raise unknown("role in columns:", role, (TIME, KEYPHASOR, f"{SIGNAL}.NAME"))
        if role in found:
            raise SettingError(f"columns: expected each role once, got {shortened(role)} twice; remove one")
        found[role] = heading.strip()
    if KEYPHASOR not in found or not any(role.startswith(SIGNAL) for role in found):
        raise SettingError(
            "columns: expected keyphasor=HEADING and signal.NAME=HEADING with format=waveform, got"
            f" {', '.join(found) or 'none'}; add them"
        )
    return found


def _sheet(content: bytes, answers: Answers, headings: Sequence[str]) -> Sheet:
    """The columns of whatever file it is, by how that begins."""
    path = answers.path
    if content.startswith(ZIP):
        return read_excel(content, path, answers.sheet, headings, MAX_SAMPLES)
    if content.startswith(b"MATLAB") or HDF5 in content[:1024]:
        return read_mat(content, path, headings)
    if UNIVERSAL.match(content):
        return waveforms_of_uff(content, path)
    return _fast(content, path, headings) or read_delimited(content, path, headings, MAX_SAMPLES)


def _fast(content: bytes, path: str, headings: Sequence[str]) -> Sheet | None:
    """A plain text of numbers below one line of headings in UTF-8, which most long records are; None where it is anything
    else, which is read cell by cell."""
    head, _, body = content.partition(b"\n")
    for separator in (",", "\t", ";"):
        names = [name.strip() for name in head.decode("utf-8-sig", "replace").strip().split(separator)]
        if len(names) > 1 and set(headings) <= set(names) and len(set(names)) == len(names) and b'"' not in head:
            try:
                with io.BytesIO(body) as text:
                    values = np.loadtxt(text, delimiter=separator, ndmin=2, comments=None)
            except ValueError:
                return None
            if values.shape[1] != len(names) or not np.all(np.isfinite(values)) or len(values) > MAX_SAMPLES:
                return None
            return Sheet(path, range(2, len(values) + 2), {name: values[:, at] for at, name in enumerate(names)})
    return None


def _time(sheet: Sheet, heading: str | None, answers: Answers) -> tuple[Array, str]:
    """When each sample was taken, s, and a remark on that if their steps are uneven."""
    if heading is None:
        if TIME in sheet.columns and isinstance(sheet.columns[TIME], np.ndarray) and answers.sampling is None:
            heading = TIME  # a universal file's own
        elif answers.sampling is None:
            raise OpenQuestion(
                f"{sheet.where}: expected a column of time or a sampling rate, got none; give sampling=Hz",
                "sampling",
                ("HZ",),
                ANY_RATE,
            )
        else:
            return np.arange(len(sheet.lines)) / answers.sampling, ""
    if answers.sampling is not None:
        raise SettingError("sampling: expected none with a column of time, got both; leave one out")
    return clock_of(sheet, heading)


def _complete(sheet: Sheet, heading: str) -> Array:
    values = sheet.numbers(heading)
    if np.any(bad := ~np.isfinite(values)):
        first = int(np.flatnonzero(bad)[0])
        raise SettingError(
            f"{sheet.where} line {sheet.lines[first]}: expected a number in {shortened(heading)}, got none; cut the record there"
        )
    return values


def _curves(
    found: Tracked, sheet: Sheet, units: dict[str, str], harmonics: Sequence[float], notes: tuple[str, ...]
) -> list[Curve]:
    """The vectors of each signal (its unit by its name) at each harmonic."""
    return [
        Curve(
            name,
            "",
            [int(sheet.lines[first]) for first in found.first],
            found.speed / RPM,
            np.abs(found.values[:, number, order]),
            phase=np.angle(found.values[:, number, order], deg=True),
            sigma=None if found.sigma is None else found.sigma[:, number, order],
            time=found.time,
            speed_unit="rpm",
            unit=f"{unit} 0pk".strip(),
            sense="lead",
            harmonic=harmonic,
            notes=notes,
        )
        for number, (name, unit) in enumerate(units.items())
        for order, harmonic in enumerate(harmonics)
    ]

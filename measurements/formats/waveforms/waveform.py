"""Raw waveforms with a keyphasor or without, by `columns`.

They come from a text table, an Excel or .mat file or a universal file:

    columns=[time=t,keyphasor=KPH,signal.1X=probe A,signal.1Y=probe B]

Without `time` the `sampling` rate is needed. `order_tracking` makes the vectors: zero to peak, a phase that leads.
Without a keyphasor the speed comes from a column (`speed=n`), `constant_speed`, or the strongest vibration in
`speed_band`; then there are amplitudes alone.
"""

from __future__ import annotations

import dataclasses
import io
import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, shortened, unknown
from ksmea.units import RPM
from measurements.formats.binary.excel import EXCEL, first_rows, read_excel
from measurements.formats.binary.mat import HDF5, read_mat
from measurements.formats.binary.tdms import MAGIC, read_tdms
from measurements.formats.binary.uff import waveforms_of_uff
from measurements.formats.column_guess import columns_question, guessed_unmarked, guessed_waveforms
from measurements.formats.curve import Curve
from measurements.formats.lazy_file import Opened
from measurements.formats.questions import OpenQuestion
from measurements.formats.sheet import Sheet, first_cells, has_no_headings, read_delimited
from measurements.formats.texts import beginning_of, is_data
from measurements.formats.unit_texts import SPEED_UNITS, speed_unit
from measurements.formats.user_answers import Answers
from measurements.formats.waveforms.clock import clock_of
from measurements.formats.waveforms.keyphasor import mark_of
from measurements.formats.waveforms.order_tracking import Tracked, tracked
from measurements.formats.waveforms.steady import MEAN, mean_of, without_phases
from measurements.formats.waveforms.unmarked import speed_in_vibration, turns_at

TIME, KEYPHASOR, SPEED, SIGNAL = "time", "keyphasor", "speed", "signal"
MOST_BYTES = 256 * 2**20  # of a file: five million samples of four channels in text
MAX_SAMPLES = 5_000_000  # rows of a text or an Excel sheet
ANY_RATE = 1000.0  # Hz, with which the rest of a file can be looked at
PLACEHOLDERS = ("time=HEADING", "keyphasor=HEADING", "signal.NAME=HEADING")
UNIVERSAL = re.compile(rb"^ *-1 *\r?\n", re.MULTILINE)


def read_waveform(opened: Opened, answers: Answers) -> list[Curve]:
    """The probes of a file with waveforms, each at each harmonic in the settings."""
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
            answers.constant_speed,
            tuple(answers.speed_band),
            answers.speed_unit,
            answers.vectors,
        ),
        lambda: _tracked(sheet, columns, answers),
    )


def _tracked(sheet: Sheet, columns: dict[str, str], answers: Answers) -> list[Curve]:
    time, clock = _time(sheet, columns.get(TIME), answers)
    names = [role.removeprefix(f"{SIGNAL}.") for role in columns if role.startswith(f"{SIGNAL}.")]
    headings = [columns[f"{SIGNAL}.{name}"] for name in names]
    signals = np.stack([_complete(sheet, heading) for heading in headings], axis=1)
    turns, remark = _turns(sheet, columns, time, signals, answers)
    found = tracked(time, signals, turns, tuple(answers.harmonics), answers.revolutions)
    notes = [clock, remark, _gaps(found)]
    has_phase = KEYPHASOR in columns
    if not has_phase:
        found = without_phases(found)
    if answers.vectors == MEAN:
        notes.append(
            f"mean of {len(found.time)} windows of {answers.revolutions} turns, with its standard error as noise"
        )
        found = mean_of(found, sheet.where)
    units = {name: sheet.unit(heading) for name, heading in zip(names, headings)}
    curves = _curves(found, sheet, units, answers.harmonics, has_phase=has_phase)
    own: dict[str, Any] = {"notes": tuple(filter(None, notes))}
    if SPEED in columns and answers.speed_unit:  # that of the column is the unit of its curves, too
        own |= {"speed_unit": answers.speed_unit, "speed": found.speed / SPEED_UNITS[answers.speed_unit]}
    return [dataclasses.replace(each, **own) for each in curves]


def _turns(sheet: Sheet, columns: dict[str, str], time: Array, signals: Array, answers: Answers) -> tuple[Array, str]:
    """Times (n_turn + 1,) s at which turns begin, and how they are known."""
    given = [name for name in (KEYPHASOR, SPEED) if name in columns]
    given += [name for name in ("constant_speed", "speed_band") if getattr(answers, name)]
    if len(given) > 1:
        raise SettingError(
            f"columns: expected one of a keyphasor and a speed, got {', '.join(given)}; leave all but one out"
        )
    if columns.get(KEYPHASOR):
        mark = mark_of(time, _complete(sheet, columns[KEYPHASOR]), answers.keyphasor_edge)
        return mark.time, mark.remark
    if answers.harmonics != [1.0]:
        raise SettingError(
            f"harmonics: expected 1 alone without a keyphasor, got {answers.harmonics}; harmonics need phases"
        )
    if SPEED in columns:
        unit = _unit_of_speed(sheet, columns[SPEED], answers)
        speed = _complete(sheet, columns[SPEED]) * SPEED_UNITS[unit]
        return turns_at(time, speed, sheet.where), f"no keyphasor: speed from {shortened(columns[SPEED])} in {unit}"
    if answers.constant_speed is not None:
        speed = np.full(len(time), answers.constant_speed * RPM)
        return turns_at(time, speed, sheet.where), f"no keyphasor: {answers.constant_speed:g} rpm throughout"
    if answers.speed_band:
        low, high = answers.speed_band
        speed = speed_in_vibration(time, signals, low * RPM, high * RPM)
        remark = (
            f"no keyphasor: speed of the strongest vibration from {low:g} to {high:g} rpm, {np.min(speed) / RPM:.5g} to"
        )
        return turns_at(time, speed, sheet.where), f"{remark} {np.max(speed) / RPM:.5g} rpm"
    raise SettingError(
        f"{sheet.where}: expected a keyphasor, or how the speed is known without one, got neither; give columns=[keyphasor=heading],"
        " columns=[speed=heading], constant_speed=RPM or speed_band=[LOWEST,HIGHEST]; all but the first give amplitudes alone"
    )


def _unit_of_speed(sheet: Sheet, heading: str, answers: Answers) -> str:
    said = speed_unit(sheet.unit(heading))
    if said and answers.speed_unit and said != answers.speed_unit:
        raise SettingError(
            f"{sheet.where}: expected speed_unit={said}, which {shortened(heading)} says, got {answers.speed_unit}; leave it out"
        )
    if not said and not answers.speed_unit:
        raise OpenQuestion(
            f"{sheet.where}: the file does not say what speed_unit {shortened(heading)} has; give speed_unit=rpm, Hz or rad/s",
            "speed_unit",
            ("RPM_HZ_OR_RAD/S",),
            "rpm",
        )
    return said or str(answers.speed_unit)


def _gaps(found: Tracked) -> str:
    return (
        f"{found.n_gap} of {found.n_gap + len(found.time)} windows left out: samples are missing in them"
        if found.n_gap
        else ""
    )


def _which_columns(content: bytes, answers: Answers) -> OpenQuestion:
    """The question which columns are what, as far as the file tells their headings."""
    said = f"{answers.path}: expected the columns of keyphasor and waveforms, got nothing; give columns"
    said += "=[time=heading,keyphasor=heading,signal.NAME=heading,…] (without time if a sampling rate is given; with speed=heading or none"
    said += " of the two if there is no keyphasor)"
    path = answers.path
    lines: Iterable[Sequence[str]]
    if content.startswith(EXCEL):
        lines = first_rows(content, path, answers.sheet, guessed_waveforms)
    elif content.startswith(b"MATLAB") or HDF5 in content[:1024]:
        lines = [list(read_mat(content, path, ()).columns)]
    elif UNIVERSAL.match(content):
        lines = [list(waveforms_of_uff(content, path).columns)]
    elif content.startswith(MAGIC):
        lines = [list(read_tdms(content, path, ()).columns)]
    else:
        text = beginning_of(content, path)
        if has_no_headings(text, path):
            raise columns_question(said, (), placeholders=PLACEHOLDERS, is_plain=True)
        lines = first_cells(text, path)
    lines = list(lines)
    has_mark = any(map(guessed_waveforms, lines))
    return columns_question(said, lines, guessed_waveforms if has_mark else guessed_unmarked, PLACEHOLDERS)


def _columns(texts: Sequence[str]) -> dict[str, str]:
    """Headings by role."""
    found: dict[str, str] = {}
    for text in texts:
        role, separator, heading = text.partition("=")
        role = role.strip()
        if not separator or not heading.strip():
            raise SettingError(f"columns: expected role=heading, such as keyphasor=KPH, got {shortened(repr(text))}")
        if role not in (TIME, KEYPHASOR, SPEED) and not re.fullmatch(rf"{SIGNAL}\.\S.*", role):
            raise unknown("role in columns:", role, (TIME, KEYPHASOR, SPEED, f"{SIGNAL}.NAME"))
        if role in found:
            raise SettingError(f"columns: expected each role once, got {shortened(role)} twice; remove one")
        found[role] = heading.strip()
    if not any(role.startswith(SIGNAL) for role in found):
        raise SettingError(
            "columns: expected signal.NAME=HEADING with format=waveform, and keyphasor=HEADING if there is one, got"
            f" {', '.join(found) or 'none'}; add them"
        )
    return found


def _sheet(content: bytes, answers: Answers, headings: Sequence[str]) -> Sheet:
    """The columns of whatever file it is, by how that begins."""
    path = answers.path
    if content.startswith(EXCEL):
        return read_excel(content, path, answers.sheet, headings, MAX_SAMPLES)
    if content.startswith(b"MATLAB") or HDF5 in content[:1024]:
        return read_mat(content, path, headings)
    if UNIVERSAL.match(content):
        return waveforms_of_uff(content, path)
    if content.startswith(MAGIC):
        return read_tdms(content, path, headings)
    return _fast(content, path, headings) or read_delimited(content, path, headings, MAX_SAMPLES)


def _fast(content: bytes, path: str, headings: Sequence[str]) -> Sheet | None:
    """A plain text of numbers below one line of headings in UTF-8, which most long records are.

    None if it is anything else, which is read cell by cell.
    """
    head, _, body = content.partition(b"\n")
    if all(each.startswith("#") for each in headings):
        return _plain(content, path)
    for separator in (",", "\t", ";"):
        names = [name.strip() for name in head.decode("utf-8-sig", "replace").strip().split(separator)]
        if len(names) > 1 and set(headings) <= set(names) and len(set(names)) == len(names) and b'"' not in head:
            if (values := _numbers(body, separator, len(names))) is None:
                return None
            return Sheet(path, range(2, len(values) + 2), {name: values[:, at] for at, name in enumerate(names)})
    return None


def _plain(content: bytes, path: str) -> Sheet | None:
    """A text of numbers alone, without headings; None if it is anything else."""
    first = content.partition(b"\n")[0].decode("utf-8-sig", "replace").strip()
    for separator in (",", "\t", ";", None):
        n = len(first.split(separator))
        if n > 1 and is_data([cell.strip() for cell in first.split(separator)]):
            if (values := _numbers(content, separator, n)) is None:
                return None
            return Sheet(path, range(1, len(values) + 1), {f"#{at + 1}": values[:, at] for at in range(n)})
    return None


def _numbers(content: bytes, separator: str | None, n: int) -> Array | None:
    """The numbers (n_row, n) of a text.

    None if it holds anything else, or more rows than a sheet may have.
    """
    try:
        with io.BytesIO(content) as text:
            values = np.loadtxt(text, delimiter=separator, ndmin=2, comments=None)
    except ValueError:
        return None
    is_plain = values.shape[1] == n and np.all(np.isfinite(values)) and len(values) <= MAX_SAMPLES
    return values if is_plain else None


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
    found: Tracked, sheet: Sheet, units: dict[str, str], harmonics: Sequence[float], *, has_phase: bool
) -> list[Curve]:
    """The vectors of each signal (its unit by its name) at each harmonic, or their amplitudes."""
    return [
        Curve(
            name,
            "",
            [int(sheet.lines[first]) for first in found.first],
            found.speed / RPM,
            np.abs(found.values[:, number, order]),
            phase=np.angle(found.values[:, number, order], deg=True) if has_phase else None,
            sigma=None if found.sigma is None else found.sigma[:, number, order],
            time=found.time,
            speed_unit="rpm",
            unit=f"{unit} 0pk".strip(),
            sense="lead" if has_phase else "",
            harmonic=harmonic,
        )
        for number, (name, unit) in enumerate(units.items())
        for order, harmonic in enumerate(harmonics)
    ]

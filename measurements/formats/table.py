"""Tables with any columns: what each holds is said by `columns`, role=heading.

Wide, a row per speed: `speed`, and of each probe NAME `amplitude.NAME` with `phase.NAME`, or `real.NAME` with `imag.NAME`, or the
complex `response.NAME` of a .mat file; `sigma.NAME`, and `speed.NAME` and `time.NAME` where probes have their own. NAME may end
in .2X for a harmonic. Long, a row per speed and probe: the same roles without a name, next to `channel`, the name, or `position` (m)
and `direction`, and `harmonic`. `status` (or status.NAME) leaves out rows that are not valid, OK or 1.

A table with the columns of the project's own file, such as one that went through a spreadsheet, needs no roles.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, shortened, unknown
from measurements.formats.column_guess import columns_question
from measurements.formats.curve import Curve, Flags
from measurements.formats.sheet import Sheet
from measurements.formats.unit_texts import amplitude_unit, degrees_per, seconds_per, sense_in_heading
from measurements.formats.user_answers import Answers
from measurements.formats.waveforms.clock import times_of
from measurements.run_up_rows import REQUIRED

VALUES = ("amplitude", "phase", "real", "imag", "response", "sigma")
OF_ROWS = ("speed", "time", "status")
OF_LONG = ("channel", "position", "direction", "harmonic")
ROLES = (*OF_ROWS, *VALUES, *OF_LONG)
MAX_CHANNELS = 1000  # of a long table, harmonics by themselves
VALID = ("valid", "ok", "good", "true", "1", "")
HARMONIC = re.compile(r"(.*)\.([0-9]+\.?[0-9]*)X", re.ASCII)
OWN_COLUMNS = {
    "speed_rpm": "speed",
    "position_m": "position",
    "direction": "direction",
    "amplitude_um_0pk": "amplitude",
    "phase_lead_deg": "phase",
    "sigma_um": "sigma",
    "time_s": "time",
    "harmonic": "harmonic",
}


@dataclass(frozen=True)
class Roles:
    """Headings by role and name of the probe; '' if the role belongs to all probes."""

    headings: dict[tuple[str, str], str]

    def of(self, role: str, name: str = "") -> str | None:
        """The heading of a role for a probe, or of all; None if neither is given."""
        return self.headings.get((role, name)) or self.headings.get((role, ""))

    @property
    def names(self) -> list[str]:
        """The probes of a wide table, in the order in which they were named."""
        return list(dict.fromkeys(name for role, name in self.headings if name and role in VALUES))

    @property
    def is_long(self) -> bool:
        return not self.names


def roles_of(texts: Sequence[str]) -> Roles:
    """Roles given by `columns`.

    Raises `SettingError` if a text is not role=heading, or a role is given twice.
    """
    found: dict[tuple[str, str], str] = {}
    for text in texts:
        left, separator, heading = text.partition("=")
        role, _, name = left.strip().partition(".")
        if not separator or not heading.strip():
            raise SettingError(
                f"columns: expected role=heading, such as speed=rpm or amplitude.A=A 1X, got {shortened(repr(text))}"
            )
        if role not in ROLES or (role in OF_LONG and name):
            raise unknown("role in columns:", role if role not in ROLES else left.strip(), ROLES)
        if (role, name) in found:
            raise SettingError(f"columns: expected each role once, got {shortened(left.strip())} twice; remove one")
        found[role, name] = heading.strip()
    return Roles(found)


def read_table(sheet: Sheet, answers: Answers) -> list[Curve]:
    """The curves of a table's probes."""
    is_own = not answers.columns and set(REQUIRED) <= {name.lower() for name in sheet.columns}
    roles = Roles(_own_roles(sheet)) if is_own else roles_of(answers.columns)
    if not roles.headings:
        raise columns_question(
            f"{sheet.where}: expected the meaning of the columns, got nothing; give columns=[speed=…,amplitude.NAME=…,"
            f"phase.NAME=…] of {_listed(sheet.columns)}",
            [list(sheet.columns)],
        )
    for heading in roles.headings.values():
        sheet.named(heading)
    curves = (
        _long(sheet, roles, is_own=is_own) if roles.is_long else [_wide(sheet, roles, each) for each in roles.names]
    )
    where = sheet.where.removeprefix(answers.path).strip()  # the sheet, of an Excel file
    return [dataclasses.replace(curve, where=where) for curve in curves]


def _own_roles(sheet: Sheet) -> dict[tuple[str, str], str]:
    lowered = {name.lower(): name for name in sheet.columns}
    for name in lowered:
        if name not in OWN_COLUMNS:
            raise SettingError(
                f"{sheet.where}: {unknown('column', name, OWN_COLUMNS)}; or say what each holds in columns"
            )
    filled = {name: lowered[name] for name in lowered if any(text for text in sheet.texts(lowered[name]))}
    return {(OWN_COLUMNS[name], ""): heading for name, heading in filled.items()}


def _wide(sheet: Sheet, roles: Roles, whole: str) -> Curve:
    found = HARMONIC.fullmatch(whole)
    name, harmonic = (found[1], float(found[2])) if found else (whole, 1.0)
    if not 0 < harmonic <= 100:
        raise SettingError(f"columns: expected a harmonic from 0.1X to 100X, got {shortened(whole)}")
    curve, is_valid = _curve(sheet, roles, whole)
    return _valid(dataclasses.replace(curve, name=name, harmonic=harmonic), is_valid)


def _long(sheet: Sheet, roles: Roles, *, is_own: bool) -> list[Curve]:
    """A curve for each channel, in the order in which they come first."""
    channel, position, direction = (roles.of(role) for role in ("channel", "position", "direction"))
    names = sheet.texts(channel) if channel else [""] * len(sheet.lines)
    places = sheet.numbers(position) if position else np.full(len(sheet.lines), np.nan)
    directions = sheet.texts(direction) if direction else [""] * len(sheet.lines)
    of_harmonic = roles.of("harmonic")
    harmonics = sheet.numbers(of_harmonic) if of_harmonic else np.ones(len(sheet.lines))
    harmonics = np.where(np.isnan(harmonics), 1.0, harmonics)
    if position:
        _require_places(sheet, places)
    rows: dict[tuple[str, float, str, float], list[int]] = {}
    for row, key in enumerate(
        zip(names, np.where(np.isnan(places), -1.0, places).tolist(), directions, harmonics.tolist())
    ):
        rows.setdefault(key, []).append(row)
    if len(rows) > MAX_CHANNELS:
        raise SettingError(
            f"{sheet.where}: expected at most {MAX_CHANNELS} probes and harmonics, got {len(rows)}; check channel, position,"
            " direction and harmonic in columns"
        )
    whole, is_valid = _curve(sheet, roles, "")
    said = {"speed_unit": "rpm", "unit": "um 0pk", "sense": "lead"} if is_own else {}
    curves = []
    for (name, place, looks, harmonic), indices in rows.items():
        if not 0 < harmonic <= 100:
            raise SettingError(f"{sheet.where}: expected harmonics from 0.1 to 100, got {harmonic:g}; check the column")
        own = {
            "name": name or (f"{looks} at {place:g} m" if position else ""),
            "position": place if position else None,
            "direction": looks,
            "harmonic": harmonic,
            **said,
        }
        part = Curve(**{**vars(whole.at(np.array(indices))), **own})
        curves.append(_valid(part, None if is_valid is None else is_valid[indices]))
    return curves


def _require_places(sheet: Sheet, places: Array) -> None:
    if np.any(bad := ~np.isfinite(places) | (places < 0) | (places > 1e3)):
        first = int(np.flatnonzero(bad)[0])
        raise SettingError(
            f"{sheet.where} line {sheet.lines[first]}: expected a position of a probe in m, got {places[first]:g}; correct it"
        )


def _curve(sheet: Sheet, roles: Roles, name: str) -> tuple[Curve, Flags | None]:
    """Rows of a table as one curve, of the roles with or without a name, and which are valid (None: all)."""
    speed = roles.of("speed", name)
    if speed is None:
        raise SettingError(
            f"columns: expected a column with the speed, got none; give speed=… of {_listed(sheet.columns)}"
        )
    amplitude, phase, heading = _vector(sheet, roles, name)
    sigma, time, status = (roles.of(role, name) for role in ("sigma", "time", "status"))
    if sigma is not None:
        _require_unit(sheet, sigma, heading)
    curve = Curve(
        name,
        "",
        list(map(int, sheet.lines)),
        sheet.numbers(speed),
        amplitude,
        phase=phase,
        sigma=None if sigma is None else sheet.numbers(sigma),
        time=None if time is None else times_of(sheet, time) * seconds_per(sheet.unit(time), sheet.where),
        speed_unit=sheet.unit(speed),
        unit=sheet.unit(heading),
        stated_sense=sense_in_heading(sheet.named(of_phase)) if (of_phase := roles.of("phase", name)) else "",
    )
    if status is None:
        return curve, None
    return curve, np.array([text.lower() in VALID for text in sheet.texts(status)])


def _valid(curve: Curve, is_valid: Flags | None) -> Curve:
    if is_valid is not None:
        curve = curve.rows(is_valid, "not valid")
    return curve if curve.time is None else curve.rows(np.isfinite(curve.time), "without a time")


def _vector(sheet: Sheet, roles: Roles, name: str) -> tuple[Array, Array | None, str]:
    """Amplitude and phase (degrees) of all rows, and the heading whose unit is theirs."""
    given = {role: roles.of(role, name) for role in ("amplitude", "phase", "real", "imag", "response")}
    ways = [given["amplitude"], given["real"] and given["imag"], given["response"]]
    if sum(map(bool, ways)) != 1 or (given["phase"] and not given["amplitude"]):
        raise SettingError(
            f"columns: expected either amplitude (with phase or without), real and imag, or response"
            f"{f' of {shortened(name)}' if name else ''}, got {', '.join(role for role in given if given[role]) or 'none'}"
        )
    if given["amplitude"]:
        phase = given["phase"]
        degrees = None if phase is None else sheet.numbers(phase) * degrees_per(sheet.unit(phase))
        return sheet.numbers(given["amplitude"]), degrees, given["amplitude"]
    if given["response"]:
        values, heading = sheet.complex_numbers(given["response"]), given["response"]
    else:
        assert given["real"] and given["imag"]
        _require_unit(sheet, given["imag"], given["real"])
        values, heading = sheet.numbers(given["real"]) + 1j * sheet.numbers(given["imag"]), given["real"]
    return np.abs(values), np.angle(values, deg=True), heading


def _require_unit(sheet: Sheet, heading: str, other: str) -> None:
    """Raise `SettingError` if a column states another unit or detector than the one assumed for it."""
    said, taken = amplitude_unit(sheet.unit(heading)), amplitude_unit(sheet.unit(other))
    if said is None or taken is None:  # no unit in these brackets, or one that is refused by itself
        return
    for own, its in ((said.unit, taken.unit), (said.detector, taken.detector)):
        if own and its and own != its:
            raise SettingError(
                f"{sheet.where}: expected {shortened(heading)} in the unit of {shortened(other)} ({its}), got {own}; bring both to"
                " one unit"
            )


def _listed(names: Iterable[str]) -> str:
    return shortened(", ".join(map(repr, names)), 300)

"""What was really measured, from a CSV file: `measurement=file measurement.path=run.csv`.

One row per speed and channel:

    speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,sigma_um
    1500,0.1,x,12.4,-31.5,
    1500,0.1,y,11.9,-122.0,

- `speed_rpm` of the shaft, above 0. Speeds may be unevenly spaced and in any order: a run-up's rows stand in the order
  of time. They are sorted for the analysis; each speed has every channel once.
- `position_m` of the probe from the rotor's left end, `direction` x or y as in the model.
- `amplitude_um_0pk` of the 1X vibration, µm zero to peak: half of peak to peak.
- `phase_lead_deg`, the angle of the complex amplitude q under Re(q e^{iΩt}): on every row (complex data) or on none
  (amplitudes). Instruments often show a lag: that is its negative. Where it is counted from does not matter.
- `sigma_um`, the standard deviation of the noise of this row: of the amplitude, and for complex data the total one,
  √2 times that of the real and of the imaginary part. On every row or on none: then the noise is estimated.
- `time_s`, optional: kept for what asks for the order in time.

The last three columns may be missing. Lines that begin with # are remarks, empty lines are left out. Nothing is guessed:
what does not fit is an error that names the line. docs/examples/run_up.csv is such a file.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NoReturn

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import Channel
from ksmea.contracts import MeasurementSource, ProblemSettings
from ksmea.errors import SettingError, unknown
from ksmea.measurement import Layout, Measurement, Noise
from ksmea.settings import setting
from ksmea.units import DEGREE, MICROMETRE, RPM

REQUIRED = ("speed_rpm", "position_m", "direction", "amplitude_um_0pk")
OPTIONAL = ("phase_lead_deg", "sigma_um", "time_s")
HEADER = ",".join((*REQUIRED, *OPTIONAL[:2]))

MOST_ROWS = 100_000  # speeds × channels; an identification of as many takes minutes
MOST_BYTES = 64 * 2**20  # as many rows have a tenth of it
# What no rotor does: a larger number is of another unit, or a slip.
LARGEST = {"speed_rpm": 1e6, "amplitude_um_0pk": 1e6, "sigma_um": 1e6, "phase_lead_deg": 1e6}
NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?", re.ASCII)
DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+", re.ASCII)
LONGEST = 40  # characters of a file that a message quotes


@dataclass(frozen=True)
class File(MeasurementSource):
    """A measured run-up, coast-down or set of steady speeds from a CSV file, amplitudes with or without phase.

    Where phases were measured, the unbalance's angle is one more unknown: the origin of measured phases is arbitrary.
    """

    path: str = setting("", "the file; docs/examples/run_up.csv shows its columns and units")
    incomplete: str = setting(
        "refuse",
        "what becomes of a speed that lacks a channel: an error, or the speed is left out",
        choices=("refuse", "drop"),
    )
    speed_from: float | None = setting(None, "lowest speed of the file that is used; null: all", unit="rpm", above=0)
    speed_to: float | None = setting(None, "highest speed of the file that is used; null: all", unit="rpm", above=0)

    def check(self) -> None:
        if not self.path:
            raise SettingError(
                "path: expected the CSV file of a measurement, got none; give measurement.path=run.csv,"
                " for example docs/examples/run_up.csv"
            )
        if self.speed_from is not None and self.speed_to is not None and self.speed_from >= self.speed_to:
            raise SettingError(
                f"speed_to: expected more than speed_from ({self.speed_from:g}), got {self.speed_to:g}; swap them"
            )
        self._run_up  # noqa: B018 – reading is checking

    @property
    def kind(self) -> str:
        return "complex" if np.iscomplexobj(self._run_up.values) else "amplitude"

    @property
    def noise(self) -> Noise | None:
        """The noise as the file states it, datum by datum; None where it does not."""
        return None if self._run_up.sigma is None else Noise(0.0, self._run_up.sigma)

    @property
    def noise_known(self) -> bool:
        return self._run_up.sigma is not None

    @property
    def time(self) -> Array | None:
        """When each speed was passed, (n_speed,) s, speeds rising; None where the file does not say."""
        return self._run_up.time

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was left out of the file, in words."""
        return self._run_up.remarks

    def fingerprint(self) -> str:
        """Hash of the file's content, which the settings name but do not hold: a changed file is another measurement."""
        return self._content[1]

    def layout(self, settings: ProblemSettings) -> Layout:
        """The file's speeds and channels; where it has phases, their origin is not known."""
        run_up = self._run_up
        lines = tuple(f"{self.path} line {line}" for line in run_up.first_lines)
        return Layout(run_up.speed, run_up.channels, self.kind, self.path, phase_known=False, locations=lines)

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        """What the file holds."""
        run_up, name = self._run_up, Path(self.path).name
        return Measurement(run_up.speed, run_up.channels, run_up.values, self.noise, name, phase_known=False)

    @cached_property
    def _content(self) -> tuple[_Rows, str]:
        content = _read_bytes(self.path)
        return _rows(_text(content, self.path), self.path), hashlib.sha256(content).hexdigest()[:16]

    @cached_property
    def _run_up(self) -> RunUp:
        return _run_up(self._content[0], self.path, self.speed_from, self.speed_to, self.incomplete == "drop")


@dataclass(frozen=True)
class RunUp:
    """What a file says, SI, speeds rising; `first_lines` is where each channel stands first."""

    speed: Array  # (n_speed,) rad/s
    channels: tuple[Channel, ...]
    first_lines: tuple[int, ...]
    values: Array | ComplexArray  # (n_speed, n_channel) m
    sigma: Array | None  # (n_speed, n_channel) m
    time: Array | None  # (n_speed,) s
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class _Rows:
    """The rows of a file in its order and units, column by column; a column that is empty throughout is None."""

    line: list[int]
    speed: list[float]
    channel: list[tuple[float, str]]
    amplitude: list[float]
    phase: list[float] | None
    sigma: list[float] | None
    time: list[float] | None


def as_csv(measurement: Measurement, remarks: Sequence[str] = (), time: Array | None = None) -> str:
    """A measurement as such a file, in the order of its speeds, or of `time` (n_speed,) s; the way back is exact to eight
    digits. Noise that is known becomes `sigma_um`."""
    optional = {
        "phase_lead_deg": None if measurement.is_amplitude else np.angle(measurement.values) / DEGREE,
        "sigma_um": measurement.noise.sd(np.abs(measurement.values)) / MICROMETRE if measurement.has_noise else None,
        "time_s": None if time is None else np.broadcast_to(time[:, None], measurement.values.shape),
    }
    amplitude = np.abs(measurement.values) / MICROMETRE
    order = np.arange(len(measurement.speed)) if time is None else np.argsort(time, kind="stable")
    lines = [*(f"# {remark}" for remark in remarks), ",".join((*REQUIRED, *optional))]
    for speed in order:
        for index, channel in enumerate(measurement.channels):
            numbers = [
                amplitude[speed, index],
                *(None if part is None else part[speed, index] for part in optional.values()),
            ]
            cells = ["" if number is None else f"{number:.8g}" for number in numbers]
            place = [f"{measurement.speed[speed] / RPM:.10g}", f"{channel.position:.10g}", channel.direction]
            lines.append(",".join([*place, *cells]))
    return "\n".join(lines) + "\n"


def _read_bytes(path: str) -> bytes:
    place = Path(path).expanduser()
    try:
        if place.is_dir():
            raise SettingError(f"{path}: expected a CSV file, got a directory; name a file in it")
        if not place.exists():
            raise SettingError(f"{path}: expected a CSV file, found none (working directory: {Path.cwd()})")
        if not place.is_file():
            raise SettingError(f"{path}: expected a CSV file, got something that is no regular file; copy it into one")
        if place.stat().st_size > MOST_BYTES:
            raise SettingError(
                f"{path}: expected at most {MOST_ROWS} rows, got {place.stat().st_size / 2**20:.0f} MB;"
                " thin it out or average neighbouring speeds"
            )
        return place.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        if isinstance(error, SettingError):
            raise
        raise SettingError(f"{path}: expected a file that can be read, got {_quoted(error)}") from error


def _text(content: bytes, path: str) -> str:
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise SettingError(f"{path}: expected a text in UTF-8, got UTF-16; save it as 'CSV UTF-8'")
    if b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise SettingError(
            f"{path} line {line}: expected a CSV text in UTF-8, got binary data or UTF-16; export or save it as 'CSV UTF-8'"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SettingError(
            f"{path} line {line}: expected a CSV text in UTF-8, got the byte 0x{content[error.start]:02x};"
            " save it as 'CSV UTF-8'"
        ) from error


def _rows(text: str, path: str) -> _Rows:
    """The rows of a file, each checked by itself and the columns that are to be full or empty."""
    lines = _cells(text, path)
    first = next(lines, None)
    if first is None:
        raise SettingError(
            f"{path}: expected the header {HEADER} and rows below it, got {'remarks only' if text.strip() else 'an empty file'}"
        )
    names = _header(path, *first)
    found: dict[str, list] = {name: [] for name in (*REQUIRED, *OPTIONAL)}
    numbers: list[int] = []
    for number, cells in lines:
        where = f"{path} line {number}"
        if len(numbers) == MOST_ROWS:
            raise SettingError(
                f"{where}: expected at most {MOST_ROWS} rows (speeds × channels), got more; thin them out or average"
                " neighbouring speeds"
            )
        if len(cells) != len(names):
            _refuse_count(where, cells, names)
        row = dict(zip(names, cells))
        for name, values in found.items():
            values.append(_value(where, name, row.get(name, "")))
        numbers.append(number)
    if not numbers:
        raise SettingError(f"{path} line {first[0]}: expected rows below the header, got none")
    optional = {name: _full_or_none(path, name, numbers, found[name]) for name in OPTIONAL}
    _check_time(path, numbers, optional["time_s"])
    return _Rows(
        numbers,
        found["speed_rpm"],
        list(zip(found["position_m"], found["direction"])),
        found["amplitude_um_0pk"],
        optional["phase_lead_deg"],
        optional["sigma_um"],
        optional["time_s"],
    )


def _cells(text: str, path: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each line that is neither a remark nor empty."""
    for number, line in enumerate(io.StringIO(text, newline=None), start=1):
        line = line.strip()
        if not line.strip(", ") or line.startswith("#"):
            continue
        try:
            (cells,) = csv.reader([line], strict=True)
        except (csv.Error, ValueError) as error:
            raise SettingError(
                f"{path} line {number}: expected cells separated by commas, got {_quoted(error)}"
            ) from error
        yield number, [cell.strip() for cell in cells]


def _header(path: str, number: int, names: Sequence[str]) -> Sequence[str]:
    where = f"{path} line {number}"
    whole = ",".join(names)
    for separator, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
        if separator in whole and not set(REQUIRED) <= set(names):
            raise SettingError(
                f"{where}: expected columns separated by commas, got {word}; write commas between cells and points in"
                " decimals"
            )
    if all(NUMBER.fullmatch(name) or name in ("", "x", "y") for name in names):
        raise SettingError(f"{where}: expected a header, got numbers ({_quoted(whole)}); put this line first: {HEADER}")
    for place, name in enumerate(names):
        if name not in (*REQUIRED, *OPTIONAL):
            raise SettingError(f"{where}: {unknown('column', _short(name), (*REQUIRED, *OPTIONAL))}")
        if name in names[:place]:
            raise SettingError(f"{where}: expected each column once, got {name} twice; remove one")
    missing = [name for name in REQUIRED if name not in names]
    if missing:
        raise SettingError(f"{where}: expected the columns {', '.join(REQUIRED)}, got no {' and no '.join(missing)}")
    return names


def _refuse_count(where: str, cells: Sequence[str], names: Sequence[str]) -> NoReturn:
    joined = ",".join(cells)
    if ";" in joined or "\t" in joined:
        hint = "separate them by commas"
    elif len(cells) > len(names):
        hint = "write decimals with a point (1.5, not 1,5)"
    else:
        hint = "an empty cell still has its comma"
    raise SettingError(
        f"{where}: expected {len(names)} cells as in the header, got {len(cells)} ({_quoted(joined)}); {hint}"
    )


def _value(where: str, name: str, cell: str) -> float | str | None:
    """A cell as a number or direction; None where an optional one is empty."""
    if name == "direction":
        if cell not in ("x", "y"):
            raise SettingError(f"{where}: expected direction x or y, got {_quoted(cell)}")
        return cell
    if not cell and name in OPTIONAL:
        return None
    if not NUMBER.fullmatch(cell):
        _refuse_number(where, name, cell)
    value = float(cell)
    if not math.isfinite(value) or abs(value) > LARGEST.get(name, math.inf):
        raise SettingError(
            f"{where}: expected {name} of at most {LARGEST.get(name, 1e308):g}, got {_quoted(cell)}; check its unit"
        )
    if name in ("speed_rpm", "sigma_um") and value <= 0:
        hint = (
            "unbalance does nothing at rest" if name == "speed_rpm" else "leave the column empty where it is not known"
        )
        raise SettingError(f"{where}: expected {name} above 0, got {_quoted(cell)}; {hint}")
    if name == "amplitude_um_0pk" and value < 0:
        raise SettingError(
            f"{where}: expected {name} of 0 or more, got {_quoted(cell)}; a sign belongs into phase_lead_deg"
        )
    return value


def _refuse_number(where: str, name: str, cell: str) -> NoReturn:
    if DECIMAL_COMMA.fullmatch(cell):
        hint = "; write decimals with a point"
    elif cell.lower().lstrip("+-") in ("nan", "inf", "infinity", "") or cell.startswith("#"):
        hint = "; leave out rows that were not measured"
    else:
        hint = ""
    raise SettingError(f"{where}: expected a number for {name}, got {_quoted(cell) if cell else 'nothing'}{hint}")


def _full_or_none(path: str, name: str, lines: Sequence[int], values: list) -> list | None:
    """A column that is full, or None where it is empty throughout."""
    given = next((line for line, value in zip(lines, values) if value is not None), None)
    if given is None:
        return None
    lacking = next((line for line, value in zip(lines, values) if value is None), None)
    if lacking is not None:
        raise SettingError(
            f"{path} line {lacking}: expected {name} on every row or on none, got none here and one on line {given};"
            " add it, or leave out the rows without it"
        )
    return values


def _check_time(path: str, lines: Sequence[int], time: list[float] | None) -> None:
    for place in range(1, len(time or ())):
        if time[place] < time[place - 1]:
            raise SettingError(
                f"{path} line {lines[place]}: expected rows in the order of time, got {time[place]:g} s after"
                f" {time[place - 1]:g} s; sort them by time_s"
            )


def _run_up(rows: _Rows, path: str, speed_from: float | None, speed_to: float | None, drop: bool) -> RunUp:
    """Rows in any order as a table of speeds and channels, SI."""
    low, high = speed_from or 0.0, speed_to or math.inf
    used = [place for place, speed in enumerate(rows.speed) if low <= speed <= high]
    if not used:
        raise SettingError(
            f"{path}: expected speeds from {low:g} to {high:g} rpm, got {min(rows.speed):g} to {max(rows.speed):g} rpm;"
            " change speed_from or speed_to"
        )
    first_lines: dict[tuple[float, str], int] = {}
    by_speed: dict[float, dict[tuple[float, str], int]] = {}
    for place in used:
        speed, channel, line = rows.speed[place], rows.channel[place], rows.line[place]
        first_lines.setdefault(channel, line)
        there = by_speed.setdefault(speed, {})
        if channel in there:
            raise SettingError(
                f"{path} line {line}: expected each speed and channel once, got {speed:g} rpm, {Channel(*channel)} again"
                f" after line {rows.line[there[channel]]}; average them, or keep one"
            )
        there[channel] = place
    complete = sorted(speed for speed, there in by_speed.items() if len(there) == len(first_lines))
    dropped = len(by_speed) - len(complete)
    if dropped and not drop:
        _refuse_incomplete(path, rows, by_speed, first_lines)
    _check_count(path, rows, complete, dropped)
    order = np.array([[by_speed[speed][channel] for channel in first_lines] for speed in complete])
    amplitude = np.array(rows.amplitude)[order] * MICROMETRE
    _check_zeros(path, amplitude, first_lines)
    remarks = [f"{dropped} of {len(by_speed)} speeds left out: a channel is missing there"] if dropped else []
    remarks += [f"{len(rows.line) - len(used)} of {len(rows.line)} rows left out by speed_from and speed_to"] * (
        len(used) < len(rows.line)
    )
    return RunUp(
        speed=np.array(complete) * RPM,
        channels=tuple(Channel(*channel) for channel in first_lines),
        first_lines=tuple(first_lines.values()),
        values=amplitude if rows.phase is None else amplitude * np.exp(1j * DEGREE * np.array(rows.phase)[order]),
        sigma=None if rows.sigma is None else np.array(rows.sigma)[order] * MICROMETRE,
        time=None if rows.time is None else np.array(rows.time)[order].min(axis=1),
        remarks=tuple(remarks),
    )


def _refuse_incomplete(
    path: str,
    rows: _Rows,
    by_speed: Mapping[float, Mapping[tuple[float, str], int]],
    first_lines: Mapping[tuple[float, str], int],
) -> NoReturn:
    lacking = [there for there in by_speed.values() if len(there) < len(first_lines)]
    place = next(iter(lacking[0].values()))
    missing = next(channel for channel in first_lines if channel not in lacking[0])
    raise SettingError(
        f"{path} line {rows.line[place]}: expected every channel at every speed, got no {Channel(*missing)} at"
        f" {rows.speed[place]:g} rpm ({len(lacking)} of {len(by_speed)} speeds lack one);"
        " measurement.incomplete=drop leaves such speeds out"
    )


def _check_count(path: str, rows: _Rows, complete: Sequence[float], dropped: int) -> None:
    if len(complete) < 2:
        hint = "the channels share too few speeds" if dropped else "one speed does not tell a response"
        only = f"1 ({complete[0]:g} rpm)" if complete else "none"
        raise SettingError(f"{path}: expected at least 2 speeds with every channel, got {only}; {hint}")


def _check_zeros(path: str, amplitude: Array, first_lines: Mapping[tuple[float, str], int]) -> None:
    for index, (channel, line) in enumerate(first_lines.items()):
        if 2 * np.count_nonzero(amplitude[:, index]) < len(amplitude):
            raise SettingError(
                f"{path} line {line}: expected amplitudes above 0, got 0 at more than half of the speeds from"
                f" {Channel(*channel)}; leave a probe out that does not work"
            )


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def _quoted(what: object) -> str:
    """Something of the file on one line, control characters made visible."""
    return repr(_short(" ".join(str(what).split())))

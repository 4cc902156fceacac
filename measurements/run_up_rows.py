"""The rows of a measurement's CSV file, read and checked cell by cell; each error names its line.

`measurements/file.py` says what the columns mean.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn

from ksmea.errors import SettingError, unknown
from ksmea.measurement.channel import DIRECTIONS, direction_at
from ksmea.measurement.notation import LAG, Notation, of_text
from ksmea.settings.regular_files import read_input
from ksmea.units import INCH, MICROMETRE

MIL = 1e-3 * INCH  # m

REQUIRED = ("speed_rpm", "position_m", "direction", "amplitude_um_0pk")
OPTIONAL = ("phase_lead_deg", "sigma_um", "time_s", "run", "harmonic")
# Further headings, each with what its numbers are multiplied by: lags count against the rotation, 1 mil pp is 12.7 µm 0-pk.
LENGTHS_UM = {"um": 1.0, "mm": 1e3, "mil": MIL / MICROMETRE, "thou": MIL / MICROMETRE, "in": INCH / MICROMETRE}
PER_0PK = {"0pk": 1.0, "pp": 0.5, "rms": math.sqrt(2)}
READ_AS = {"phase_lag_deg": ("phase_lead_deg", -1.0)} | {
    f"amplitude_{unit}_{kind}": ("amplitude_um_0pk", size * part)
    for unit, size in LENGTHS_UM.items()
    for kind, part in PER_0PK.items()
    if (unit, kind) != ("um", "0pk")
}
# Units and sign of phases that headings say
SAYS = {"phase_lag_deg": LAG} | {
    f"amplitude_{unit}_{kind}": f"{unit}_{kind}" for unit in LENGTHS_UM for kind in PER_0PK
}
IMPORT = "`python -m bench import`"
HEADER = ",".join((*REQUIRED, *OPTIONAL[:2]))

MAX_ROWS = 100_000  # speeds × channels; an identification of as many takes minutes
MAX_BYTES = 64 * 2**20  # as many rows have a tenth of it
# What no rotor does: a larger number is of another unit, or a slip.
LARGEST = {"speed_rpm": 1e6, "amplitude_um_0pk": 1e6, "sigma_um": 1e6, "phase_lead_deg": 1e6, "harmonic": 100}
ABOVE_ZERO = {  # and what to do where it is not
    "speed_rpm": "unbalance does nothing at rest",
    "sigma_um": "leave the column empty where it is not known",
    "harmonic": "1 is the speed of rotation, 2 twice that; leave it empty for 1",
}
NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?", re.ASCII)
DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+", re.ASCII)
DIGITS = 15  # that a double holds of any number
MAX_ANGLE = 360  # degrees, of a direction
MAX_QUOTED = 40  # characters of a file that a message quotes


@dataclass(frozen=True)
class Rows:
    """The rows of a file in its order and units, column by column.

    A column that is empty throughout is None.
    """

    line: list[int]
    speed: list[float]
    channel: list[tuple[float, str, float]]  # position, direction, harmonic
    amplitude: list[float]
    phase: list[float] | None
    sigma: list[float] | None
    time: list[float] | None
    run: list[str] | None


def rows_at(rows: Rows, indices: Sequence[int]) -> Rows:
    """Some of the rows, in this order."""
    return Rows(**{key: values and [values[index] for index in indices] for key, values in vars(rows).items()})


def to_digits(rows: Rows) -> Rows:
    """The rows to as many digits as conversions of units and means leave true.

    118.4 mil is 3007.36 µm, not 3007.3600000000003.
    """
    found = {key: getattr(rows, key) for key in ("speed", "amplitude", "phase", "sigma", "time")}
    return replace(
        rows, **{key: values and [float(f"{each:.{DIGITS}g}") for each in values] for key, values in found.items()}
    )


def rows_of_run(rows: Rows, name: str, path: str) -> Rows:
    """The rows of one run, of a file with several."""
    names = rows.run or []
    if name not in names:
        raise unknown(f"run of {path}:", name, [*dict.fromkeys(names)])
    return rows_at(rows, [index for index, each in enumerate(names) if each == name])


def read_bytes(path: str, most: int = MAX_BYTES) -> bytes:
    """Content of a CSV file; `SettingError` if it is missing, unreadable or larger than `most` bytes."""

    def too_large(size: int) -> str:
        if most > MAX_BYTES:
            return f"expected at most {most >> 20} MB, got {size >> 20} MB; cut the record into parts"
        return (
            f"expected at most {MAX_ROWS} rows, got {size / 2**20:.0f} MB; thin it out or average neighbouring speeds"
        )

    return read_input(path, "CSV", most, too_large)


def text_of(content: bytes, path: str) -> str:
    """The content as text; `SettingError` if it is no UTF-8."""
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


def rows_of(text: str, path: str) -> Rows:
    """The rows of a file, each checked by itself and the columns that are to be full or empty."""
    lines = _cells(text, path)
    first = next(lines, None)
    if first is None:
        raise SettingError(
            f"{path}: expected the header {HEADER} and rows below it, got {'remarks only' if text.strip() else 'an empty file'}"
        )
    factors = {known: factor for known, factor in (READ_AS.get(name, ("", 1.0)) for name in first[1]) if known}
    names = _header(path, *first)
    found: dict[str, list[Any]] = {name: [] for name in (*REQUIRED, *OPTIONAL)}
    numbers: list[int] = []
    for number, cells in lines:
        where = f"{path} line {number}"
        if len(numbers) == MAX_ROWS:
            raise SettingError(
                f"{where}: expected at most {MAX_ROWS} rows (speeds × channels), got more; thin them out or average"
                " neighbouring speeds"
            )
        if len(cells) != len(names):
            _refuse_count(where, cells, names)
        row = dict(zip(names, cells))
        for name, values in found.items():
            values.append(_value(where, name, row.get(name, ""), factors.get(name, 1.0)))
        numbers.append(number)
    if not numbers:
        raise SettingError(f"{path} line {first[0]}: expected rows below the header, got none")
    optional = {name: _full_or_none(path, name, numbers, found[name]) for name in OPTIONAL if name != "harmonic"}
    _check_time(path, numbers, optional["time_s"], optional["run"])
    return Rows(
        numbers,
        found["speed_rpm"],
        list(zip(found["position_m"], found["direction"], [each or 1.0 for each in found["harmonic"]])),
        found["amplitude_um_0pk"],
        optional["phase_lead_deg"],
        optional["sigma_um"],
        optional["time_s"],
        optional["run"],
    )


def notation_of(text: str, path: str) -> Notation:
    """Notation at the head of a file of this project, or else of its headings, such as amplitude_mil_pp.

    >>> notation_of("speed_rpm,amplitude_mil_pp,phase_lag_deg", "run.csv").words
    'mil_pp,lag,rpm'
    """
    _, headings = next(_cells(text, path), (0, []))
    return of_text(text, Notation().with_words(",".join(SAYS[name] for name in headings if name in SAYS)))


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
                f"{path} line {number}: expected cells separated by commas, got {quoted(error)}"
            ) from error
        yield number, [cell.strip() for cell in cells]


def _header(path: str, number: int, names: Sequence[str]) -> Sequence[str]:
    """The names of the columns; names in `READ_AS` are replaced by the names they are read as."""
    where = f"{path} line {number}"
    names = [READ_AS[name][0] if name in READ_AS else name for name in names]
    whole = ",".join(names)
    for separator, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
        if separator in whole and not set(REQUIRED) <= set(names):
            raise SettingError(
                f"{where}: expected columns separated by commas, got {word}; write commas between cells and points in"
                f" decimals, or let {IMPORT} do it"
            )
    if all(NUMBER.fullmatch(name) or name in ("", "x", "y") for name in names):
        raise SettingError(f"{where}: expected a header, got numbers ({quoted(whole)}); put this line first: {HEADER}")
    for index, name in enumerate(names):
        if name not in (*REQUIRED, *OPTIONAL):
            raise SettingError(
                f"{where}: {unknown('column', _short(name), (*REQUIRED, *OPTIONAL))}; {IMPORT} reads"
                " tables with other columns"
            )
        if name in names[:index]:
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
        f"{where}: expected {len(names)} cells as in the header, got {len(cells)} ({quoted(joined)}); {hint}"
    )


def _value(where: str, name: str, cell: str, factor: float) -> float | str | None:
    """A cell as a number, times a factor, or direction; None if an optional one is empty."""
    if name == "direction":
        return cell if cell in DIRECTIONS else _direction(where, cell)
    if not cell and name in OPTIONAL:
        return None
    if name == "run":
        return cell
    if not NUMBER.fullmatch(cell):
        _refuse_number(where, name, cell)
    value = float(cell) * factor
    if not math.isfinite(value) or abs(value) > LARGEST.get(name, math.inf):
        raise SettingError(
            f"{where}: expected {name} of at most {LARGEST.get(name, 1e308):g}, got {quoted(cell)}; check its unit"
        )
    if name in ABOVE_ZERO and value <= 0:
        raise SettingError(f"{where}: expected {name} above 0, got {quoted(cell)}; {ABOVE_ZERO[name]}")
    if name == "amplitude_um_0pk" and value < 0:
        raise SettingError(
            f"{where}: expected {name} of 0 or more, got {quoted(cell)}; a sign belongs into phase_lead_deg"
        )
    return value


def _direction(where: str, cell: str) -> str:
    if not NUMBER.fullmatch(cell) or abs(float(cell)) > MAX_ANGLE:
        raise SettingError(f"{where}: expected direction x, y or degrees from x towards y, got {quoted(cell)}")
    return direction_at(float(cell))


def _refuse_number(where: str, name: str, cell: str) -> NoReturn:
    if DECIMAL_COMMA.fullmatch(cell):
        hint = "; write decimals with a point"
    elif cell.lower().lstrip("+-") in ("nan", "inf", "infinity", "") or cell.startswith("#"):
        hint = "; leave out rows that were not measured"
    else:
        hint = ""
    raise SettingError(f"{where}: expected a number for {name}, got {quoted(cell) if cell else 'nothing'}{hint}")


def _full_or_none(path: str, name: str, lines: Sequence[int], values: list[Any]) -> list[Any] | None:
    """A column that is full, or None if it is empty throughout."""
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


def _check_time(path: str, lines: Sequence[int], time: list[float] | None, run: list[str] | None) -> None:
    if time is None:
        return
    for index in range(1, len(time)):
        is_same_run = run is None or run[index] == run[index - 1]
        if is_same_run and time[index] < time[index - 1]:
            raise SettingError(
                f"{path} line {lines[index]}: expected rows in the order of time, got {time[index]:g} s after"
                f" {time[index - 1]:g} s; sort them by time_s"
            )


def _short(text: str) -> str:
    return text if len(text) <= MAX_QUOTED else text[: MAX_QUOTED - 1] + "…"


def quoted(what: object) -> str:
    """Something of the file on one line, control characters made visible."""
    return repr(_short(" ".join(str(what).split())))

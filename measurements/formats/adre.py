"""Tabular lists of Bently Nevada ADRE Sxp.

Blocks of lines with bars or tabs between the cells, UTF-16 or UTF-8.

    CH#|Channel Name|Machine Name|Status|Angle|Direction|Speed Units(P)|Amp Unit|Phase Unit|
    1|BRG1X|TURBINE|OK|45°|Right|rpm|mil pp|deg|

    CH#|Channel Name|Sample#|Sample Cause|Date|Speed(P)|Speed(S)|Direct|Avg Gap|Inst Gap|1XAmplitude|1X Phase|2XAmplitude|2X Phase|
    1|BRG1X|1|DT-T|03Mar1953 03:03:01.468|3599|0|0.994|-10.4|-10.4|0.454|138|0.221|25|

The first kind of block says what each channel is and is repeated, often before each sample; the second kind has a row per channel
and sample. A number may have letters behind it that say why it is not to be trusted, as 138BMA does: such a vector is left out. A
sample that stands again, as it does where groups of plots overlap, is read once; where its values differ it is refused. Phases
are lags.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ksmea.errors import SettingError, shortened
from measurements.formats.curve import Curve
from measurements.formats.texts import number, rows_of_cells, text_of
from measurements.formats.timestamps import seconds
from measurements.formats.user_answers import Answers
from measurements.run_up_rows import MAX_ROWS

CHANNEL, SAMPLE, SPEED, DATE = "channel name", "sample#", "speed(p)", "date"
OF_CHANNEL = ("angle", "direction", "speed units(p)", "amp unit")
FLAGGED = re.compile(r"([-+]?[0-9]*\.?[0-9]+)\s*[A-Za-z]{1,8}", re.ASCII)
AMPLITUDE = re.compile(r"([0-9]+\.?[0-9]*)\s*x\s*amplitude", re.ASCII)


@dataclass
class _Channel:
    """Properties and samples of one channel, while they are read."""

    said: dict[str, str] = field(default_factory=dict)
    lines: list[int] = field(default_factory=list)
    samples: dict[str, dict[str, str]] = field(default_factory=dict)  # cells by column, by number of the sample
    repeated: int = 0


def read_adre(content: bytes, answers: Answers) -> list[Curve]:
    """The channels of a list, each at each harmonic that it has.

    Raises `SettingError`, with the line at fault, for other content.
    """
    path, text = answers.path, text_of(content, answers.path)
    channels = _channels(text, path)
    if not channels:
        raise SettingError(
            f"{path}: expected an ADRE tabular list with the columns CH#, Channel Name, Sample#, Speed(P), 1XAmplitude, 1X Phase,"
            " got none; name the format of the file"
        )
    return [
        curve
        for name, channel in channels.items()
        for harmonic, column in _harmonics(channel).items()
        for curve in [_curve(name, channel, harmonic, column, path)]
        if curve is not None
    ]


def is_adre(text: str) -> bool:
    """Whether a text has a header of such a list."""
    return _separator(text) is not None


def _separator(text: str) -> str | None:
    return next((each for each in ("|", "\t", ",", ";") if re.search(rf"CH#\s*{re.escape(each)}", text)), None)


def _channels(text: str, path: str) -> dict[str, _Channel]:
    found: dict[str, _Channel] = {}
    header: list[str] = []
    separator = _separator(text)
    if separator is None:
        return found
    n_row = 0
    for line, cells in rows_of_cells(text, separator, path):
        lowered = [cell.lower() for cell in cells]
        if lowered[0] == "ch#":
            header = _header(lowered, f"{path} line {line}")
            continue
        if not header:
            continue
        n_row += 1
        if n_row > 2 * MAX_ROWS:
            raise SettingError(f"{path} line {line}: expected at most {2 * MAX_ROWS} rows, got more; thin them out")
        if len(cells) < len(header) or any(cells[len(header) :]):
            raise SettingError(f"{path} line {line}: expected {len(header)} cells as in the header, got {len(cells)}")
        row = dict(zip(header, cells))
        if not row[CHANNEL]:
            raise SettingError(f"{path} line {line}: expected a channel name, got none")
        channel = found.setdefault(row[CHANNEL], _Channel())
        _add(channel, row, line, f"{path} line {line}")
    return {name: channel for name, channel in found.items() if channel.samples}


def _header(names: list[str], where: str) -> list[str]:
    while names and not names[-1]:
        names.pop()
    if CHANNEL not in names:
        raise SettingError(f"{where}: expected a column Channel Name with CH#, got none")
    for name in names:
        if names.count(name) > 1:
            raise SettingError(f"{where}: expected each column once, got {shortened(name)} twice; remove one")
    if SAMPLE in names and SPEED not in names:
        raise SettingError(f"{where}: expected a column Speed(P) with Sample#, got none")
    return names


def _add(channel: _Channel, row: dict[str, str], line: int, where: str) -> None:
    if SAMPLE not in row:
        said = {name: row[name] for name in OF_CHANNEL if name in row}
        if channel.said and said != channel.said:
            raise SettingError(
                f"{where}: expected the channel to be as before, got other units or another angle; correct it"
            )
        channel.said = said
        return
    sample = row[SAMPLE]
    if sample in channel.samples:
        if row != channel.samples[sample]:
            raise SettingError(
                f"{where}: expected sample {shortened(sample)} once, got it again with other values; remove one"
            )
        channel.repeated += 1
        return
    channel.samples[sample] = row
    channel.lines.append(line)


def _harmonics(channel: _Channel) -> dict[float, str]:
    """Columns of amplitudes by harmonic."""
    columns = dict.fromkeys(name for row in channel.samples.values() for name in row)
    return {float(found[1]): name for name in columns if (found := AMPLITUDE.fullmatch(name)) and float(found[1]) > 0}


def _curve(name: str, channel: _Channel, harmonic: float, column: str, path: str) -> Curve | None:
    """None if the channel has no vectors, as a keyphasor or a gap voltage has none."""
    rows = list(channel.samples.values())
    of_phase = next((each for each in (f"{harmonic:g}x phase", f"{harmonic:g}xphase") if each in rows[0]), None)
    if not any(row.get(column) for row in rows):
        return None
    amplitude, flagged = _numbers([row.get(column, "") for row in rows], channel.lines, path)
    phase, flagged_phase = _numbers([row.get(of_phase, "") if of_phase else "" for row in rows], channel.lines, path)
    speed, flagged_speed = _numbers([row[SPEED] for row in rows], channel.lines, path)
    angle = " ".join(channel.said.get(each, "") for each in ("angle", "direction")).strip()
    is_from_vertical = channel.said.get("direction", "").lower() in ("left", "right")
    curve = Curve(
        name,
        "",
        list(channel.lines),
        speed,
        amplitude,
        phase=phase if of_phase else None,
        time=seconds([row.get(DATE, "") for row in rows]) if DATE in rows[0] else None,
        speed_unit=channel.said.get("speed units(p)", ""),
        unit=channel.said.get("amp unit", ""),
        sense="lag",
        angle=angle if is_from_vertical else "",
        harmonic=harmonic,
        left_out={"twice": channel.repeated} if channel.repeated else {},
    )
    return curve.rows(~(flagged | flagged_phase | flagged_speed), "flagged")


def _numbers(cells: Sequence[str], lines: Sequence[int], path: str) -> tuple[np.ndarray, np.ndarray]:
    """Numbers, and which of them have letters behind them that say not to trust them."""
    flagged = np.array([bool(FLAGGED.fullmatch(cell)) for cell in cells])
    values = [
        np.nan if flag else number(cell, f"{path} line {line}") for cell, line, flag in zip(cells, lines, flagged)
    ]
    return np.array(values), flagged

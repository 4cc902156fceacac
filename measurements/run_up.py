"""A run-up as a table of speeds and channels, from the rows of its file in any order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.measurement.speeds import SpeedHistory
from ksmea.units import DEGREE, MICROMETRE, RPM
from measurements.formats.questions import OpenQuestion
from measurements.run_up_rows import Rows
from measurements.sweeps import speed_history

ChannelCells = tuple[float, str, float]  # position (m), direction, harmonic


@dataclass(frozen=True)
class RunUp:
    """Contents of a file, SI, speeds rising.

    `first_lines` are the lines in which each channel appears first.
    """

    speed: Array  # (n_speed,) rad/s
    channels: tuple[Channel, ...]
    first_lines: tuple[int, ...]
    values: Array | ComplexArray  # (n_speed, n_channel) m
    sigma: Array | None  # (n_speed, n_channel) m
    history: SpeedHistory | None
    time: Array | None  # (n_speed,) s
    remarks: tuple[str, ...]
    order: Indices  # (n_speed, n_channel) the row of each


def run_up(
    rows: Rows,
    path: str,
    speed_from: float | None,
    speed_to: float | None,
    drop: bool,
    least: int = 2,
    repeats: bool = False,
) -> RunUp:
    """Rows in any order as a table of `least` speeds or more and channels, SI.

    With `repeats` a speed may be measured several times: the n-th rows of its channels belong together.
    """
    low, high = speed_from or 0.0, speed_to or math.inf
    used = [index for index, speed in enumerate(rows.speed) if low <= speed <= high]
    if not used:
        raise SettingError(
            f"{path}: expected speeds from {low:g} to {high:g} rpm, got {min(rows.speed):g} to {max(rows.speed):g} rpm;"
            " change speed_from or speed_to"
        )
    first_lines, by_speed = _by_speed(rows, used, path, repeats)
    complete = sorted(speed for speed, there in by_speed.items() if len(there) == len(first_lines))
    dropped = len(by_speed) - len(complete)
    if dropped and not drop:
        _refuse_incomplete(path, rows, by_speed, first_lines)
    _check_count(path, [speed for speed, _ in complete], dropped, least)
    order = np.array([[by_speed[speed][channel] for channel in first_lines] for speed in complete])
    amplitude = np.array(rows.amplitude)[order] * MICROMETRE
    _check_zeros(path, amplitude, first_lines)
    _check_harmonics(path, first_lines, has_phases=rows.phase is not None)
    remarks = [f"{dropped} of {len(by_speed)} speeds left out: a channel is missing there"] if dropped else []
    remarks += [f"{len(rows.line) - len(used)} of {len(rows.line)} rows left out by speed_from and speed_to"] * (
        len(used) < len(rows.line)
    )
    speeds = np.array([speed for speed, _ in complete]) * RPM
    recorded = np.argsort(order.min(axis=1))
    time = None if rows.time is None else np.array(rows.time)[order].min(axis=1)
    return RunUp(
        speed=speeds,
        channels=tuple(Channel(*channel) for channel in first_lines),
        first_lines=tuple(first_lines.values()),
        values=amplitude if rows.phase is None else amplitude * np.exp(1j * DEGREE * np.array(rows.phase)[order]),
        sigma=None if rows.sigma is None else np.array(rows.sigma)[order] * MICROMETRE,
        history=None if dropped else speed_history(speeds[recorded], None if time is None else time[recorded]),
        time=time,
        remarks=tuple(remarks),
        order=order,
    )


def _by_speed(
    rows: Rows, used: Sequence[int], path: str, repeats: bool
) -> tuple[dict[ChannelCells, int], dict[tuple[float, int], dict[ChannelCells, int]]]:
    """First line of each channel, and its rows by speed and repeat.

    The repeat is how many times the channel was measured there before.
    """
    first_lines: dict[ChannelCells, int] = {}
    by_speed: dict[tuple[float, int], dict[ChannelCells, int]] = {}
    for index in used:
        speed, channel, line = rows.speed[index], rows.channel[index], rows.line[index]
        first_lines.setdefault(channel, line)
        earlier = 0
        while channel in (there := by_speed.setdefault((speed, earlier), {})) and repeats:
            earlier += 1
        if channel in there:
            raise OpenQuestion(
                f"{path} line {line}: expected each speed and channel once, got {speed:g} rpm, {Channel(*channel)} again"
                f" after line {rows.line[there[channel]]}; average them (measurement.repeats=average), or keep one",
                "repeats",
                ("AVERAGE",),
                "average",
            )
        there[channel] = index
    return first_lines, by_speed


def _refuse_incomplete(
    path: str,
    rows: Rows,
    by_speed: Mapping[tuple[float, int], Mapping[ChannelCells, int]],
    first_lines: Mapping[ChannelCells, int],
) -> NoReturn:
    lacking = [there for there in by_speed.values() if len(there) < len(first_lines)]
    index = next(iter(lacking[0].values()))
    missing = next(channel for channel in first_lines if channel not in lacking[0])
    raise OpenQuestion(
        f"{path} line {rows.line[index]}: expected every channel at every speed, got no {Channel(*missing)} at"
        f" {rows.speed[index]:g} rpm ({len(lacking)} of {len(by_speed)} speeds lack one);"
        " measurement.incomplete=drop leaves such speeds out, interpolate brings channels to common ones",
        "incomplete",
        ("DROP_OR_INTERPOLATE",),
        "drop",
    )


def _check_count(path: str, complete: Sequence[float], dropped: int, least: int) -> None:
    if len(complete) < least:
        hint = (
            "the channels share too few speeds"
            if dropped
            else "one speed does not tell a response; import it as a run of a campaign (+experiment=balance)"
        )
        only = f"1 ({complete[0]:g} rpm)" if complete else "none"
        raise SettingError(f"{path}: expected at least {least} speeds with every channel, got {only}; {hint}")


def _check_zeros(path: str, amplitude: Array, first_lines: Mapping[ChannelCells, int]) -> None:
    for index, (channel, line) in enumerate(first_lines.items()):
        if 2 * np.count_nonzero(amplitude[:, index]) < len(amplitude):
            raise SettingError(
                f"{path} line {line}: expected amplitudes above 0, got 0 at more than half of the speeds from"
                f" {Channel(*channel)}; leave a probe out that does not work"
            )


def _check_harmonics(path: str, first_lines: Mapping[ChannelCells, int], *, has_phases: bool) -> None:
    """Check that amplitudes have only harmonics that the measurement accepts, with the line.

    See `ksmea.measurement.measurement`.
    """
    others = [(cells, line) for cells, line in first_lines.items() if not Channel(*cells).is_1x]
    if others and len(others) == len(first_lines):
        raise SettingError(f"{path}: expected rows at harmonic 1, got none; add the 1X vibration")
    if others and not has_phases:
        cells, line = others[0]
        raise SettingError(
            f"{path} line {line}: expected phases (phase_lead_deg) with {Channel(*cells)}, got amplitudes alone, which are"
            " never 0 where there is noise alone; add them, or leave out the rows of this harmonic"
        )

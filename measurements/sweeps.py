"""The parts of a record in which the speed goes one way: a run-up, a coast-down, or both in one file."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from measurements.formats.questions import OpenQuestion
from measurements.run_up_rows import Rows, rows_at
from measurements.vectors import by_channel

TURNED = 0.1  # of the range of speeds: what goes back by less goes on
UP, DOWN, ANY = "up", "down", "any"


def legs(speed: Array) -> list[tuple[int, int, int]]:
    """First index, index behind the last and sense (+1, −1) of each part of speeds (n,) that goes one way.

    >>> legs(np.array([1.0, 2.0, 3.0, 2.5, 1.0]))
    [(0, 3, 1), (3, 5, -1)]
    """
    least = TURNED * float(np.ptp(speed))
    if least == 0:
        return [(0, len(speed), 1)]
    turns, sense, low, high = [0], 0, 0, 0
    senses = []
    for index, value in enumerate(speed):
        low = index if value <= speed[low] else low
        high = index if value >= speed[high] else high
        if sense <= 0 and value - speed[low] > least:
            if sense < 0:
                turns.append(low + 1)
            sense, high = 1, index
            senses.append(sense)
        elif sense >= 0 and speed[high] - value > least:
            if sense > 0:
                turns.append(high + 1)
            sense, low = -1, index
            senses.append(sense)
    return [(start, stop, each) for (start, stop), each in zip(pairwise([*turns, len(speed)]), senses)]


def has_both(rows: Rows) -> bool:
    """Whether the speed of any channel turns back."""
    speed = np.array(rows.speed)
    return any(len(legs(speed[indices])) > 1 for indices in by_channel(rows).values())


def rows_of_sweep(rows: Rows, sweep: str, path: str) -> tuple[Rows, str]:
    """The rows in which the speed goes up, or down, and a remark on the others. Raises `SettingError` where there is no such
    part or there are several."""
    speed, kept = np.array(rows.speed), []
    sense = 1 if sweep == UP else -1
    for channel, indices in by_channel(rows).items():
        parts = [(start, stop) for start, stop, each in legs(speed[indices]) if each == sense]
        if len(parts) != 1:
            raise SettingError(
                f"{path}: expected one part in which the speed goes {sweep}, which sweep asks for, got {len(parts) or 'none'} of"
                f" {channel}; cut the file, or give sweep=any"
            )
        start, stop = parts[0]
        kept += indices[start:stop].tolist()
    left_out = len(rows.line) - len(kept)
    told = f"sweep: {sweep}" + (f", {left_out} of {len(rows.line)} rows left out" if left_out else "")
    return rows_at(rows, sorted(kept)), told


def require_one_way(rows: Rows, path: str) -> None:
    """Raise `SettingError` where the speed turns back and nobody has said what is meant."""
    if has_both(rows):
        raise OpenQuestion(
            f"{path}: expected speeds that rise or fall throughout, got both; give sweep=up or sweep=down for one part of the"
            " record, or sweep=any for speeds in any order",
            "sweep",
            ("UP_DOWN_OR_ANY",),
            UP,
        )

"""Sweeps in a record: run-up and coast-down in one file, and the rate of each from times or rows.

With times the rate is the slope of the speed. Without them, speeds that rise or fall throughout, in many rows that are not evenly
spaced, are taken for a sweep. If each row is a turn of the shaft, as in a record triggered by its key, Ω² is a straight line
over the rows at a constant rate α, with the slope 4πα.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.speeds import DIRECTIONS, SpeedHistory
from ksmea.units import TURN
from measurements.formats.questions import OpenQuestion
from measurements.run_up_rows import Rows, rows_at
from measurements.slow_roll import by_channel

TURNED = 0.1  # of the range of speeds: what goes back by less goes on
STEADY = 1e-6  # of the highest speed: rows that differ by less have one speed
UP, DOWN, ANY = "up", "down", "any"


def legs(speed: Array) -> list[tuple[int, int, int]]:
    """First index, index behind the last and sense (+1, −1) of each part of speeds (n,) that goes one way.

    >>> legs(np.array([1.0, 2.0, 3.0, 2.5, 1.0]))
    [(0, 3, 1), (3, 5, -1)]
    """
    least = TURNED * float(np.ptp(speed))
    if least <= TURNED * STEADY * float(np.max(speed)):
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
    """The rows in which the speed goes up, or down, and a remark on the others.

    Raises `SettingError` if such a part is missing or there are several.
    """
    speed, kept = np.array(rows.speed), []
    sense = 1 if sweep == UP else -1
    for channel, indices in by_channel(rows).items():
        parts = [(start, stop) for start, stop, each in legs(speed[indices]) if each == sense]
        if len(parts) != 1:
            raise SettingError(
                f"{path}: expected one part in which the speed goes {sweep}, as sweep requires, got"
                f" {len(parts) or 'none'} of {channel}; cut the file, or give sweep=any"
            )
        start, stop = parts[0]
        kept += indices[start:stop].tolist()
    left_out = len(rows.line) - len(kept)
    remark = f"sweep: {sweep}" + (f", {left_out} of {len(rows.line)} rows left out" if left_out else "")
    return rows_at(rows, sorted(kept)), remark


def require_one_way(rows: Rows, path: str) -> None:
    """Raise `SettingError` if the speed turns back and nobody has said what is meant."""
    if has_both(rows):
        raise OpenQuestion(
            f"{path}: expected speeds that rise or fall throughout, got both; give sweep=up or sweep=down for one part of the"
            " record, or sweep=any for speeds in any order",
            "sweep",
            ("UP_DOWN_OR_ANY",),
            UP,
        )


FEWEST = 10  # rows with times that say a rate
MANY = 50  # rows without times that are taken for a sweep: steady speeds are set by hand, and fewer
EVEN = 0.02  # of the mean step, by which the steps of a grid of steady speeds differ at most
FEWEST_EVEN, SINGLE = (
    3.0,
    0.5,
)  # even steps in a row, on average, of a grid that is finer in places; part of the rows that are of one step
NEAR_ROW = 1.0  # rows: root mean square distance of the row numbers from those at a constant rate
STRAIGHTER = 3.0  # times as near as those of a speed that rises evenly from row to row


def speed_history(speed: Array, time: Array | None) -> SpeedHistory | None:
    """History of speeds (n,) rad/s in the order of their rows, with times (n,) s or none.

    None if they are no sweep.
    """
    steps = np.diff(speed)
    if time is not None and len(speed) >= FEWEST and time[-1] > time[0]:
        return _timed(speed, time) if _is_one_way(speed) else None
    if len(speed) < MANY or not (np.all(steps > 0) or np.all(steps < 0)) or _is_grid(steps):
        return None
    if _distance(speed**2) < min(NEAR_ROW, _distance(speed) / STRAIGHTER):
        rates = _slopes(np.arange(len(speed), dtype=float), speed**2) / (2 * TURN)
        # rising rows may have been sorted: nobody sorts them so that they fall
        return SpeedHistory("either" if rates[0] > 0 else DIRECTIONS[1], (float(rates[0]), float(rates[1])))
    return SpeedHistory("either" if steps[0] > 0 else DIRECTIONS[1])


def _is_grid(steps: Array) -> bool:
    """Whether steps (n - 1,) form a grid, or grids in turn.

    Steady speeds are set evenly, and more finely at criticals.
    """
    close = EVEN * abs(steps.mean())
    rows = np.split(steps, np.flatnonzero(np.abs(np.diff(steps)) > close) + 1)
    lengths = np.array([len(row) for row in rows])
    is_even = all(np.ptp(row) < close for row in rows)
    return bool(is_even and lengths.mean() >= FEWEST_EVEN and np.mean(lengths == 1) <= SINGLE) or np.ptp(steps) < close


def _timed(speed: Array, time: Array) -> SpeedHistory:
    rates = _slopes(time, speed)
    return SpeedHistory(DIRECTIONS[int(rates.sum() < 0)], (float(rates[0]), float(rates[1])), from_times=True)


def _is_one_way(speed: Array) -> bool:
    """Whether speeds go one way but for noise: steps back are a tenth of all at most."""
    steps = np.diff(speed)
    return bool(np.abs(steps.sum()) >= 0.8 * np.abs(steps).sum())


def _slopes(x: Array, y: Array) -> Array:
    """Slopes of straight lines through the first and the second half, (2,)."""
    half = len(x) // 2
    return np.array([np.polyfit(x[part], y[part], 1)[0] for part in (slice(0, half), slice(half, None))])


def _distance(y: Array) -> float:
    """Root mean square distance of row numbers from a straight line through y, rows."""
    rows = np.arange(len(y))
    slope, offset = np.polyfit(rows, y, 1)
    return float(np.std(y - slope * rows - offset) / abs(slope))

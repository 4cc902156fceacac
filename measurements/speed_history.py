"""How the speed went, from the rows of a file in the order in which they were recorded.

With times the rate is the slope of the speed. Without them speeds that rise or fall throughout, in many rows that are not evenly
spaced, are taken for a sweep. Where each row is a turn of the shaft, as a record triggered by its key has it, Ω² is a straight line
over the rows at a constant rate α, with the slope 4πα.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from ksmea.speed_history import DIRECTIONS, SpeedHistory
from ksmea.units import TURN

FEWEST = 10  # rows with times that say a rate
MANY = 50  # rows without times that are taken for a sweep: steady speeds are set by hand, and fewer
EVEN = 0.02  # of the mean step, by which the steps of a grid of steady speeds differ at most
NEAR_ROW = 1.0  # rows: root mean square distance of the row numbers from those at a constant rate
STRAIGHTER = 3.0  # times as near as those of a speed that rises evenly from row to row


def speed_history(speed: Array, time: Array | None) -> SpeedHistory | None:
    """Of speeds (n,) rad/s in the order of their rows, with times (n,) s or none; None where they are no sweep."""
    steps = np.diff(speed)
    if time is not None and len(speed) >= FEWEST and time[-1] > time[0]:
        return _timed(speed, time) if _is_one_way(speed) else None
    if len(speed) < MANY or not (np.all(steps > 0) or np.all(steps < 0)) or np.ptp(steps) < EVEN * abs(steps.mean()):
        return None
    if _distance(speed**2) < min(NEAR_ROW, _distance(speed) / STRAIGHTER):
        rates = _slopes(np.arange(len(speed), dtype=float), speed**2) / (2 * TURN)
        # rising rows may have been sorted: nobody sorts them so that they fall
        return SpeedHistory("either" if rates[0] > 0 else DIRECTIONS[1], (float(rates[0]), float(rates[1])))
    return SpeedHistory("either" if steps[0] > 0 else DIRECTIONS[1])


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

"""Times of samples as a file states them: a column of numbers, or of dates and clock times.

Even samples whose printed times are rounded are put back on their even steps. Other times are taken as they stand: a logger that
samples whenever it can has steps of its own, and 36 s of steps of 632 to 648 µs at random lie up to milliseconds off even ones.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, shortened
from measurements.formats.sheet import Sheet
from measurements.formats.timestamps import seconds
from measurements.formats.unit_texts import seconds_per

MOST_DECIMALS = 9  # of a time in a file, in its own unit
LARGEST = 1e12  # of a time: seconds and even milliseconds of a calendar are less
ROUNDED = 0.55  # of the last decimal, by which a rounded time may lie off its true value, and a little more for the fitted line
EXACT = 1e-3  # of the last decimal: what numbers lie off it by their binary form
SAME = 1e-4  # of a step, by which the steps of an even clock may differ


def clock_of(sheet: Sheet, heading: str) -> tuple[Array, str]:
    """The time of each sample, s, from a column, and a remark if steps are uneven.

    Raises `SettingError` if times do not rise.
    """
    stated = times_of(sheet, heading)
    unit = seconds_per(sheet.unit(heading), sheet.where)
    if np.any(bad := ~(np.abs(stated) <= LARGEST)):
        first = int(np.flatnonzero(bad)[0])
        raise SettingError(
            f"{sheet.where} line {sheet.lines[first]}: expected a time in {shortened(heading)}, got"
            f" {'none' if np.isnan(stated[first]) else f'{stated[first]:g}'}; cut the record there"
        )
    if len(stated) > 1 and (even := _even(stated)) is not None:
        return even * unit, ""
    time = stated * unit
    steps = np.diff(time)
    if len(time) < 2 or np.any(steps <= 0):
        first = int(np.flatnonzero(steps <= 0)[0]) + 1 if len(time) > 1 else 0
        raise SettingError(
            f"{sheet.where} line {sheet.lines[first]}: expected times that rise, got one that does not; sort them, or give"
            " sampling=Hz instead of the column if the clock is too coarse"
        )
    if np.ptp(steps) <= SAME * np.median(steps):
        return time, ""
    least, middle, most = (f"{1e6 * each:.4g}" for each in (np.min(steps), np.median(steps), np.max(steps)))
    return time, f"clock: uneven steps of {least} to {most} µs (median {middle}), each sample at its own time"


def times_of(sheet: Sheet, heading: str) -> Array:
    """A column of times as numbers, in its own unit; dates and clock times as seconds from the first."""
    try:
        return sheet.numbers(heading)
    except SettingError:
        found = seconds(sheet.texts(heading))
        if found is None:
            raise
        return found


def _even(time: Array) -> Array | None:
    """Even times (n,) of which the given ones are rounded; None if rounding does not explain them."""
    if np.any(np.diff(time) < 0):
        return None
    number = np.arange(len(time), dtype=float)
    slope, offset = np.polyfit(number, time - time[0], 1)
    even = time[0] + offset + slope * number
    return even if float(np.max(np.abs(time - even))) <= ROUNDED * _last_place(time) else None


def _last_place(time: Array) -> float:
    """Rounding unit of times: the last decimal that any of them has, or the spacing of single precision.

    It is 0 if neither is known.
    """
    for decimals in range(MOST_DECIMALS + 1):
        scaled = time * 10.0**decimals
        if np.all(np.abs(scaled - np.round(scaled)) <= EXACT):
            return float(10.0**-decimals)
    single = time.astype(np.float32)
    return float(np.spacing(np.max(np.abs(single)))) if np.array_equal(single, time) else 0.0

"""Turns of a shaft without a keyphasor.

They come from a column of its speed, from one constant speed, or from the vibration itself.

Without a mark nothing says where a turn begins: the turns give amplitudes, and phases only of one window to the next.

From the vibration, the speed is the frequency of its strongest component in a stated band, which has to be the 1X. Spectra of short
windows (ten periods, Hann) are searched for the course of largest power whose speed changes by a few per cent at most from one
window to the next (dynamic programming, A. J. Viterbi, IEEE Trans. Inf. Theory 13 (1967) 260–269, doi 10.1109/TIT.1967.1054010);
each peak lies at the vertex of a parabola through the logarithms of three lines.
"""

from __future__ import annotations

import numpy as np
import scipy

from ksmea.arrays import Array, Indices
from ksmea.errors import SettingError
from ksmea.units import RPM, TURN

SAMPLES_A_TURN = 16  # of the highest speed
PERIODS = 10  # of the middle of the band, in a window
STEP = 0.25  # of a window, from one to the next
PADDED = 8  # times as long as the window, with zeros
STEEPEST = 0.06  # relative change of the speed from one window to the next, at most
FEWEST_WINDOWS = 4
CLEAR = 4.0  # times as strong as the middle of the band is the 1X in half of the windows
SMOOTHED = 7  # windows that a parabola evens


def turns_at(time: Array, speed: Array, where: str) -> Array:
    """Times (n_turn + 1,) s at which whole turns have passed since the first sample.

    The speed is (n_sample,) rad/s.
    """
    if np.any(bad := speed <= 0):
        at = int(np.flatnonzero(bad)[0])
        raise SettingError(
            f"{where}: expected speeds above 0 in each sample, got {speed[at] / RPM:g} rpm at {time[at]:.6g} s; cut the record there"
        )
    turns = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(time))]) / TURN
    return np.asarray(np.interp(np.arange(int(turns[-1]) + 1), turns, time))


def speed_in_vibration(time: Array, signals: Array, lowest: float, highest: float) -> Array:
    """The speed (n_sample,) rad/s between two speeds at which signals (n_sample, n_signal) vibrate most.

    Raises `SettingError` if the record is too short or nothing stands out.
    """
    rate = (len(time) - 1) / (time[-1] - time[0])
    block = max(
        int(rate * TURN / (SAMPLES_A_TURN * highest)), 1
    )  # of samples that are averaged: more are of no use here
    n = len(time) // block
    means = [each[: n * block].reshape(n, block).mean(axis=1) for each in (time, *signals.T)]
    even = np.linspace(means[0][0], means[0][-1], n)
    waves = np.stack([np.interp(even, means[0], each) for each in means[1:]])
    rate /= block
    length = int(PERIODS * TURN / np.sqrt(lowest * highest) * rate)
    starts = np.arange(0, len(even) - length + 1, max(int(STEP * length), 1))
    if highest * 2 > np.pi * rate:
        raise SettingError(
            f"speed_band: expected speeds of at least four samples a turn, got {highest / RPM:g} rpm; lower the band"
        )
    if len(starts) < FEWEST_WINDOWS:
        raise SettingError(
            f"speed_band: expected a record of {PERIODS} turns and more, got {time[-1] - time[0]:.3g} s; raise the band, or give"
            " constant_speed"
        )
    power, lines = _spectra(waves, starts, length, rate, lowest, highest)
    course = _course(power, lines)
    strong = power[np.arange(len(starts)), course] / np.median(power, axis=1)
    if np.median(strong) < CLEAR**2:
        raise SettingError(
            f"speed_band: expected a vibration that stands out between {lowest / RPM:g} and {highest / RPM:g} rpm, got none; change the"
            " band, or name a column of the speed"
        )
    found = _vertices(power, lines, course)
    width = min(SMOOTHED, len(found) - (len(found) + 1) % 2)
    smooth = scipy.signal.savgol_filter(found, width, 2) if width > 2 else found
    # straight on to the ends of the record, half a window from the middles of the first and the last
    return np.asarray(
        np.clip(
            scipy.interpolate.interp1d(even[starts + length // 2], smooth, fill_value="extrapolate")(time),
            lowest,
            highest,
        )
    )


def _spectra(
    waves: Array, starts: Indices, length: int, rate: float, lowest: float, highest: float
) -> tuple[Array, Array]:
    """Power (n_window, n_line) of all signals in the band, and its lines (n_line,) rad/s."""
    size = PADDED * length
    lines = TURN * rate * np.arange(size // 2 + 1) / size
    band = np.flatnonzero((lines >= lowest) & (lines <= highest))
    taper = np.hanning(length)
    power = np.zeros((len(starts), len(band)))
    for row, start in enumerate(starts):
        part = waves[:, start : start + length]
        part = part - part.mean(axis=1, keepdims=True)
        power[row] = np.sum(np.abs(np.fft.rfft(part * taper, size)[:, band]) ** 2, axis=0)
    return power + np.finfo(float).tiny, lines[band]


def _course(power: Array, lines: Array) -> Indices:
    """The line of each window on the course of the largest product of powers that is nowhere too steep."""
    gain = np.log(power)
    reach = max(int(STEEPEST * float(np.mean(lines)) / (lines[1] - lines[0])), 1)
    best = gain[0]
    came = np.zeros(power.shape, dtype=int)
    for row in range(1, len(power)):
        padded = np.pad(best, reach, constant_values=-np.inf)
        nearby = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
        came[row] = np.argmax(nearby, axis=1) + np.arange(len(lines)) - reach
        best = best[came[row]] + gain[row]
    course = [int(np.argmax(best))]
    for row in range(len(power) - 1, 0, -1):
        course.append(int(came[row, course[-1]]))
    return np.array(course[::-1])


def _vertices(power: Array, lines: Array, course: Indices) -> Array:
    """The speed of each window between its lines."""
    inner = np.clip(course, 1, len(lines) - 2)
    rows = np.arange(len(power))
    left, middle, right = (np.log(power[rows, inner + step]) for step in (-1, 0, 1))
    bend = left - 2 * middle + right
    shift = np.where(bend < 0, (left - right) / (2 * np.where(bend < 0, bend, 1.0)), 0.0)
    return np.asarray(lines[inner] + np.clip(shift, -1, 1) * (lines[1] - lines[0]))

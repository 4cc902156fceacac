"""Slow roll: the probe readings of a shaft that turns too slowly to deflect, subtracted from all rows.

The mean vector of a channel's rows up to the highest speed of slow roll is subtracted from its other rows, as complex numbers. Its
variance is added to theirs if the file states one; the correlation that this makes between rows is neglected.
"""

from __future__ import annotations

import dataclasses
from functools import partial

import numpy as np
import scipy  # its parts load at first use, and few files need peaks

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.units import DEGREE
from measurements.run_up_rows import Rows, rows_at

NEAR = 0.15  # of the first critical speed: below, unbalance moves a flexible rotor by less than 2.3 % of its mass eccentricity
PROMINENT = 0.3  # of the largest amplitude: the prominence of a peak that counts as a resonance
SUBTRACTED = "slow roll: subtracted"  # how the remark begins by which a file is known


def without_slow_roll(rows: Rows, highest: float, path: str) -> tuple[Rows, str]:
    """The rows above a speed (rpm) without the slow-roll vectors, and the remark that says these."""
    if rows.phase is None:
        raise SettingError(
            f"{path}: expected phases for slow_roll, which is a vector, got amplitudes; leave slow_roll out"
        )
    values, speed = vectors(rows), np.array(rows.speed)
    sigma = None if rows.sigma is None else np.array(rows.sigma)
    runouts, kept = [], []
    for channel, indices in by_channel(rows).items():
        slow, fast = indices[speed[indices] <= highest], indices[speed[indices] > highest]
        if not len(slow) or not len(fast):
            raise SettingError(
                f"{path}: expected rows of {channel} up to slow_roll={highest:g} rpm and above, got {np.min(speed[indices]):g} to"
                f" {np.max(speed[indices]):g} rpm; change slow_roll"
            )
        runout = np.mean(values[slow])
        values[fast] = values[fast] - runout
        if sigma is not None:
            sigma[fast] = np.hypot(sigma[fast], np.sqrt(np.sum(sigma[slow] ** 2)) / len(slow))
        kept += fast.tolist()
        runouts.append(
            f"{channel} {abs(runout):.4g} µm at {np.angle(runout, deg=True):.4g}° lead of {len(slow)} row{'s' * (len(slow) > 1)}"
        )
    changed = rows_at(with_vectors(rows, values, sigma), sorted(kept))
    said = f"{SUBTRACTED}, the mean vector up to {highest:g} rpm of {'; '.join(runouts)}"
    peaks = map(partial(_first_peak, changed), by_channel(changed).values())
    critical = min((peak for peak in peaks if peak), default=None)
    if critical is None or highest < NEAR * critical:
        return changed, said
    ratio = highest / critical
    return changed, (
        f"{said}; {highest:g} rpm is {100 * ratio:.0f} % of the first resonance in these data, {critical:.0f} rpm, where unbalance moves"
        f" the shaft by up to {100 * ratio**2 / (1 - ratio**2):.1f} % of the mass eccentricity: this real motion is subtracted too; give"
        f" slow_roll below {NEAR * critical:.0f} rpm"
    )


def _first_peak(rows: Rows, indices: Indices) -> float | None:
    """Speed (rpm) of the first resonance of a channel at 1X: the lowest peak that stands out.

    None without one.
    """
    speed, amplitude = np.array(rows.speed)[indices], np.array(rows.amplitude)[indices]
    if rows.channel[indices[0]][2] != 1:
        return None
    order = np.argsort(speed, kind="stable")
    peaks, _ = scipy.signal.find_peaks(amplitude[order], prominence=PROMINENT * amplitude.max())
    return float(speed[order][peaks[0]]) if len(peaks) else None


def vectors(rows: Rows) -> Array | ComplexArray:
    """Reading of each row, (n_row,) µm zero to peak: complex with phases, otherwise amplitudes."""
    amplitude = np.array(rows.amplitude)
    return amplitude if rows.phase is None else amplitude * np.exp(1j * DEGREE * np.array(rows.phase))


def with_vectors(rows: Rows, values: Array | ComplexArray, sigma: Array | None) -> Rows:
    """The rows with other vectors (n_row,) and standard deviations."""
    return dataclasses.replace(
        rows,
        amplitude=np.abs(values).tolist(),
        phase=None if rows.phase is None else np.angle(values, deg=True).tolist(),
        sigma=None if sigma is None else sigma.tolist(),
    )


def by_channel(rows: Rows) -> dict[Channel, Indices]:
    """Indices of the rows of each channel, in the order of the file."""
    found: dict[tuple[float, str, float], list[int]] = {}
    for index, channel in enumerate(rows.channel):
        found.setdefault(channel, []).append(index)
    return {Channel(*channel): np.array(indices) for channel, indices in found.items()}

"""Slow roll: the probe readings of a shaft that turns too slowly to deflect, subtracted from all rows.

The mean vector of a channel's rows up to the highest speed of slow roll is subtracted from its other rows, as complex numbers. Its
variance is added to theirs if the file states one; the correlation that this makes between rows is neglected.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.units import DEGREE
from measurements.run_up_rows import Rows, rows_at

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
    changed = with_vectors(rows, values, sigma)
    return rows_at(
        changed, sorted(kept)
    ), f"{SUBTRACTED}, the mean vector up to {highest:g} rpm of {'; '.join(runouts)}"


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

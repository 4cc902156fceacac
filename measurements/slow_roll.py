"""Slow roll: what probes read of a shaft that turns so slowly that it does not move, taken off once.

The mean vector of a channel's rows up to the highest speed of slow roll is subtracted from its other rows, as complex numbers. Its
own variance is added to theirs where the file states one; that it is the same error in all rows is not said.
"""

from __future__ import annotations

import numpy as np

from ksmea.errors import SettingError
from measurements.run_up_rows import Rows, rows_at
from measurements.vectors import by_channel, vectors, with_vectors

SUBTRACTED = "slow roll: subtracted"  # how the remark begins by which a file is known


def without_slow_roll(rows: Rows, highest: float, path: str) -> tuple[Rows, str]:
    """The rows above a speed (rpm) without the slow-roll vectors, and the remark that says these."""
    if rows.phase is None:
        raise SettingError(
            f"{path}: expected phases for slow_roll, which is a vector, got amplitudes; leave slow_roll out"
        )
    values, speed = vectors(rows), np.array(rows.speed)
    sigma = None if rows.sigma is None else np.array(rows.sigma)
    told, kept = [], []
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
        told.append(
            f"{channel} {abs(runout):.4g} µm at {np.angle(runout, deg=True):.4g}° lead of {len(slow)} row{'s' * (len(slow) > 1)}"
        )
    changed = with_vectors(rows, values, sigma)
    return rows_at(changed, sorted(kept)), f"{SUBTRACTED}, the mean vector up to {highest:g} rpm of {'; '.join(told)}"

"""The band of speeds of a run-up: its two ends and a number of equal steps."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError

FASTEST = 1e7  # in any unit: no shaft turns as fast


def check_band(speed_from: float, speed_to: float, n_speed: int) -> None:
    """Raise `SettingError` where the ends are swapped, or are one while several speeds are asked for."""
    if speed_to > FASTEST:
        raise SettingError(f"speed_to: expected at most {FASTEST:g}, got {speed_to:g}; check it and its unit")
    if speed_to < speed_from or (speed_to == speed_from and n_speed > 1):
        raise SettingError(f"speed_to: expected more than speed_from ({speed_from:g}), got {speed_to:g}; swap them")


def band(speed_from: float, speed_to: float, n_speed: int, rad_per_s: float) -> Array:
    """(n_speed,) rad/s, from ends in a unit of `rad_per_s`."""
    return rad_per_s * np.linspace(speed_from, speed_to, n_speed)

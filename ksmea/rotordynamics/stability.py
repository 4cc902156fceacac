"""Stability threshold: the lowest spin speed at which a free vibration grows.

No steady-state response exists there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ksmea.arrays import Array

N_SCAN = 24  # speeds that are looked at; unstable bands narrower than a step between them may be missed
SLOWEST = 1e-6  # of the highest speed: stands in for rest, where coefficients over speed have no value
TOLERANCE = 1e-6  # of the highest speed
N_HALVING = 10  # of the way to an unstable state: the last stable one is found within 0.1 % of it


def scanned_speeds(highest: float) -> Array:
    """The spin speeds (rad/s) that are looked at, from rest to the highest, (N_SCAN + 1,)."""
    return np.linspace(0.0, highest, N_SCAN + 1).clip(SLOWEST * highest)


def lowest_unstable_speed(growth_rate: Callable[[Array], Array], highest: float) -> float:
    """Lowest speed up to `highest` (rad/s) at which a growth rate is above 0.

    The growth rate is a function of speeds (n,) to (n,) 1/s. The result is 0 if it is so from rest, infinite if
    nowhere.
    """
    speed = scanned_speeds(highest)
    unstable = np.flatnonzero(growth_rate(speed) > 0)
    if not len(unstable):
        return np.inf
    if unstable[0] == 0:
        return 0.0
    low, high = float(speed[unstable[0] - 1]), float(speed[unstable[0]])
    while high - low > TOLERANCE * highest:
        middle = (low + high) / 2
        low, high = (low, middle) if growth_rate(np.array([middle]))[0] > 0 else (middle, high)
    return high


def grows_nowhere(growth_rate: Callable[[Array], Array], highest: float) -> bool:
    """Whether a growth rate, as above, is above 0 at none of the speeds that are looked at.

    The highest of them, at which most rotors that are unstable are so, is requested first and alone.
    """
    last, others = np.split(scanned_speeds(highest)[::-1], [1])
    return not (np.any(growth_rate(last) > 0) or np.any(growth_rate(others) > 0))


def last_stable(is_stable: Callable[[float], bool]) -> float:
    """Largest part of the way from a stable state to an unstable one up to which `is_stable`.

    It is from 0 to 1, within 2^-`N_HALVING`.
    """
    low, high = 0.0, 1.0
    for _ in range(N_HALVING):
        middle = (low + high) / 2
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return low

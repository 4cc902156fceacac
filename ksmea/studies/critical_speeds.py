"""Where natural frequencies equal a multiple of the spin speed: the crossings of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.optimize import brentq, linear_sum_assignment

from ksmea.arrays import Array
from ksmea.rotordynamics import FreeRotor
from ksmea.whirl import NO_PEAK, CriticalSpeed, direction_of_whirl

TOLERANCE = 1e-9  # of the highest speed
SAME = 0.2  # |ln| of the ratio of a damped critical speed to an undamped one that may be the same one


def critical_speeds(rotor: FreeRotor, speed: Array, harmonics: Sequence[float]) -> tuple[CriticalSpeed, ...]:
    """Speeds (rad/s) within rising scanned speeds (n_speed,) at which a damped natural frequency is a harmonic of the speed, each
    with the undamped critical speed next to it; none where damping is so large that the response has no peak. A frequency that crosses twice between two scanned speeds is missed."""
    damped, undamped = rotor.frequencies, partial(rotor.frequencies, damped=False)
    tables = damped(speed), undamped(speed)
    found: list[CriticalSpeed] = []
    for harmonic in harmonics:
        at_harmonic = [
            _critical_speed(rotor, each, harmonic) for each in _crossings(damped, tables[0], speed, harmonic)
        ]
        resonant = [each for each in at_harmonic if each.damping_ratio < NO_PEAK]
        found += _with_undamped(resonant, np.array(_crossings(undamped, tables[1], speed, harmonic)))
    return tuple(found)


def _critical_speed(rotor: FreeRotor, speed: float, harmonic: float) -> CriticalSpeed:
    [motions] = rotor.motions(np.array([speed]))
    nearest = int(np.argmin(np.abs(motions.eigenvalue.imag - harmonic * speed)))
    direction = direction_of_whirl(*motions.shape[nearest].T)
    return CriticalSpeed(speed, harmonic, complex(motions.eigenvalue[nearest]), direction)


def _crossings(frequencies: Callable[[Array], Array], table: Array, speed: Array, harmonic: float) -> list[float]:
    """Where a column of frequencies, whose `table` at the scanned speeds is (n_speed, n), equals a multiple of the speed, rising."""
    is_above = table >= harmonic * speed[:, None]
    found = []
    for interval, column in zip(*np.nonzero(is_above[:-1] != is_above[1:])):

        def excess_at(at: float, column: int = int(column)) -> float:
            return float(frequencies(np.array([at]))[0, column] - harmonic * at)

        found.append(brentq(excess_at, speed[interval], speed[interval + 1], xtol=TOLERANCE * speed[-1]))
    return sorted(found)


def _with_undamped(found: list[CriticalSpeed], undamped: Array) -> list[CriticalSpeed]:
    """Each with the undamped critical speed that is nearest to it, which belongs to no other."""
    if not found or not len(undamped):
        return found
    apart = np.abs(np.log(np.array([each.speed for each in found])[:, None] / undamped))
    nearest = dict(zip(*(part.tolist() for part in linear_sum_assignment(np.minimum(apart, SAME)))))
    return [
        CriticalSpeed(each.speed, each.harmonic, each.eigenvalue, each.direction, float(undamped[nearest[index]]))
        if index in nearest and apart[index, nearest[index]] < SAME
        else each
        for index, each in enumerate(found)
    ]

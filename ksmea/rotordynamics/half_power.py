"""Half-power widths of the peaks of a response over speed."""
# Shorter than 40 lines: one definition that charts, fine speeds and texts share.

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, peak_indices

HALF_POWER = np.sqrt(0.5)  # of the amplitude at a peak


@dataclass(frozen=True)
class FullPeak:
    """A peak with both speeds (rad/s) at which the amplitude is lower by a factor √2."""

    speed: float
    low: float
    high: float

    @property
    def width(self) -> float:
        return self.high - self.low


def full_peaks(speed: Array, amplitude: Array) -> Iterator[FullPeak]:
    """Peaks of an amplitude (n_speed,) at rising speeds that fall to half power on both sides."""
    for peak in peak_indices(amplitude):
        least = HALF_POWER * amplitude[peak]
        before, behind = np.flatnonzero(amplitude[:peak] < least), np.flatnonzero(amplitude[peak:] < least)
        if len(before) and len(behind):
            first, last = before[-1], peak + behind[0]
            low = np.interp(least, amplitude[first : first + 2], speed[first : first + 2])
            high = np.interp(-least, -amplitude[last - 1 : last + 1], speed[last - 1 : last + 1])
            yield FullPeak(float(speed[peak]), float(low), float(high))

"""Pulses whose times a sampling rate rounds, evened over neighbouring turns.

A pulse with steep edges is known to a sample: with 60 samples in a turn the speed of one turn would be wrong by up to 1.7 %, which is
more than the width of a sharp resonance. How far pulses lie off an even course shows in the third differences of their times, which a
steady acceleration leaves at 0 and independent errors of σ at √20 σ. Where that makes turns uneven, each time is that of a cubic
through the pulses around it (A. Savitzky & M. J. E. Golay, Anal. Chem. 36 (1964) 1627–1639, doi 10.1021/ac60214a047), through as many
as the speed needs.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from ksmea.arrays import Array

UNEVEN = 1e-3  # relative error of the speed of one turn, below which pulses are left as they are
WANTED = 3e-4  # relative error of the speed that is aimed at
ORDER = 3
WIDEST = 61  # pulses
NORMAL = 0.6745  # median of the modulus of a normal error, in standard deviations


def evened(pulses: Array) -> Array:
    """Pulse times (n,) s, smoothed where their errors make the speed of a turn uncertain."""
    error = _relative_error(pulses)
    if error < UNEVEN:
        return pulses
    widths = range(ORDER + 2, min(WIDEST, len(pulses)) + 1, 2)
    enough = (width for width in widths if error * _left(width) < WANTED)
    width = next(enough, max(widths, default=0))
    return np.asarray(savgol_filter(pulses, width, ORDER)) if width else pulses


def _relative_error(pulses: Array) -> float:
    """Of a pulse time, in turns."""
    uneven = np.diff(pulses, 3)
    if not uneven.size:
        return 0.0
    return float(np.median(np.abs(uneven)) / NORMAL / np.sqrt(20) / np.median(np.diff(pulses)))


def _left(width: int) -> float:
    """The error of the slope of a cubic through as many even points of unit error."""
    return float(np.linalg.norm(savgol_coeffs(width, ORDER, deriv=1)))

"""Vectors at multiples of the speed of rotation from waveforms and a keyphasor, turn by turn.

The angle θ(t) of the shaft is a cubic spline through the pulses, 2π apart and evened where the sampling rate rounds their times
(`evened`), so that a speed that changes within a turn turns no phase. In windows of whole turns the waveform is fitted, by least
squares, by a constant and a harmonic series,

    x(t) ≈ a + Σ_h Re(q_h e^{ihθ(t)}).

Each q_h is zero to peak and its phase is a lead, counted from the mark's edge (`keyphasor`). Samples need not divide
the turn evenly. The first harmonics are always fitted too, so that they do not leak into the requested ones. White
noise of σ in each of n samples makes a vector of variance 4 σ²/n. The gap of a probe drifts: the fit is repeated
without the line through the constants of neighbouring windows, since a straight line in each would cost 1X nearly half
of its precision. Nor need samples be even in time: each counts at its own angle, as a logger's clock says it, and
windows in which samples are missing are left out.

The noise of a vector is what differs from one window to the next: of white noise the second difference of three disjoint windows
has the variance 6 s², and a vector that changes evenly with speed leaves nothing of itself there.

A pulse with steep edges is known to a sample: with 60 samples in a turn the speed of one turn would be wrong by up to
1.7 %, which is more than the width of a sharp resonance. How far pulses lie off an even course shows in the third
differences of their times, which are 0 for a steady acceleration and √20 σ for independent errors of σ. If these make
turns uneven, each time is taken from a cubic through the pulses around it (A. Savitzky & M. J. E. Golay, Anal. Chem. 36
(1964) 1627–1639, doi 10.1021/ac60214a047), through as many as the speed needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.units import TURN
from measurements.formats.waveforms.keyphasor import IRREGULAR

ALONG = (1.0, 2.0, 3.0)  # harmonics that are fitted in any case
SAMPLES_PER_UNKNOWN = 2  # in each window, at least
FEWEST_PULSES = 4  # that a cubic goes through
APART = 1e-9  # relative: far below the error of any speed
GAP = 0.15  # of a window, without samples
MISSING = 2.5  # steps of the clock, from which on samples are missing
FEWEST_WINDOWS = 5  # that say a noise
NEIGHBOURS = 10  # windows on either side that share their noise


@dataclass(frozen=True)
class Tracked:
    """Vectors of windows one after the other."""

    time: Array  # (n_window,) s, where each begins
    speed: Array  # (n_window,) rad/s, mean
    values: ComplexArray  # (n_window, n_signal, n_harmonic), zero to peak
    sigma: Array | None  # the same shape, total; None where the windows are too few to say
    first: Indices  # (n_window,) the first sample
    n_gap: int = 0  # windows that are left out since samples are missing in them


def tracked(time: Array, signals: Array, pulses: Array, harmonics: tuple[float, ...], revolutions: int = 1) -> Tracked:
    """Vectors of signals (n_sample, n_signal) at harmonics, from windows of `revolutions` turns.

    Turns are between pulses (n_pulse,) s.

    Raises `SettingError` if pulses are missing, samples too few, or a harmonic is not whole in a window.
    """
    for harmonic in harmonics:
        if abs(harmonic * revolutions - round(harmonic * revolutions)) > 1e-9:
            raise SettingError(
                f"revolutions: expected windows with whole periods of {harmonic:g}X, got {revolutions} turns; give more, such as"
                f" revolutions={_whole(harmonic)}"
            )
    if len(pulses) < (least := max(FEWEST_PULSES, revolutions + 1)):
        raise SettingError(
            f"keyphasor: expected at least {least} pulses, got {len(pulses)}; check the column, or lower revolutions"
        )
    _require_regular(pulses)
    pulses = evened(pulses)
    ends = pulses[: (len(pulses) - 1) // revolutions * revolutions + 1 : revolutions]
    starts = np.searchsorted(time, ends)
    whole = np.flatnonzero(~_has_gap(time, starts, ends))
    n_gap = len(starts) - 1 - len(whole)
    fitted = _fitted(np.diff(starts)[whole], harmonics, revolutions)
    # the samples of whole windows, one window after the other
    counts = np.diff(starts)[whole]
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    inside = np.arange(int(counts.sum())) + np.repeat(starts[whole] - first, counts)
    at = time[inside]
    angle = TURN * _turns(pulses, at)
    basis = [np.ones(len(inside))]
    for harmonic in fitted:
        basis += [np.cos(harmonic * angle), -np.sin(harmonic * angle)]
    functions, waves = np.stack(basis), signals[inside].T
    levels = _least_squares(functions, waves, first)[:, 0].T  # (n_signal, n_window), by which the gap drifts
    centres = (ends[:-1] + ends[1:])[whole] / 2
    drift = np.stack([np.interp(at, centres, level) for level in levels])
    coefficients = _least_squares(functions, waves - drift, first)
    values = coefficients[:, 1::2] + 1j * coefficients[:, 2::2]  # (n_window, n_harmonic, n_signal)
    values = np.moveaxis(values[:, : len(harmonics)], 1, 2)
    speed = _distinct(TURN * revolutions / np.diff(ends)[whole])
    return Tracked(ends[whole], speed, values, noise_of(values), starts[whole], n_gap)


def _distinct(speed: Array) -> Array:
    """Speeds (n,) of which none is equal to another.

    Some pulses that fall on samples coincide in all digits by chance.
    """
    order = np.argsort(speed, kind="stable")
    steps = (1 + APART) ** np.arange(len(speed))
    found = np.empty(len(speed))
    found[order] = np.maximum.accumulate(speed[order] / steps) * steps
    return found


def _has_gap(time: Array, starts: Indices, ends: Array) -> NDArray[np.bool_]:
    """Whether samples are missing in a window (n_window,), so that its harmonics are badly determined.

    A gap of 0.15 turns raises the error of 1X by a third, one of a quarter to 2.6 times.
    """
    steps = np.diff(time)
    wide = np.flatnonzero(steps > max(GAP * float(np.median(np.diff(ends))), MISSING * float(np.median(steps))))
    found = np.diff(starts) == 0
    for step in wide:  # from one sample to the next, which may be in another window
        low, high = np.searchsorted(ends, [time[step], time[step + 1]], side="right") - 1
        found[max(low, 0) : max(high + 1, 0)] = True
    return found


def _fitted(counts: Indices, harmonics: tuple[float, ...], revolutions: int) -> tuple[float, ...]:
    """The harmonics that are fitted, with so many samples in each window.

    Raises `SettingError` if these are too few.
    """
    fewest = int(np.min(counts)) if len(counts) else 0
    fitted = tuple(dict.fromkeys((*harmonics, *ALONG)))
    if fewest < SAMPLES_PER_UNKNOWN * (1 + 2 * len(fitted)):
        fitted = tuple(harmonics)
    if fewest < (least := SAMPLES_PER_UNKNOWN * (1 + 2 * len(fitted))):
        raise SettingError(
            f"waveform: expected at least {least} samples in {revolutions} turns, got {fewest}; sample faster, or give more"
            " revolutions"
        )
    return fitted


def noise_of(values: ComplexArray) -> Array | None:
    """Standard deviation (total) of vectors (n_window, …) by second differences over neighbouring windows.

    None if these are too few.
    """
    if len(values) < FEWEST_WINDOWS:
        return None
    squared = np.abs(values[:-2] - 2 * values[1:-1] + values[2:]) ** 2 / 6  # of the windows 1 … n − 2
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(squared, axis=0)])
    centre = np.arange(len(values)) - 1
    low, high = np.clip(centre - NEIGHBOURS, 0, len(squared)), np.clip(centre + NEIGHBOURS + 1, 0, len(squared))
    shape = (-1,) + (1,) * (values.ndim - 1)
    return np.asarray(np.sqrt((total[high] - total[low]) / (high - low).reshape(shape)))


def _least_squares(basis: Array, signals: Array, starts: Indices) -> Array:
    """Coefficients (n_window, n_basis, n_signal) of basis functions in signals, by normal equations.

    The basis is (n_basis, n_sample), signals are (n_signal, n_sample), windows begin at `starts`. A harmonic series
    over whole turns is well conditioned.
    """
    n_basis = len(basis)
    gram = np.empty((len(starts), n_basis, n_basis))
    for row in range(n_basis):
        for column in range(row + 1):
            sums = np.add.reduceat(basis[row] * basis[column], starts)
            gram[:, row, column] = gram[:, column, row] = sums
    right = np.stack(
        [np.stack([np.add.reduceat(each * signal, starts) for each in basis], axis=-1) for signal in signals], axis=-1
    )
    return np.linalg.solve(gram, right)


def _turns(pulses: Array, time: Array) -> Array:
    """How many turns after the first pulse, at times between the first and the last."""
    number = np.arange(len(pulses), dtype=float)
    return np.asarray(scipy.interpolate.CubicSpline(pulses, number)(time))


def _require_regular(pulses: Array) -> None:
    turns = np.diff(pulses)
    ratio = turns[1:] / turns[:-1]
    bad = np.flatnonzero((ratio > IRREGULAR) | (ratio < 1 / IRREGULAR))
    if len(bad):
        at = int(bad[0]) + 1
        raise SettingError(
            f"keyphasor: expected one pulse in each turn, got turns of {turns[at - 1]:.4g} s and {turns[at]:.4g} s one after the"
            f" other at {pulses[at]:.6g} s; a pulse is missing or there is one too many: cut the record, or clean the signal"
        )


def _whole(harmonic: float) -> int:
    """The fewest turns with whole periods of a harmonic."""
    return next((n for n in range(1, 101) if abs(harmonic * n - round(harmonic * n)) < 1e-9), 100)


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
    return np.asarray(scipy.signal.savgol_filter(pulses, width, ORDER)) if width else pulses


def _relative_error(pulses: Array) -> float:
    """Error of a pulse time, in turns."""
    uneven = np.diff(pulses, 3)
    if not uneven.size:
        return 0.0
    return float(np.median(np.abs(uneven)) / NORMAL / np.sqrt(20) / np.median(np.diff(pulses)))


def _left(width: int) -> float:
    """The error of the slope of a cubic through as many even points of unit error."""
    return float(np.linalg.norm(scipy.signal.savgol_coeffs(width, ORDER, deriv=1)))

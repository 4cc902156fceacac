"""Noise model of a measurement: a part relative to the response and a floor."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, Indices


@dataclass(frozen=True)
class Noise:
    """Gaussian noise with standard deviation s, s² = (relative · |y|)² + floor².

    For complex data s² is the total variance, s/√2 per real and imaginary part; for amplitudes s is the standard deviation itself.

    Args:
        relative: standard deviation as a fraction of each value; one number, or one per speed (n_speed, 1) if runs have noise of
            their own.
        floor: standard deviation without any response, m; one number, one per datum (n_speed, n_channel) if the data came with
            their own, or one per speed (n_speed, 1) if runs have noise of their own.
        rows: slice of the speeds of each run that has noise of its own. Default: empty, one level for all.

    >>> Noise(relative=0.1, floor=1e-6).sd(np.array([0.0, 10e-6])).round(9).tolist()  # m
    [1e-06, 1.414e-06]
    """

    relative: float | Array
    floor: float | Array
    rows: tuple[slice, ...] = ()

    @classmethod
    def of_runs(cls, levels: Sequence[tuple[float, float]], rows: tuple[slice, ...]) -> Noise:
        """Noise with a level for each run.

        Args:
            levels: relative part and floor (m) of each run.
            rows: slice of the speeds of each run; runs follow one another.
        """
        counts = [run.stop - run.start for run in rows]
        relative, floor = (np.repeat(part, counts)[:, None] for part in zip(*levels, strict=True))
        return cls(relative, floor, rows)

    @property
    def levels(self) -> tuple[tuple[float, float], ...]:
        """Relative part and floor (m) of each run that has its own, or the one level of all.

        If each datum has a floor of its own, it is their rms.
        """
        groups = self.rows or (slice(None),)
        return tuple((_rms(self.relative, rows), _rms(self.floor, rows)) for rows in groups)

    def scaled(self, factor: float) -> Noise:
        """Noise with both parts multiplied by a factor.

        Args:
            factor: factor on the standard deviation.
        """
        return dataclasses.replace(self, relative=self.relative * factor, floor=self.floor * factor)

    def part(self, indices: Indices) -> Noise:
        """Noise at some of the speeds.

        Args:
            indices: rising indices of speeds.
        """
        relative, floor = (np.asarray(part)[indices] if np.ndim(part) else part for part in (self.relative, self.floor))
        return Noise(relative, floor)

    def sd(self, amplitude: Array) -> Array:
        """Standard deviation at amplitudes.

        Args:
            amplitude: amplitudes (…, n_speed, n_channel), m.

        Returns:
            Standard deviation s, (…, n_speed, n_channel), m.
        """
        return np.asarray(np.hypot(self.relative * np.abs(amplitude), self.floor))

    def variance(self, amplitude: Array) -> Array:
        """Variance at amplitudes.

        Args:
            amplitude: amplitudes (…, n_speed, n_channel), m.

        Returns:
            Variance s², (…, n_speed, n_channel), m².
        """
        return np.asarray((self.relative * np.abs(amplitude)) ** 2 + np.square(self.floor))

    @property
    def is_absent(self) -> bool:
        """Whether both parts are 0 everywhere."""
        return bool(np.all(np.equal(self.relative, 0)) and np.all(np.equal(self.floor, 0)))


def _rms(part: float | Array, rows: slice) -> float:
    values = np.asarray(part)[rows] if np.ndim(part) else np.asarray(part)
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0

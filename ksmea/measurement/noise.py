"""Noise model of a measurement: a part relative to the response and a floor."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, Indices


@dataclass(frozen=True)
class Noise:
    """Noise with standard deviation s, s² = (relative · |y|)² + floor² (m).

    For complex data s² is the total variance, s/√2 per real and imaginary part; for amplitudes s is the standard
    deviation itself. `floor` is one number, or one per datum (n_speed, n_channel) where the data came with their own.
    Where runs have noise of their own, both are one number per speed (n_speed, 1), and `rows` says where each run lies.
    """

    relative: float | Array
    floor: float | Array
    rows: tuple[slice, ...] = ()

    @classmethod
    def of_runs(cls, levels: Sequence[tuple[float, float]], rows: tuple[slice, ...]) -> Noise:
        """Noise with a relative part and a floor (m) for each run, which lie one after the other."""
        counts = [run.stop - run.start for run in rows]
        relative, floor = (np.repeat(part, counts)[:, None] for part in zip(*levels, strict=True))
        return cls(relative, floor, rows)

    @property
    def levels(self) -> tuple[tuple[float, float], ...]:
        """Relative part and floor (m) of each run that has its own, or the one of all; where each datum has a floor of its own,
        their rms."""
        groups = self.rows or (slice(None),)
        return tuple((_rms(self.relative, rows), _rms(self.floor, rows)) for rows in groups)

    def scaled(self, factor: float) -> Noise:
        return dataclasses.replace(self, relative=self.relative * factor, floor=self.floor * factor)

    def part(self, indices: Indices) -> Noise:
        """Noise of some of the speeds, by rising index."""
        relative, floor = (np.asarray(part)[indices] if np.ndim(part) else part for part in (self.relative, self.floor))
        return Noise(relative, floor)

    def sd(self, amplitude: Array) -> Array:
        """s at amplitudes (…, n_speed, n_channel), m."""
        return np.asarray(np.hypot(self.relative * np.abs(amplitude), self.floor))

    def variance(self, amplitude: Array) -> Array:
        """s², m²."""
        return np.asarray((self.relative * np.abs(amplitude)) ** 2 + np.square(self.floor))

    @property
    def is_absent(self) -> bool:
        return bool(np.all(np.equal(self.relative, 0)) and np.all(np.equal(self.floor, 0)))


def _rms(part: float | Array, rows: slice) -> float:
    values = np.asarray(part)[rows] if np.ndim(part) else np.asarray(part)
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0

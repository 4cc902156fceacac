"""Channels that were recorded at speeds of their own, brought to common ones by interpolation.

The channel with the fewest rows gives the common speeds, between the speeds that all channels reach. Every other
channel is interpolated there between its two neighbouring rows, linearly in real and imaginary part. The error of that
is estimated by the difference e to a cubic through four rows. If standard deviations σ are stated, the new one is
√(Σ w² σ² + e²); if they are not, a speed at which e exceeds 2 % of the vector is left out. With or without them a
speed is left out if its neighbours lie more than 5 % of it apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from measurements.formats.curve import Flags
from measurements.run_up_rows import Rows
from measurements.slow_roll import by_channel, vectors

LARGEST_ERROR = 0.02  # of a vector, by interpolation, where no noise is stated that it could be added to
WIDEST = 0.05  # of a speed, between the rows that it lies between
SAME = 1e-9  # relative: rounding


@dataclass(frozen=True)
class Interpolated:
    """A channel at other speeds."""

    values: Array | ComplexArray
    sigma: Array | None
    error: Array  # by interpolation
    weights: Array  # (n, 2) of the two neighbours
    neighbours: Indices  # (n, 2)
    is_near: Flags  # whether these lie near enough

    @property
    def is_kept(self) -> Flags:
        """Which speeds can be used: near rows, and an error that is small or part of a stated sigma."""
        if self.sigma is not None:
            return self.is_near
        return np.asarray(self.is_near & (self.error <= LARGEST_ERROR * np.abs(self.values)))


def interpolated(speed: Array, values: Array | ComplexArray, sigma: Array | None, at: Array) -> Interpolated:
    """Values (n,) at rising speeds (n,), brought to speeds `at` (k,) between the first and the last."""
    right = np.clip(np.searchsorted(speed, at), 1, len(speed) - 1)
    neighbours = np.stack([right - 1, right], axis=1)
    below, above = speed[right - 1], speed[right]
    part = (at - below) / (above - below)
    part = np.where(np.abs(at - below) <= SAME * at, 0.0, np.where(np.abs(at - above) <= SAME * at, 1.0, part))
    weights = np.stack([1 - part, part], axis=1)
    linear = np.sum(weights * values[neighbours], axis=1)
    is_row = (part == 0) | (part == 1)
    error = np.where(is_row, 0.0, np.abs(linear - _cubic(speed, values, right, at)))
    spread = None
    if sigma is not None:
        spread = np.sqrt(np.sum((weights * sigma[neighbours]) ** 2, axis=1) + error**2)
    is_near = is_row | (above - below <= WIDEST * at)
    return Interpolated(linear, spread, error, weights, neighbours, is_near)


def _cubic(speed: Array, values: Array | ComplexArray, right: Indices, at: Array) -> Array | ComplexArray:
    """Lagrange's polynomial through the four rows about each speed, or through fewer if there are no more."""
    n_node = min(4, len(speed))
    first = np.clip(right - 2, 0, len(speed) - n_node)
    nodes = first[:, None] + np.arange(n_node)
    x = speed[nodes]
    total: Any = np.zeros(len(at), dtype=values.dtype)
    for node in range(n_node):
        others = [other for other in range(n_node) if other != node]
        weight = np.prod([(at - x[:, other]) / (x[:, node] - x[:, other]) for other in others], axis=0)
        total = total + weight * values[nodes[:, node]]
    return total


def at_shared_speeds(rows: Rows, path: str) -> tuple[Rows, str | None]:
    """The rows with every channel at the common speeds, and what that did.

    They are unchanged if all have the same speeds.
    """
    channels = by_channel(rows)
    speed = np.array(rows.speed)
    sets = [frozenset(speed[indices].tolist()) for indices in channels.values()]
    if len(set(sets)) == 1:
        return rows, None
    ordered = {channel: _rising(speed, indices, channel, path) for channel, indices in channels.items()}
    low = max(float(speed[indices[0]]) for indices in ordered.values())
    high = min(float(speed[indices[-1]]) for indices in ordered.values())
    inside = {
        channel: indices[(speed[indices] >= low) & (speed[indices] <= high)] for channel, indices in channels.items()
    }
    grid = min(inside, key=lambda channel: len(inside[channel]))
    common = inside[grid]  # in the order of the file, as the speed went
    if not len(common):
        raise SettingError(f"{path}: expected speeds that all channels reach, got none; import the channels one by one")
    values = vectors(rows)
    sigma = None if rows.sigma is None else np.array(rows.sigma)
    at = speed[common]
    moved = {
        channel: interpolated(speed[indices], values[indices], None if sigma is None else sigma[indices], at)
        for channel, indices in ordered.items()
    }
    kept = np.ones(len(common), dtype=bool)
    for each in moved.values():
        kept &= each.is_kept
    if not np.any(kept):
        raise SettingError(
            f"{path}: expected channels whose rows lie near enough to each other to be interpolated, got none; use"
            " incomplete=drop, or measure them together"
        )
    worst = max(float(np.max(each.error[kept] / np.abs(each.values[kept]))) for each in moved.values())
    remark = (
        f"channels interpolated to {np.count_nonzero(kept)} common speeds, from {grid}; estimated error at most"
        f" {100 * worst:.2g} % of a vector{', part of sigma_um' if sigma is not None else ''}"
    )
    if left_out := len(common) - np.count_nonzero(kept):
        remark += f"; {left_out} speeds left out"
    return _combined(rows, ordered, moved, at, np.flatnonzero(kept)), remark


def _rising(speed: Array, indices: Indices, channel: Channel, path: str) -> Indices:
    order = indices[np.argsort(speed[indices], kind="stable")]
    if len(order) < 2 or np.any(np.diff(speed[order]) <= 0):
        raise SettingError(
            f"{path}: expected two speeds or more of {channel}, each once, to interpolate between, got others; give repeats=average"
        )
    return order


def _combined(
    rows: Rows, ordered: dict[Channel, Indices], moved: dict[Channel, Interpolated], at: Array, kept: Indices
) -> Rows:
    """The rows of all channels at the speeds that are kept, next to each other."""
    line, out_speed, out_channel = [], [], []
    amplitude: list[float] = []
    phase: list[float] = []
    sigma: list[float] = []
    time: list[float] = []
    times = None if rows.time is None else np.array(rows.time)
    for index in kept:
        for channel, indices in ordered.items():
            each = moved[channel]
            near = indices[each.neighbours[index]]
            line.append(rows.line[int(near[int(each.weights[index, 1] > 0.5)])])
            out_speed.append(float(at[index]))
            out_channel.append((channel.position, channel.direction, channel.harmonic))
            value = each.values[index]
            amplitude.append(float(np.abs(value)))
            phase.append(float(np.angle(value, deg=True)))
            if each.sigma is not None:
                sigma.append(float(each.sigma[index]))
            if times is not None:
                time.append(float(each.weights[index] @ times[near]))
    order = range(len(line)) if times is None else sorted(range(len(line)), key=lambda row: (time[row], row))

    def put(values: list[float]) -> list[float]:
        return [values[row] for row in order]

    return Rows(
        [line[row] for row in order],
        put(out_speed),
        [out_channel[row] for row in order],
        put(amplitude),
        None if rows.phase is None else put(phase),
        None if rows.sigma is None else put(sigma),
        None if times is None else put(time),
        None,
    )

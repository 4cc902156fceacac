"""Noise from repeats, independent of the model: repeated speeds in a run, and runs with equal weights.

A cell is a run at one speed, k times measured, in one channel. Its sum of squares about its mean has n (k − 1)
degrees of freedom (n = 1 of amplitudes, 2 of complex data). With s² = (relative · |mean|)² + floor² all cells
together have the deviance Σ [ n (k − 1) ln s² + n Σ|y − mean|² / s² ], free of the means (restricted likelihood,
Patterson & Thompson 1971).

Runs with the same weights at the same speed have the same mean. The scatter of their means, in units expected from
the repeats, is compared with the repeats by F of the two mean squares. The ratio is overestimated, as 1/s² of an
estimate is: by ν/(ν − 2) with ν degrees of freedom, about half the degrees of freedom of a level for each of its two
parts. F itself expects the factor of all together. Each run is compared with the others likewise, and each channel;
their p are corrected for the number of comparisons (Bonferroni).
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.optimize import minimize

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.likelihood.likelihood import noise_limits
from ksmea.measurement.campaign import Run
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.speeds import equal_speeds
from ksmea.records.campaign import SpreadRecord

LEAST_DEGREES = 6  # of freedom; with fewer a level of two parts means nothing
N_LEVEL = 9  # levels of each part of the noise that a search is started from the best of
STANDS_OUT = 0.01  # p, corrected, below which a run or a channel is named


@dataclass(frozen=True)
class Repeats:
    """The noise of repeats with its degrees of freedom, and how runs that are alike differ beyond it.

    All together, then the runs and channels that stand out. Without repeats in runs the runs themselves are the repeats
    (`are_runs`).
    """

    noise: Noise
    degrees: int
    amplitude: tuple[float, float]  # m, the smallest and the largest that was repeated
    are_runs: bool
    between: SpreadRecord | None = None
    standing_out: tuple[SpreadRecord, ...] = ()


@dataclass(frozen=True)
class _Cell:
    """Run at one speed: index of the run, times measured, mean and sum of squares (n_channel,).

    The squares are about the mean.
    """

    run: int
    count: int
    mean: Array | ComplexArray
    squares: Array


def repeats(measurement: Measurement) -> Repeats | None:
    """Noise from the repeats of a campaign; None for other data, or if there are too few repeats."""
    campaign = measurement.campaign
    if campaign is None:
        return None
    by_speed = [_cells(measurement, group) for group in equal_speeds(measurement.speed)]
    alike = [] if campaign.own else [same for cells in by_speed for same in _alike(cells, campaign.runs)]
    within = [cell for cells in by_speed for cell in cells]
    found = _level(measurement, within, are_runs=False)
    if found is None:
        return _level(measurement, [_joined(cells) for cells in alike], are_runs=True)
    of_run: list[Repeats | None] = [found] * len(campaign.runs)
    if campaign.own_noise:
        parts = ([cell for cell in within if cell.run == run] for run in range(len(of_run)))
        of_run = [_level(measurement, part, are_runs=False) for part in parts]
    levels = [level for level in of_run if level is not None]
    return _compared(measurement, found, alike, levels) if len(levels) == len(of_run) else found


def _cells(measurement: Measurement, group: Indices) -> list[_Cell]:
    """The cells at one speed."""
    inside = [(run, group[(group >= rows.start) & (group < rows.stop)]) for run, rows in enumerate(measurement.rows)]
    return [_cell(run, measurement.values[indices]) for run, indices in inside if len(indices)]


def _cell(run: int, values: Array | ComplexArray) -> _Cell:
    mean = values.mean(axis=0)
    return _Cell(run, len(values), mean, np.sum(np.abs(values - mean) ** 2, axis=0))


def _alike(cells: Sequence[_Cell], runs: Sequence[Run]) -> Iterable[list[_Cell]]:
    """Cells at one speed of runs with the same known weights, two or more."""
    known = [cell for cell in cells if not runs[cell.run].unknown_weights]
    for weights in dict.fromkeys(runs[cell.run].weights for cell in known):
        same = [cell for cell in known if runs[cell.run].weights == weights]
        if len(same) > 1:
            yield same


def _joined(cells: Sequence[_Cell]) -> _Cell:
    """The means of runs as repeats of one run."""
    return _cell(cells[0].run, np.array([cell.mean for cell in cells]))


def _level(measurement: Measurement, cells: Iterable[_Cell], *, are_runs: bool) -> Repeats | None:
    """The noise of cells, by the restricted likelihood; None for too few degrees of freedom."""
    repeated = [cell for cell in cells if cell.count > 1]
    dimensions, n_channel = measurement.dimensions, len(measurement.channels)
    degrees = dimensions * np.array([cell.count - 1 for cell in repeated], dtype=int)
    if np.sum(degrees) * n_channel < LEAST_DEGREES:
        return None
    magnitude, squares = (np.array(part) for part in zip(*((np.abs(cell.mean), cell.squares) for cell in repeated)))

    def restricted_deviance(logarithms: Array) -> float:
        variance = Noise(*np.exp(logarithms)).variance(magnitude)
        return float(np.sum(degrees[:, None] * np.log(variance) + dimensions * squares / variance))

    lower, upper = noise_limits(measurement.values)
    grid = np.stack(np.meshgrid(*np.linspace(lower, upper, N_LEVEL).T), axis=-1).reshape(-1, 2)
    start = min(grid, key=restricted_deviance)
    best = minimize(restricted_deviance, start, method="L-BFGS-B", bounds=list(zip(lower, upper))).x
    relative, floor = np.exp(best).tolist()
    reach = float(magnitude.min()), float(magnitude.max())
    return Repeats(Noise(relative, floor), int(np.sum(degrees)) * n_channel, reach, are_runs)


def _compared(
    measurement: Measurement, found: Repeats, alike: Sequence[Sequence[_Cell]], levels: Sequence[Repeats]
) -> Repeats:
    """The repeats with how runs that are alike differ beyond them, each run with its level."""
    if not alike or measurement.campaign is None:
        return found
    noises, n_part = [level.noise for level in levels], min(level.degrees for level in levels) / 2
    unbiased = (1 - 2 / n_part) * found.degrees / (found.degrees - 2)
    dimensions, n_channel = measurement.dimensions, len(measurement.channels)

    def spread(what: str, squares: float, degrees: int, n_compared: int = 1) -> SpreadRecord:
        ratio = float(squares / degrees) * unbiased
        p = n_compared * float(scipy.stats.f.sf(ratio, dimensions * degrees, found.degrees))
        return SpreadRecord(what, ratio, min(1.0, p))

    def runs_standing_out(alike: Sequence[Sequence[_Cell]]) -> list[SpreadRecord]:
        """Against all others: the one that does so most, then of the others among themselves."""
        own: dict[int, list[Array]] = defaultdict(list)
        for cells in alike:
            away, share = _away(cells, noises)
            for cell, each in zip(cells, away / (1 - share)):  # a mean apart from that of the others
                own[cell.run].append(each)
        if len(own) < 3:
            return []
        names = [run.name for run in measurement.campaign.runs] if measurement.campaign else []
        each = {run: spread(f"run {names[run]}", np.sum(parts), np.size(parts), len(own)) for run, parts in own.items()}
        most = max(each, key=lambda run: each[run].ratio)
        if each[most].p >= STANDS_OUT:
            return []
        others = [[cell for cell in cells if cell.run != most] for cells in alike]
        return [each[most], *runs_standing_out([cells for cells in others if len(cells) > 1])]

    by_channel = np.sum([np.sum(_away(cells, noises)[0], axis=0) for cells in alike], axis=0)
    degrees = sum(len(cells) - 1 for cells in alike)
    channels = [spread(str(item), own, degrees, n_channel) for item, own in zip(measurement.channels, by_channel)]
    channels = sorted((each for each in channels if each.p < STANDS_OUT), key=lambda each: -each.ratio)
    between = spread("runs", float(np.sum(by_channel)), degrees * n_channel)
    return dataclasses.replace(found, between=between, standing_out=(*runs_standing_out(alike), *channels))


def _away(cells: Sequence[_Cell], noises: Sequence[Noise]) -> tuple[Array, Array]:
    """Squared distance of each cell's mean from the overall mean, and the cell's share in that mean.

    The distance is in units of the cell's noise; both are (n_cell, n_channel)."""
    means = np.array([cell.mean for cell in cells])
    level = np.abs(means.mean(axis=0))
    weight = np.array([cell.count / noises[cell.run].variance(level) for cell in cells])  # 1/m²
    share = weight / weight.sum(axis=0)
    return np.abs(means - np.sum(share * means, axis=0)) ** 2 * weight, share

"""Speeds that a model's response is drawn at: few where it is smooth, many at resonances, whose peaks would else be cut off.

Beginning with those measured and some even ones, each speed at which the logarithm of an amplitude bends is given neighbours half
way to those that it has, until the curve between any two is a straight line as far as a figure shows.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.alignment import aligned
from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.measurement import Layout, Measurement

N_EVEN = 100  # speeds of each run to begin with
MOST = 1000  # of each run
BENT = 0.06  # of ln|q|: 6 % of an amplitude, the width of a line
MAX_ROUNDS = 10  # of halving: of 1/100 of a band 1e-5 of it is left


def fine_layout(problem: Problem, measurement: Measurement, x: Array) -> Layout:
    """The layout of a measurement at speeds that suit the response at values x (d,) SI, run by run."""
    bands = [measurement.speed[rows] for rows in measurement.rows]
    speeds = [np.union1d(band, np.linspace(np.min(band), np.max(band), N_EVEN)) for band in bands]
    sizes = _by_run(_sizes(problem, _layout(measurement, speeds), x), speeds)
    for _ in range(MAX_ROUNDS):
        added = [_between(*each) if len(each[0]) < MOST else np.empty(0) for each in zip(speeds, sizes)]
        if not any(len(each) for each in added):
            break
        new = [own if len(own) else speed[:1] for own, speed in zip(added, speeds)]  # a run without any is no run
        found = _by_run(_sizes(problem, _layout(measurement, new), x), new)
        for index, own in enumerate(added):
            if len(own):
                speeds[index], sizes[index] = _merged(speeds[index], sizes[index], own, found[index])
    return _layout(measurement, speeds)


def _layout(measurement: Measurement, speeds: list[Array]) -> Layout:
    """The same measurement at other speeds of each run."""
    campaign = measurement.campaign and measurement.campaign.with_counts([len(each) for each in speeds])
    return dataclasses.replace(measurement.layout, speed=np.concatenate(speeds), campaign=campaign)


def _sizes(problem: Problem, layout: Layout, x: Array) -> Array:
    """ln|q| (n_speed, n_channel)."""
    response = np.abs(aligned(problem, layout).response(x[None])[0])
    return np.asarray(np.log(np.maximum(response, np.finfo(float).tiny)))


def _by_run(sizes: Array, speeds: list[Array]) -> list[Array]:
    return np.split(sizes, np.cumsum([len(each) for each in speeds])[:-1])


def _between(speed: Array, sizes: Array) -> Array:
    """Speeds half way to the neighbours of each speed at which a curve bends."""
    left, right = np.diff(speed)[:-1, None], np.diff(speed)[1:, None]
    straight = (sizes[:-2] * right + sizes[2:] * left) / (left + right)
    bends = np.flatnonzero(np.max(np.abs(sizes[1:-1] - straight), axis=1) > BENT)  # of the speed behind each of these
    intervals = np.union1d(bends, bends + 1)
    return np.asarray((speed[intervals] + speed[intervals + 1]) / 2)


def _merged(speed: Array, sizes: Array, more: Array, more_sizes: Array) -> tuple[Array, Array]:
    together = np.concatenate([speed, more])
    order = np.argsort(together)
    return together[order], np.concatenate([sizes, more_sizes])[order]

"""Data at other multiples of the speed of rotation than 1X: what of them a problem can say anything about."""

from __future__ import annotations

import numpy as np

from ksmea.alignment import through
from ksmea.contracts import Problem
from ksmea.measurement import Measurement
from ksmea.screening import sobol


def answered(problem: Problem, measurement: Measurement) -> tuple[Problem, Measurement]:
    """A problem and its measurement through the channels at whose harmonics the problem moves at all: a linear model answers
    unbalance at 1X alone, and what else was measured tells nothing of it. They are as they are where that is all of them.

    It is asked at one set of values that is nothing special: the third point of a Sobol' sequence.
    """
    if all(channel.is_1x for channel in measurement.channels):
        return problem, measurement
    x = problem.parameters.to_si(sobol(4, len(problem.parameters))[2:3])
    moves = np.any(problem.response(x)[0] != 0, axis=0)
    return _through(problem, measurement, [bool(each) for each in moves])


def at_1x(problem: Problem, measurement: Measurement) -> tuple[Problem, Measurement]:
    """A problem and its measurement at the speed of rotation alone."""
    return _through(problem, measurement, [channel.is_1x for channel in measurement.channels])


def _through(problem: Problem, measurement: Measurement, is_kept: list[bool]) -> tuple[Problem, Measurement]:
    kept = [index for index, each in enumerate(is_kept) if each or measurement.channels[index].is_1x]
    if len(kept) == len(measurement.channels):
        return problem, measurement
    part = measurement.through(kept)
    return through(problem, part.channels), part

"""Response curves of a run, for the figures that compare measurement, identified model and surrogate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ksmea.contracts import ComplexArray, Problem
from ksmea.identification import Identification
from ksmea.measurement import Measurement
from ksmea.parameters import Array

DIGITS = 8  # a figure of differences needs no more, and records stay small


def response_curves(
    problem: Problem, measurement: Measurement, true_response: ComplexArray, found: Identification
) -> dict[str, Any]:
    """Amplitudes (n_speed, n_channel), m, by name: the noise-free truth, the measurement, the identified model, and
    surrogate and true model at the surrogate's last optimum."""
    identified = problem.response(found.x[None])[0]
    curves = {
        "true": true_response,
        "measured": measurement.values,
        "identified": identified,
        "predicted": found.predicted,
        "modelled": found.modelled,
    }
    return {
        "speed": _rounded(measurement.speed),
        "channels": [str(channel) for channel in measurement.channels],
        **{name: _rounded(np.abs(values)) for name, values in curves.items() if values is not None},
    }


def _rounded(values: Array) -> list[Any]:
    return np.vectorize(lambda value: float(f"{value:.{DIGITS}g}"))(values).tolist()


def amplitude(curves: Mapping[str, Any], name: str) -> Array | None:
    """A curve of a record as an array (n_speed, n_channel), m, or None where the record has none."""
    return np.array(curves[name]) if name in curves else None

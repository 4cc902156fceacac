"""Response curves of a run, for the figures that compare measurement, identified model and surrogate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.identification import Identification
from ksmea.measurement import Measurement, Noise

N_FINE = 1000  # speeds that a fitted curve is drawn at, besides those measured
DIGITS = 8  # a figure of differences needs no more, and records stay small


def response_curves(
    problem: Problem, measurement: Measurement, true_response: ComplexArray | None, found: Identification
) -> dict[str, Any]:
    """Amplitudes (n_speed, n_channel), m, by name: the noise-free truth where it is known, the measurement, the identified model, and
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


def fit_curves(problem: Problem, measurement: Measurement, x: Array, noise: Noise | None) -> dict[str, Any]:
    """Data and fitted response over speed: amplitudes (m) and, of complex data, phases (rad), (n_speed, n_channel) each;
    `sd` of the noise at the fit where it is known or estimated; `fine` holds the fit at more speeds than were measured."""
    fitted = problem.response(x[None])[0]
    lowest, highest = float(np.min(measurement.speed)), float(np.max(measurement.speed))
    speed = np.union1d(measurement.speed, np.linspace(lowest, highest, N_FINE))
    fine = problem.at(speed, measurement.channels).response(x[None])[0]
    with_phase = not measurement.is_amplitude
    return {
        "speed": _rounded(measurement.speed),
        "channels": [str(channel) for channel in measurement.channels],
        "measured": _polar(measurement.values, with_phase),
        "fitted": _polar(fitted, with_phase),
        "sd": None if noise is None or noise.is_absent else _rounded(noise.sd(np.abs(fitted))),
        "fine": {"speed": _rounded(speed), **_polar(fine, with_phase)},
    }


def _polar(values: Array | ComplexArray, with_phase: bool) -> dict[str, Any]:
    phase = {"phase": _rounded(np.angle(values))} if with_phase else {}
    return {"amplitude": _rounded(np.abs(values))} | phase


def _rounded(values: Array) -> list[Any]:
    return np.vectorize(lambda value: float(f"{value:.{DIGITS}g}"))(values).tolist()


def amplitude(curves: Mapping[str, Any], name: str) -> Array | None:
    """A curve of a record as an array (n_speed, n_channel), m, or None where the record has none."""
    return np.array(curves[name]) if name in curves else None

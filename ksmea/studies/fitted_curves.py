"""Data and fitted response over speed, as an identification's figures draw them."""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.alignment import aligned
from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.difference_likelihood import likelihood_of
from ksmea.identification import Identification
from ksmea.likelihood import Likelihood
from ksmea.measurement import Layout, Measurement, Noise
from ksmea.model import Model
from ksmea.records.curves import FineCurve, FitCurves, Polar, ResponseCurves, matrix, row
from ksmea.studies.fine_speeds import fine_layout


def fit_curves(problem: Problem, measurement: Measurement, x: Array, noise: Noise | None) -> FitCurves:
    """Data and fitted response at x (d,) SI over speed, with the noise where it is known or estimated. Where only differences
    between runs count, what these show alike is added, at the measured speeds alone."""
    fitted = problem.response(x[None])[0]
    with_phase = not measurement.is_amplitude
    if measurement.is_by_differences and noise is not None:
        likelihood = with_noise(problem, measurement, noise)
        fitted = fitted + likelihood.alike(problem.parameters.to_cube(x), fitted)
        fine = _curve(measurement.layout, fitted)
    else:
        fine = fine_curve(problem, measurement, x)
    return FitCurves(
        speed=row(measurement.speed),
        channels=tuple(str(channel) for channel in measurement.channels),
        measured=Polar.of(measurement.values, with_phase=with_phase),
        fitted=Polar.of(fitted, with_phase=with_phase),
        sd=None if noise is None or noise.is_absent else matrix(noise.sd(np.abs(fitted))),
        fine=fine,
    )


def fine_curve(problem: Problem, measurement: Measurement, x: Array) -> FineCurve:
    """The response at x (d,) SI at as many speeds in the band of each run as a figure needs, with phases where data have any."""
    layout = fine_layout(problem, measurement, x)
    return _curve(layout, aligned(problem, layout).response(x[None])[0])


def _curve(layout: Layout, response: ComplexArray) -> FineCurve:
    return FineCurve.of(layout.speed, response, layout.breaks, with_phase=layout.kind == "complex")


def response_curves(problem: Problem, measurement: Measurement, found: Identification) -> ResponseCurves:
    """Amplitudes of measurement, identified model, and surrogate and true model at the surrogate's last optimum."""
    identified = problem.response(found.x[None])[0]
    return ResponseCurves(
        speed=row(measurement.speed),
        channels=tuple(str(channel) for channel in measurement.channels),
        measured=matrix(np.abs(measurement.values)),
        identified=matrix(np.abs(identified)),
        predicted=None if found.predicted is None else matrix(np.abs(found.predicted)),
        modelled=None if found.modelled is None else matrix(np.abs(found.modelled)),
        breaks=measurement.breaks,
    )


def with_noise(problem: Problem, measurement: Measurement, noise: Noise) -> Likelihood:
    """The likelihood of a measurement whose noise is known by now."""
    return likelihood_of(Model(problem), dataclasses.replace(measurement, noise=noise))

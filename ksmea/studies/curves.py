"""Curves over speed for figures: data and fitted response of an identification.

A response is drawn at few speeds where it is smooth, and at many at resonances, whose peaks would otherwise be cut off. Starting
with the measured speeds and some even ones, each speed at which the logarithm of an amplitude bends is given neighbours half way to
the next ones, until the curve between any two is straight as far as a figure shows. Each half-power width then gets 40 speeds, so that
loops in the complex plane are round.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Identification
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.records.curves import (
    FINE_DIGITS,
    SPEED_DIGITS,
    FineCurve,
    FineResponses,
    FitCurves,
    Polar,
    ResponseCurves,
    matrix,
    row,
)
from ksmea.rotordynamics.half_power import full_peaks


def fit_curves(case: Case, x: Array, noise: Noise | None) -> FitCurves:
    """Data and fitted response at x (d,) SI over speed, with the noise where it is known or estimated.

    If only differences between runs count, their common part is added, at the measured speeds alone.
    """
    problem, measurement = case.problem, case.measurement
    fitted = problem.response(x[None])[0]
    with_phase = not measurement.is_amplitude
    if measurement.is_by_differences and noise is not None:
        likelihood = with_noise(case, noise)
        fitted = fitted + likelihood.alike(problem.parameters.to_cube(x), fitted)
        fine = _curve(measurement.layout, fitted)
    else:
        fine = fine_curve(case, x)
    return FitCurves(
        speed=row(measurement.speed),
        channels=tuple(str(channel) for channel in measurement.channels),
        measured=Polar.of(measurement.values, with_phase=with_phase),
        fitted=Polar.of(fitted, with_phase=with_phase),
        sd=None if noise is None or noise.is_absent else matrix(noise.sd(np.abs(fitted))),
        fine=fine,
    )


def fine_curve(case: Case, x: Array) -> FineCurve:
    """Response at x (d,) SI at as many speeds in the band of each run as a figure needs.

    Phases are included if data have any. A problem without a response elsewhere is evaluated at the measured speeds.
    """
    try:
        layout = fine_layout(case.measurement, [(case.problem, x)])
        return _curve(layout, aligned(case.problem, layout).response(x[None])[0])
    except SettingError:
        return _curve(case.measurement.layout, case.problem.response(x[None])[0])


def _curve(layout: Layout, response: ComplexArray) -> FineCurve:
    return FineCurve.of(layout.speed, response, layout.breaks, with_phase=layout.kind == "complex")


def response_curves(case: Case, found: Identification) -> ResponseCurves:
    """Amplitudes of measurement, identified model, and both models at the surrogate's last optimum.

    The models are the surrogate and the true one.
    """
    measurement, identified = case.measurement, case.problem.response(found.x[None])[0]
    return ResponseCurves(
        speed=row(measurement.speed),
        channels=tuple(str(channel) for channel in measurement.channels),
        measured=matrix(np.abs(measurement.values)),
        identified=matrix(np.abs(identified)),
        predicted=None if found.predicted is None else matrix(np.abs(found.predicted)),
        modelled=None if found.modelled is None else matrix(np.abs(found.modelled)),
        breaks=measurement.breaks,
    )


def with_noise(case: Case, noise: Noise) -> Likelihood:
    """The likelihood of a measurement whose noise is known by now."""
    return likelihood_of(case.of_measurement(dataclasses.replace(case.measurement, noise=noise)))


def fine_responses(measurement: Measurement, models: Mapping[str, Model]) -> FineResponses:
    """Amplitudes of models at common speeds that show the peaks of all of them.

    Models are named as fields of the record.
    """
    layout = fine_layout(measurement, list(models.values()))
    found = _responses(list(models.values()), layout)
    return FineResponses(
        speed=row(layout.speed, SPEED_DIGITS),
        breaks=layout.breaks,
        **{name: matrix(np.abs(response), FINE_DIGITS) for name, response in zip(models, found)},
    )


Model = tuple[Problem, Array]  # with values (d,) SI of its unknowns

N_EVEN = 100  # speeds of each run to begin with
MOST = 2000  # of each run, before those of peaks
BENT = 0.01  # of ln|q|: 1 % of an amplitude, the width of a line
MAX_ROUNDS = 12  # of halving: of 1/100 of a band 2e-6 of it is left
IN_A_PEAK = 40  # speeds within a half-power width
WIDTHS = 2  # half-power widths about a peak that have as many each
MOST_PARTS = 2 * WIDTHS * IN_A_PEAK  # of a gap between two speeds


def fine_layout(measurement: Measurement, models: Sequence[Model]) -> Layout:
    """The layout of a measurement at speeds that suit the responses of all models, run by run."""
    bands = [measurement.speed[rows] for rows in measurement.rows]
    speeds = [np.union1d(band, np.linspace(np.min(band), np.max(band), N_EVEN)) for band in bands]
    sizes = _by_run(_sizes(models, _layout(measurement, speeds)), speeds)
    for _ in range(MAX_ROUNDS):
        added = [_between(*each) if len(each[0]) < MOST else np.empty(0) for each in zip(speeds, sizes)]
        if not any(len(each) for each in added):
            break
        new = [own if len(own) else speed[:1] for own, speed in zip(added, speeds)]  # a run without any is no run
        found = _by_run(_sizes(models, _layout(measurement, new)), new)
        for index, own in enumerate(added):
            if len(own):
                speeds[index], sizes[index] = _merged(speeds[index], sizes[index], own, found[index])
    return _layout(measurement, [_with_full_peaks(*each) for each in zip(speeds, sizes)])


def _layout(measurement: Measurement, speeds: list[Array]) -> Layout:
    """Layout of the measurement at other speeds of each run."""
    campaign = measurement.campaign and measurement.campaign.with_counts([len(each) for each in speeds])
    return dataclasses.replace(measurement.layout, speed=np.concatenate(speeds), campaign=campaign)


def _sizes(models: Sequence[Model], layout: Layout) -> Array:
    """ln|q| (n_speed, n_channel of all models)."""
    amplitude = np.abs(np.hstack(_responses(models, layout)))
    return np.asarray(np.log(np.maximum(amplitude, np.finfo(float).tiny)))


def _responses(models: Sequence[Model], layout: Layout) -> list[ComplexArray]:
    """Response (n_speed, n_channel) of each model, by one evaluation for all models of a problem."""
    found: dict[int, ComplexArray] = {}
    for problem in {id(problem): problem for problem, _ in models}.values():
        own = [index for index, (other, _) in enumerate(models) if other is problem]
        points = np.array([models[index][1] for index in own])
        found |= dict(zip(own, aligned(problem, layout).response(points)))
    return [found[index] for index in range(len(models))]


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


def _with_full_peaks(speed: Array, sizes: Array) -> Array:
    """Speeds that are no farther apart than 1/40 of each half-power width.

    That holds in each width and in half a width on both sides.
    """
    full = speed
    for peak in (each for size in sizes.T for each in full_peaks(speed, np.exp(size))):
        step, room = peak.width / IN_A_PEAK, (WIDTHS - 1) / 2 * peak.width
        within = np.flatnonzero(
            (full[1:] > peak.low - room) & (full[:-1] < peak.high + room)
        )  # gaps, by their lower ends
        parts = np.ceil((full[within + 1] - full[within]) / step).astype(int)
        added = [
            np.linspace(full[at], full[at + 1], n_part + 1)[1:-1]
            for at, n_part in zip(within, np.minimum(parts, MOST_PARTS))
        ]
        full = np.union1d(full, np.concatenate([np.empty(0), *added]))
    return full

"""Identification: the values that a method finds from one measurement, each with an interval.

Intervals, noise and most likely values belong to one maximum of the true model's likelihood: the one nearest to the method's
result, or the highest of the whole box if `details` are set or data are few. The record also has the method's own result. All that
takes evaluations and Jacobians of the true model, which are counted apart from the method's. What a report on one identification
adds is in `ksmea.studies.identification_details`, so that a change there leaves finished identifications fresh.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent, SettingError
from ksmea.fits.fitting import Fit, likely_maxima
from ksmea.fits.joint_fit import joint_maxima
from ksmea.identification.trace import TracedProblem, thinned, within_budget
from ksmea.inference.cramer_rao import Identifiability, identifiability
from ksmea.inference.critical_rise import can_be_simulated, simulated_rise
from ksmea.inference.intervals import Estimate, Interval, estimate
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.numerics.meter import JACOBIAN_AS_EVALUATIONS, Meter
from ksmea.plugins.identification import Identification, Method, Stage, Streams, at_limit
from ksmea.problem.case import Case
from ksmea.problem.counted import CountedProblem
from ksmea.problem.differences_problem import as_searched
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem, joint_values
from ksmea.records.identification import (
    IdentificationRecord,
    IntervalEffort,
    NoiseLevel,
    ParameterRecord,
    SearchStageRecord,
    Seconds,
    UpdateRecord,
)
from ksmea.records.record import finite
from ksmea.records.trace import TraceRecord
from ksmea.studies.curves import response_curves, with_noise
from ksmea.studies.enough_data import can_be_tested, require_enough
from ksmea.studies.inputs import input_records, origins_of
from ksmea.units import TURN

OF_DIFFERENCES = "likelihood of differences"  # the name of a stage
INTERVALS = ("profile", "information", "none")
INPUTS = ("joint", "stated")
FEW_DATA = 10  # for each unknown and noise level: with fewer, intervals hold what is likely all over the box


@dataclass(frozen=True)
class IdentificationOptions:
    """Contents of a record in addition to the method's result, and the evaluations it may use.

    Args:
        intervals: 'profile' (from the information, checked and where needed replaced by the profile likelihood: some ten
            Jacobians an unknown), 'information' (unchecked: a few in all) or 'none'. If they cannot be computed, the record has
            the reason.
        level: confidence of the intervals.
        crlb: Cramér–Rao bounds and correlations at the reported values.
        curves: the amplitudes that figures compare.
        details: let intervals reach over all likely maxima of the box, as they do with few data (`FEW_DATA`).
        inputs: 'joint' (numbers known to a tolerance are also fitted, in the last step, and intervals allow for them) or 'stated'
            (they are taken as exact).
        budget: evaluations of the true model for the method, in which a Jacobian counts as `jacobian_cost`; intervals are computed
            beyond it.

    Raises:
        SettingError: intervals of another name.
    """

    intervals: str = "profile"
    level: float = 0.95
    crlb: bool = True
    curves: bool = False
    details: bool = False
    budget: int | None = None
    jacobian_cost: int = JACOBIAN_AS_EVALUATIONS
    inputs: str = "joint"

    def __post_init__(self) -> None:
        if self.inputs not in INPUTS:
            raise SettingError(f"inputs: expected {' | '.join(INPUTS)}, got {self.inputs!r}")
        if self.intervals not in INTERVALS:
            raise SettingError(f"intervals: expected {' | '.join(INTERVALS)}, got {self.intervals!r}")


@dataclass(frozen=True)
class Identified:
    """Identification with the objects that its details are made of.

    `case` is as compared (`Case.answered`), `noise` known or estimated, `fit` the maximum that intervals belong to,
    `information` at the reported values; None without them.
    """

    record: IdentificationRecord
    case: Case
    noise: Noise | None
    fit: Fit | None
    information: Identifiability | None
    can_be_tested: bool  # whether data exceed unknowns by enough for a test of the fit


def identification(
    case: Case,
    method: Method,
    streams: Streams,
    options: IdentificationOptions = IdentificationOptions(),
    rng: np.random.Generator | None = None,
) -> IdentificationRecord:
    """The record of `identified`, without details."""
    return identified(case, method, streams, options, rng).record


def identified(
    case: Case, method: Method, streams: Streams, options: IdentificationOptions, rng: np.random.Generator | None
) -> Identified:
    """Identify the unknowns of a problem from a measurement by a method; true values have no part in it.

    `rng` is for the simulations of intervals from few data (`ksmea.inference.critical_rise`) and the search of the
    whole box.

    Raises:
        SettingError: fewer data than unknowns.
        ArithmeticError: an identified value is not finite.
    """
    case = case.answered()
    measurement = case.measurement
    with_noise = measurement.noise is None and options.intervals != "none"
    n_unknown = len(case.problem.parameters)
    require_enough(measurement.layout, n_unknown, with_noise=with_noise)
    record, found = _found(case, method, streams, Meter(options.budget, options.jacobian_cost))
    noise, fit = measurement.noise, None
    if options.intervals != "none" and (noise is None or measurement.has_noise):
        record, noise, fit = _with_intervals(record, case, options, rng)
    within = case if options.inputs == "joint" else case.by(case.problem.as_stated)
    information = _information(within, record.values, noise, fit) if options.crlb else None
    if information is not None:
        record = _with_crlb(record, information)
    if options.curves:
        record = dataclasses.replace(record, curves=response_curves(case, found))
    testable = can_be_tested(measurement.layout, n_unknown, with_noise=with_noise)
    return Identified(record, case, noise, fit, information, testable)


def _found(case: Case, method: Method, streams: Streams, meter: Meter) -> tuple[IdentificationRecord, Identification]:
    """Result, record and trace of the method; of differences, the nearest maximum of their likelihood."""
    measurement, searched = case.measurement, as_searched(case)
    traced = TracedProblem(searched.problem, searched.measurement, meter)
    found = within_budget(method, traced, searched.measurement, streams)
    if measurement.is_by_differences and (measurement.noise is None or measurement.has_noise):
        with suppress(BudgetSpent):
            found = _at_nearest(found, case.by(CountedProblem(case.problem, meter)), meter)
    trace = thinned(traced.improvements, found.stages)
    found = _within_a_turn(case.problem.parameters, found)
    return _method_record(searched, found, meter, trace), found


def _at_nearest(found: Identification, case: Case, meter: Meter) -> Identification:
    """Result with one more stage, the nearest maximum of the likelihood of differences."""
    likelihood, parameters = likelihood_of(case), case.problem.parameters
    stages = found.stages or (Stage("search", found.x, meter.evaluations, meter.jacobians),)
    nearest = nearest_maximum(likelihood, np.clip(parameters.to_cube(found.x), 0.0, 1.0))
    x = parameters.to_si(nearest.theta[: likelihood.d])
    stages = (*stages, Stage(OF_DIFFERENCES, x, meter.evaluations, meter.jacobians))
    return dataclasses.replace(found, x=x, stages=stages)


def _within_a_turn(parameters: Parameters, found: Identification) -> Identification:
    """Identification with freely turning angles in (−180°, 180°], far from the limits of their search."""
    x = np.array([parameter.turned(value) for parameter, value in zip(parameters, found.x)])
    if np.array_equal(x, found.x):
        return found
    return dataclasses.replace(found, x=x, at_limit=at_limit(parameters.to_cube(x)))


def _method_record(case: Case, found: Identification, took: Meter, trace: TraceRecord) -> IdentificationRecord:
    """Record of the method's own result, with its evaluations of the true model by our count."""
    for x in (found.x, *(stage.x for stage in found.stages)):
        if not np.all(np.isfinite(x)):
            raise ArithmeticError(f"the identified values are not finite: {x}")
    return IdentificationRecord(
        status="budget" if found.was_cut_short else "done",
        stop=found.stop,
        parameters=tuple(
            ParameterRecord(parameter.name, parameter.unit, parameter.si_per_unit, float(value), at)
            for parameter, value, at in zip(case.problem.parameters, found.x, found.at_limit)
        ),
        misfit=finite(_likelihood_misfit(case, found.x)),
        updates=found.updates,
        model_evaluations=took.evaluations,
        model_jacobians=took.jacobians,
        surrogate_evaluations=found.surrogate_evaluations,
        seconds=Seconds(**found.seconds),
        history=tuple(
            UpdateRecord(
                tuple(update.x.tolist()),
                finite(update.predicted_misfit),
                finite(update.misfit),
                finite(update.smc),
                finite(update.sdf),
                None if update.polish_gain is None else finite(update.polish_gain),
                tuple(
                    SearchStageRecord(each.name, tuple(each.x.tolist()), finite(each.misfit)) for each in update.search
                ),
            )
            for update in found.history
        ),
        remarks=(*case.problem.remarks_at(case.problem.speed), *found.remarks),
        notes={name: finite(value) for name, value in found.notes.items()},
        trace=trace,
        notation=case.measurement.notation,
    )


def _likelihood_misfit(case: Case, x: Array) -> float:
    """The likelihood misfit at x (d,) SI: the same form whatever a method minimised, to compare them by."""
    misfit = Misfit(case.measurement, "likelihood")
    return float(misfit.value(misfit.observed(case.problem.response(x[None])))[0])


def _with_intervals(
    record: IdentificationRecord, case: Case, options: IdentificationOptions, rng: np.random.Generator | None
) -> tuple[IdentificationRecord, Noise | None, Fit | None]:
    """The record with intervals, noise level and their cost.

    The noise, estimated if it was not known; the fit they belong to. If they cannot be computed, the record has the
    reason. All likely maxima of the box are searched for with details or few data.
    """
    started = time.perf_counter()
    counted, check, level = CountedProblem(case.problem), options.intervals == "profile", options.level
    likelihood = likelihood_of(case.by(counted))
    own: Sequence[int] = range(likelihood.d)
    try:
        maxima, rises = [nearest_maximum(likelihood, case.problem.parameters.to_cube(record.x))], None
        are_few = check and likelihood.n_residual < FEW_DATA * len(likelihood.lower)
        if options.details or are_few:
            maxima = likely_maxima(likelihood, maxima[0], rng)
        if options.inputs == "joint" and (joint := counted.joint) is not counted:
            likelihood, maxima, own = _joint(case, joint, maxima)
        elif are_few and (rises := _simulated(likelihood, level, maxima, rng)) is not None:
            maxima = maxima[: len(rises)]
        estimated = estimate(
            likelihood, maxima[0], others=maxima[1:], level=level, check=check, rises=rises, profiled=own
        )
        fit = Fit(likelihood, estimated.point)
    except np.linalg.LinAlgError as error:
        return dataclasses.replace(record, interval_error=str(error)), case.measurement.noise, None
    effort = IntervalEffort(
        level=level,
        noise=_noise_level(estimated.noise, case.measurement),
        model_evaluations=counted.meter.evaluations,
        model_jacobians=counted.meter.jacobians,
        seconds=time.perf_counter() - started,
    )
    record = dataclasses.replace(
        record,
        parameters=_with_ends(record.parameters, case.problem.parameters, _part(estimated, own)),
        intervals=effort,
        deviance=finite(fit.deviance),
        search_excess=finite(_excess(fit, joint_values(case.problem, fit.problem, record.x))),
    )
    return _with_inputs(record, fit, own), estimated.noise, fit


def _joint(case: Case, joint: Problem, maxima: Sequence[Point]) -> tuple[Likelihood, list[Point], list[int]]:
    """Likelihood of the joint problem, its maxima, and the indices of the problem's own unknowns."""
    likelihood, parameters = likelihood_of(case.by(joint)), case.problem.parameters
    values = [parameters.to_si(point.theta[: len(parameters)]) for point in maxima]
    starts = [joint.parameters.to_cube(joint_values(case.problem, joint, x)) for x in values]
    return (
        likelihood,
        joint_maxima(likelihood, starts),
        [joint.parameters.names.index(name) for name in parameters.names],
    )


def _part(estimated: Estimate, own: Sequence[int]) -> Estimate:
    """An estimate of some of its unknowns."""
    if len(own) == len(estimated.x):
        return estimated
    return dataclasses.replace(
        estimated, x=estimated.x[list(own)], intervals=tuple(estimated.intervals[index] for index in own)
    )


def _with_inputs(record: IdentificationRecord, fit: Fit, own: Sequence[int]) -> IdentificationRecord:
    """Record with numbers that are known to a tolerance, and the origin of each unknown's uncertainty."""
    inputs = input_records(fit)
    if not inputs:
        return record
    origins = origins_of(fit, own)
    parameters = tuple(dataclasses.replace(part, origin=each) for part, each in zip(record.parameters, origins))
    return dataclasses.replace(record, parameters=parameters, inputs=inputs)


def _simulated(
    likelihood: Likelihood, level: float, maxima: Sequence[Point], rng: np.random.Generator | None
) -> Array | None:
    """Rise of the deviance around the highest maxima (n, d), by simulations; None if there can be none."""
    if rng is not None and can_be_simulated(likelihood):
        with suppress(np.linalg.LinAlgError):  # no finite response somewhere on the way
            return simulated_rise(likelihood, level, maxima, rng.spawn(1)[0])
    return None


def _excess(fit: Fit, x: Array) -> float:
    """How much higher the deviance is at x (d,) SI than at the fit's maximum, at the same noise."""
    theta = np.concatenate([fit.problem.parameters.to_cube(x), fit.point.theta[len(x) :]])
    return fit.likelihood.deviance(theta) - fit.deviance


def _with_ends(
    parts: Sequence[ParameterRecord], parameters: Parameters, estimated: Estimate
) -> tuple[ParameterRecord, ...]:
    at = at_limit(parameters.to_cube(estimated.x))
    return tuple(
        _with_end(part, *values) for part, *values in zip(parts, parameters, estimated.intervals, estimated.x, at)
    )


def _with_end(
    part: ParameterRecord, parameter: Parameter, interval: Interval, most_likely: float, at: bool
) -> ParameterRecord:
    """An unknown with its interval and most likely value.

    An angle that is free to turn is given in (−180°, 180°], the method's value on the turn nearest to it; an interval
    as wide as a turn holds any value.
    """
    if parameter.is_full_turn and not interval.high - interval.low < TURN:
        interval = Interval(-np.inf, np.inf, "not identifiable")
    turned = parameter.turned(float(most_likely))
    by = turned - float(most_likely)
    found = part.identified
    if parameter.is_full_turn:
        found += TURN * round((turned - found) / TURN)
    return dataclasses.replace(
        part,
        identified=found,
        at_limit=at,
        low=finite(interval.low + by),
        high=finite(interval.high + by),
        kind=interval.basis,
        most_likely=turned,
    )


def _noise_level(noise: Noise, measurement: Measurement) -> NoiseLevel:
    relative, floor = (float(np.sqrt(np.mean(np.square(part)))) for part in (noise.relative, noise.floor))
    return NoiseLevel(relative, floor, measurement.by_run(noise), estimated=measurement.noise is None)


def _information(case: Case, x: Array, noise: Noise | None, fit: Fit | None) -> Identifiability | None:
    """Information of data with this noise at x (d,) SI, or at a joint fit; None without noise or response."""
    if noise is None or noise.is_absent:
        return None
    try:
        return _identifiability(case, x, noise, None if fit is None or not len(fit.inputs) else fit.x)
    except np.linalg.LinAlgError:
        return None


def _with_crlb(record: IdentificationRecord, information: Identifiability) -> IdentificationRecord:
    """Record with Cramér–Rao bounds and correlations at the reported values; None if infinite."""
    return dataclasses.replace(
        record,
        parameters=tuple(
            dataclasses.replace(part, crlb=finite(crlb)) for part, crlb in zip(record.parameters, information.crlb)
        ),
        correlation=tuple(tuple(finite(value) for value in line) for line in information.correlation),
    )


def _identifiability(case: Case, x: Array, noise: Noise, beside: Array | None) -> Identifiability:
    """Information of the data at x (d,) SI, or at the values of a joint fit (if given).

    If only differences between runs count, it is the information of these at x alone."""
    problem, measurement = case.problem, case.measurement
    if not measurement.is_by_differences:
        known = measurement.noise is not None
        return identifiability(problem, x, noise, measurement.kind, noise_known=known, beside=beside)
    parameters = problem.parameters
    whitened = with_noise(case, noise).at(parameters.to_cube(x)).whitened / parameters.width
    return Identifiability(x, whitened, np.where(x == 0, parameters.width, np.abs(x)))

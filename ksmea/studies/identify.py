"""Identification: the values that a method finds from one measurement, with an interval beside each.

Intervals, noise and most likely values belong to one maximum of the true model's likelihood: the one nearest to what the
method found, or with details and where data are few the highest that a search of the whole box meets. The record says where the method ended
besides. All that takes evaluations and Jacobians of the true model, which are counted apart from the method's.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import LONGEST_NAME, BudgetSpent, SettingError, shortened
from ksmea.fits.fitting import Fit, likely_maxima
from ksmea.fits.lack_of_fit import fit_quality
from ksmea.identification.trace import PredictionCount, TracedProblem, thinned, with_counted_surrogate, within_budget
from ksmea.inference.cramer_rao import Identifiability, identifiability
from ksmea.inference.intervals import Estimate, Interval, estimate
from ksmea.inference.maximisation import nearest_maximum
from ksmea.inference.simulated_rise import can_be_simulated, simulated_rise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Identification, Stage, Streams, at_limit
from ksmea.plugins.method import Method
from ksmea.problem.alignment import answered
from ksmea.problem.budget_and_journal import Budget, BudgetedProblem
from ksmea.problem.counted import Count, CountedProblem, Model
from ksmea.problem.differences_problem import as_searched
from ksmea.problem.load import FORCE
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.records.identification import (
    DataDescription,
    IdentificationRecord,
    IntervalEffort,
    LackOfFit,
    NoiseLevel,
    ParameterRecord,
    SearchStageRecord,
    Seconds,
    UpdateRecord,
)
from ksmea.records.record import finite
from ksmea.records.trace import TraceRecord
from ksmea.studies.curves import fit_curves, response_curves, with_noise
from ksmea.studies.enough_data import can_be_tested, require_enough
from ksmea.studies.hausman import both_ways, repeats_of
from ksmea.studies.locate import LocationOptions, location
from ksmea.studies.misreadings import misreadings, slips
from ksmea.studies.remarks import campaign_remarks
from ksmea.studies.stability import stability_of
from ksmea.studies.weights import weights_found
from ksmea.units import TURN

AUTO = "auto"
OF_DIFFERENCES = "likelihood of differences"  # the name of a stage
INTERVALS = ("profile", "information", "none")
FEW_DATA = 10  # for each unknown and noise level: with fewer, intervals hold what is likely all over the box
LACK_OF_FIT_LEVEL = 0.01  # chance of rejecting a right model


def identification(
    problem: Problem,
    measurement: Measurement,
    method: Method,
    streams: Streams,
    *,
    intervals: str = "profile",
    level: float = 0.95,
    crlb: bool = True,
    details: bool = False,
    curves: bool = False,
    beside: LocationOptions | None = None,
    remarks: Sequence[str] = (),
    rng: np.random.Generator | None = None,
    budget: Budget | None = None,
) -> IdentificationRecord:
    """The record of what a method identifies from a measurement; true values have no part in it.

    `intervals`: 'profile' (from the information, checked and where needed replaced by the profile likelihood: some ten
    Jacobians an unknown), 'information' (unchecked: a few in all) or 'none'; `level` is their confidence. Where they
    cannot be computed the record says why. `crlb` adds Cramér–Rao bounds and correlations at the reported values.
    `details` adds what a report on one identification shows: the data in words with `remarks`, data and fit over speed,
    and a test of the fit by simulations. With it, and where data are few (`FEW_DATA`), intervals reach over all likely maxima
    of the whole box; where they are few, simulations tell how far the deviance rises within them (`ksmea.inference.simulated_rise`), if
    there is a generator. All that draws from `rng`. `curves` adds the amplitudes that figures compare. `beside`
    (`location_options`) adds the unknowns beside a force that the model lacks (`ksmea.studies.locate`): they stay true although
    the model is wrong. `budget` is what the method may take of the true model; intervals are made beyond it.

    Raises `SettingError` for settings that cannot be and for fewer data than unknowns, `ArithmeticError` where what was identified is not finite.
    """
    if intervals not in INTERVALS:
        raise SettingError(f"intervals: expected {' | '.join(INTERVALS)}, got {intervals!r}")
    if (details or beside) and rng is None:
        raise SettingError(
            f"{'details' if details else 'unmodelled'}: expected a generator for the simulations of its tests, got none; give rng"
        )
    measured = measurement.channels
    problem, measurement = answered(problem, measurement)
    if left_out := [str(channel) for channel in measured if channel not in measurement.channels]:
        remarks = (*remarks, f"left out, since the model has no response there: {', '.join(left_out)}")
    n_unknown, with_noise = len(problem.parameters), measurement.noise is None and intervals != "none"
    require_enough(measurement.layout, n_unknown, with_noise=with_noise)
    testable = can_be_tested(measurement.layout, n_unknown, with_noise=with_noise)
    predictions = PredictionCount()
    searched, data = as_searched(problem, measurement)
    traced = TracedProblem(searched, data, predictions)
    found = within_budget(with_counted_surrogate(method, predictions), traced, data, streams, budget, predictions)
    if measurement.is_by_differences and (measurement.noise is None or measurement.has_noise):
        counted = CountedProblem(problem, traced.count)
        with suppress(BudgetSpent):
            within = counted if budget is None else BudgetedProblem(counted, budget)
            found = _at_nearest(found, within, traced.count, measurement)
    trace = thinned(traced.improvements, found.stages)
    found = _within_a_turn(problem.parameters, found)
    record = _method_record(searched, data, found, traced.count, trace)
    noise = measurement.noise
    if intervals != "none" and (noise is None or measurement.has_noise):
        record, noise = _with_intervals(
            record,
            problem,
            measurement,
            level,
            check=intervals == "profile",
            rng=rng,
            details=details,
            test=testable,
        )
    told = _told(problem, measurement, record.values, noise) if crlb else None
    if told is not None:
        record = _with_crlb(record, told)
    if details:
        x = record.values
        rejected = record.lack_of_fit is not None and record.lack_of_fit.rejected
        misread = misreadings(problem, measurement, x, noise, rejected=rejected)
        remarks = (*remarks, *(misread or slips(problem, x, measurement)))
        known, told_noise = measurement.noise is not None, None if measurement.is_by_differences else noise
        record = dataclasses.replace(
            record,
            both_ways=both_ways(problem, measurement, x),
            data=_description(problem, measurement, remarks, testable=testable),
            repeats=repeats_of(measurement),
            fit=fit_curves(problem, measurement, x, noise),
            stability=stability_of(problem, x, told_noise, measurement.kind, noise_known=known, level=level, told=told),
        )
    if beside is not None and rng is not None:
        record = dataclasses.replace(record, location=location(problem, measurement, rng, options=beside))
    if curves:
        record = dataclasses.replace(record, curves=response_curves(problem, measurement, found))
    return record


def location_options(unmodelled: str, level: float) -> LocationOptions | None:
    """What is tried where for the unknowns beside an unmodelled force: at a position (m), anything anywhere for `AUTO`,
    nothing where it is empty. `level` is that of intervals."""
    if not unmodelled:
        return None
    if unmodelled == AUTO:
        return LocationOptions(interval_level=level)
    try:
        position = float(unmodelled)
    except ValueError:
        raise SettingError(
            f"unmodelled: expected {AUTO} or the position of a site in m, got {shortened(unmodelled, LONGEST_NAME)!r}"
        ) from None
    return LocationOptions(interval_level=level, positions=[position], kinds=[FORCE])


def _at_nearest(found: Identification, problem: Problem, count: Count, measurement: Measurement) -> Identification:
    """What was found, and as one more stage the maximum of the likelihood nearest to it: of differences, where a search takes
    their noise for independent."""
    likelihood, parameters = likelihood_of(Model(problem), measurement), problem.parameters
    stages = found.stages or (Stage("search", found.x, count.evaluations, count.jacobians),)
    nearest = nearest_maximum(likelihood, np.clip(parameters.to_cube(found.x), 0.0, 1.0))
    x = parameters.to_si(nearest.theta[: likelihood.d])
    stages = (*stages, Stage(OF_DIFFERENCES, x, count.evaluations, count.jacobians))
    return dataclasses.replace(found, x=x, stages=stages)


def _within_a_turn(parameters: Parameters, found: Identification) -> Identification:
    """The same identification with angles that are free to turn in (−180°, 180°], far from the limits of their search."""
    x = np.array([parameter.turned(value) for parameter, value in zip(parameters, found.x)])
    if np.array_equal(x, found.x):
        return found
    return dataclasses.replace(found, x=x, at_limit=at_limit(parameters.to_cube(x)))


def _method_record(
    problem: Problem, measurement: Measurement, found: Identification, took: Count, trace: TraceRecord
) -> IdentificationRecord:
    """What the method itself found, and what it took of the true model by our own count, whatever it says."""
    for x in (found.x, *(stage.x for stage in found.stages)):
        if not np.all(np.isfinite(x)):
            raise ArithmeticError(f"the identified values are not finite: {x}")
    return IdentificationRecord(
        status="budget" if found.was_cut_short else "done",
        stop=found.stop,
        parameters=tuple(
            ParameterRecord(parameter.name, parameter.unit, parameter.si_per_unit, float(value), at)
            for parameter, value, at in zip(problem.parameters, found.x, found.at_limit)
        ),
        misfit=finite(_likelihood_misfit(problem, measurement, found.x)),
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
        remarks=found.remarks,
        notes={name: finite(value) for name, value in found.notes.items()},
        trace=trace,
    )


def _likelihood_misfit(problem: Problem, measurement: Measurement, x: Array) -> float:
    """The likelihood misfit at x (d,) SI: the same form whatever a method minimised, to compare them by."""
    misfit = Misfit(measurement, "likelihood")
    return float(misfit.value(misfit.observed(problem.response(x[None])))[0])


def _with_intervals(
    record: IdentificationRecord,
    problem: Problem,
    measurement: Measurement,
    level: float,
    *,
    check: bool,
    rng: np.random.Generator | None,
    details: bool,
    test: bool,
) -> tuple[IdentificationRecord, Noise | None]:
    """The record with intervals, noise level and what they took, and the noise, estimated where it was not known; what
    cannot be computed costs no identification. With `details`, and where data are few, all likely maxima of the box are looked
    for, and with details and `test` the fit is tested."""
    started = time.perf_counter()
    counted = CountedProblem(problem)
    likelihood = likelihood_of(Model(counted), measurement)
    try:
        maxima, rises = [nearest_maximum(likelihood, problem.parameters.to_cube(record.x))], None
        are_few = check and _has_few_data(likelihood)
        if details or are_few:
            maxima = likely_maxima(likelihood, maxima[0], rng)
        if are_few and (rises := _simulated(likelihood, level, maxima, rng)) is not None:
            maxima = maxima[: len(rises)]
        estimated = estimate(likelihood, maxima[0], others=maxima[1:], level=level, check=check, rises=rises)
        fit = Fit(problem, likelihood, estimated.point)
    except np.linalg.LinAlgError as error:
        return dataclasses.replace(record, interval_error=str(error)), measurement.noise
    effort = IntervalEffort(
        level=level,
        noise=_noise_level(estimated.noise, measurement),
        model_evaluations=counted.count.evaluations,
        model_jacobians=counted.count.jacobians,
        seconds=time.perf_counter() - started,
    )
    return dataclasses.replace(
        record,
        parameters=_with_ends(record.parameters, problem.parameters, estimated),
        intervals=effort,
        deviance=finite(fit.deviance),
        search_excess=finite(_excess(fit, record.x)),
        lack_of_fit=_lack_of_fit(fit, rng) if details and rng is not None and test else None,
        weights=weights_found(fit, level) if details else None,
    ), estimated.noise


def _simulated(
    likelihood: Likelihood, level: float, maxima: Sequence[Point], rng: np.random.Generator | None
) -> Array | None:
    """How far the deviance may rise around the highest maxima (n, d), by simulations; None where there can be none."""
    if rng is not None and can_be_simulated(likelihood):
        with suppress(np.linalg.LinAlgError):  # no finite response somewhere on the way
            return simulated_rise(likelihood, level, maxima, rng.spawn(1)[0])
    return None


def _has_few_data(likelihood: Likelihood) -> bool:
    """Whether the data are so few for the unknowns and noise levels that other maxima can be as likely."""
    return likelihood.n_residual < FEW_DATA * len(likelihood.lower)


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
    """An unknown with its interval and most likely value. An angle that is free to turn is told in (−180°, 180°], the
    method's value on the turn nearest to it; an interval as wide as a turn holds any value."""
    if parameter.is_full_turn and not interval.high - interval.low < TURN:
        interval = Interval(-np.inf, np.inf, "not identifiable")
    told = parameter.turned(float(most_likely))
    by = told - float(most_likely)
    found = part.identified
    if parameter.is_full_turn:
        found += TURN * round((told - found) / TURN)
    return dataclasses.replace(
        part,
        identified=found,
        at_limit=at,
        low=finite(interval.low + by),
        high=finite(interval.high + by),
        kind=interval.kind,
        most_likely=told,
    )


def _noise_level(noise: Noise, measurement: Measurement) -> NoiseLevel:
    relative, floor = (float(np.sqrt(np.mean(np.square(part)))) for part in (noise.relative, noise.floor))
    return NoiseLevel(relative, floor, measurement.noise is None, measurement.by_run(noise))


def _lack_of_fit(fit: Fit, rng: np.random.Generator) -> LackOfFit:
    tested = fit_quality(fit, rng)
    return LackOfFit(float(tested.p), tested.worst_statistic, bool(tested.p < LACK_OF_FIT_LEVEL))


def _told(problem: Problem, measurement: Measurement, x: Array, noise: Noise | None) -> Identifiability | None:
    """What data with this noise tell about the unknowns at x (d,) SI; None without noise, or where they have no response."""
    if noise is None or noise.is_absent:
        return None
    try:
        return _identifiability(problem, measurement, x, noise)
    except np.linalg.LinAlgError:
        return None


def _with_crlb(record: IdentificationRecord, told: Identifiability) -> IdentificationRecord:
    """The record with Cramér–Rao bounds and correlations at the reported values; None where they are infinite."""
    return dataclasses.replace(
        record,
        parameters=tuple(
            dataclasses.replace(part, crlb=finite(crlb)) for part, crlb in zip(record.parameters, told.crlb)
        ),
        correlation=tuple(tuple(finite(value) for value in line) for line in told.correlation),
    )


def _identifiability(problem: Problem, measurement: Measurement, x: Array, noise: Noise) -> Identifiability:
    """What the data tell at x (d,) SI; of differences between runs, what these do."""
    if not measurement.is_by_differences:
        return identifiability(problem, x, noise, measurement.kind, noise_known=measurement.noise is not None)
    parameters = problem.parameters
    whitened = with_noise(problem, measurement, noise).at(parameters.to_cube(x)).whitened / parameters.width
    return Identifiability(x, whitened, np.where(x == 0, parameters.width, np.abs(x)))


def _description(
    problem: Problem, measurement: Measurement, remarks: Sequence[str], *, testable: bool
) -> DataDescription:
    return DataDescription(
        source=measurement.source,
        kind=measurement.kind,
        n_speed=len(measurement.speed),
        speed_from=float(np.min(measurement.speed)),
        speed_to=float(np.max(measurement.speed)),
        channels=tuple(str(channel) for channel in measurement.channels),
        remarks=(*campaign_remarks(problem, measurement), *remarks),
        reference=measurement.campaign.reference if measurement.campaign else "",
        too_few_to_test=not testable,
    )

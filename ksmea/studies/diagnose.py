"""Diagnosis of a measurement as a record: misfit of the model, its physical cause, and the evidence."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ksmea.diagnosis.diagnosis import Criteria, Diagnosis, diagnose
from ksmea.diagnosis.further_measurement import Split
from ksmea.diagnosis.located_verdict import is_one_law, remark_on, seeks_laws, with_location, without_names
from ksmea.diagnosis.observability import Detectable
from ksmea.diagnosis.trials import Trial
from ksmea.fits.fitting import Fit, fit_baseline
from ksmea.fits.joint_fit import joint_baseline
from ksmea.fits.lack_of_fit import FitQuality, whirl_parts
from ksmea.fits.search import Effort, Search
from ksmea.inference.intervals import Estimate, estimate
from ksmea.location.location import missing_to_locate
from ksmea.location.unknown_force import READING
from ksmea.measurement.campaign import notation
from ksmea.measurement.measurement import Measurement
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.records.diagnosis import (
    CoefficientRecord,
    DetectableRecord,
    DiagnosisRecord,
    FitQualityRecord,
    LackOfFitRecord,
    NoiseRecord,
    SplitRecord,
    TrialRecord,
)
from ksmea.records.estimate import StabilityRecord
from ksmea.records.extension import AveragedRecord, EffectRecord, ExplanationRecord, PredictiveGainRecord
from ksmea.records.record import finite
from ksmea.settings.settings import Settings, setting
from ksmea.studies.diagnosis_curves import diagnosis_curves
from ksmea.studies.diagnosis_remarks import (
    disagreements,
    effect_record,
    estimated_record,
    reading_of,
    reading_remarks,
    remarks_on,
    slips_of,
    stated_effects,
)
from ksmea.studies.enough_data import estimate_record, noise_record
from ksmea.studies.hausman import both_ways, repeats_of
from ksmea.studies.inputs import input_records
from ksmea.studies.locate import Located, LocationOptions, location
from ksmea.studies.misreadings import Misread
from ksmea.studies.remarks import campaign_remarks, refuse_differences
from ksmea.studies.stability import stability_of

WRONG = ("named", "ambiguous", "unknown")  # verdicts on a model that is not adequate


@dataclass(frozen=True)
class DiagnosisOptions(Settings):
    """How sure a diagnosis has to be, and how hard it looks."""

    level: float = setting(
        0.01,
        "chance of rejecting a right model; 4000 simulations resolve no smaller one",
        at_least=0.002,
        at_most=0.5,
    )
    interval_level: float = setting(0.95, "confidence level of intervals", above=0, at_most=0.9999)
    blocks: int = setting(
        6, "contiguous blocks of speeds that are left out in turn; fewer than 5 cannot support an extension", at_least=2
    )
    screening: int = setting(4096, "points of the baseline model's range that are screened", at_least=64)
    starts: int = setting(12, "fits of the baseline model from the best of them", at_least=1)
    scan: int = setting(
        200, "number of these points, mostly the best, that are screened again at each value of an effect", at_least=1
    )
    scan_values: int = setting(
        16,
        "values of an effect with one unknown, within its limits; twice as many for each further unknown",
        at_least=1,
    )
    effect_starts: int = setting(5, "fits of each effect from the best of those", at_least=1)
    firsts: int = setting(
        3, "first effects to which second ones are added, if the residuals of the best one are not noise", at_least=1
    )
    pairs: int = setting(
        18, "pairs of effects that are fitted to the end, and as many at most whose second one is scanned", at_least=1
    )
    average: bool = setting(True, "where several explanations are near, average unknowns and responses over them")
    split: bool = setting(
        True, "where several explanations are near, seek the further measurement that tells them apart"
    )
    locate: bool = setting(
        True,
        "also locate an unknown force of any cause, if the model is wrong",
    )

    @property
    def location(self) -> LocationOptions:
        return LocationOptions(level=self.level, interval_level=self.interval_level, blocks=self.blocks)

    @property
    def criteria(self) -> Criteria:
        return Criteria(self.level, self.interval_level, self.blocks)

    @property
    def effort(self) -> Effort:
        return Effort(
            screening=self.screening,
            starts=self.starts,
            scan=self.scan,
            scan_values=self.scan_values,
            effect_starts=self.effect_starts,
            firsts=self.firsts,
            pairs=self.pairs,
            average=self.average,
            split=self.split,
        )


@dataclass(frozen=True)
class Report:
    """Contents of a diagnosis record in addition to the verdict.

    `left_out` names effects that are not in the library, and why; `remarks` are remarks on the data that are known before.
    `details` adds remarks on data that look like an input error, for a report on one diagnosis. `fine` adds the curves of both
    models at as many speeds as its figures need.
    """

    left_out: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    details: bool = True
    fine: bool = True


def diagnosis(
    case: Case,
    effects: Mapping[str, AnyEffect],
    rng: np.random.Generator,
    *,
    options: DiagnosisOptions | None = None,
    report: Report = Report(),
    workers: Workers = ALONE,
) -> DiagnosisRecord:
    """Diagnosis of a measurement by a problem and the effects, by name, that may extend it.

    The record names effects that do not fit the problem in addition to the ones left out before, and why. If the model is wrong
    and the data over-determine an unknown force, the record also has its location. This location is the verdict (`located`) if no
    effect explains the data; then laws that the force may follow are sought too.

    Raises ValueError if there are effects, but none of them has a location on the problem.
    """
    refuse_differences(case.measurement, "diagnose")
    options = options or DiagnosisOptions()
    search = Search(rng, options.effort, workers)
    baseline = joint_baseline(fit_baseline(case, search))
    reading = reading_of(baseline.best, case, search.rng, options.criteria) if report.details else None
    if reading is not None and (record := _read_otherwise(reading, case.problem, search, options, report)) is not None:
        return record
    is_locatable = options.locate and not missing_to_locate(case.problem, case.measurement.kind)
    locate = Located(rng, options.location, workers) if is_locatable else None
    found = diagnose(case, effects, search, options.criteria, baseline, locate)
    measurement = case.measurement
    problem, where = case.problem, None
    given_up: tuple[str, ...] = ()
    ahead = (*campaign_remarks(case), *problem.remarks_at(problem.speed), *report.remarks)
    case = found.baseline.case  # with the noise that it goes by
    if locate is not None and found.verdict in WRONG:
        sites, sought = locate(case), options.location
        with_laws = seeks_laws(found, sites)
        where = location(
            case, rng, options=sought, baseline=found.baseline, with_laws=with_laws, workers=workers, found=sites
        )
        if is_one_law(found, where, sites):
            given_up, found = (remark_on(found, where),), without_names(found)
    record = diagnosis_record(found, fine=report.fine)
    remarks = (*ahead, *remarks_on(found, measurement), *given_up)
    if where is not None:
        record = with_location(record, where)
        remarks = (*remarks, *disagreements(found, where))
    if report.details and (record.verdict != "located" or _reads_wrong(record)):  # explained data are not misread
        remarks = (*remarks, *slips_of(found, problem, reading))
    remarks = (*remarks, *(reading_remarks(found) if report.details else ()))
    return dataclasses.replace(
        record,
        left_out={**report.left_out, **record.left_out},
        remarks=remarks,
        repeats=repeats_of(case.measurement),
        is_split_sought=options.split,
        both_ways=both_ways(case, found.baseline.x) if report.details else None,
    )


def _read_otherwise(
    found: Misread, problem: Problem, search: Search, options: DiagnosisOptions, report: Report
) -> DiagnosisRecord | None:
    """Diagnosis of misread data, which ends the search; None if something else is wrong, too."""
    reading, _ = found.best
    case = Case.of(problem, reading.measurement)
    read = diagnose(case, {}, search, options.criteria)
    if read.baseline_quality.p < options.criteria.half:
        return None
    record = diagnosis_record(read, fine=report.fine)
    remarks = (*problem.remarks_at(case.measurement.speed), *report.remarks)
    return dataclasses.replace(
        record, verdict="misread", reading=str(found), left_out=dict(report.left_out), remarks=remarks
    )


def _reads_wrong(record: DiagnosisRecord) -> bool:
    """Whether the reading of a plane is unknown, which may be one that was given wrongly."""
    return record.location is not None and record.location.kind == READING


def diagnosis_record(found: Diagnosis, *, fine: bool = False) -> DiagnosisRecord:
    """Diagnosis as plain data, values in their units; `fine` adds the models' curves at more speeds."""
    measurement, gain = found.baseline.measurement, found.predictive_gain
    return DiagnosisRecord(
        verdict=found.verdict,
        named=found.named,
        ambiguity_group=found.ambiguity_group,
        locations=found.locations,
        applied=_applied(found),
        ranking=tuple(_trial(trial, found) for trial in found.trials),
        lack_of_fit=_lack_of_fit(found),
        noise=_noise(found),
        coefficients=_coefficients(found),
        predictive_gain=None if gain is None else PredictiveGainRecord.of(gain.elpd, gain.rmse_before, gain.rmse_after),
        min_detectable={
            name: tuple(_detectable(location, each) for each in parts)
            for name, (location, parts) in found.detectable.items()
        },
        split=None if found.split is None else _split(found.split),
        collinearity=dict(found.collinearity),
        aliases={name: text for candidate in found.applied for name, text in candidate.effect.aliases.items()},
        effects=tuple(dict.fromkeys(trial.name for trial in found.trials)),
        curves=diagnosis_curves(found, fine=fine),
        left_out=dict(found.left_out),
        source=measurement.source,
        notation=measurement.notation,
        stability=_stability(found),
        explanations=_explanations(found),
        averaged=_averaged(found),
        inputs=input_records(_believed(found)),
    )


def _explanations(found: Diagnosis) -> tuple[ExplanationRecord, ...]:
    weights = () if found.averaged is None else found.averaged.weights.tolist()
    return tuple(
        ExplanationRecord(
            each.label,
            tuple(stated_effects(each.applied, each.fit, _unchecked(each.fit, found))),
            each.deviance_drop,
            each.delta_bic,
            weight,
        )
        for each, weight in itertools.zip_longest(found.explanations, weights)
    )


def _averaged(found: Diagnosis) -> AveragedRecord | None:
    if found.averaged is None:
        return None
    rows = zip(found.baseline.problem.parameters, found.averaged.values, found.averaged.intervals, strict=True)
    return AveragedRecord(
        found.interval_level,
        tuple(estimate_record(item, float(value), interval) for item, value, interval in rows if not item.is_input),
    )


def _stability(found: Diagnosis) -> StabilityRecord | None:
    """Stability of the model that the verdict accepts."""
    fit = _believed(found)
    known, level = fit.measurement.noise is not None, found.interval_level
    return stability_of(fit.problem, fit.x, fit.noise, fit.measurement.kind, noise_known=known, level=level)


def _believed(found: Diagnosis) -> Fit:
    return found.best if found.best is not None and found.named else found.baseline


def _split(split: Split) -> SplitRecord:
    return SplitRecord(
        split.measurement,
        now=min(pair.now for pair in split.distinguished),
        then=min(pair.then for pair in split.distinguished),
        together=tuple((pair.one, pair.other) for pair in split.together),
        run="" if split.weight is None else notation([split.weight]),
    )


def _applied(found: Diagnosis) -> tuple[EffectRecord, ...]:
    if found.best is None or found.best_estimate is None:
        return tuple(map(effect_record, found.applied))
    return tuple(stated_effects(found.applied, found.best, found.best_estimate))


def _unchecked(fit: Fit, found: Diagnosis) -> Estimate:
    return estimate(fit.likelihood, fit.point, level=found.interval_level, check=False)


def _trial(trial: Trial, found: Diagnosis) -> TrialRecord:
    """A trial with its sizes, taken from the extended fit if the verdict names this effect alone."""
    if found.best_estimate is not None and found.applied == (trial.candidate,):
        estimated = found.best_estimate
    else:
        estimated = _unchecked(trial.fit, found)
    own = range(trial.fit.likelihood.d - trial.n_unknown, trial.fit.likelihood.d)
    return TrialRecord(
        effect=trial.name,
        location=trial.location,
        deviance_drop=trial.deviance_drop,
        delta_bic=trial.delta_bic,
        p=trial.p,
        parameters=tuple(estimated_record(trial.fit, estimated, index) for index in own),
        words=trial.candidate.effect.in_words(),
    )


def _coefficients(found: Diagnosis) -> tuple[CoefficientRecord, ...]:
    n_baseline = len(found.baseline.problem.parameters)
    fit = found.best or found.baseline
    return tuple(
        CoefficientRecord(
            parameter.name,
            before=estimated_record(fit, found.baseline_estimate, index) if index < n_baseline else None,
            after=None if found.best_estimate is None else estimated_record(fit, found.best_estimate, index),
        )
        for index, parameter in enumerate(fit.problem.parameters.items)
        if not parameter.is_input
    )


def _lack_of_fit(found: Diagnosis) -> LackOfFitRecord:
    after = None
    if found.best is not None and found.best_quality is not None:
        after = _quality(found.best_quality, found.best)
    before = _quality(found.baseline_quality, found.baseline)
    return LackOfFitRecord(before=before, after=after, level=found.level / 2)


def _quality(quality: FitQuality, fit: Fit) -> FitQualityRecord:
    return FitQualityRecord(
        p=quality.p,
        p_by_statistic=quality.p_by_statistic,
        statistic=quality.worst_statistic,
        reduced_chi2=quality.reduced_chi2,
        band=quality.worst_band,
        channel=str(fit.measurement.channels[quality.worst_channel]),
        excess=quality.worst_excess,
        whirl=_whirl(quality, fit.measurement),
        deviance=float(fit.deviance),
    )


def _whirl(quality: FitQuality, measurement: Measurement) -> dict[str, tuple[float, float]]:
    """Mean squares of the residuals' forward and backward parts by plane, in units of the noise."""
    if measurement.is_amplitude:
        return {}
    found = {}
    for position, both in whirl_parts(quality.residuals, measurement.channels).items():
        forward, backward = np.mean(np.abs(both) ** 2, axis=1)
        found[f"{position:g}"] = (float(forward), float(backward))
    return found


def _noise(found: Diagnosis) -> NoiseRecord:
    measurement = found.baseline.measurement
    noise = measurement.noise
    return NoiseRecord(
        known=noise is not None,
        by_datum=noise is not None and np.ndim(noise.floor) > 0,
        before=noise_record(found.baseline_estimate.noise, measurement),
        after=None if found.best_estimate is None else noise_record(found.best_estimate.noise, measurement),
    )


def _detectable(location: str, detectable: Detectable) -> DetectableRecord:
    parameter = detectable.parameter
    return DetectableRecord(
        location=location,
        parameter=parameter.name,
        unit=parameter.unit,
        size=finite(detectable.size / parameter.si_per_unit),
        largest=detectable.largest / parameter.si_per_unit,
        observable=detectable.is_observable,
    )

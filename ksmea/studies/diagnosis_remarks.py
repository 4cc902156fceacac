"""Remarks and statements of a diagnosis.

They are on noise stated too small or too large, on the rate of a sweep, on names that a location contradicts, on data
that look misread, on slow roll, on a gain that is a unit, and on each effect.

A rate that a diagnosis finds is compared with the rate that rows give, which the fit does not use, or by its pull with the rate that times
give, which is known to a tolerance. A statement says where an effect acts and how much of it there is, at its fitted sizes
(`ksmea.records.statement`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import scipy

from ksmea.arrays import Array
from ksmea.diagnosis.diagnosis import Criteria, Diagnosis
from ksmea.diagnosis.trials import Candidate
from ksmea.fits.fitting import Fit
from ksmea.fits.lack_of_fit import fit_quality, is_size_alone, is_stated_too_large
from ksmea.inference.input_budget import critical_pull
from ksmea.inference.intervals import Estimate
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import ACCELERATION, SpeedHistory, rate_name
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.records.estimate import EstimateRecord
from ksmea.records.extension import EffectRecord
from ksmea.records.location import LocationRecord
from ksmea.records.statement import StatementRecord, of_unknowns
from ksmea.studies.enough_data import estimate_record
from ksmea.studies.misreadings import Misread, first_criticals, misread, slips, unit_of_gain
from ksmea.units import DEGREE, MICROMETRE, RPM

GAIN = "channel_gain"  # the effect whose size may be a unit
SLOW = 0.3  # of the first critical speed: below, a shaft follows its unbalance by less than 10 % of the eccentricity
FEWEST_SLOW = 3  # rows there that a slow-roll vector is read from
CHANCE = 0.0027  # beyond 3 σ, shared by all probes, of a vector that noise alone makes


def remarks_on(found: Diagnosis, measurement: Measurement) -> tuple[str, ...]:
    """Remarks on stated noise, on the rate of a sweep, and of the named effects."""
    noise, sweep = stated_noise_remarks(found, measurement), sweep_remarks(found, measurement)
    return (*noise, *sweep, *caveats(found))


def stated_noise_remarks(found: Diagnosis, measurement: Measurement) -> tuple[str, ...]:
    """A remark if stated noise is not accepted, or is larger than the scatter of the data allows."""
    stated, taken = measurement.noise, found.baseline.measurement.noise  # the noise that the diagnosis goes by
    if stated is None or taken is None:
        return ()
    factor = float(np.nanmax(taken.sd(np.abs(measurement.values)) / stated.sd(np.abs(measurement.values))))
    if factor > 1:
        return (
            (
                f"the data scatter {factor:.2f} times as much as their stated noise, evenly over speeds and channels: noise"
                f" is taken {factor:.2f} times as large; if it is not, something is wrong that looks like noise"
            ),
        )
    fit, quality = (found.baseline, found.baseline_quality)
    if found.best is not None and found.best_quality is not None:
        fit, quality = found.best, found.best_quality
    if is_stated_too_large(quality, fit.likelihood.n_residual - fit.likelihood.n_free, found.level / 2):
        return (
            (
                f"the data scatter {np.sqrt(quality.reduced_chi2):.2f} times as much as their stated noise: intervals are wider, and"
                " effects must be larger to be seen, than with noise as large as that"
            ),
        )
    return ()


def caveats(found: Diagnosis) -> tuple[str, ...]:
    """Remarks of the named effects."""
    machine, applied = found.baseline.problem.machine, found.applied if found.named else ()
    said = {each.name: each.effect.caveat(machine) for each in applied}
    return tuple(f"{name}: {caveat}" for name, caveat in said.items() if caveat)


def sweep_remarks(found: Diagnosis, measurement: Measurement) -> tuple[str, ...]:
    """Remarks on the rate of each run; none where no rate is known."""
    if measurement.campaign is None:
        return _rate_remarks(found, measurement.history, ACCELERATION)
    runs = measurement.campaign.runs
    return tuple(
        f"run {run.name}: {remark}" for run in runs for remark in _rate_remarks(found, run.history, rate_name(run.name))
    )


def _rate_remarks(found: Diagnosis, history: SpeedHistory | None, name: str) -> tuple[str, ...]:
    """Whether a fitted rate agrees with the rate from times or rows, and whether the rate was constant."""
    if history is None or history.rates is None or history.rate is None:
        return ()
    given = "the times give" if history.from_times else "the rows, if each is a turn of the shaft, give"
    said = []
    if not history.is_constant:
        first, second = (rate / RPM for rate in history.rates)
        said.append(
            f"{given} {first:.3g} rpm/s in the first half of the run and {second:.3g} rpm/s in the second: a sweep at a constant"
            " rate is an approximation"
        )
    if found.best is None or found.best_estimate is None or name not in found.best.problem.parameters.names:
        return tuple(said)
    index = found.best.problem.parameters.names.index(name)
    interval, rate = found.best_estimate.intervals[index], found.best_estimate.x[index]
    prior, spread = found.best.problem.parameters.items[index].prior, ""
    agree = interval.low <= history.rate <= interval.high
    if prior is not None:
        sd = (interval.high - interval.low) / (2 * scipy.stats.norm.isf((1 - found.interval_level) / 2))
        learnt = np.sqrt(max(prior.sd**2 - sd**2, 0.0))
        agree, spread = abs(rate - prior.value) <= critical_pull(1) * learnt, f" ± {prior.sd / RPM:.2g}"
    verdict = "they agree" if agree else "they disagree, as if the model lacks something in addition to the sweep"
    fitted = f"{rate / RPM:.3g} [{interval.low / RPM:.3g}, {interval.high / RPM:.3g}]"
    fit = "the fit" if prior is None else "the fit with these times"
    return (*said, f"{given} {history.rate / RPM:.3g}{spread} rpm/s, {fit} {fitted} rpm/s: {verdict}")


def disagreements(found: Diagnosis, where: LocationRecord) -> tuple[str, ...]:
    """Remark for each named effect at a place, if something unknown is located only elsewhere."""
    if not found.named or not where.is_local:
        return ()
    said = []
    for candidate in found.applied:
        places = candidate.effect.places(found.baseline.problem.machine)
        if places and not any(where.accepts(place) for place in places):
            at = ", ".join(f"{site.kind} at {site.position:g} m" for site in where.sites)
            said.append(
                f"{candidate.name} is named, which acts at {', '.join(f'{place:g} m' for place in places)}, but without the"
                f" library something unknown is found elsewhere: {at}; doubt the name, or a second cause is hidden"
            )
    return tuple(said)


def reading_of(fit: Fit, case: Case, rng: np.random.Generator, criteria: Criteria) -> Misread | None:
    """Readings of the data that fit decisively better than the baseline model's fit to the data as read."""
    quality = fit_quality(fit, rng.spawn(1)[0])
    rejected = quality.p < criteria.half and not is_size_alone(quality, criteria.half)
    return misread(case, own_values(fit, case.problem), fit.noise, rejected=rejected)


def slips_of(found: Diagnosis, problem: Problem, reading: Misread | None) -> tuple[str, ...]:
    """Remarks on data that look misread, which they do not where an effect explains them."""
    fit, quality = found.baseline, found.baseline_quality
    if found.named and found.best is not None and found.best_quality is not None:
        fit, quality = found.best, found.best_quality
    case, rejected = found.baseline.case.by(problem), quality.p < found.level / 2
    x = own_values(fit, problem)
    if reading is not None and rejected:
        return (str(reading),)
    return slips(case, x)


def own_values(fit: Fit, problem: Problem) -> Array:
    """Values (d,) SI of a problem's own unknowns in a fit that may have further ones."""
    return fit.x[[fit.problem.parameters.names.index(name) for name in problem.parameters.names]]


def stated_effects(applied: Sequence[Candidate], fit: Fit, estimated: Estimate) -> Iterator[EffectRecord]:
    """Each effect of a fit, whose unknowns are the last ones, with what is said of it."""
    counts = [len(each.effect.parameters(fit.problem.machine)) for each in applied]
    first = fit.likelihood.d - sum(counts)
    for candidate, count in zip(applied, counts):
        yield effect_record(candidate, _statement(candidate, fit, estimated, range(first, first + count)))
        first += count


def effect_record(candidate: Candidate, statement: StatementRecord | None = None) -> EffectRecord:
    effect: Any = candidate.effect  # effects are frozen dataclasses of settings
    return EffectRecord(candidate.name, str(effect), dataclasses.asdict(effect), statement)


def _statement(candidate: Candidate, fit: Fit, estimated: Estimate, own: range) -> StatementRecord:
    estimates = {each.name: each for each in (estimated_record(fit, estimated, index) for index in own)}
    sizes = of_unknowns(estimates, _correlation(estimated.point.whitened, own))
    return candidate.effect.statement_on(fit.problem.machine, sizes)


def estimated_record(fit: Fit, estimated: Estimate, index: int) -> EstimateRecord:
    return estimate_record(fit.problem.parameters.items[index], float(estimated.x[index]), estimated.intervals[index])


def _correlation(whitened: Array, own: range) -> Array:
    """Correlation (e, e) of the errors of unknowns, from sensitivities (m, p) of all."""
    covariance = np.linalg.pinv(whitened.T @ whitened)[np.ix_(own, own)]
    sd = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    return np.asarray(np.clip(covariance / np.outer(sd, sd), -1.0, 1.0))


def reading_remarks(found: Diagnosis) -> tuple[str, ...]:
    """Remarks on what probes read otherwise than the accepted model has it."""
    return (*_gain_remarks(found), *_slow_roll_remarks(found))


def _slow_roll_remarks(found: Diagnosis) -> tuple[str, ...]:
    """Mean vector of each probe at low speed that the accepted model does not predict.

    It is given if it exceeds the noise; empty for amplitudes, and without rows below SLOW times the first critical
    speed.
    """
    accepted = found.named and found.best is not None
    fit = found.best if accepted and found.best is not None else found.baseline
    measurement, plain = fit.measurement, found.baseline
    criticals = first_criticals(plain.problem, plain.x, float(np.max(measurement.speed)))
    if measurement.is_amplitude or measurement.is_by_differences or criticals is None or not len(criticals):
        return ()
    slow = measurement.speed < SLOW * criticals[0]
    if np.count_nonzero(slow) < FEWEST_SLOW:
        return ()
    response = fit.response()
    weight = fit.noise.sd(np.abs(response))[slow] ** -2  # (n_slow, n_channel), m⁻²
    mean = np.sum(weight * (measurement.values - response)[slow], axis=0) / np.sum(weight, axis=0)
    deviations = np.abs(mean) * np.sqrt(2 * np.sum(weight, axis=0))  # noise is that of both parts together
    exceeds = np.sqrt(2 * np.log(len(measurement.channels) / CHANCE))  # of a Rayleigh distribution
    rows = f"mean of {np.count_nonzero(slow)} rows up to {np.max(measurement.speed[slow]) / RPM:.0f} rpm"
    return tuple(
        f"slow roll of probe {channel}: {abs(vector) / MICROMETRE:.2g} µm at {np.angle(vector) / DEGREE:.0f}° that the model does not"
        f" predict ({rows}, {size:.0f} σ); subtract it, or diagnose with runout and bow among the effects"
        for channel, vector, size in zip(measurement.channels, mean, deviations)
        if channel.is_1x and size > exceeds
    )


def _gain_remarks(found: Diagnosis) -> tuple[str, ...]:
    """The unit that a gain of the accepted model is the factor of."""
    if not found.named or found.best is None:
        return ()
    values = dict(zip(found.best.problem.parameters.names, found.best.x, strict=True))
    said = []
    for candidate in found.applied:
        sizes = [size for name, size in values.items() if candidate.name == GAIN and name.startswith(GAIN)]
        said += [
            f"a gain of {1 + size:.3g} ({candidate.effect}) is that of another unit: {unit}; check its scale, or the plane that it"
            " is compared with"
            for size in sizes
            if (unit := unit_of_gain(1 + size))
        ]
    return tuple(said)

"""Remarks and statements of a diagnosis: on noise stated too small or too large, on the rate of a sweep, and on each effect.

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
from ksmea.diagnosis.diagnosis import Diagnosis
from ksmea.diagnosis.trials import Candidate
from ksmea.fits.fitting import Fit
from ksmea.fits.lack_of_fit import is_stated_too_large
from ksmea.inference.input_budget import critical_pull
from ksmea.inference.intervals import Estimate
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import ACCELERATION, SpeedHistory, rate_name
from ksmea.records.estimate import EstimateRecord
from ksmea.records.extension import EffectRecord
from ksmea.records.statement import StatementRecord, of_unknowns
from ksmea.studies.enough_data import estimate_record
from ksmea.units import RPM


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


def sweep_remarks(found: Diagnosis, measurement: Measurement) -> tuple[str, ...]:
    """Remarks on the rate of each run; none where no rate is known."""
    if measurement.campaign is None:
        return _rate_remarks(found, measurement.history, ACCELERATION)
    runs = measurement.campaign.runs
    return tuple(
        f"run {run.name}: {remark}" for run in runs for remark in _rate_remarks(found, run.history, rate_name(run.name))
    )


def _rate_remarks(found: Diagnosis, history: SpeedHistory | None, name: str) -> tuple[str, ...]:
    """Whether a fitted rate and that of times or rows agree, and whether the speed went at a constant one."""
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
    verdict = "they agree" if agree else "they disagree, as where the model lacks something besides the sweep"
    fitted = f"{rate / RPM:.3g} [{interval.low / RPM:.3g}, {interval.high / RPM:.3g}]"
    fit = "the fit" if prior is None else "the fit with these times"
    return (*said, f"{given} {history.rate / RPM:.3g}{spread} rpm/s, {fit} {fitted} rpm/s: {verdict}")


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
    return candidate.effect.statement(of_unknowns(estimates, _correlation(estimated.point.whitened, own)))


def estimated_record(fit: Fit, estimated: Estimate, index: int) -> EstimateRecord:
    return estimate_record(
        fit.problem.parameters.items[index], float(estimated.x[index]), estimated.intervals[index]
    )


def _correlation(whitened: Array, own: range) -> Array:
    """Correlation (e, e) of the errors of unknowns, from sensitivities (m, p) of all."""
    covariance = np.linalg.pinv(whitened.T @ whitened)[np.ix_(own, own)]
    sd = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    return np.asarray(np.clip(covariance / np.outer(sd, sd), -1.0, 1.0))

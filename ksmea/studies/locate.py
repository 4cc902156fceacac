"""Location of what a model lacks as a record.

It has the sites at which an unknown force explains a measurement, and its action.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ksmea.arrays import Array
from ksmea.diagnosis.predictive_gain import predictive_gain
from ksmea.diagnosis.trials import Candidate, trial_of
from ksmea.errors import SettingError, unknown
from ksmea.fits.fitting import Fit, fit_from_values
from ksmea.location.force_law import LawFit, fitted_laws, located_fit, smooth_fits
from ksmea.location.location import Location, locate
from ksmea.location.recovered_force import RecoveredForce, recovered_force, site_intervals
from ksmea.location.unknown_force import QUANTITIES, READING, SiteFit, inputs_held
from ksmea.nonlinear.smooth_law import SmoothForce
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.case import Case
from ksmea.problem.load import FORCE, LOADS, MOMENT
from ksmea.records.estimate import EstimateRecord
from ksmea.records.extension import EffectRecord, ExtensionRecord, PredictiveGainRecord
from ksmea.records.location import (
    LATERAL,
    NONE,
    NOTHING,
    CoefficientsRecord,
    ForceRecord,
    LawCoefficientRecord,
    LawRecord,
    LocationRecord,
    PartRecord,
    PlainRecord,
    SeriesRecord,
    SiteRecord,
    StiffnessRecord,
)
from ksmea.records.record import series
from ksmea.settings.settings import Settings, setting
from ksmea.studies.enough_data import estimate_record, noise_record
from ksmea.studies.remarks import refuse_differences

LOCAL_FORCE = "local_force"  # the effect that a law at a place is


@dataclass(frozen=True)
class LocationOptions(Settings):
    """Candidate effects and positions of a location, and the level of its rejections."""

    level: float = setting(
        0.01, "chance of rejecting the true site; 2000 simulations resolve no smaller one", at_least=0.002, at_most=0.5
    )
    interval_level: float = setting(0.95, "confidence level of intervals", above=0, at_most=0.9999)
    positions: list[float] = setting([], "sites that are tried; an empty list: every node of the mesh", unit="m")
    kinds: list[str] = setting(
        [FORCE, MOMENT, READING],
        f"what may act: {FORCE}, {MOMENT}, {READING} (of the probes at a plane), {LATERAL} (also tried where neither alone"
        " is accepted, beside forces at two positions)",
    )
    blocks: int = setting(
        6, "contiguous blocks of speeds that are left out in turn; fewer than 5 cannot support a law", at_least=2
    )
    starts: int = setting(4, "starts of the fit at each site, before sites share the best unknowns", at_least=1)

    def check(self) -> None:
        for quantity in self.kinds:
            if quantity not in QUANTITIES:
                raise unknown("kind", quantity, QUANTITIES)


def location(
    case: Case,
    rng: np.random.Generator,
    *,
    options: LocationOptions | None = None,
    baseline: Fit | None = None,
    with_laws: bool = True,
    workers: Workers = ALONE,
    found: Location | None = None,
) -> LocationRecord:
    """Sites at which an unknown force, moment or reading explains a measurement.

    `baseline` is the fit of the model without any of these, if it is known already: the model with a law that holds is compared
    with it. With `with_laws`, laws that the force may follow are sought. Workers share the sites. `found` is the
    location if it has been sought before (`located`).

    Raises `SettingError` if there are too few data to decide.
    """
    refuse_differences(case.measurement, "locate")
    options = options or LocationOptions()
    if case.at_1x() is not case:
        baseline = None  # it is a fit to other data
    found = found or located(case, rng, options, workers)
    return location_record(found, rng, options, baseline, with_laws, workers)


def located(case: Case, rng: np.random.Generator, options: LocationOptions, workers: Workers = ALONE) -> Location:
    """The sites, each fitted and tested."""
    return locate(
        case.by(case.problem.joint).at_1x(),
        rng,
        positions=options.positions,
        quantities=options.kinds,
        level=options.level,
        n_start=options.starts,
        workers=workers,
    )


@dataclass(frozen=True, eq=False)
class Located:
    """Locations by measurement, each sought when it is first requested."""

    rng: np.random.Generator
    options: LocationOptions
    workers: Workers = ALONE
    found: dict[int, tuple[Case, Location]] = field(default_factory=dict)  # by its measurement

    def __call__(self, case: Case) -> Location:
        key = id(case.measurement)
        if key not in self.found:
            self.found[key] = case, located(case, self.rng, self.options, self.workers)
        return self.found[key][1]


def location_record(
    found: Location,
    rng: np.random.Generator,
    options: LocationOptions,
    baseline: Fit | None = None,
    with_laws: bool = True,
    workers: Workers = ALONE,
) -> LocationRecord:
    """A location as plain data; values of unknowns in their units.

    The best site is the site of the best law if a law is not rejected, else the one with the smallest residuals.
    """
    interval_level = options.interval_level
    problem, measurement = found.plain.likelihood.problem, found.plain.likelihood.measurement
    believed = [] if found.is_plain_enough else [found.sites[index] for index in found.accepted]
    laws = _laws(believed, found, workers.progress) if with_laws else []
    law = next((fit for fit in laws if fit.p >= found.level), None)
    best = None if law is None else law.site.unmodelled
    believed = sorted(believed, key=lambda fit: fit.unmodelled != best)  # those of no law stay in their order
    extension, gain = (None, None) if law is None else _extended(law, found.plain, baseline, options.blocks)
    along = [*problem.sites, *problem.landmarks.values(), *(channel.position for channel in measurement.channels)]
    return LocationRecord(
        kind=NOTHING if found.is_plain_enough else (believed[0].unmodelled.quantity or NONE) if believed else NONE,
        candidates=tuple(_site(found, index) for index in found.ranked),
        plain=PlainRecord(found.plain_quality.p, found.plain.point.deviance, found.plain.point.n_left),
        noise=noise_record(found.noise, measurement),
        noise_known=measurement.noise is not None,
        coefficients=_coefficients(found.plain, believed, interval_level, workers),
        force=_force(believed[0], recovered_force(believed[0], rng), interval_level) if believed else None,
        speed=tuple(measurement.speed.tolist()),
        shaft=(float(min(along)), float(max(along))),
        landmarks=dict(problem.landmarks),
        planes=tuple(dict.fromkeys(channel.position for channel in measurement.channels)),
        level=found.level,
        interval_level=interval_level,
        laws=tuple(_law(fit, found.level) for fit in laws),
        n_channel=len(measurement.channels),
        breaks=measurement.breaks,
        remarks=problem.remarks_at(measurement.speed),
        notation=measurement.notation,
        extension=extension,
        predictive_gain=gain,
    )


def _site(found: Location, index: int) -> SiteRecord:
    fit, quality = found.sites[index], found.qualities[index]
    return SiteRecord(
        kind=str(fit.unmodelled.quantity),
        position=fit.unmodelled.position,
        p=quality.p,
        p_by_statistic=quality.p_by_statistic,
        chi2=fit.point.deviance,
        n_left=fit.point.n_left,
        accepted=quality.p >= found.level,
        second=fit.unmodelled.second,
    )


def _coefficients(
    plain: SiteFit, believed: Sequence[SiteFit], level: float, workers: Workers
) -> tuple[CoefficientsRecord, ...]:
    """Every unknown by the plain model and with the unknown quantity at the accepted sites.

    The best site is first.
    """
    of_plain, *of_sites = workers.unseen.each(partial(_estimates, level=level), (plain, *believed))
    return tuple(
        CoefficientsRecord(
            name=own.name,
            plain=own,
            best=of_sites[0][index] if of_sites else None,
            over_sites=_over_sites([estimates[index] for estimates in of_sites]) if of_sites else None,
        )
        for index, own in enumerate(of_plain)
    )


def _over_sites(estimates: Sequence[EstimateRecord]) -> EstimateRecord:
    """The best site's estimate with an interval that contains the intervals of all sites."""
    low = [each.low for each in estimates if each.low is not None]
    high = [each.high for each in estimates if each.high is not None]
    return dataclasses.replace(
        estimates[0],
        low=min(low) if len(low) == len(estimates) else None,
        high=max(high) if len(high) == len(estimates) else None,
        interval="over sites",
    )


def _estimates(fit: SiteFit, level: float) -> list[EstimateRecord]:
    parameters = fit.likelihood.problem.parameters
    values, intervals = parameters.to_si(fit.point.theta), site_intervals(fit, level)
    return [
        estimate_record(parameters.items[index], float(values[index]), intervals[index]) for index in parameters.own
    ]


def _force(fit: SiteFit, recovered: RecoveredForce, level: float) -> ForceRecord:
    stiffness, coherence = recovered.dynamic_stiffness, recovered.coherence
    return ForceRecord(
        kind=str(fit.unmodelled.quantity),
        position=fit.unmodelled.position,
        parts=tuple(
            PartRecord(
                part,
                unit,
                real=_series(values.real, level),
                imaginary=_series(values.imag, level),
                amplitude=_series(np.abs(values), level),
            )
            for (part, unit), values in zip(recovered.names, np.moveaxis(recovered.parts, 2, 0))
        ),
        work=None if recovered.work is None else _series(recovered.work, level),
        stiffness=()
        if stiffness is None or coherence is None
        else tuple(
            StiffnessRecord(part, float(follows), _series(values.real, level), _series(values.imag, level))
            for (part, _), follows, values in zip(recovered.names, coherence, np.moveaxis(stiffness, 2, 0))
        ),
        second=fit.unmodelled.second,
    )


def _laws(believed: Sequence[SiteFit], found: Location, progress: Callable[[], None]) -> list[LawFit]:
    """Laws at the accepted sites, the lowest BIC first.

    Then a smooth function of speed if all laws are rejected.
    """
    sites = [inputs_held(fit) for fit in believed if fit.unmodelled.quantity in LOADS]
    simple = fitted_laws(sites, found.noise, progress)
    return simple if any(fit.p >= found.level for fit in simple) else [*simple, *smooth_fits(sites, found.noise)]


def _law(fit: LawFit, level: float) -> LawRecord:
    return LawRecord(
        law=fit.law.name,
        key=fit.law.key,
        kind=str(fit.site.unmodelled.quantity),
        position=fit.site.unmodelled.position,
        p=fit.p,
        bic=fit.bic,
        accepted=fit.p >= level,
        coefficients=tuple(
            LawCoefficientRecord(name, unit, value=float(value / size), sd=float(sd / size))
            for (name, unit, size), value, sd in zip(fit.law.coefficients, fit.values, fit.sd)
        ),
        amplitude=tuple(series(each) for each in np.abs(fit.force).T),
        amplitude_sd=_amplitude_sd(fit),
    )


def _amplitude_sd(fit: LawFit) -> tuple[tuple[float, ...], ...]:
    """Standard deviations of the amplitude for a law of speed; empty for a law of the motion."""
    if fit.law.follows_motion:
        return ()
    _, sd = fit.amplitude(fit.site.likelihood.problem.speed)
    return tuple(series(each) for each in sd.T)


def _extended(
    law: LawFit, plain: SiteFit, baseline: Fit | None, n_block: int
) -> tuple[ExtensionRecord | None, PredictiveGainRecord | None]:
    """The model with a law as part of it, and its predictive gain over the baseline model.

    None if the problem does not take the law (not a rotor of this project, or one with a force of this law already), or has no
    steady-state response with it.
    """
    settings: dict[str, Any] = {"position": law.site.unmodelled.position, "law": law.law.key}
    if isinstance(law.law, SmoothForce):
        settings["knots"] = law.law.knots.tolist()
    problem = plain.likelihood.problem
    if baseline is None:
        baseline = fit_from_values(plain.likelihood.case, problem.parameters.to_si(plain.point.theta))
    extension = None
    with suppress(SettingError, np.linalg.LinAlgError):
        effect: AnyEffect = registry.create("effect", LOCAL_FORCE, settings)
        fit = located_fit(effect.added_to(problem), law, plain, baseline)
        better = trial_of(Candidate(LOCAL_FORCE, effect), fit, baseline, 1).delta_bic
        extension = _extension(EffectRecord(LOCAL_FORCE, str(effect), settings), fit, better)
        gain = predictive_gain(baseline, fit, n_block)
        return extension, PredictiveGainRecord.of(gain.elpd, gain.rmse_before, gain.rmse_after)
    return extension, None


def _extension(effect: EffectRecord, fit: Fit, delta_bic: float) -> ExtensionRecord:
    parameters = fit.problem.parameters.items
    values = {item.name: float(item.turned(x) / item.si_per_unit) for item, x in zip(parameters, fit.x)}
    return ExtensionRecord(effect, values, {item.name: item.unit for item in parameters}, delta_bic)


def _series(draws: Array, level: float) -> SeriesRecord:
    """A quantity (1 + n_draw, n_speed), the estimate first, to five digits."""
    low, high = np.quantile(draws[1:], [(1 - level) / 2, (1 + level) / 2], axis=0)
    return SeriesRecord(*map(series, (draws[0], low, high)))

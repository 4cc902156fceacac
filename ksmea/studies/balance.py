"""The study `balance`: a campaign of runs with known and unknown weights → a record.

No model of the rotor is requested.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import ComplexArray, Indices
from ksmea.balancing.amplitudes import AmplitudeFit, fitted_amplitudes
from ksmea.balancing.correction import Correction, correction
from ksmea.balancing.estimation import WeightEstimate, estimated, polar_interval, scaled_by_unknown_runs
from ksmea.balancing.fit import AUTO, COMMON, FREE, NO, YES, Asked, Fit
from ksmea.balancing.holes import split
from ksmea.balancing.leave_out import conformal_radius2, folded, squared_errors
from ksmea.balancing.misfits import (
    EntryMisfit,
    fitted_without_misfits,
    misfits_beside_channels,
    misfits_beside_speeds,
    run_p,
)
from ksmea.balancing.readings import Readings, readings
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Measurement
from ksmea.records.balancing import (
    BalanceRecord,
    CorrectionRecord,
    DriftRecord,
    EntryMisfitRecord,
    EntryRecord,
    HoleRecord,
    LeftOutRecord,
    PlaneRecord,
    PolarRecord,
    RunMisfitRecord,
    SplitRecord,
    SpreadRecord,
    WeightRecord,
)
from ksmea.records.record import finite, series
from ksmea.settings.settings import Settings, setting
from ksmea.units import DEGREE, MICROMETRE

CHOICES = (AUTO, YES, NO)
EstimatesByOthers = dict[int, tuple[Fit, WeightEstimate]]  # of runs by their index, by all others


@dataclass(frozen=True)
class BalanceOptions(Settings):
    """Terms of the model of the responses, and options of the report."""

    drift: str = setting(AUTO, "a drift of the responses over time_s; auto: where BIC has it", choices=CHOICES)
    slope: str = setting(
        AUTO, "the response changes with the deviation of a run's speed; auto: where p < 0.01", choices=CHOICES
    )
    growth: str = setting(
        AUTO, "influence coefficients change with the size of weights; auto: where p < 0.01", choices=CHOICES
    )
    leave_out: bool = setting(False, "the weights of each run from all others, as a table")
    folds: int = setting(
        10, "parts of the runs without which variance components are estimated for leave_out", at_least=2
    )
    misfits: bool = setting(True, "runs that do not fit are left out of the fit")
    level: float = setting(
        0.01, "chance of calling a run or an entry a misfit where none is, over all tests", above=0, at_most=0.5
    )
    interval_level: float = setting(0.95, "confidence level of intervals and regions", above=0, at_most=0.9999)
    speed_tolerance: float = setting(
        0.01, "neighbouring speeds that are nearer than this, relative, are one nominal speed", at_least=0, at_most=0.2
    )

    @property
    def asked(self) -> Asked:
        return Asked(self.drift, self.slope, self.growth)


def balance(
    measurement: Measurement,
    rng: np.random.Generator,
    *,
    options: BalanceOptions | None = None,
    progress: Callable[[], None] = lambda: None,
) -> BalanceRecord:
    """Influence coefficients, unknown weights and corrections of a campaign.

    `progress` is called at each step.

    Amplitudes alone do in one plane. Raises `SettingError` for data without weights, and runs that do not tell the planes apart.
    """
    options = options or BalanceOptions()
    kept = [index for index, channel in enumerate(measurement.channels) if channel.is_1x]
    data = readings(measurement.through(kept), options.speed_tolerance)
    level = options.level if options.misfits else 0.0
    fit: Fit
    out: dict[int, float] = {}
    if measurement.is_amplitude:
        fit = fitted_amplitudes(data)
    else:
        fit, out = fitted_without_misfits(data, data.is_known, level, options.asked)
        fit = scaled_by_unknown_runs(fit)
    progress()
    if options.leave_out and not fit.is_free:
        raise SettingError(
            f"study.leave_out: expected more runs with known weights, of which a covariance can be estimated, got"
            f" {len(data.is_known)}; leave it out"
        )
    has_unknown = len(data.is_known) < len(data.names)
    by_others = (
        folded(fit, data.is_known, options.folds, progress)
        if fit.is_free and (options.leave_out or has_unknown)
        else {}
    )
    left_out = _left_out(by_others, fit, options.interval_level) if options.leave_out else None
    found = _record(fit, out, correction(fit, rng), by_others, left_out, options)
    return dataclasses.replace(found, notation=measurement.notation)


def _record(
    fit: Fit,
    out: dict[int, float],
    corrected: Correction,
    by_others: EstimatesByOthers,
    left_out: LeftOutRecord | None,
    options: BalanceOptions,
) -> BalanceRecord:
    data = fit.readings
    level = options.interval_level
    radius2 = conformal_radius2(squared_errors(by_others), level) if by_others else _radius2(fit, level)
    every = np.arange(len(data.names))
    order = every if data.time is None else np.argsort(data.time, kind="stable")
    p = np.full(len(every), np.nan)
    if fit.is_free:
        p[data.is_known] = run_p(fit, data.is_known)
    entries = _entries(data)
    by_speeds = [] if isinstance(fit, AmplitudeFit) else misfits_beside_speeds(data, options.level)
    misfits = [("other speeds", each) for each in by_speeds]
    misfits += [("other speeds and channels", each) for each in misfits_beside_channels(fit, options.level)]
    unknown = [int(run) for run in np.setdiff1d(every, data.is_known)]
    return BalanceRecord(
        entries=entries,
        bare=_coefficients(fit, 0, MICROMETRE, options.interval_level),
        planes=tuple(
            PlaneRecord(
                plane.position,
                _coefficients(fit, 1 + index, MICROMETRE / plane.unit.si, options.interval_level),
                str(plane.unit),
            )
            for index, plane in enumerate(data.details)
        ),
        n_run=len(every),
        n_used=len(fit.used),
        method=fit.method,
        dof=finite(fit.dof),
        interval_level=options.interval_level,
        level=options.level,
        weights=tuple(
            each for run in unknown for each in _weights(fit, run, np.flatnonzero(np.isnan(data.weights[run])), radius2)
        ),
        correction=_correction(data, corrected, fit, options.interval_level),
        spread=_spread(fit),
        run_misfits=tuple(
            RunMisfitRecord(data.names[run], value, _weights(fit, run, np.arange(len(data.planes)), radius2))
            for run, value in sorted(out.items(), key=lambda item: item[1])
        ),
        entry_misfits=tuple(_entry_misfit(data, entries, beside, each) for beside, each in misfits),
        slope=tuple(fit.influence.slope.real.tolist()) if fit.terms.slope else (),
        growth=fit.influence.growth.real if fit.terms.growth else None,
        growth_scale=fit.influence.scale / data.units[0].si,
        spread_growth=fit.components.growth,
        time_constant=None if fit.components.drift is None else fit.components.time_constant,
        deviance_of_drift=fit.deviance_of_drift,
        runs=tuple(data.names[run] for run in order),
        run_time=tuple((every if data.time is None else data.time[order] - data.time.min()).tolist()),
        run_p=tuple(1.0 if np.isnan(value) else float(value) for value in p[order]),
        drift=_drift(fit, order, entries),
        left_out=left_out,
        remarks=data.remarks,
        unit=str(data.units[0]),
        is_amplitude=isinstance(fit, AmplitudeFit),
    )


def _entries(data: Readings) -> tuple[EntryRecord, ...]:
    return tuple(EntryRecord(float(speed), str(channel)) for speed in data.speed for channel in data.channels)


def _polar(value: complex, variance: float, radius2: float, unit: float) -> PolarRecord:
    """A complex number with the sizes and angles within its region; no intervals where that has no end."""
    if not np.isfinite(radius2):
        return _plain_polar(value, unit)
    size, angle = polar_interval(value, float(np.sqrt(radius2 * variance)))
    ends = (None, None) if angle is None else (angle[0] / DEGREE, angle[1] / DEGREE)
    return PolarRecord(abs(value) / unit, float(np.angle(value)) / DEGREE, size[0] / unit, size[1] / unit, *ends)


def _plain_polar(value: complex, unit: float) -> PolarRecord:
    return PolarRecord(float(abs(value)) / unit, float(np.angle(value)) / DEGREE)


def _radius2(fit: Fit, level: float) -> float:
    """Squared radius of the region of a complex number, in units of its variance."""
    if fit.dof == 0:
        return float("inf")
    return float(scipy.stats.f.ppf(level, 2, 2 * fit.dof)) if np.isfinite(fit.dof) else float(-np.log1p(-level))


def _coefficients(fit: Fit, row: int, unit: float, level: float) -> tuple[PolarRecord, ...]:
    """The bare response (row 0) or the influence coefficients of a plane, entry by entry."""
    values, n = fit.influence.coefficients[row], fit.influence.coefficients.shape[1]
    variance = np.diag(fit.coefficient_covariance).real[row * n : (row + 1) * n]
    return tuple(
        _polar(complex(value), float(each), _radius2(fit, level), unit) for value, each in zip(values, variance)
    )


def _weights(fit: Fit, run: int, planes: Indices, radius2: float) -> tuple[WeightRecord, ...]:
    return tuple(_weight_records(fit, run, estimated(fit, run, planes), radius2))


def _weight_records(fit: Fit, run: int, found: WeightEstimate, radius2: float) -> list[WeightRecord]:
    data = fit.readings
    records = []
    for index, plane in enumerate(found.planes):
        unit = data.units[plane]
        value, variance = complex(found.weights[index]), float(found.covariance[index, index].real)
        known = complex(data.weights[run, plane])
        is_known = bool(np.isfinite(known))
        inside = abs(value - known) ** 2 <= radius2 * variance if is_known else None
        records.append(
            WeightRecord(
                data.names[run],
                float(data.planes[plane]),
                _polar(value, variance, radius2, unit.si),
                found.p,
                _plain_polar(known, unit.si) if is_known else None,
                inside,
                str(unit),
            )
        )
    return records


def _correction(data: Readings, found: Correction, fit: Fit, level: float) -> CorrectionRecord:
    variance = np.zeros(len(data.planes)) if found.variance is None else found.variance
    ends = np.quantile(found.left_draws, [(1 - level) / 2, (1 + level) / 2], axis=0) if len(found.left_draws) else None
    left = []
    for index, value in enumerate(found.left):
        plain = _plain_polar(complex(value), MICROMETRE)
        low, high = (None, None) if ends is None else (ends[:, index] / MICROMETRE).tolist()
        left.append(PolarRecord(plain.size, plain.angle, low, high))
    return CorrectionRecord(
        tuple(data.planes.tolist()),
        tuple(
            _polar(complex(w), float(v), _radius2(fit, level), unit.si)
            for w, v, unit in zip(found.weights, variance, data.units)
        ),
        tuple(_plain_polar(complex(value), MICROMETRE) for value in fit.influence.bare),
        tuple(left),
        found.p,
        tuple(map(str, data.units)),
        finite(found.condition),
        *_common(fit, found),
        *_in_holes(fit, found.weights),
    )


def _common(fit: Fit, found: Correction) -> tuple[tuple[PolarRecord, ...], tuple[PolarRecord, ...]]:
    """The weights without what readings hardly show, and what each entry is with them.

    Nothing where they show all.
    """
    if found.common is None:
        return (), ()
    weights = tuple(_plain_polar(complex(w), unit.si) for w, unit in zip(found.common, fit.readings.units))
    return weights, _response_with(fit, found.common)


def _in_holes(fit: Fit, weights: ComplexArray) -> tuple[tuple[SplitRecord, ...], tuple[PolarRecord, ...]]:
    """Correction weights (n_plane,) kg m split onto the holes of planes, and the resulting entries.

    Only some planes have holes.
    """
    splits, put_on = [], weights.copy()
    for index, plane in enumerate(fit.readings.details):
        if plane.holes is None:
            continue
        found, unit = split(complex(weights[index]), plane.holes), plane.unit
        put_on[index] -= found.left
        splits.append(
            SplitRecord(
                plane.position,
                tuple(
                    HoleRecord(hole, plane.holes.angles[hole - 1] / DEGREE, size / unit.si, str(unit))
                    for hole, size in zip(found.holes, found.sizes)
                ),
                _plain_polar(found.left, unit.si),
                str(unit),
            )
        )
    return tuple(splits), _response_with(fit, put_on) if splits else ()


def _response_with(fit: Fit, weights: ComplexArray) -> tuple[PolarRecord, ...]:
    influence = fit.influence
    response = influence.bare + influence.effective(weights) @ influence.planes
    return tuple(_plain_polar(complex(value), MICROMETRE) for value in response)


def _spread(fit: Fit) -> tuple[SpreadRecord, ...]:
    """Standard deviations entry by entry, and p of equal spread between runs and repeats (F test)."""
    data, components = fit.readings, fit.components
    repeats, drift = data.repeat_variance, components.drift
    found = []
    for index, entry in enumerate(_entries(data)):
        spread = float(components.spread[index, index].real) if fit.method in (FREE, COMMON) else None
        drifting = None if drift is None else float(drift[index, index].real)
        repeat = None if repeats is None else float(repeats[index])
        p = None
        if spread is not None and repeat and fit.dof:
            between = spread + (drifting or 0.0)
            p = float(scipy.stats.f.sf(between / repeat, 2 * fit.dof, 2 * data.repeat_dof))
        found.append(SpreadRecord(entry, _sd(spread), _sd(drifting), _sd(repeat), p))
    return tuple(found)


def _sd(variance: float | None) -> float | None:
    return None if variance is None else float(np.sqrt(variance)) / MICROMETRE


def _drift(fit: Fit, order: Indices, entries: Sequence[EntryRecord]) -> tuple[DriftRecord, ...]:
    """The drift at the time of every run, from the runs used."""
    drift, time = fit.components.drift, fit.readings.time
    if drift is None or time is None:
        return ()
    across = np.kron(fit.components.correlation(time[order], time[fit.used]), drift)
    found: ComplexArray = (across @ fit.solution.white).reshape(len(order), -1) / MICROMETRE
    return tuple(
        DriftRecord(entry, series(found[:, index].real), series(found[:, index].imag))
        for index, entry in enumerate(entries)
    )


def _entry_misfit(data: Readings, entries: Sequence[EntryRecord], beside: str, found: EntryMisfit) -> EntryMisfitRecord:
    return EntryMisfitRecord(
        data.names[found.run],
        entries[found.entry],
        beside,
        found.p,
        found.n_test,
        _plain_polar(found.measured, MICROMETRE),
        _plain_polar(found.expected, MICROMETRE),
    )


def _left_out(found: EstimatesByOthers, fit: Fit, level: float) -> LeftOutRecord:
    """Table of weights from all other runs, and its figures of merit.

    The width of each region is calibrated on the other runs."""
    squared, runs = squared_errors(found), list(found)
    radius2 = [conformal_radius2(np.delete(squared, index, axis=0), level) for index in range(len(runs))]
    records = [
        each
        for (run, (own, estimate)), radius in zip(found.items(), radius2)
        for each in _weight_records(own, run, estimate, radius)
    ]
    unit = fit.readings.units[0]
    known = fit.readings.weights[runs] / unit.si
    estimates = np.array([estimate.weights for _, estimate in found.values()]) / unit.si
    error = np.abs(estimates) - np.abs(known)
    least = float(np.median(np.abs(known[np.abs(known) > 0])))
    is_large = np.abs(known) > least * (1 - 1e-6)
    angle = np.abs(np.angle(estimates[is_large] / known[is_large])) / DEGREE
    return LeftOutRecord(
        tuple(records),
        float(np.sqrt(np.mean(error**2))),
        float(np.mean(np.abs(error))),
        float(np.mean(angle)) if angle.size else None,
        least,
        float(np.mean([bool(each.is_inside) for each in records])),
        str(unit),
    )

"""Balancing results of a campaign.

Unknown weights, influence coefficients, and weights that cancel the unbalance.

All of it follows from the unknowns and their covariance C at the maximum of the likelihood (inverse Fisher information). A
function g of them has the covariance J C Jᵀ with J = ∂g/∂x (delta method). A weight has two components w; the interval of
its size, or of its angle, is what that takes in the region (w − ŵ)ᵀ C⁻¹ (w − ŵ) ≤ c with c the critical rise of one
unknown: the profile likelihood of a function of the two (D. M. Bates and D. G. Watts, Nonlinear Regression Analysis and Its
Applications, 1988, chapter 6).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.fits.fitting import Fit
from ksmea.inference.critical_rise import critical_rise
from ksmea.measurement.campaign import Campaign, WeightUnit, weight_names
from ksmea.numerics.differences import central_differences
from ksmea.problem.problem import Problem
from ksmea.problem.trial_weights import disk_positions, is_on
from ksmea.records.curves import matrix, row
from ksmea.records.weights import InfluenceRecord, VectorRecord, WeightsRecord
from ksmea.units import GRAM_MILLIMETRE

N_ANGLE = 720  # points on the edge of a region of two components: its extremes are met within 1e-5 of its width
STEP = 1e-6  # of central differences, in parts of each unknown's range
TRIAL = GRAM_MILLIMETRE  # kg m, of which the response is divided by: small beside any unbalance, far above rounding


@dataclass(frozen=True)
class _Estimate:
    """Values (d,) SI of a problem's unknowns, their covariance (d, d) and the critical rise.

    The rise belongs to an interval.
    """

    problem: Problem
    x: Array
    covariance: Array
    rise: float
    campaign: Campaign


def weights_found(fit: Fit, level: float) -> WeightsRecord | None:
    """Weights found by the fit of a campaign.

    None if no run carried any, or the problem or the data cannot determine them.
    """
    problem, measurement = fit.problem, fit.measurement
    campaign = measurement.campaign
    if campaign is None or not _positions(campaign) or measurement.is_amplitude or not _can_tell(problem):
        return None
    found = _Estimate(problem, fit.x, _covariance(fit), critical_rise(fit.likelihood, level), campaign)
    unweighted = problem.at(np.unique(measurement.speed), problem.channels)
    unbalance = problem.unbalance(found.x)
    influence = {
        position: _influence(unweighted, found.x, position) for position in _planes(problem, campaign, unbalance)
    }
    by_differences = measurement.is_by_differences  # the unbalance of all runs is not known
    before, after = _amplitudes(unweighted, found, unbalance, {each: influence[each][0] for each in unbalance})
    return WeightsRecord(
        level=level,
        weights=tuple(_weights(found)),
        corrections=() if by_differences else tuple(_corrections(found)),
        speed=row(unweighted.speed),
        channels=tuple(map(str, problem.channels)),
        influence=tuple(_influence_record(found, position, *values) for position, values in influence.items()),
        before=() if by_differences else tuple(before.max(axis=0).tolist()),
        after=() if by_differences else tuple(after.max(axis=0).tolist()),
    )


def _can_tell(problem: Problem) -> bool:
    return problem.takes_unbalance and problem.has_sensitivity


def _covariance(fit: Fit) -> Array:
    """Covariance of the unknowns (d, d) SI, if the noise is also estimated."""
    d = fit.likelihood.d
    scale = np.outer(fit.problem.parameters.width, fit.problem.parameters.width)
    return np.asarray(np.linalg.pinv(fit.point.information, hermitian=True)[:d, :d] * scale)


def _positions(campaign: Campaign) -> list[float]:
    """Positions at which the shaft carried weights in any run, m."""
    return [weight.position for run in campaign.runs for weight in run.all_weights]


def _planes(problem: Problem, campaign: Campaign, unbalance: Mapping[float, complex]) -> list[float]:
    """Positions of weights, of the unbalance and of disks, from the left, m.

    Positions of the unbalance are kept exactly.
    """
    planes = list(unbalance)
    for position in (*_positions(campaign), *disk_positions(problem).values()):
        if not any(is_on(position, other) for other in planes):
            planes.append(position)
    return sorted(planes)


def _weights(found: _Estimate) -> list[VectorRecord]:
    names = found.problem.parameters.names
    return [
        _vector(found, weight.position, run.name, found.x[columns], np.eye(len(names))[columns])
        for run in found.campaign.runs
        for number, weight in enumerate(run.unknown_weights, start=1)
        for columns in [[names.index(name) for name in weight_names(run.name, number)]]
    ]


def _corrections(found: _Estimate) -> list[VectorRecord]:
    unbalance, slope = _unbalance_slope(found)
    return [
        _vector(found, position, "", -np.array([size.real, size.imag]), -np.stack([change.real, change.imag]))
        for (position, size), change in zip(unbalance.items(), slope)
    ]


def _unbalance_slope(found: _Estimate) -> tuple[dict[float, complex], ComplexArray]:
    """The unbalance by position and its derivatives (n_plane, d), kg m per SI unit."""
    parameters = found.problem.parameters
    differences = central_differences(found.x, STEP * parameters.width, parameters.lower, parameters.upper)
    values = np.array([list(found.problem.unbalance(x).values()) for x in differences.points])
    return dict(found.problem.unbalance(found.x)), differences.derivative(values.astype(complex))


def _vector(found: _Estimate, position: float, run: str, value: Array, slope: Array) -> VectorRecord:
    """A vector (2,) that depends on the unknowns by a slope (2, d)."""
    covariance = slope @ found.covariance @ slope.T
    values, directions = np.linalg.eigh(covariance)
    axes = directions * np.sqrt(found.rise * np.maximum(values, 0.0))
    turn = np.linspace(0.0, 2 * np.pi, N_ANGLE, endpoint=False)
    edge = np.array([1, 1j]) @ (value[:, None] + axes @ np.stack([np.cos(turn), np.sin(turn)]))
    best = complex(*value)
    away = np.angle(edge * np.conj(best)) if best else np.zeros(1)
    holds_zero = bool(np.ptp(away) > np.pi)  # seen from 0 the region reaches all around
    unit = _unit(found.campaign, position)
    return VectorRecord(
        position=position,
        plane=_plane(found.problem, position),
        run=run,
        x=best.real,
        y=best.imag,
        size=abs(best),
        size_low=0.0 if holds_zero else float(np.min(np.abs(edge))),
        size_high=float(np.max(np.abs(edge))),
        angle=float(np.angle(best)),
        angle_low=None if holds_zero else float(np.angle(best) + np.min(away)),
        angle_high=None if holds_zero else float(np.angle(best) + np.max(away)),
        weight_unit=str(unit),
        weight_unit_si=unit.si,
    )


def _unit(campaign: Campaign, position: float) -> WeightUnit:
    """Unit of weights in a plane.

    It is the unit of its file; at other positions the common unit of all planes, or g mm.
    """
    units = {plane.unit for plane in campaign.planes}
    own = (plane.unit for plane in campaign.planes if is_on(position, plane.position))
    return next(own, units.pop() if len(units) == 1 else WeightUnit())


def _plane(problem: Problem, position: float) -> str:
    return next((name for name, place in problem.landmarks.items() if is_on(position, place)), "")


def _influence(problem: Problem, x: Array, position: float) -> tuple[ComplexArray, ComplexArray]:
    """Influence coefficients of a plane (n_speed, n_channel), m/(kg m), and their slope.

    The slope is (n_speed, n_channel, d).
    """
    (loaded, loaded_slope), (bare, slope) = (
        problem.with_unbalance(position, TRIAL, 0.0).linearised(x),
        problem.linearised(x),
    )
    return (loaded - bare) / TRIAL, (loaded_slope - slope) / TRIAL


def _influence_record(
    found: _Estimate, position: float, influence: ComplexArray, slope: ComplexArray
) -> InfluenceRecord:
    relative = (
        slope / influence[..., None]
    )  # its real part is that of ln |influence|, its imaginary part that of the phase
    logarithm, phase = (np.sqrt(_quadratic(part, found.covariance)) for part in (relative.real, relative.imag))
    unit = _unit(found.campaign, position)
    return InfluenceRecord(
        position=position,
        plane=_plane(found.problem, position),
        amplitude=matrix(np.abs(influence)),
        phase=matrix(np.angle(influence)),
        amplitude_sd=matrix(np.abs(influence) * logarithm),
        phase_sd=matrix(phase),
        weight_unit=str(unit),
        weight_unit_si=unit.si,
    )


def _quadratic(slope: Array, covariance: Array) -> Array:
    """Variances (…) of what depends on the unknowns by slopes (…, d)."""
    return np.asarray(np.einsum("...i,ij,...j->...", slope, covariance, slope))


def _amplitudes(
    problem: Problem, found: _Estimate, unbalance: Mapping[float, complex], influence: Mapping[float, ComplexArray]
) -> tuple[Array, Array]:
    """1X amplitudes (n_speed, n_channel), m, without weights, and expected with the corrections.

    They are of all excitation in the model other than unbalance, and of the difference between the true unbalance and
    the identified one.
    """
    corrected = problem
    for position, size in unbalance.items():
        corrected = corrected.with_unbalance(position, abs(size), float(np.angle(-size)))
    left = corrected.response(found.x[None])[0]
    _, of_unbalance = _unbalance_slope(found)
    slope = sum(
        (coefficient[..., None] * change for coefficient, change in zip(influence.values(), of_unbalance)),
        np.zeros((*left.shape, len(found.x)), dtype=complex),
    )
    variance = _quadratic(slope.real, found.covariance) + _quadratic(slope.imag, found.covariance)
    return np.abs(problem.response(found.x[None])[0]), np.sqrt(np.abs(left) ** 2 + variance)

"""Readings of a campaign for balancing: one row of complex responses per run.

An *entry* is a speed and a channel; entry e = speed index · n_channel + channel index. Speeds of different runs that differ by
less than a tolerance are one nominal speed. Repeats within a run are averaged. A run may lack speeds that other runs have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.balancing.influence import tell_planes_apart
from ksmea.errors import SettingError, shortened
from ksmea.measurement.campaign import Campaign, Plane, WeightUnit
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.units import RPM

MOST_CAUSES = 5  # runs that a remark names


@dataclass(frozen=True)
class Readings:
    """Runs × entries, SI. `weights` are complex, size · e^{i angle}, in the planes; NaN if unknown."""

    names: tuple[str, ...]
    planes: Array  # (n_plane,) m
    weights: ComplexArray  # (n_run, n_plane) kg m
    response: ComplexArray  # (n_run, n_entry) m; 0 if missing
    is_missing: Mask  # (n_run, n_entry)
    speed: Array  # (n_speed,) rad/s, nominal
    channels: tuple[Channel, ...]
    deviation: Array  # (n_run, n_speed), speed / nominal speed - 1; 0 if missing
    time: Array | None  # (n_run,) s
    variance: Array | None  # (n_run, n_entry) m², of a mean of repeats as `sigma_um` states it; NaN if missing
    repeat_variance: Array | None  # (n_entry,) m², of a mean of repeats, from their scatter
    repeat_dof: int  # complex degrees of freedom of that
    remarks: tuple[str, ...]
    details: tuple[Plane, ...]  # units and holes, of each of the planes

    @property
    def units(self) -> tuple[WeightUnit, ...]:
        """Unit of the weights in each plane."""
        return tuple(plane.unit for plane in self.details)

    @property
    def is_known(self) -> Indices:
        """Indices of the runs whose weights are all known."""
        return np.flatnonzero(np.all(np.isfinite(self.weights), axis=1))

    @property
    def is_complete(self) -> Mask:
        """Whether each run (n_run,) has all speeds."""
        return np.asarray(~np.any(self.is_missing, axis=1))

    @property
    def speed_of_entry(self) -> Indices:
        return np.repeat(np.arange(len(self.speed)), len(self.channels))


def readings(measurement: Measurement, tolerance: float) -> Readings:
    """Runs of a campaign at common speeds.

    They are the speeds that all runs have, or at which most runs with known weights distinguish the planes.

    If amplitudes alone are measured, the speeds are the ones that all runs have. `tolerance` is the largest relative
    distance of neighbours that count as one nominal speed.

    Amplitudes alone are real responses. Raises `SettingError` for amplitudes of several planes, for data without
    runs, without weights, or without a common speed.
    """
    campaign = measurement.campaign
    if campaign is None or not any(run.weights for run in campaign.runs):
        raise SettingError(
            "balance: expected a campaign of runs with and without weights, got none with a weight; use"
            " measurement=campaign and name the weights of each run"
        )
    planes = _planes(campaign)
    if measurement.is_amplitude and len(planes) > 1:
        raise SettingError(
            f"balance: expected weights in one plane where amplitudes alone are measured, got {len(planes)} planes, whose effects"
            " add with phases that no run shows together; add phase_lead_deg, or balance one plane after the other"
        )
    label = _nominal(measurement.speed, tolerance)
    run = np.repeat(np.arange(len(campaign.runs)), [each.n_speed for each in campaign.runs])
    weights = np.array([[_weight(campaign, r, plane) for plane in planes] for r in range(len(campaign.runs))])
    names = tuple(each.name for each in campaign.runs)
    has = np.zeros((len(names), int(label.max()) + 1), dtype=bool)
    has[run, label] = True
    is_kept = _kept(has, weights, measurement.is_amplitude)
    _require_common_speeds(names, has[:, is_kept], tolerance)
    groups = [[np.flatnonzero((run == r) & (label == v)) for v in np.flatnonzero(is_kept)] for r in range(len(names))]
    values = np.asarray(measurement.values, dtype=complex)
    mean_speed = np.array([[_mean(measurement.speed, rows) for rows in row] for row in groups])
    nominal = np.nanmedian(mean_speed, axis=0)
    repeat_variance, dof = _repeat_variance(values, groups)
    return Readings(
        names=names,
        planes=planes,
        weights=weights,
        response=np.array([np.concatenate([np.nan_to_num(_mean(values, rows)) for rows in row]) for row in groups]),
        is_missing=np.repeat(~has[:, is_kept], len(measurement.channels), axis=1),
        speed=nominal,
        channels=measurement.channels,
        deviation=np.nan_to_num(mean_speed / nominal - 1),
        time=None if (time := measurement.time) is None else np.array([time[np.hstack(row)].mean() for row in groups]),
        variance=_stated_variance(measurement, groups),
        repeat_variance=repeat_variance,
        repeat_dof=dof,
        remarks=_remarks(names, has, is_kept),
        details=tuple(campaign.plane(float(position)) for position in planes),
    )


def _kept(has: Mask, weights: ComplexArray, is_amplitude: bool) -> Mask:
    """The speeds (n_speed,) that all runs have, or most runs with known weights and enough of them.

    `has` is (n_run, n_speed).
    """
    is_common = np.all(has, axis=0)
    if is_amplitude:
        return np.asarray(is_common)
    known = np.all(np.isfinite(weights), axis=1)
    most = np.sum(has[known], axis=0) > np.sum(known) / 2
    apart = [tell_planes_apart(weights[known & own]) for own in has.T]
    return np.asarray(is_common | (most & apart))


def _require_common_speeds(names: Sequence[str], has: Mask, tolerance: float) -> None:
    lacking = [name for name, own in zip(names, has) if not np.any(own)]
    if lacking:
        raise SettingError(
            f"balance: expected speeds that the {len(names)} runs share to {100 * tolerance:g} %, got none of run"
            f" {shortened(lacking[0])}; measure all runs at the same speeds, or raise study.speed_tolerance"
        )


def _remarks(names: Sequence[str], has: Mask, is_kept: Mask) -> tuple[str, ...]:
    """Speeds that are left out with the runs that lack them, and runs without some of the others."""
    found = []
    if not np.all(is_kept):
        causes = _lacking(names, has[:, ~is_kept])
        found.append(f"{np.sum(~is_kept)} of {len(is_kept)} speeds left out: {causes}")
    if not np.all(has[:, is_kept]):
        found.append(
            f"of {np.sum(is_kept)} speeds some runs lack a few and are fitted at theirs: {_lacking(names, has[:, is_kept])}"
        )
    return tuple(found)


def _lacking(names: Sequence[str], has: Mask) -> str:
    causes = [f"{shortened(name)} lacks {np.sum(~own)}" for name, own in zip(names, has) if not np.all(own)]
    more = f" and {len(causes) - MOST_CAUSES} more runs lack some" if len(causes) > MOST_CAUSES else ""
    return f"{', '.join(causes[:MOST_CAUSES])}{more}"


def _mean(values: ComplexArray | Array, rows: Indices) -> Any:
    """Mean over rows; NaN of none."""
    return values[rows].mean(axis=0) if len(rows) else np.full(values.shape[1:], np.nan)


def _nominal(speed: Array, tolerance: float) -> Indices:
    """The index of the nominal speed of each speed: a gap above the tolerance begins the next."""
    order = np.argsort(speed, kind="stable")
    gap = np.diff(speed[order]) / speed[order][:-1]
    label = np.empty(len(speed), dtype=np.intp)
    label[order] = np.concatenate([[0], np.cumsum(gap > tolerance)])
    for index in range(label.max() + 1):
        low, high = speed[label == index].min(), speed[label == index].max()
        if high > (1 + 3 * tolerance) * low:
            raise SettingError(
                f"study.speed_tolerance: expected speeds that fall into groups, got neighbours within {100 * tolerance:g} % all"
                f" the way from {low / RPM:.4g} to {high / RPM:.4g} rpm; lower it"
            )
    return label


def _planes(campaign: Campaign) -> Array:
    return np.array(sorted({weight.position for run in campaign.runs for weight in run.all_weights}))


def _weight(campaign: Campaign, run: int, plane: float) -> complex:
    """The sum of the weights of a run in a plane, kg m; NaN if one is unknown."""
    at = campaign.runs[run]
    if any(sought.position == plane for sought in at.unknown_weights):
        return complex(np.nan)
    known = (weight for weight in at.weights if weight.position == plane)
    return complex(sum(weight.magnitude * np.exp(1j * weight.angle) for weight in known))


def _repeat_variance(values: ComplexArray, groups: Sequence[Sequence[Indices]]) -> tuple[Array | None, int]:
    """Variance (n_entry,) of the mean of a run's repeats, and its degrees of freedom per entry.

    It is pooled over runs with all speeds.
    """
    squares, dof, n_repeat = [], 0, []
    for row in groups:
        n = min(len(rows) for rows in row)
        if n > 0:
            n_repeat.append(n)
        if n > 1:
            dof += n - 1
            parts = [values[rows[:n]] for rows in row]
            squares.append(np.concatenate([np.sum(np.abs(part - part.mean(axis=0)) ** 2, axis=0) for part in parts]))
    return (np.sum(squares, axis=0) / dof / np.mean(n_repeat), dof) if dof else (None, 0)


def _stated_variance(measurement: Measurement, groups: Sequence[Sequence[Indices]]) -> Array | None:
    if measurement.noise is None or not measurement.has_noise:
        return None
    variance = measurement.noise.variance(np.abs(measurement.values))
    return np.array([np.concatenate([_mean(variance, rows) / max(len(rows), 1) for rows in row]) for row in groups])

"""What a campaign measured, as balancing sees it: one row of complex responses per run.

An *entry* is a speed and a channel; entry e = speed index · n_channel + channel index. Speeds of different runs that differ by
less than a tolerance are one nominal speed. Repeats within a run are averaged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
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
    response: ComplexArray  # (n_run, n_entry) m
    speed: Array  # (n_speed,) rad/s, nominal
    channels: tuple[Channel, ...]
    deviation: Array  # (n_run, n_speed), speed / nominal speed - 1
    time: Array | None  # (n_run,) s
    variance: Array | None  # (n_run, n_entry) m², of a mean of repeats as `sigma_um` states it
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
    def speed_of_entry(self) -> Indices:
        return np.repeat(np.arange(len(self.speed)), len(self.channels))


def _left_out(n: int, of: int, lacking: Mapping[str, int]) -> str:
    """How many speeds are left out, and the runs that lack them."""
    causes = [f"{shortened(name)} lacks {count}" for name, count in lacking.items()]
    more = f" and {len(causes) - MOST_CAUSES} more runs lack some" if len(causes) > MOST_CAUSES else ""
    return f"{n} of {of} speeds left out: {', '.join(causes[:MOST_CAUSES])}{more}"


def readings(measurement: Measurement, tolerance: float) -> Readings:
    """The runs of a campaign at the speeds that all of them have; `tolerance` is the largest relative distance of neighbours
    that count as one nominal speed.

    Amplitudes alone are real responses. Raises `SettingError` for amplitudes of several planes, for data without runs,
    without weights, or without a speed that all runs share.
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
    everywhere = [v for v in range(label.max() + 1) if len(np.unique(run[label == v])) == len(campaign.runs)]
    if not everywhere:
        raise SettingError(
            f"balance: expected a speed that all {len(campaign.runs)} runs share to {100 * tolerance:g} %, got none; measure"
            " all runs at the same speeds, or raise study.speed_tolerance"
        )
    n_label = int(label.max()) + 1
    lacking = {each.name: n for r, each in enumerate(campaign.runs) if (n := n_label - len(np.unique(label[run == r])))}
    groups = [[np.flatnonzero((run == r) & (label == v)) for v in everywhere] for r in range(len(campaign.runs))]
    values = np.asarray(measurement.values, dtype=complex)
    mean_speed = np.array([[measurement.speed[rows].mean() for rows in row] for row in groups])
    nominal = np.median(mean_speed, axis=0)
    repeat_variance, dof = _repeat_variance(values, groups)
    return Readings(
        names=tuple(each.name for each in campaign.runs),
        planes=planes,
        weights=np.array([[_weight(campaign, r, plane) for plane in planes] for r in range(len(campaign.runs))]),
        response=np.array([np.concatenate([values[rows].mean(axis=0) for rows in row]) for row in groups]),
        speed=nominal,
        channels=measurement.channels,
        deviation=mean_speed / nominal - 1,
        time=None if (time := measurement.time) is None else np.array([time[np.hstack(row)].mean() for row in groups]),
        variance=_stated_variance(measurement, groups),
        repeat_variance=repeat_variance,
        repeat_dof=dof,
        remarks=(_left_out(n_label - len(everywhere), n_label, lacking),) if lacking else (),
        details=tuple(campaign.plane(float(position)) for position in planes),
    )


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
    """Variance (n_entry,) of the mean of a run's repeats, pooled over runs, and its degrees of freedom per entry."""
    squares, dof, n_repeat = [], 0, []
    for row in groups:
        n = min(len(rows) for rows in row)
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
    return np.array([np.concatenate([variance[rows].mean(axis=0) / len(rows) for rows in row]) for row in groups])

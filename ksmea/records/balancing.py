"""The record of a balancing: influence coefficients, unknown weights, corrections, drift, and what does not fit.

Lengths in m, speeds in rad/s, times in s; vibrations in µm 0-peak, weights in g mm and angles in degrees: what a balancer reads.
An interval of an angle is None where the interval of the size reaches 0.
"""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.record import Record


@dataclass(frozen=True)
class PolarRecord:
    """A complex number as size and angle (deg), each with its interval."""

    size: float
    angle: float
    low: float | None = None
    high: float | None = None
    angle_low: float | None = None
    angle_high: float | None = None


@dataclass(frozen=True)
class EntryRecord:
    """A speed and a channel."""

    speed: float
    channel: str


@dataclass(frozen=True)
class PlaneRecord:
    """Influence coefficients of a plane, entry by entry, µm/(g mm)."""

    position: float
    coefficients: tuple[PolarRecord, ...]


@dataclass(frozen=True)
class WeightRecord:
    """A weight of a run as its response tells it; `known` is what its mark says, size and angle, None where unknown.
    `p` is that of what the run's weights leave of its response."""

    run: str
    position: float
    weight: PolarRecord
    p: float
    known: PolarRecord | None = None
    is_inside: bool | None = None  # whether the region holds the known weight


@dataclass(frozen=True)
class RunMisfitRecord:
    """A run whose response is not that of its known weights; `weights` are those that it tells."""

    run: str
    p: float
    weights: tuple[WeightRecord, ...]


@dataclass(frozen=True)
class EntryMisfitRecord:
    """An entry unlike its neighbours `beside` it, other speeds or other channels; responses in µm."""

    run: str
    entry: EntryRecord
    beside: str
    p: float
    n_test: int
    measured: PolarRecord
    expected: PolarRecord


@dataclass(frozen=True)
class SpreadRecord:
    """Standard deviations of one entry, µm: of a run without weights, of the drift, of the mean of repeats; `p` that of the
    spread of runs being that of repeats."""

    entry: EntryRecord
    spread: float | None
    drift: float | None
    repeats: float | None
    p: float | None


@dataclass(frozen=True)
class DriftRecord:
    """The drift of one entry over the runs in the order of time, µm."""

    entry: EntryRecord
    real: tuple[float, ...]
    imaginary: tuple[float, ...]


@dataclass(frozen=True)
class CorrectionRecord:
    """Weights to be added to the bare rotor, and what each entry then is; `p` that of the bare response being from
    unbalance in the planes alone."""

    position: tuple[float, ...]
    weight: tuple[PolarRecord, ...]
    bare: tuple[PolarRecord, ...]
    left: tuple[PolarRecord, ...]
    p: float | None


@dataclass(frozen=True)
class LeftOutRecord:
    """How well weights are told by runs whose own were not used: root mean square and mean absolute error of sizes (g mm),
    mean error of angles (deg) of weights of at least `least_of_angle` (g mm), the median, part of the regions that hold the weight."""

    weights: tuple[WeightRecord, ...]
    rms_size: float
    mean_size: float
    mean_angle: float | None
    least_of_angle: float
    coverage: float


@dataclass(frozen=True)
class BalanceRecord(Record):
    """What balancing found of a campaign. `method` says how covariances were found (`ksmea.balancing.fit`), `dof` with how
    many complex degrees of freedom, None: known."""

    entries: tuple[EntryRecord, ...]
    bare: tuple[PolarRecord, ...]
    planes: tuple[PlaneRecord, ...]
    n_run: int
    n_used: int
    method: str
    dof: float | None
    interval_level: float
    level: float
    weights: tuple[WeightRecord, ...]
    correction: CorrectionRecord
    spread: tuple[SpreadRecord, ...]
    run_misfits: tuple[RunMisfitRecord, ...]
    entry_misfits: tuple[EntryMisfitRecord, ...]
    slope: tuple[float, ...]  # d ln |y| / d ln speed, one per speed; empty where not fitted
    growth: float | None  # of a coefficient at the largest weight, relative
    growth_scale: float  # g mm
    spread_growth: float
    time_constant: float | None  # s; None without a drift
    deviance_of_drift: float | None
    runs: tuple[str, ...]  # in the order of time
    run_time: tuple[float, ...]  # s from the first; their number where no time is known
    run_p: tuple[float, ...]
    drift: tuple[DriftRecord, ...]
    left_out: LeftOutRecord | None
    remarks: tuple[str, ...] = ()
    seconds: float | None = None

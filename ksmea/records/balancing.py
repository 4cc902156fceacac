"""Record of a balancing: influence coefficients, unknown weights, corrections, drift and misfits.

Lengths in m, speeds in rad/s, times in s; vibrations in µm 0-peak, weights in the unit of their file (g mm, oz in, g at a
radius …) and angles in degrees: what a balancer reads.
An interval of an angle is None if the interval of the size reaches 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, Protocol

from ksmea.measurement.notation import Notation
from ksmea.records.in_notation import InNotation, without_default_notation
from ksmea.units import DEGREES, MICROMETRES, TIME, Length, Quantity, Speed

USUAL = "g mm"  # the unit of weights of files and records that say none


class HasUnit(Protocol):
    @property
    def unit(self) -> str: ...


def _of_unit(record: HasUnit) -> Quantity:
    return Quantity(record.unit)


def _of_influence(record: HasUnit) -> Quantity:
    return Quantity(f"µm/({record.unit})")


@dataclass(frozen=True)
class PolarRecord:
    """A complex number as size and angle (deg), each with its interval."""

    size: float
    angle: Annotated[float, DEGREES]
    low: float | None = None
    high: float | None = None
    angle_low: Annotated[float | None, DEGREES] = None
    angle_high: Annotated[float | None, DEGREES] = None


@dataclass(frozen=True)
class EntryRecord:
    """A speed and a channel."""

    speed: Speed
    channel: str


@dataclass(frozen=True)
class PlaneRecord:
    """Influence coefficients of a plane, entry by entry."""

    position: Length
    coefficients: Annotated[tuple[PolarRecord, ...], _of_influence]
    unit: str = USUAL


@dataclass(frozen=True)
class WeightRecord:
    """A weight of a run, estimated from its response.

    `known` is the size and angle on its mark; None if unknown. `p` is the lack-of-fit p of the run's response with its
    weights.
    """

    run: str
    position: Length
    weight: Annotated[PolarRecord, _of_unit]
    p: float
    known: Annotated[PolarRecord | None, _of_unit] = None
    is_inside: bool | None = None  # whether the region holds the known weight
    unit: str = USUAL


@dataclass(frozen=True)
class RunMisfitRecord:
    """A run whose response does not fit its known weights; `weights` are estimated from the response."""

    run: str
    p: float
    weights: tuple[WeightRecord, ...]


@dataclass(frozen=True)
class EntryMisfitRecord:
    """An entry that deviates from its neighbours, other speeds or other channels; responses in µm."""

    run: str
    entry: EntryRecord
    beside: str
    p: float
    n_test: int
    measured: Annotated[PolarRecord, MICROMETRES]
    expected: Annotated[PolarRecord, MICROMETRES]


@dataclass(frozen=True)
class SpreadRecord:
    """Standard deviations of one entry, µm: of a run without weights, the drift, the mean of repeats.

    `p` tests whether runs spread no more than repeats (F test).
    """

    entry: EntryRecord
    spread: Annotated[float | None, MICROMETRES]
    drift: Annotated[float | None, MICROMETRES]
    repeats: Annotated[float | None, MICROMETRES]
    p: float | None


@dataclass(frozen=True)
class DriftRecord:
    """The drift of one entry over the runs in the order of time, µm."""

    entry: EntryRecord
    real: Annotated[tuple[float, ...], MICROMETRES]
    imaginary: Annotated[tuple[float, ...], MICROMETRES]


@dataclass(frozen=True)
class HoleRecord:
    """A weight in a hole, which count from 1."""

    hole: int
    angle: Annotated[float, DEGREES]
    size: Annotated[float, _of_unit]
    unit: str


@dataclass(frozen=True)
class SplitRecord:
    """The correction weight of a plane in its holes, and what is missing from it."""

    position: Length
    weights: tuple[HoleRecord, ...]
    missing: Annotated[PolarRecord, _of_unit]
    unit: str


def _of_correction(record: CorrectionRecord) -> Quantity | None:
    """None if planes have units of their own, which `units` has."""
    names = set(record.units or [USUAL])
    return Quantity(names.pop()) if len(names) == 1 else None


@dataclass(frozen=True)
class CorrectionRecord:
    """Weights to be added to the bare rotor, in the units of their planes, and what each entry then is.

    `p` of the hypothesis that the bare response is from unbalance in the planes alone. If the `condition` number of the
    planes is harmful, `common` are the weights without what readings hardly show. `splits` are the weights in holes,
    with which entries are `left_split`.
    """

    position: tuple[Length, ...]
    weight: Annotated[tuple[PolarRecord, ...], _of_correction]
    bare: Annotated[tuple[PolarRecord, ...], MICROMETRES]
    left: Annotated[tuple[PolarRecord, ...], MICROMETRES]
    p: float | None
    units: tuple[str, ...] = ()
    condition: float | None = None
    common: Annotated[tuple[PolarRecord, ...], _of_correction] = ()
    left_common: Annotated[tuple[PolarRecord, ...], MICROMETRES] = ()
    splits: tuple[SplitRecord, ...] = ()
    left_split: Annotated[tuple[PolarRecord, ...], MICROMETRES] = ()

    def unit(self, plane: int) -> str:
        """Unit of the weights in a plane, by its number from 0."""
        return self.units[plane] if self.units else USUAL


@dataclass(frozen=True)
class LeftOutRecord:
    """Errors of weights estimated from runs whose own weights were not used.

    Root mean square and mean absolute error of sizes, mean error of angles (deg) of weights of at least
    `least_of_angle` (g mm), the median, part of the regions that hold the weight.
    """

    weights: tuple[WeightRecord, ...]
    rms_size: Annotated[float, _of_unit]
    mean_size: Annotated[float, _of_unit]
    mean_angle: Annotated[float | None, DEGREES]
    least_of_angle: Annotated[float, _of_unit]
    coverage: float
    unit: str = USUAL


def _of_run_time(record: BalanceRecord) -> Quantity | None:
    """None if the runs are counted, since no time is known."""
    is_counted = record.run_time == tuple(range(len(record.run_time)))
    return None if is_counted else TIME


@dataclass(frozen=True)
class BalanceRecord(InNotation):
    """Result of balancing a campaign.

    `method` says how covariances were found (`ksmea.balancing.fit`), `dof` with how many complex degrees of freedom,
    None: known.
    """

    entries: tuple[EntryRecord, ...]
    bare: Annotated[tuple[PolarRecord, ...], MICROMETRES]
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
    growth_scale: Annotated[float, _of_unit]
    spread_growth: float
    time_constant: Annotated[float | None, _of_run_time]  # None without a drift
    deviance_of_drift: float | None
    runs: tuple[str, ...]  # in the order of time
    run_time: Annotated[tuple[float, ...], _of_run_time]  # from the first; their number where no time is known
    run_p: tuple[float, ...]
    drift: tuple[DriftRecord, ...]
    left_out: LeftOutRecord | None
    remarks: tuple[str, ...] = ()
    seconds: float | None = None
    unit: str = USUAL  # of weights where those of all planes count together: that of the first plane
    is_amplitude: bool = (
        False  # responses are amplitudes; angles of influence coefficients count from the bare response
    )
    notation: Notation = field(default_factory=Notation)  # of the measurement's own file

    def to_data(self) -> dict[str, Any]:
        return without_default_notation(super().to_data(), self.notation)

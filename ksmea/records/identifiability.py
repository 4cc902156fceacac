"""The record of how well data would determine the unknowns before anything is measured.

Cramér–Rao lower bounds (CRLB), 1 σ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.records.estimate import StabilityRecord
from ksmea.records.identification import LackOfFit
from ksmea.records.inputs import Origin
from ksmea.records.record import Record, renamed
from ksmea.units import LENGTH, SI_PER_UNIT, SPEED, Length, OfUnknown, Part, Quantity, Speed, Vibration

_RENAMED = {"bound": "crlb"}  # in earlier records

# The speeds' count, [lowest, highest] of a band in rad/s, a position in m, a factor of the noise, a kind of data, or a number of the model
# that is exact.
ALL_NUMBERS = "all"
SEEN_FALL = 0.01  # of a CRLB
Value = int | float | str | tuple[float, float]


@dataclass(frozen=True)
class Unknown:
    """An unknown and how well the data determine it.

    All values are SI; divided by `si_per_unit` they are in `unit`.
    """

    IN_UNIT: ClassVar = ("true", "lower", "upper", "crlb")

    name: str
    unit: str
    si_per_unit: float
    true: float  # value at which everything is linearised
    lower: float  # limits of the search
    upper: float
    crlb: float | None  # smallest standard deviation of an unbiased estimate; None where not identifiable
    origin: Origin | None = None  # of it; None if all numbers of the model are exact, and if not identifiable

    @property
    def crlb_si(self) -> float:
        """The CRLB, infinite where the unknown is not identifiable."""
        return np.inf if self.crlb is None else self.crlb

    @property
    def crlb_pct(self) -> float:
        """The CRLB in per cent of the value; NaN if no percentage is defined (`base`)."""
        return percent(self.crlb_si, self.base)

    @property
    def base(self) -> float:
        """Base of percentages, SI: the value.

        It is 0 if none is defined: for a value of 0, and for an angle, whose zero is arbitrary.
        """
        return 0.0 if self.unit in SI_PER_UNIT["angle"] else self.true


@dataclass(frozen=True)
class DataDescription:
    """The data that are to be measured."""

    n_speed: int
    speed_from: Speed
    speed_to: Speed
    channels: tuple[str, ...]  # for example 'x at 0.1 m'
    positions: tuple[Length, ...]  # of the measuring planes, rising
    kind: str  # 'amplitude' or 'complex'
    relative: Part  # standard deviation of the noise as a part of the value
    floor: Vibration  # its constant part
    noise_known: bool  # whether the noise's level is known, or estimated along


@dataclass(frozen=True)
class Direction:
    """Joint change of the unknowns, relative to their values.

    It is relative to the range of the search for a value of 0 and for an angle.
    """

    change: tuple[float, ...]  # unit vector (d,)
    crlb: Part | None  # of the relative change in that direction; None where not identifiable


def _of_variation(record: Variation) -> Quantity | None:
    return {"band": SPEED, "position": LENGTH}.get(record.variation)


@dataclass(frozen=True)
class Variation:
    """How well other data would determine the unknowns: one thing changed, all else as it is."""

    variation: str  # 'speeds', 'band', 'position', 'noise', 'kind' or 'numbers'
    value: Annotated[Value, _of_variation]
    crlb: tuple[OfUnknown | None, ...]  # (d,) SI

    @property
    def crlb_si(self) -> Array:
        """(d,) SI, infinite where the unknown is not identifiable."""
        return np.array([np.inf if value is None else value for value in self.crlb])


@dataclass(frozen=True)
class IdentifiabilityRecord(Record):
    """Precision of each unknown from such data, and from other data.

    `sigmas` CRLBs are the half-width of the interval of probability `level`.
    """

    level: float
    sigmas: float
    data: DataDescription
    parameters: tuple[Unknown, ...]
    correlation: tuple[tuple[float | None, ...], ...]  # (d, d) of the estimates; None where not identifiable
    worst_direction: Direction  # the joint change that the data constrain least
    variations: tuple[Variation, ...] = ()
    stability: StabilityRecord | None = None  # None in older records, and where the problem cannot tell
    lack_of_fit: LackOfFit | None = None  # of the model that was fitted to a measurement; None where nothing was
    remarks: tuple[str, ...] = ()  # what was assumed of the noise
    numbers: tuple[str, ...] = ()  # that are known to a tolerance, in words

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def least_variations(self) -> tuple[Variation, ...]:
        """Variations by numbers that would lower no CRLB by `SEEN_FALL` if they were exact.

        Texts and charts leave them out.
        """
        entries = [each for each in self.variations if each.variation == "numbers" and each.value != ALL_NUMBERS]
        return tuple(each for each in entries if not self._largest_fall(each) > SEEN_FALL)

    def _largest_fall(self, entry: Variation) -> float:
        """The largest fall of a CRLB, as a part of it; infinite if an unknown becomes identifiable."""
        ratios = [
            after / before if np.isfinite(before) else -np.inf if np.isfinite(after) else 1.0
            for before, after in zip(self.crlb_si, entry.crlb_si)
        ]
        return 1 - min(ratios)

    @property
    def crlb_si(self) -> Array:
        """CRLBs (d,) of the data as they are, SI, infinite where not identifiable."""
        return np.array([parameter.crlb_si for parameter in self.parameters])

    @classmethod
    def upgraded(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Earlier records say `bound` for a CRLB, and `least_told` for the worst direction."""
        if "least_told" not in data:
            return data
        worst = data["least_told"]
        return {
            **data,
            "parameters": [renamed(parameter, _RENAMED) for parameter in data["parameters"]],
            "variations": [renamed(variation, _RENAMED) for variation in data["variations"]],
            "worst_direction": {"change": worst["direction"], "crlb": worst["bound"]},
        }


def percent(crlb: float, true: float) -> float:
    """CRLB in per cent of the true value; NaN if the value is 0.

    >>> percent(0.5, -10.0)
    5.0
    """
    return 100 * crlb / abs(true) if true else np.nan

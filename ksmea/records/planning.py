"""Record of a plan: speeds, probes or trial unbalance to add, and the reduced CRLB (1 σ) by each.

CRLB is the Cramér–Rao lower bound.

A *reduction* is by how many per cent the CRLB of the target falls; where all unknowns are the target, the geometric mean of
the half axes of their confidence ellipsoid. None says that something becomes known that was not known at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.campaign import Weight, notation
from ksmea.records.estimate import StabilityRecord
from ksmea.records.identification import LackOfFit
from ksmea.records.record import Record, renamed
from ksmea.units import Angle, Length, OfUnknown, Quantity, Speed, Unbalance

OfTarget = Annotated[float, Quantity("SI, of the target")]

# Names in records that say 'bound' and 'gain'.
_RENAMED = {
    "bound": "crlb",
    "unplanned_bound": "unplanned_crlb",
    "gain_pct": "reduction_pct",
    "unplanned_gain_pct": "unplanned_reduction_pct",
    "criterion_gain_pct": "criterion_reduction_pct",
}


@dataclass(frozen=True)
class Unknown:
    """An unknown. Values are SI; divided by `si_per_unit` they are in `unit`."""

    IN_UNIT: ClassVar = ("true", "range_sd")

    name: str
    unit: str
    si_per_unit: float
    true: float  # value at which everything is linearised
    range_sd: float  # standard deviation of a value drawn evenly between the limits of the search


@dataclass(frozen=True)
class Candidates:
    """Candidates for addition, column by column, an entry per candidate.

    None if a family has no such column.
    """

    reduction_pct: tuple[float | None, ...]  # with this candidate alone
    criterion_reduction_pct: tuple[float, ...]  # the same with the weak prior that the choice counts on
    crlb: tuple[OfTarget | None, ...] | None = None  # with this candidate alone; None: not known, or several targets
    speed: tuple[Speed, ...] | None = None
    position: tuple[Length, ...] | None = None
    direction: tuple[str, ...] | None = None  # of a probe, 'x', 'y' or degrees
    magnitude: tuple[Unbalance, ...] | None = None  # of a trial unbalance
    phase: tuple[Angle, ...] | None = None
    number: tuple[str, ...] | None = None  # that is exact, in words


@dataclass(frozen=True)
class Addition:
    """Something that could be added: a speed, a probe, a trial unbalance or a number that is measured.

    None if it does not apply.
    """

    speed: Speed | None = None
    position: Length | None = None
    direction: str | None = None  # of a probe, 'x', 'y' or degrees
    magnitude: Unbalance | None = None  # of a trial unbalance
    phase: Angle | None = None
    number: str | None = None  # known to a tolerance, that is to be measured, in words


@dataclass(frozen=True, kw_only=True)
class Step(Addition):
    """One addition, after all earlier ones of its family."""

    candidate: int  # index among the family's candidates
    crlb: tuple[OfUnknown | None, ...]  # (d,) SI, with this and all earlier additions; None: not known
    reduction_pct: float | None
    unplanned_crlb: tuple[OfUnknown | None, ...]  # (d,) SI, with as many data that were not chosen
    unplanned_reduction_pct: float | None


@dataclass(frozen=True)
class Family:
    """Additions of one kind: 'speeds', 'probes', 'trial run' or 'numbers'."""

    family: str
    candidates: Candidates
    steps: tuple[Step, ...]

    @property
    def chosen(self) -> tuple[int, ...]:
        """Indices of the chosen candidates, in the order of the choice."""
        return tuple(step.candidate for step in self.steps)


@dataclass(frozen=True)
class PlanningRecord(Record):
    """Additions to the present data with which the target becomes known best, family by family."""

    target: str | None  # the unknown that is to become known best; None: all of them
    parameters: tuple[Unknown, ...]
    speed_from: Speed  # of the present data
    speed_to: Speed
    n_speed: int
    crlb: tuple[OfUnknown | None, ...]  # (d,) SI, of the present data; None: not known
    families: tuple[Family, ...]
    remarks: tuple[str, ...] = ()  # what was not considered, and why
    stability: StabilityRecord | None = None  # None in older records, and where the problem cannot tell
    lack_of_fit: LackOfFit | None = None  # of the model that was fitted to a measurement; None where nothing was

    @property
    def target_index(self) -> int | None:
        """Index of the target among the unknowns; None if all of them are the target."""
        return None if self.target is None else [parameter.name for parameter in self.parameters].index(self.target)

    @property
    def target_unknown(self) -> Unknown | None:
        return None if self.target_index is None else self.parameters[self.target_index]

    @property
    def trial_run(self) -> str:
        """The further run with a weight as `measurement.runs` has it.

        '' where none makes the target known better.
        """
        for family in self.families:
            step = family.steps[-1]
            is_of_use = self.target not in self.unknown_with(step.crlb)
            if step.position is not None and step.magnitude is not None and step.phase is not None and is_of_use:
                return notation([Weight(step.position, step.magnitude, step.phase)])
        return ""

    def unknown_with(self, crlb: Sequence[float | None]) -> tuple[str, ...]:
        """Unknowns that data determine less well than the limits of the search do.

        Args:
            crlb: CRLBs (d,) of these data, 1 σ, SI; None: infinite.
        """
        return tuple(
            parameter.name
            for parameter, value in zip(self.parameters, infinite_where_none(crlb))
            if value > parameter.range_sd
        )

    @classmethod
    def upgraded(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Earlier records say `bound` and `gain`, and keep the present speeds as [lowest, highest, number]."""
        if "bound" not in data:
            return data
        speed_from, speed_to, n_speed = data["speed"]
        families = [
            {
                **family,
                "candidates": renamed(family["candidates"], _RENAMED),
                "steps": [renamed(step, _RENAMED) for step in family["steps"]],
            }
            for family in data["families"]
        ]
        facts = {"speed_from": speed_from, "speed_to": speed_to, "n_speed": int(n_speed), "families": families}
        return {**renamed(data, _RENAMED), **facts}


def infinite_where_none(crlb: Sequence[float | None]) -> Array:
    """CRLBs (n,), infinite where nothing is known."""
    return np.array([np.inf if value is None else value for value in crlb])

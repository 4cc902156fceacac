"""The trace of a run as data: improvements by column, oldest first, and the stages of its method."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.problem.parameters import Parameters
from ksmea.records.record import rounded
from ksmea.units import OfUnknown

ERROR_DIGITS = 5  # that are kept of errors


@dataclass(frozen=True)
class StageRecord:
    """A finished part of a method (`ksmea.plugins.identification.Stage`); counts include earlier parts."""

    name: str
    evaluations: int
    jacobians: int
    x: tuple[OfUnknown, ...]  # (d,) SI
    error: float | None = None  # as that of improvements
    on_surrogate: bool = False


@dataclass(frozen=True)
class TraceRecord:
    """Improvements of the best misfit of the true model, thinned (`ksmea.identification.trace`).

    Each column has one entry for each. All but `seconds` depends on the seed alone.

    Where the truth is known, `least` is the misfit at the maximum of the likelihood nearest to it, and `error` the root mean
    square over the unknowns of the deviation from it in units of the CRLB there; x is left out where there are errors.
    """

    evaluations: tuple[int, ...]  # of the true model, those of the improvement included
    jacobians: tuple[int, ...]
    surrogate_evaluations: tuple[int, ...]  # points that a surrogate has predicted
    misfit: tuple[float, ...]  # of `ksmea.identification.trace.comparable_misfit`
    seconds: tuple[float, ...]  # since the method began
    x: tuple[tuple[OfUnknown, ...], ...] = ()  # (d,) SI each
    error: tuple[float, ...] = ()
    least: float | None = None
    stages: tuple[StageRecord, ...] = ()  # of the method, in their order; none where it tells none

    def check(self, d: int) -> None:
        """Raise `SettingError` if columns differ in length, or points have not d values."""
        n = len(self.evaluations)
        counts = self.evaluations, self.jacobians, self.surrogate_evaluations
        values = self.misfit, self.seconds, self.x or self.misfit, self.error or self.misfit
        if {*map(len, counts), *map(len, values)} != {n}:
            raise SettingError(f"trace: expected {n} entries in each column, got another number of them")
        if {*map(len, self.x), *(len(stage.x) for stage in self.stages)} - {d}:
            raise SettingError(f"trace: expected {d} values at each point, got another number of them")

    @property
    def excess(self) -> Array | None:
        """Excess of the misfit (n,) over the maximum nearest to the true values.

        None if these are not known.
        """
        return None if self.least is None else np.array(self.misfit) - self.least

    def judged(self, parameters: Parameters, true: Array, crlb: Sequence[float | None], least: float | None) -> Self:
        """This trace against true values (d,) SI and their CRLB.

        Unknowns that the data do not tell have no part in errors.
        """
        bounds = np.array([np.nan if bound is None else bound for bound in crlb])

        def error(x: Sequence[float]) -> float:
            deviations = np.array([parameter.turned(value) for parameter, value in zip(parameters, x - true)])
            return rounded(np.sqrt(np.nanmean((deviations / bounds) ** 2)), ERROR_DIGITS)

        if np.all(np.isnan(bounds)):
            return dataclasses.replace(self, least=least)
        return dataclasses.replace(
            self,
            x=(),
            error=tuple(error(x) for x in self.x),
            least=least,
            stages=tuple(dataclasses.replace(stage, error=error(stage.x)) for stage in self.stages),
        )


def stage_number(stages: Sequence[StageRecord], evaluations: int, jacobians: int) -> int:
    """Index of the stage that these counts fall into, among the stages that evaluate the true model.

    Counts beyond the last of these stages belong to it.
    """
    taking = [number for number, stage in enumerate(stages) if not stage.on_surrogate]
    ended = [evaluations > stages[number].evaluations or jacobians > stages[number].jacobians for number in taking[:-1]]
    return taking[sum(ended)] if taking else 0

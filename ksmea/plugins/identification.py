"""What an identification returns, and the random streams it is given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ksmea.arrays import Array, ComplexArray

BUDGET_STOPS = ("updates", "budget")  # stop reasons that say it was cut short, not that it converged


@dataclass(frozen=True)
class Streams:
    """Independent generators by component, so that methods that share a component draw the same numbers for it."""

    design: np.random.Generator
    surrogate: np.random.Generator
    optimizer: np.random.Generator


POLISH = "polish"  # name of the part of a search that goes on from where the optimiser ended


@dataclass(frozen=True)
class SearchStage:
    """A part of a search on the surrogate as it ended: the optimum until then, and its misfit on the surrogate."""

    name: str
    x: Array  # (d,) SI
    misfit: float


@dataclass(frozen=True)
class Update:
    """One updating step: the surrogate's optimum, its misfit as predicted and as the true model has it, and both
    stopping rules there (eqs. 23 and 24)."""

    x: Array  # (d,) SI
    predicted_misfit: float
    misfit: float
    smc: float
    sdf: float  # m
    sum_of_amplitudes: float  # Σ|y_FE|, m: what sdf is to be compared with
    search: tuple[SearchStage, ...] = ()  # how x was found

    @property
    def polish_gain(self) -> float | None:
        """How far the polish came below the optimiser's misfit on the surrogate; None without a polish."""
        if len(self.search) < 2 or self.search[-1].name != POLISH:
            return None
        return self.search[-2].misfit - self.search[-1].misfit


@dataclass(frozen=True)
class Stage:
    """A part of a method as it ended: the point that it left to the next one, and what all until then took of the true model.
    A part `on_surrogate` takes nothing of it."""

    name: str
    x: Array  # (d,) SI
    evaluations: int
    jacobians: int
    on_surrogate: bool = False


@dataclass(frozen=True)
class Identification:
    """Identified values and all that stands behind them; `misfit` is in the method's own form.

    `stop` is one of: smc, sdf, repeated (the optimum is a sample already), updates, budget, optimizer.
    Evaluations and Jacobians are what the method counts; a record has the study's own count (`ksmea.studies.identify`).
    `seconds` splits the wall time into model, surrogate (fits), search (optimiser and predictions) and total.
    `stages` are the parts of the method in their order: x is that of the last. Left out: there is only one.
    """

    x: Array  # (d,) SI
    at_limit: tuple[bool, ...]  # which of them lie at a search limit
    misfit: float
    stop: str
    updates: int
    model_evaluations: int
    model_jacobians: int
    surrogate_evaluations: int
    seconds: Mapping[str, float]
    history: tuple[Update, ...] = ()
    predicted: Array | ComplexArray | None = None  # (n_speed, n_channel) by the surrogate at its last optimum
    modelled: Array | ComplexArray | None = None  # by the true model at the same point
    remarks: tuple[str, ...] = ()  # what a report should say of how the values were found
    notes: Mapping[str, float] = field(default_factory=dict)
    stages: tuple[Stage, ...] = ()

    @property
    def was_cut_short(self) -> bool:
        return self.stop in BUDGET_STOPS


def at_limit(u: Array, tolerance: float = 1e-3) -> tuple[bool, ...]:
    """Which coordinates of a point in the unit cube lie at a search limit, within a thousandth of the range."""
    return tuple(bool(at) for at in (u <= tolerance) | (u >= 1 - tolerance))

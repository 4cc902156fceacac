"""Contract of an identification method.

A problem, a measurement and random streams in, the most likely values out.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
A method may own parts: a surrogate, an optimiser and a number of samples.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.measurement import Measurement
from ksmea.problem.problem import Problem
from ksmea.settings.settings import Settings, part_fields

BUDGET_STOPS = ("updates", "budget")  # stop reasons that say it was cut short, not that it converged


@dataclass(frozen=True)
class Streams:
    """Independent generators by component.

    Methods that share a component draw equal numbers for it.
    """

    design: np.random.Generator
    surrogate: np.random.Generator
    optimizer: np.random.Generator


POLISH = "polish"  # name of the part of a search that goes on from where the optimiser ended


@dataclass(frozen=True)
class SearchStage:
    """Part of a search on the surrogate as it ended.

    The optimum until then, and its misfit on the surrogate.
    """

    name: str
    x: Array  # (d,) SI
    misfit: float


@dataclass(frozen=True)
class Update:
    """One updating step: the surrogate's optimum, its misfit predicted and true, and both stopping rules.

    Source:
        Han, Guo & Gao, JSV 332 (2013) 2659–2671, doi:10.1016/j.jsv.2012.12.025, eqs. (23) and (24).
    """

    x: Array  # (d,) SI
    predicted_misfit: float
    misfit: float
    smc: float
    sdf: float  # m
    sum_of_amplitudes: float  # Σ|y_FE|, m: what sdf is to be compared with
    search: tuple[SearchStage, ...] = ()  # how x was found

    @property
    def polish_gain(self) -> float | None:
        """Decrease of the misfit on the surrogate by the polish after the optimiser; None without a polish."""
        if len(self.search) < 2 or self.search[-1].name != POLISH:
            return None
        return self.search[-2].misfit - self.search[-1].misfit


@dataclass(frozen=True)
class Stage:
    """Part of a method as it ended.

    Its last point, and all evaluations and Jacobians of the true model until then.

    A part `on_surrogate` uses none of its own.
    """

    name: str
    x: Array  # (d,) SI
    evaluations: int
    jacobians: int
    on_surrogate: bool = False


@dataclass(frozen=True)
class Identification:
    """Identified values, and how they were found.

    Args:
        x: values (d,), SI.
        at_limit: whether each lies at a search limit.
        misfit: misfit at x, in the method's own form.
        stop: reason of the end: smc, sdf, repeated (the optimum is a sample already), updates, budget or optimizer.
        updates: number of updating steps.
        model_evaluations: evaluations of the true model as the method counts them; a record has the study's own count
            (`ksmea.studies.identify`).
        model_jacobians: Jacobians of the true model, counted likewise.
        surrogate_evaluations: predictions of the surrogate.
        seconds: wall time of model, surrogate (fits), search (optimiser and predictions) and total, s.
        history: updating steps.
        predicted: response (n_speed, n_channel), m, by the surrogate at its last optimum.
        modelled: response (n_speed, n_channel), m, by the true model at that point.
        remarks: sentences for reports on how the values were found.
        notes: numbers for the record.
        stages: parts of the method in their order; x is the point of the last one. Default: empty, a single part.
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
    """Whether each coordinate of a point in the unit cube lies at a search limit.

    Args:
        u: point (d,) in the unit cube.
        tolerance: distance from a limit that counts as at it, a fraction of the range.

    >>> at_limit(np.array([0.0005, 0.5, 1.0]))
    (True, False, True)
    """
    return tuple(bool(at) for at in (u <= tolerance) | (u >= 1 - tolerance))


METHOD_PARTS = ("surrogate", "optimizer", "samples")  # what a method may own, each chosen by name or number in a run


@dataclass(frozen=True)
class Method(Settings):
    """Settings of an identification method.

    Fields marked as parts (`ksmea.settings.settings.part`) are what it is made of: a `surrogate`, an `optimizer`, the number of
    `samples`. A run that uses it ignores the parts that it does not have.
    """

    @classmethod
    def part_names(cls) -> tuple[str, ...]:
        """Names of the parts that it has, of surrogate, optimizer and samples."""
        own = {field.name for field in part_fields(cls)}
        return tuple(name for name in METHOD_PARTS if name in own)

    @property
    def ignores(self) -> tuple[str, ...]:
        """Parts of a run that make no difference to it."""
        return tuple(sorted(set(METHOD_PARTS) - set(self.part_names())))

    def validate(self, problem: Problem) -> None:
        """Check before a run that its parts work together on a problem.

        Default: they do.

        Args:
            problem: problem to identify, aligned with the measurement.

        Raises:
            SettingError: its parts cannot work together on this problem.
        """

    @abstractmethod
    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        """Identify the values that agree best with a measurement.

        The problem of a study counts its evaluations and keeps each improvement (`ksmea.identification.trace.TracedProblem`); the record
        of the study has both.

        Args:
            problem: problem at the speeds and channels of the measurement (`ksmea.problem.alignment.aligned`).
            measurement: data, m; its noise is None if the level is not known.
            streams: independent generators for design, surrogate and optimiser.

        Returns:
            Identified values (d,), SI, and how they were found.

        Raises:
            SettingError: the problem is not evaluated at the speeds and channels of the measurement.

        >>> from ksmea.measurement.measurement import Measurement
        >>> from ksmea.measurement.noise import Noise
        >>> from ksmea.plugins import registry
        >>> from ksmea.testing.jeffcott import Jeffcott
        >>> problem, x = Jeffcott(), np.array([0.9e6, 1.1e6, 900.0, 1200.0, 4e-4])  # N/m, N s/m, kg m
        >>> data = Measurement(problem.speed, problem.channels, problem.response(x[None])[0], Noise(0.01, 0.0), "exact")
        >>> method = registry.create("method", "direct", {}, {"optimizer": registry.create("optimizer", "lm", {})})
        >>> found = method.identify(problem, data, Streams(*np.random.default_rng(0).spawn(3)))
        >>> (found.x / x).round(3).tolist(), found.stop
        ([1.0, 1.0, 1.0, 1.0, 1.0], 'optimizer')
        """

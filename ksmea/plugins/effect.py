"""Contract of an effect: a physical cause that a model may lack, at one location.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
Parameter vectors are SI, in the order of `Problem.parameters`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.measurement import Measurement
from ksmea.problem.parameters import Parameter
from ksmea.problem.problem import Problem
from ksmea.settings.settings import Settings

Seen = TypeVar("Seen", bound="Problem")  # the kind of problems that an effect can be added to


class ForceLaw(Protocol):
    """A law of a local force, such as one of `ksmea.nonlinear.laws`; `coefficients` have a name, a unit and its size in SI."""

    @property
    def key(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def coefficients(self) -> tuple[tuple[str, str, float], ...]: ...


@dataclass(frozen=True)
class Effect(Settings, Generic[Seen]):
    """A physical cause that a model may lack, at one location; what registers under `ksmea.effects` is such an effect with
    its default location. How it changes a response is between it and the kind of problems that it can be added to."""

    # Effects that can look alike, by name, and what separates them. Left out: none.
    aliases: ClassVar[Mapping[str, str]] = MappingProxyType({})
    if_nowhere: ClassVar[str] = "leave it out"  # what a message says to do where a problem has no location for it
    # Whether it is fitted from values all over its limits, as what moves or hides resonances asks for. Left out: yes.
    is_scanned: ClassVar[bool] = True

    def locations(self, problem: Seen) -> Sequence[Self]:
        """This effect at each location of the problem where it may sit; empty where it cannot be. Left out: as it is."""
        return (self,)

    def is_offered(self, problem: Seen) -> bool:
        """Whether it is tried on a problem without being asked for by name. Left out: yes."""
        return True

    def seen_in(self, measurement: Measurement) -> Self | None:
        """This effect with what a measurement says of it besides its values, such as the direction of a run; None where nothing
        speaks for it, and it is tried only where it is asked for by name. Left out: as it is."""
        return self

    def path(self, problem: Seen) -> Array:
        """Values (n, e) SI leading away from 0: fits go along them, each from the last one. Left out: a scan instead."""
        return np.empty((0, 0))

    @abstractmethod
    def parameters(self, problem: Seen) -> tuple[Parameter, ...]:
        """Its unknowns with physical limits. At 0 of all of them the model is as without it."""

    @abstractmethod
    def added_to(self, problem: Problem) -> Problem:
        """The problem with this effect, whose unknowns follow its own: a problem like any other."""

    def places(self, problem: Seen) -> Sequence[float]:
        """Where on the shaft it acts alone, or whose reading it changes, m: a second opinion on its name. Left out: nowhere."""
        return ()

    def force_at(self) -> tuple[float, ForceLaw] | None:
        """Where a force acts alone, m, and the nonlinear law that its unknowns are coefficients of. Left out: nowhere."""
        return None

    @abstractmethod
    def draw(self, problem: Seen, rng: np.random.Generator) -> Array:
        """Plausible values (e,) SI within their limits, for data that hide it (`measurements/hidden_size.py` scales them)."""


AnyEffect = Effect[Any]  # on whatever kind of problems

"""Contract of an effect: a physical cause that a model may lack, at one location.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
Parameter vectors are SI, in the order of `Problem.parameters`.
"""

from __future__ import annotations

import re
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
from ksmea.records.statement import ORBIT as ORBIT  # noqa: PLC0414 – part of the contract
from ksmea.records.statement import POLAR
from ksmea.records.statement import SizeRecord as SizeRecord  # noqa: PLC0414 – part of the contract
from ksmea.records.statement import StatementRecord as StatementRecord  # noqa: PLC0414 – part of the contract
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

    # Effects that can look alike, by name, and what separates them. Default: empty.
    aliases: ClassVar[Mapping[str, str]] = MappingProxyType({})
    # A noun for it in sentences, such as 'residual bow'. Default: the name of its class.
    words: ClassVar[str] = ""
    # Where it acts and how much of it there is, a sentence without a full stop and with its unknowns in braces
    # (`ksmea.records.statement`), such as "The shaft is {youngs_modulus_change:stiffer|softer} than in the model".
    # Default: `words`, location and sizes.
    says: ClassVar[str] = ""
    # What to check on the machine if it is named, a sentence. Default: empty.
    check_next: ClassVar[str] = ""
    # The picture that shows it best: a response with speeds in the complex plane, or orbits. Default: polar.
    picture: ClassVar[str] = POLAR
    if_nowhere: ClassVar[str] = "leave it out"  # what a message says to do where a problem has no location for it
    # Whether it is fitted from values all over its limits, as an effect that moves or hides resonances requires. Default: True.
    is_scanned: ClassVar[bool] = True
    # Whether readings of complex data are those without it plus a sum linear in its unknowns, the same whatever the motion: these
    # are then eliminated in place of a scan. Default: False.
    adds_readings: ClassVar[bool] = False

    def locations(self, problem: Seen) -> Sequence[Self]:
        """This effect at each possible location of the problem.

        Empty if the problem has no location for it. Default: this effect alone.
        """
        return (self,)

    def kin(self, problem: Seen) -> Sequence[Self]:
        """Wider forms of this effect, such as a bow in two shapes, with other values of the model's unknowns.

        If this effect explains the data, forms that do so as well are further explanations under its name. Default:
        empty.
        """
        return ()

    def caveat(self, problem: Seen) -> str:
        """Remark for a diagnosis that names it, a sentence that follows its name and a colon. Default: empty, no remark."""
        return ""

    def is_offered(self, problem: Seen) -> bool:
        """Whether it is tried on a problem even if its name is not given. Default: True."""
        return True

    def seen_in(self, measurement: Measurement) -> Self | None:
        """This effect with what a measurement says of it in addition to its values, such as the direction of a run; None if nothing
        in the measurement suggests it: then it is tried only if its name is given. Default: this effect unchanged."""
        return self

    def path(self, problem: Seen) -> Array:
        """Values (n, e) SI leading away from 0, fitted in this order, each from the last fit. Default: empty, a scan instead."""
        return np.empty((0, 0))

    @abstractmethod
    def parameters(self, problem: Seen) -> tuple[Parameter, ...]:
        """Its unknowns with physical limits. At 0 of all of them the model is as without it."""

    @abstractmethod
    def added_to(self, problem: Problem) -> Problem:
        """The problem with this effect, whose unknowns follow its own: a problem like any other."""

    def places(self, problem: Seen) -> Sequence[float]:
        """Positions on the shaft (m) at which alone it acts, or whose reading it changes: a second opinion on its name. Default: empty."""
        return ()

    def force_at(self) -> tuple[float, ForceLaw] | None:
        """Position (m) of a force that acts alone, and the nonlinear law whose coefficients are the unknowns. Default: None."""
        return None

    @classmethod
    def in_words(cls) -> str:
        """Its `words`, or the name of its class in words."""
        return cls.words or re.sub(r"(?<=[a-z])(?=[A-Z])", " ", cls.__name__).lower()

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """Statement about this effect, with its sizes.

        `sizes` has each unknown by name, and each pair `name_x`, `name_y` as the vector `name`. Default: the sentence
        of `says`; an effect whose sentence depends on its sizes, or needs others, overrides it.
        """
        place = str(self)
        words = self.in_words()
        return StatementRecord(
            words, self.says or self._in_short(sizes), dict(sizes), place, self.check_next, self.picture
        )

    def vectors(self) -> Sequence[str]:
        """Names of vectors among its unknowns, without `_x` and `_y`. Default: empty."""
        return ()

    def _in_short(self, sizes: Mapping[str, SizeRecord]) -> str:
        """A sentence that holds of every effect: 'Probe rotation of {probe_rotation} {place}'."""
        vectors = self.vectors()
        parts = {f"{vector}_{axis}" for vector in vectors for axis in "xy"}
        names = [name for name, size in sizes.items() if name not in parts and (size.angle is None or name in vectors)]
        words = self.in_words()
        words = f"{words[:1].upper()}{words[1:]}"
        if len(names) == 1:
            return f"{words} of {{{names[0]}}} {{place}}"
        sized = ", ".join(f"{name.replace('_', ' ')} {{{name}}}" for name in names)
        return f"{words} {{place}}: {sized}"

    @abstractmethod
    def draw(self, problem: Seen, rng: np.random.Generator) -> Array:
        """Plausible values (e,) SI within their limits, for data that hide it (`measurements/hidden_size.py` scales them)."""


AnyEffect = Effect[Any]  # on whatever kind of problems

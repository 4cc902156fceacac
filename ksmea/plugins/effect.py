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
    """Law of a local force, such as one of `ksmea.nonlinear.laws`.

    `coefficients` have a name, a unit and its size in SI.
    """

    @property
    def key(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def coefficients(self) -> tuple[tuple[str, str, float], ...]: ...


@dataclass(frozen=True)
class Effect(Settings, Generic[Seen]):
    """Physical cause that a model may lack, at one location.

    Classes registered under `ksmea.effects` are effects with their default location. How an effect changes a response is between it
    and the kind of problems that it can be added to.

    Source:
        Each effect states its own: `python -m bench help effect NAME`.

    >>> from ksmea.plugins import registry
    >>> import ksmea
    >>> problem, runout = ksmea.load_problem("three_disk", mesh=13).problem, registry.create("effect", "runout", {})
    >>> [str(each) for each in runout.locations(problem)], [each.name for each in runout.parameters(problem)]
    (['at 0.1 m'], ['runout_x', 'runout_y'])
    >>> extended = runout.added_to(problem)
    >>> extended.parameters.names
    ('kxx', 'kyy', 'cxx', 'cyy', 'u', 'runout_x', 'runout_y')
    """

    # Effects that can look alike, by name, and what separates them. Default: empty.
    aliases: ClassVar[Mapping[str, str]] = MappingProxyType({})
    # A noun for it in sentences, such as 'residual bow'. Default: the name of its class.
    words: ClassVar[str] = ""
    # Where it acts and how much of it there is, a sentence without a full stop and with its unknowns in braces
    # (`ksmea.records.statement`), such as "The shaft is {youngs_modulus_change:stiffer|softer} than in the model".
    # Default: `words`, location and sizes.
    says: ClassVar[str] = ""
    # A check on the machine if it is named, and the finding that would confirm it: one imperative sentence of at most
    # 20 words. Default: empty.
    check_next: ClassVar[str] = ""
    # Whether it is an error of the measurement, such as a probe's angle, which leaves the machine as the model has it.
    # Default: False.
    is_of_measurement: ClassVar[bool] = False
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

        Default: this effect alone.

        Args:
            problem: problem that it may be added to.

        Returns:
            Effects of this class; empty if the problem has no location for it.
        """
        return (self,)

    def kin(self, problem: Seen) -> Sequence[Self]:
        """Wider forms of this effect, such as a bow in two shapes, with other values of the model's unknowns.

        If this effect explains the data, forms that do so as well are further explanations under its name. Default: empty.

        Args:
            problem: problem that it may be added to.

        Returns:
            Effects, at their locations.
        """
        return ()

    def caveat(self, problem: Seen) -> str:
        """Remark for a diagnosis that names it, a sentence that follows its name and a colon.

        Default: empty, no remark.

        Args:
            problem: problem that was diagnosed.
        """
        return ""

    def is_offered(self, problem: Seen) -> bool:
        """Whether it is tried on a problem even if its name is not given.

        Default: True.

        Args:
            problem: problem to be diagnosed.
        """
        return True

    def seen_in(self, measurement: Measurement) -> Self | None:
        """This effect with further information from a measurement, such as the direction of a run.

        Default: this effect unchanged.

        Args:
            measurement: data of the diagnosis.

        Returns:
            The effect; None if nothing in the measurement suggests it. It is then tried only if its name is given.
        """
        return self

    def path(self, problem: Seen) -> Array:
        """Values of its unknowns that lead away from 0, fitted in this order, each from the last fit.

        Default: empty, a scan instead.

        Args:
            problem: problem that it may be added to.

        Returns:
            Values (n, e), SI, with e the number of its unknowns.
        """
        return np.empty((0, 0))

    def scan_further(self, problem: Seen) -> Array:
        """Values of its unknowns that a scan adds to its own, which lie all over their limits.

        For narrow parts of the limits in which it acts strongly, such as resonances of its own. Default: none.

        Args:
            problem: problem that it may be added to.

        Returns:
            Values (n, e), SI, within the limits.
        """
        return np.empty((0, len(self.parameters(problem))))

    @abstractmethod
    def parameters(self, problem: Seen) -> tuple[Parameter, ...]:
        """Its unknowns with physical limits.

        If all of them are 0, the model is as without it.

        Args:
            problem: problem that it may be added to.

        Returns:
            Unknowns (e,), limits in SI.
        """

    @abstractmethod
    def added_to(self, problem: Problem) -> Problem:
        """Problem with this effect: a problem like any other.

        Args:
            problem: problem without it.

        Returns:
            Problem with the unknowns of `problem`, followed by the effect's own.
        """

    def places(self, problem: Seen) -> Sequence[float]:
        """Positions on the shaft at which alone it acts, or whose reading it changes.

        A second opinion on its name.

        Default: empty.

        Args:
            problem: problem that it may be added to.

        Returns:
            Positions, m.
        """
        return ()

    def force_at(self) -> tuple[float, ForceLaw] | None:
        """Position (m) of a force that acts alone, and the nonlinear law whose coefficients are the unknowns.

        Default: None.
        """
        return None

    @classmethod
    def in_words(cls) -> str:
        """Its `words`, or the name of its class in words."""
        return cls.words or re.sub(r"(?<=[a-z])(?=[A-Z])", " ", cls.__name__).lower()

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """Statement about this effect, with its sizes.

        Default: the sentence of `says`; an effect whose sentence depends on its sizes, or needs others, overrides it.

        Args:
            sizes: each unknown by name, and each pair `name_x`, `name_y` as the vector `name`.

        Returns:
            Words, sentence and check of a diagnosis that names it.
        """
        place = str(self)
        words = self.in_words()
        says = self.says or self._in_short(sizes)
        of_measurement = self.is_of_measurement
        return StatementRecord(words, says, dict(sizes), place, self.check_next, self.picture, of_measurement)

    def statement_on(self, problem: Seen, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """Statement about this effect on a machine, for a sentence that depends on its parts.

        Default: `statement`.

        Args:
            problem: problem without this effect.
            sizes: as of `statement`.
        """
        return self.statement(sizes)

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
        """Plausible values of its unknowns, for data that hide it.

        `measurements/hidden_size.py` scales them.

        Args:
            problem: problem that it may be added to.
            rng: generator of the draw.

        Returns:
            Values (e,), SI, within the limits.
        """


AnyEffect = Effect[Any]  # on whatever kind of problems

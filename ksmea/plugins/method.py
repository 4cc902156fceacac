"""Contract of an identification method: a problem and a measurement in, the most likely values out.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
A method may own parts: a surrogate, an optimiser and a number of samples.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from ksmea.measurement.measurement import Measurement
from ksmea.plugins.identification import Identification, Streams
from ksmea.problem.problem import Problem
from ksmea.settings.settings import Settings, part_fields

METHOD_PARTS = ("surrogate", "optimizer", "samples")  # what a method may own, each chosen by name or number in a run


@dataclass(frozen=True)
class Method(Settings):
    """Settings of a way to identify. Fields marked as parts (`ksmea.settings.settings.part`) are what it is made of: a `surrogate`,
    an `optimizer`, the number of `samples`. A run that uses it ignores the parts that it has not."""

    @classmethod
    def part_names(cls) -> tuple[str, ...]:
        own = {field.name for field in part_fields(cls)}
        return tuple(name for name in METHOD_PARTS if name in own)

    @property
    def ignores(self) -> tuple[str, ...]:
        """Parts of a run that make no difference to it."""
        return tuple(sorted(set(METHOD_PARTS) - set(self.part_names())))

    def validate(self, problem: Problem) -> None:
        """Raise `SettingError` where its parts cannot work together on this problem, before it runs. Left out: they can."""

    @abstractmethod
    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        """The values that agree best with the measurement. A problem that is not seen as the measurement is a
        `SettingError`; `ksmea.problem.alignment.aligned` makes the one that is. The problem that an identification hands over
        counts what it is asked and keeps each improvement (`ksmea.identification.trace.TracedProblem`), and its record has both."""

"""Contracts of problem settings, which build a problem, and of measurement sources.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
Sign convention: a real response is Re(q e^{iΩt}); complex responses q are in m, 0-peak.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.problem import Problem
from ksmea.records.hidden import HiddenEffect
from ksmea.settings.settings import Settings


@dataclass(frozen=True)
class ProblemSettings(Settings):
    """What registers under `ksmea.problems`: settings that build a problem, and the published values of its unknowns. They are
    apart so that what is handed to an identification cannot hold the values it is to find."""

    @abstractmethod
    def build(self) -> Problem:
        """The problem, without any value of its unknowns."""

    def reference(self) -> Mapping[str, float]:
        """Published values by parameter name, SI, for synthetic data and tables alone. Left out: none are known."""
        return {}


@dataclass(frozen=True)
class MeasurementSource(Settings):
    """What registers under `ksmea.measurements`: where a measurement comes from. The defaults are those of a source that
    knows no truth, such as real data; `read` or `measure`, `kind` and, where known, `noise` are all that one has to say."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """One of `ksmea.measurement.measurement.OBSERVABLES`."""

    def read(self) -> Measurement:
        """The measurement, of a source that holds one whatever the problem is: a file. Left out: it makes its own."""
        raise SettingError(f"expected a source that holds a measurement, got {type(self).__name__}; give it a problem")

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        """One measurement of the problem that `settings` build. Only what makes data uses the true values (SI by name)
        and the generators, of the noise and of effects that are hidden in the data. Left out: what it holds (`read`)."""
        return self.read()

    def layout(self, settings: ProblemSettings) -> Layout:
        """Speeds, channels and kind of every measurement, before one is made. Left out: as `measure` returns them."""
        unused = np.random.default_rng(0)
        return self.measure(settings, {}, unused, unused).layout

    @property
    def noise(self) -> Noise | None:
        """The noise in the data. Left out: nobody knows it."""
        return None

    @property
    def noise_known(self) -> bool:
        """Whether an identification is told the noise. Left out: where it is known at all."""
        return self.noise is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a report should say of the data, such as what was left out. Left out: nothing."""
        return ()

    def true_values(self, settings: ProblemSettings) -> Mapping[str, float]:
        """True value of every unknown of the aligned problem by name, SI. Left out: nobody knows any."""
        return {}

    def response(
        self, settings: ProblemSettings, truth: Mapping[str, float], hidden: np.random.Generator
    ) -> ComplexArray | None:
        """What is measured, without its noise, (n_speed, n_channel) m. Left out: nobody knows it."""
        return None

    def hidden_effects(self, settings: ProblemSettings, hidden: np.random.Generator) -> tuple[HiddenEffect, ...]:
        """What data drawn by `hidden` hide, for records. Left out: nothing that anyone knows of."""
        return ()

    def with_hidden(
        self, settings: ProblemSettings, problem: Problem, hidden: np.random.Generator
    ) -> tuple[Problem, Array] | None:
        """A problem with what data drawn by `hidden` hide, and true values (e,) SI of the unknowns added. Left out: None."""
        return None

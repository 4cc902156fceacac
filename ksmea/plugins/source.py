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
    """Settings registered under `ksmea.problems`, which build a problem, and the published values of its unknowns. They are
    apart so that what is handed to an identification cannot hold the values it is to find."""

    @abstractmethod
    def build(self) -> Problem:
        """The problem, without any value of its unknowns."""

    def reference(self) -> Mapping[str, float]:
        """Published values by parameter name, SI, for synthetic data and tables alone. Default: empty."""
        return {}


@dataclass(frozen=True)
class MeasurementSource(Settings):
    """Base of the settings registered under `ksmea.measurements`, which are sources of measurements.

    The defaults suit a source without known true values, such as real data. A subclass must have `read` or `measure`,
    `kind` and, if it is known, `noise`.
    """

    @property
    @abstractmethod
    def kind(self) -> str:
        """One of `ksmea.measurement.measurement.OBSERVABLES`."""

    def read(self) -> Measurement:
        """The measurement, of a source that holds one whatever the problem is: a file. Default: not supported."""
        raise SettingError(f"expected a source that holds a measurement, got {type(self).__name__}; give it a problem")

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        """One measurement of the problem that `settings` build. Only what makes data uses the true values (SI by name)
        and the generators, of the noise and of effects that are hidden in the data. Default: the measurement it holds (`read`)."""
        return self.read()

    def layout(self, settings: ProblemSettings) -> Layout:
        """Speeds, channels and kind of every measurement, before one is made. Default: as `measure` returns them."""
        unused = np.random.default_rng(0)
        return self.measure(settings, {}, unused, unused).layout

    @property
    def noise(self) -> Noise | None:
        """The noise in the data. Default: None, not known."""
        return None

    @property
    def noise_known(self) -> bool:
        """Whether the identification uses the noise level. Default: True if it is known."""
        return self.noise is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the data for reports, such as what was left out. Default: empty."""
        return ()

    def true_values(self, settings: ProblemSettings) -> Mapping[str, float]:
        """True value of every unknown of the aligned problem by name, SI. Default: empty, not known."""
        return {}

    def response(
        self, settings: ProblemSettings, truth: Mapping[str, float], hidden: np.random.Generator
    ) -> ComplexArray | None:
        """The measured response without its noise, (n_speed, n_channel) m. Default: None, not known."""
        return None

    def hidden_effects(self, settings: ProblemSettings, hidden: np.random.Generator) -> tuple[HiddenEffect, ...]:
        """Effects hidden in data drawn by `hidden`, for records. Default: empty."""
        return ()

    def with_hidden(
        self, settings: ProblemSettings, problem: Problem, hidden: np.random.Generator
    ) -> tuple[Problem, Array] | None:
        """A problem with what data drawn by `hidden` hide, and true values (e,) SI of the unknowns added. Default: None."""
        return None

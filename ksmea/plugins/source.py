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
    """Settings registered under `ksmea.problems`, which build a problem and know its published values.

    They are apart from the problem so that the input of an identification cannot hold the values it is to find.

    >>> from ksmea.testing.jeffcott import JeffcottRotor
    >>> rotor = JeffcottRotor(n_speed=3)
    >>> rotor.build().speed.tolist(), rotor.reference()["kxx"]  # rad/s, N/m
    ([100.0, 300.0, 500.0], 900000.0)
    """

    @abstractmethod
    def build(self) -> Problem:
        """Problem without any value of its unknowns."""

    def reference(self) -> Mapping[str, float]:
        """Published values by parameter name, SI, for synthetic data and tables alone.

        Default: empty.
        """
        return {}


@dataclass(frozen=True)
class MeasurementSource(Settings):
    """Base of the settings registered under `ksmea.measurements`, which are sources of measurements.

    The defaults suit a source without known true values, such as real data. A subclass must have `read` or `measure`,
    `kind` and, if it is known, `noise`.

    >>> from ksmea.plugins import registry
    >>> source = registry.create("measurement", "file", {"path": "docs/examples/run_up.csv"})
    >>> str(source.kind), source.read().values.shape
    ('complex', (90, 2))
    """

    @property
    @abstractmethod
    def kind(self) -> str:
        """Observable, one of `ksmea.measurement.measurement.OBSERVABLES`: "amplitude" or "complex"."""

    def read(self) -> Measurement:
        """Measurement of a source that holds one, whatever the problem is: a file.

        Default: not supported.

        Raises:
            SettingError: the source needs a problem.
        """
        raise SettingError(f"expected a source that holds a measurement, got {type(self).__name__}; give it a problem")

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        """Measurement of the problem that some settings build.

        Only code that makes data uses the true values and the generators. Default: the measurement it holds (`read`).

        Args:
            settings: settings of the problem.
            truth: true values by name, SI.
            noise: generator of the noise.
            hidden: generator of effects that are hidden in the data.

        Returns:
            Measurement, values (n_speed, n_channel) in m.

        Raises:
            SettingError: the source cannot measure this problem.
        """
        return self.read()

    def layout(self, settings: ProblemSettings) -> Layout:
        """Speeds, channels and kind of every measurement, before one is made.

        Default: as `measure` returns them.

        Args:
            settings: settings of the problem.
        """
        unused = np.random.default_rng(0)
        return self.measure(settings, {}, unused, unused).layout

    @property
    def noise(self) -> Noise | None:
        """Noise in the data.

        Default: None, not known.
        """
        return None

    @property
    def noise_known(self) -> bool:
        """Whether the identification uses the noise level.

        Default: True if it is known.
        """
        return self.noise is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the data for reports, such as on rows that were dropped.

        Default: empty.
        """
        return ()

    def true_values(self, settings: ProblemSettings) -> Mapping[str, float]:
        """True value of every unknown of the aligned problem.

        Default: empty, not known.

        Args:
            settings: settings of the problem.

        Returns:
            Values by name, SI.
        """
        return {}

    def response(
        self, settings: ProblemSettings, truth: Mapping[str, float], hidden: np.random.Generator
    ) -> ComplexArray | None:
        """Measured response without its noise.

        Default: None, not known.

        Args:
            settings: settings of the problem.
            truth: true values by name, SI.
            hidden: generator of effects that are hidden in the data.

        Returns:
            Complex response (n_speed, n_channel), m.
        """
        return None

    def hidden_effects(self, settings: ProblemSettings, hidden: np.random.Generator) -> tuple[HiddenEffect, ...]:
        """Effects hidden in data, for records.

        Default: empty.

        Args:
            settings: settings of the problem.
            hidden: generator that the data were drawn with.
        """
        return ()

    def with_hidden(
        self, settings: ProblemSettings, problem: Problem, hidden: np.random.Generator
    ) -> tuple[Problem, Array] | None:
        """Problem with the effects hidden in data, and true values of the added unknowns.

        Default: None.

        Args:
            settings: settings of the problem.
            problem: problem without them.
            hidden: generator that the data were drawn with.

        Returns:
            Problem, and values (e,), SI.
        """
        return None

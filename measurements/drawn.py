"""Synthetic measurements whose kind and noise level are drawn for an instance of `problem=drawn`.

Family, set and number seed the draw, as they seed the draw of the rotor; an experiment gives both the same
(`measurement.instance: ${problem.instance}`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.measurement import OBSERVABLES, Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.settings.settings import setting
from measurements.synthetic import Synthetic

# Relative standard deviation of each value, evenly in its logarithm: 1 % is a careful measurement, 10 % the paper's worst.
RELATIVE = 0.01, 0.1


@dataclass(frozen=True)
class Drawn(MeasurementSource):
    """Amplitudes or complex responses, as likely, with known Gaussian noise of 1 to 10 % of each value."""

    family: str = setting("three_disk", "the family of the instance (`python -m bench help problem drawn`)")
    instance: int = setting(0, "number of the draw", at_least=0)
    held_back: bool = setting(False, "draw from the stream of the instances that no method is developed on")

    @cached_property
    def _synthetic(self) -> Synthetic:
        entropy = [*b"noise", *self.family.encode(), int(self.held_back), self.instance]
        rng = np.random.default_rng(np.random.SeedSequence(entropy))
        relative = round(math.exp(rng.uniform(*np.log(RELATIVE))), 4)  # the same on machines that round differently
        return Synthetic(kind=OBSERVABLES[rng.integers(len(OBSERVABLES))], relative=relative)

    @property
    def kind(self) -> str:
        return self._synthetic.kind

    @property
    def noise(self) -> Noise:
        """The noise that is drawn, SI."""
        return self._synthetic.noise

    def layout(self, settings: ProblemSettings) -> Layout:
        for name in ("family", "instance", "held_back"):
            own, of_problem = getattr(self, name), getattr(settings, name, None)
            if of_problem not in (None, own):
                raise SettingError(
                    f"measurement.{name}: expected {of_problem} as in the problem, got {own};"
                    f" give measurement.{name}={of_problem}"
                )
        return self._synthetic.layout(settings)

    def true_values(self, settings: ProblemSettings) -> dict[str, float]:
        """True values of the problem; stability is checked when it is measured."""
        return dict(settings.reference())

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        return self._synthetic.measure(settings, truth, noise, hidden)

    def response(
        self, settings: ProblemSettings, truth: Mapping[str, float], hidden: np.random.Generator
    ) -> ComplexArray:
        return self._synthetic.response(settings, truth, hidden)

"""Synthetic measurements: the response of a problem at known values, with noise drawn on it.

Here, and nowhere in what identifies, the true values are known.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ksmea.contracts import ComplexArray, Problem, ProblemSettings
from ksmea.errors import SettingError, unknown
from ksmea.measurement import KINDS, Measurement, Noise, observe
from ksmea.parameters import Array
from ksmea.settings import Settings, setting

MICROMETRE = 1e-6  # m


@dataclass(frozen=True)
class Synthetic(Settings):
    """A measurement made by the problem's own model, perhaps on another mesh, with Gaussian noise.

    The paper says '10 % Gaussian noise' and not what it multiplies: here each value by its own standard deviation.
    """

    kind: str = setting(
        "amplitude", "what is measured: amplitudes, or complex responses with their phase", choices=KINDS
    )
    relative: float = setting(0.0, "standard deviation of the noise relative to each value", at_least=0)
    floor: float = setting(
        0.0, "standard deviation of the noise that is there without any response", unit="µm", at_least=0
    )
    noise_known: bool = setting(
        True, "tell the identification the noise's level; false: it is estimated, relative part and floor together"
    )
    mesh: int | None = setting(
        None, "number of elements of the model that makes the data; null: the problem's", at_least=1
    )
    truth: dict[str, float] = setting(
        {}, "true values in the units of the problem's parameters; a name left out: the published one"
    )

    def true_values(self, settings: ProblemSettings, problem: Problem) -> dict[str, float]:
        """True value of every unknown by name, SI."""
        values = dict(self._source(settings).reference())
        units = {parameter.name: parameter.si_per_unit for parameter in problem.parameters}
        for name, value in self.truth.items():
            if name not in units:
                raise unknown("parameter in measurement.truth:", name, units)
            values[name] = value * units[name]
        missing = [name for name in units if name not in values]
        if missing:
            raise SettingError(f"measurement.truth: expected a value for {', '.join(missing)}, got none; add it")
        return {name: values[name] for name in units}

    def measure(self, settings: ProblemSettings, truth: Mapping[str, float], rng: np.random.Generator) -> Measurement:
        """One noisy measurement of the problem at the true values (SI)."""
        problem = self._source(settings).build()
        values = observe(_response_at(problem, truth), self.kind, self.noise, rng)
        noise = self.noise if self.noise_known else None
        return Measurement(problem.speed, problem.channels, values, noise, source="synthetic")

    @property
    def noise(self) -> Noise:
        """The noise that is drawn, SI."""
        return Noise(self.relative, self.floor * MICROMETRE)

    def response(self, settings: ProblemSettings, truth: Mapping[str, float]) -> ComplexArray:
        """The noise-free response (n_speed, n_channel), m, that is measured."""
        return _response_at(self._source(settings).build(), truth)

    def _source(self, settings: ProblemSettings) -> ProblemSettings:
        if self.mesh is None:
            return settings
        if "mesh" not in {field.name for field in dataclasses.fields(settings)}:
            raise SettingError("measurement.mesh: expected a problem with a mesh, got one without; leave it null")
        try:
            return dataclasses.replace(settings, mesh=self.mesh)
        except SettingError as error:
            raise SettingError(f"measurement.{error}") from error


def _response_at(problem: Problem, truth: Mapping[str, float]) -> ComplexArray:
    x: Array = np.array([truth[name] for name in problem.parameters.names])
    return problem.response(x[None])[0]

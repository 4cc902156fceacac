"""What a run is made of: its plugins with their settings checked, the problem and the true values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.plan.draw import Draw
from bench.plan.plan import generator
from ksmea import registry
from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.identifiability import identifiability
from ksmea.measurement import Measurement

# Where a run's settings keep the hash of the file that a plugin of the group names: another file is another question.
FINGERPRINTS = {"problem": "fingerprint", "measurement": "measurement_fingerprint"}


@dataclass(frozen=True)
class Setup:
    """`plugins` by group, None where a part is ignored; `truth` by name, SI, as far as it is known to anyone: empty for
    what was really measured."""

    plugins: Mapping[str, Any]
    problem: Problem
    truth: Mapping[str, float]
    samples: int

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> Setup:
        """What a run's settings say, its files unchanged since they were planned."""
        plugins = plugins_of(settings)
        for group, fingerprint in fingerprints(plugins).items():
            if settings.get(FINGERPRINTS[group], fingerprint) != fingerprint:
                raise SettingError(
                    f"the {group}'s file has changed since the experiment was planned; give its command again"
                )
        problem = plugins["problem"].build()
        if hasattr(plugins["measurement"], "adapted"):
            problem = plugins["measurement"].adapted(problem)
        truth = plugins["measurement"].true_values(plugins["problem"], problem)
        return cls(plugins, problem, truth, settings.get("samples") or 0)

    def measure(self, draw: Draw) -> Measurement:
        """The measurement of one run."""
        plugin = self.plugins["measurement"]
        return plugin.measure(
            self.plugins["problem"], self.truth, generator(draw.seeds["noise"]), **self._stream_of_hidden(draw)
        )

    def true_response(self, draw: Draw) -> ComplexArray | None:
        """What is measured in one run without its noise, (n_speed, n_channel) m, where anyone knows it."""
        if not self.truth:
            return None
        plugin = self.plugins["measurement"]
        return plugin.response(self.plugins["problem"], self.truth, **self._stream_of_hidden(draw))

    def hidden(self, draw: Draw) -> list[dict[str, Any]]:
        """What the data of one run hide, for its record and nothing else."""
        stream = self._stream_of_hidden(draw)
        return self.plugins["measurement"].hidden_effects(self.plugins["problem"], **stream) if stream else []

    def with_hidden(self, draw: Draw) -> tuple[Problem, Array] | None:
        """The problem with what the data of one run hide, and all true values (d,) SI; None where nothing is hidden. For
        judging what was found, after it was found."""
        stream = self._stream_of_hidden(draw)
        if not stream:
            return None
        problem, theta = self.plugins["measurement"].with_hidden(self.plugins["problem"], self.problem, **stream)
        return problem, np.concatenate([self.true_x, theta])

    def _stream_of_hidden(self, draw: Draw) -> dict[str, np.random.Generator]:
        """The generator that effects are drawn by, for a measurement that hides some."""
        if not getattr(self.plugins["measurement"], "hidden", ()):
            return {}
        return {"hidden": generator(draw.seeds["hidden"])}

    @property
    def true_x(self) -> Array:
        """True values (d,) SI, in the order of the problem's parameters."""
        return np.array([self.truth[name] for name in self.problem.parameters.names])

    def require_truth(self, who: str) -> None:
        """Raise `SettingError` where an unknown has no true value."""
        missing = [name for name in self.problem.parameters.names if name not in self.truth]
        if missing:
            raise SettingError(
                f"{who}: expected a measurement with true values, at which Cramér–Rao bounds are taken, got none of"
                f" {', '.join(missing)}; use measurement=synthetic, with measurement.truth where nothing is published"
            )

    def crlb(self) -> list[float | None]:
        """Cramér–Rao bound of each unknown, SI, as the measurement's noise has it; None where there is none,
        or no true value to take it at."""
        measurement = self.plugins["measurement"]
        if not self.truth or measurement.noise.is_absent:
            return [None] * len(self.problem.parameters)
        found = identifiability(
            self.problem, self.true_x, measurement.noise, measurement.kind, noise_known=measurement.noise_known
        )
        return [float(bound) if np.isfinite(bound) else None for bound in found.bound]


def fingerprints(plugins: Mapping[str, Any]) -> dict[str, str]:
    """Hash of the content of each plugin's file, by group, of those that name one."""
    return {group: plugins[group].fingerprint() for group in FINGERPRINTS if hasattr(plugins[group], "fingerprint")}


def plugins_of(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The plugins that a run's settings name, their settings checked; a part that is ignored is None."""
    settings = {"study": {"name": "identify"}, **settings}  # records older than studies name none
    return {
        group: registry.create(group, settings[group]["name"], _without_name(settings[group]))
        if settings.get(group) is not None
        else None
        for group in registry.GROUPS
    }


def _without_name(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in settings.items() if key != "name"}

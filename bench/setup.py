"""What a run is made of: its plugins with their settings checked, the problem and the true values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea import registry
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.identifiability import identifiability
from ksmea.parameters import Array


@dataclass(frozen=True)
class Setup:
    """`plugins` by group, None where a part is ignored; `truth` by name, SI, as far as it is known to anyone."""

    plugins: Mapping[str, Any]
    problem: Problem
    truth: Mapping[str, float]
    samples: int

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> Setup:
        """What a run's settings say, its files unchanged since they were planned."""
        plugins = plugins_of(settings)
        if "fingerprint" in settings and plugins["problem"].fingerprint() != settings["fingerprint"]:
            raise SettingError(
                "the problem's file has changed since the experiment was planned; give its command again"
            )
        problem = plugins["problem"].build()
        truth = plugins["measurement"].true_values(plugins["problem"], problem)
        return cls(plugins, problem, truth, settings.get("samples") or 0)

    @property
    def true_x(self) -> Array:
        """True values (d,) SI, in the order of the problem's parameters."""
        return np.array([self.truth[name] for name in self.problem.parameters.names])

    def bounds(self) -> list[float | None]:
        """Cramér–Rao bound of each unknown, SI, as the measurement's noise has it; None where there is none."""
        measurement = self.plugins["measurement"]
        if measurement.noise.is_absent:
            return [None] * len(self.problem.parameters)
        found = identifiability(
            self.problem, self.true_x, measurement.noise, measurement.kind, noise_known=measurement.noise_known
        )
        return [float(bound) if np.isfinite(bound) else None for bound in found.bound]


def plugins_of(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The plugins that a run's settings name, their settings checked; a part that is ignored is None."""
    return {
        group: registry.create(group, settings[group]["name"], _without_name(settings[group]))
        if settings.get(group) is not None
        else None
        for group in registry.GROUPS
    }


def _without_name(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in settings.items() if key != "name"}

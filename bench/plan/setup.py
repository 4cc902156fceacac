"""Parts of a run: plugins with checked settings, problem, true values (`Setup`); seeds (`Draw`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.plan.plan import generator
from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.inference.cramer_rao import identifiability
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.plugins.identification import Method
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.problem.alignment import aligned
from ksmea.problem.problem import Problem
from ksmea.records.hidden import HiddenEffect

# Where a run's settings keep the hash of the file that a plugin of the group names: another file is another question.
FINGERPRINTS = {"problem": "fingerprint", "measurement": "measurement_fingerprint"}

PARTS_FIRST = sorted(registry.GROUPS, key=lambda group: group == "method")  # a method is made of others


@dataclass(frozen=True)
class Setup:
    """Parts of a run: plugins, problem and true values.

    `plugins` are by group, None if a part is ignored. `aligned_problem` is None for a study that requests none. `truth`
    is by name, SI, as far as it is known to anyone: empty for what was really measured.
    """

    plugins: Mapping[str, Any]
    aligned_problem: Problem | None
    truth: Mapping[str, float]

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> Setup:
        """Setup from a run's settings, its files unchanged since they were planned."""
        plugins = plugins_of(settings)
        for group, fingerprint in fingerprints(plugins).items():
            if settings.get(FINGERPRINTS[group], fingerprint) != fingerprint:
                raise SettingError(
                    f"the {group}'s file has changed since the experiment was planned; give its command again"
                )
        source: MeasurementSource = plugins["measurement"]
        if "problem" in plugins["study"].ignores:
            return cls(plugins | {"problem": None}, None, {})
        problem = aligned(plugins["problem"].build(), source.layout(plugins["problem"]))
        return cls(plugins, problem, source.true_values(plugins["problem"]))

    @property
    def problem(self) -> Problem:
        """Problem as the measurement sees it; `TypeError` in a study that ignores the problem."""
        if self.aligned_problem is None:
            raise TypeError("a study that ignores the problem requested it")
        return self.aligned_problem

    @property
    def settings(self) -> ProblemSettings:
        """Settings of the problem."""
        settings: ProblemSettings = self.plugins["problem"]
        return settings

    @property
    def method(self) -> Method:
        """How the unknowns are identified, with its surrogate, optimiser and samples."""
        method: Method = self.plugins["method"]
        return method

    @property
    def source(self) -> MeasurementSource:
        """Source of the measurement."""
        source: MeasurementSource = self.plugins["measurement"]
        return source

    def measure(self, draw: Draw) -> Measurement:
        """The measurement of one run."""
        noise, hidden = generator(draw.seeds["noise"]), generator(draw.seeds["hidden"])
        return self.source.measure(self.settings, self.truth, noise, hidden)

    def true_response(self, draw: Draw) -> ComplexArray | None:
        """Noise-free data of one run, (n_speed, n_channel) m; None if not known."""
        return self.source.response(self.settings, self.truth, generator(draw.seeds["hidden"]))

    def hidden(self, draw: Draw) -> tuple[HiddenEffect, ...]:
        """Effects hidden in the data of one run, for its record only."""
        return self.source.hidden_effects(self.settings, generator(draw.seeds["hidden"]))

    def with_hidden(self, draw: Draw) -> tuple[Problem, Array] | None:
        """The problem with what the data of one run hide, and all true values (d,) SI.

        None if nothing is hidden. For judging what was found, after it was found.
        """
        found = self.source.with_hidden(self.settings, self.problem, generator(draw.seeds["hidden"]))
        return None if found is None else (found[0], np.concatenate([self.true_x, found[1]]))

    @property
    def true_x(self) -> Array:
        """True values (d,) SI, in the order of the problem's parameters."""
        return np.array([self.truth[name] for name in self.problem.parameters.names])

    def require_truth(self, who: str) -> None:
        """Raise `SettingError` if an unknown has no true value."""
        missing = [name for name in self.problem.parameters.names if name not in self.truth]
        if missing:
            raise SettingError(
                f"{who}: expected a measurement with true values, at which the CRLB is taken, got none of"
                f" {', '.join(missing)}; use measurement=synthetic, with measurement.truth where nothing is published"
            )

    def refuse_exact_data(self, who: str) -> None:
        """Raise `SettingError` if data have no noise; its level need not be known."""
        noise = self.source.noise
        if noise is not None and noise.is_absent:
            raise SettingError(
                f"{who}: expected noise, without which any difference is a misfit, got none; say measurement.relative=0.05 or"
                " measurement.floor=0.1 (µm)"
            )

    def require_noise(self, who: str) -> Noise:
        """Noise of the measurement; `SettingError` if the measurement has no noise."""
        noise = self.source.noise
        if noise is None or noise.is_absent:
            raise SettingError(
                f"{who}: expected a measurement with noise, without which every unknown is known exactly, got none; give"
                " measurement.relative=0.1 or measurement.floor=0.5 (µm)"
            )
        return noise

    def crlb(self, problem: Problem | None = None) -> list[float | None]:
        """Cramér–Rao lower bound (CRLB) of each unknown, SI, for the measurement's noise.

        None without noise or true values, or if it is not finite. `problem` replaces the problem of this setup.
        """
        source = self.source
        if not self.truth or source.noise is None or source.noise.is_absent:
            return [None] * len(self.problem.parameters)
        found = identifiability(
            problem or self.problem, self.true_x, source.noise, source.kind, noise_known=source.noise_known
        )
        return [float(value) if np.isfinite(value) else None for value in found.crlb]


def fingerprints(plugins: Mapping[str, Any]) -> dict[str, str]:
    """Hash of the content of each plugin's file, by group, for plugins that name a file."""
    return {group: found for group in FINGERPRINTS if plugins[group] and (found := plugins[group].fingerprint())}


def plugins_of(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The plugins that a run's settings name, their settings checked, the method made of its parts.

    Ignored parts are None.
    """
    settings = {"study": {"name": "identify"}, **settings}  # records older than studies name none
    plugins: dict[str, Any] = {}
    for group in PARTS_FIRST:
        chosen = settings.get(group)
        if chosen is None:
            plugins[group] = None
            continue
        own = {key: value for key, value in chosen.items() if key != "name"}
        parts = {**plugins, "samples": settings.get("samples")} if group == "method" else {}
        plugins[group] = registry.create(group, chosen["name"], own, parts)
    return plugins


@dataclass(frozen=True)
class Draw:
    """Inputs of one run in addition to its settings.

    `seeds` are given by component. `journal` is the file for model evaluations, None if no journal is kept.
    `with_curves` requests the response curves for figures. `with_progress` is True for the only run, which shows its
    own progress. Up to `workers` processes may share the run. `with_fine` adds responses at more speeds than were measured, which costs
    some twenty evaluations of the model.
    """

    seeds: Mapping[str, list[int]]
    journal: Path | None = None
    with_curves: bool = False
    with_progress: bool = False
    workers: int = 1
    with_fine: bool = False

"""From a composed configuration to a plan: one configuration per choice of plugins, typed updates for plain values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydra.core.config_loader import ConfigLoader
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from bench import records
from bench.collect import collect
from bench.execute import plugins_of
from bench.overrides import Choice, grid_points, parse
from bench.plan import Cell, ParameterFacts, Plan, make_plan, write_plan
from bench.provenance import code_digest, library_versions
from ksmea import registry
from ksmea.errors import SettingError

# Settings of the whole experiment, which cannot be an axis of it.
WHOLE = ("name", "repetitions", "workers", "timeout", "output", "batches", "batch", "paper", "grid")


@dataclass(frozen=True)
class Experiment:
    """A plan and how its runs are dealt out."""

    plan: Plan
    output: Path
    batches: int
    workers: int | None
    timeout: float | None

    @classmethod
    def compose(cls, loader: ConfigLoader, master: DictConfig, arguments: list[str]) -> Experiment:
        choices = parse(arguments)
        fixed = [choice for choice in choices if len(choice.values) <= 1]
        swept = {choice.key: choice.values for choice in choices if len(choice.values) > 1}
        for key in swept:
            if key in WHOLE or key == "experiment":
                raise SettingError(f"{key}: expected one value for the whole experiment, got several; give one")
        composer = _Composer(loader, master, fixed)
        config = composer.composed({})
        _check_whole(config)
        grid = OmegaConf.to_container(config.grid)
        points = grid_points(grid, swept, {choice.key for choice in fixed})
        cells = tuple(_cell(composer.at(point), point) for point in points)
        axes = _axes(points)
        plan = make_plan(
            name=config.name,
            paper=config.paper,
            axes=axes,
            command=tuple(arguments),
            cells=cells,
            repetitions=config.repetitions,
            code=code_digest(cell.settings for cell in cells),
            versions=library_versions(),
        )
        return cls(plan, Path(config.output).absolute(), config.batches, config.workers, config.timeout)

    def prepare(self) -> list[list[str]]:
        """Write the plan; the overrides of each job that has work left."""
        write_plan(self.plan, self.output)
        finished = {
            key for key, record in records.read_records(self.output).items() if record["status"] in records.RESULTS
        }
        jobs = []
        for batch in range(self.batches):
            if any(run.key not in finished for run in self.plan.runs[batch :: self.batches]):
                jobs.append(self._job(batch))
        return jobs

    def _job(self, batch: int) -> list[str]:
        output = str(self.output).replace("\\", "\\\\").replace("'", "\\'")
        job = [f"output='{output}'", f"batches={self.batches}", f"batch={batch}"]
        if self.workers is not None:
            job.append(f"workers={self.workers}")
        if self.timeout is not None:
            job.append(f"timeout={self.timeout}")
        return job

    def collect(self) -> int:
        """Tables and figures of what is there; the exit code."""
        return collect(self.output)


class _Composer:
    """Configurations at the points of a grid: composed once per choice of groups, then updated."""

    def __init__(self, loader: ConfigLoader, master: DictConfig, fixed: Iterable[Choice]) -> None:
        self._loader = loader
        self._master = master
        self._fixed = [choice.override.input_line for choice in fixed]
        self._composed: dict[tuple[str, ...], DictConfig] = {}

    def at(self, point: dict[str, Any]) -> DictConfig:
        groups = {key: value for key, value in point.items() if key in registry.GROUPS}
        config = self.composed(groups).copy()
        for key, value in point.items():
            if key not in groups:
                OmegaConf.update(config, key, value, merge=True)
        return config

    def composed(self, groups: dict[str, str]) -> DictConfig:
        overrides = tuple(f"{group}={name}" for group, name in groups.items())
        if overrides not in self._composed:
            self._composed[overrides] = self._loader.load_configuration(
                config_name=self._master.hydra.job.config_name,
                overrides=[*self._fixed, *overrides],
                run_mode=RunMode.RUN,
            )
        return self._composed[overrides]


def _check_whole(config: DictConfig) -> None:
    for key, least in (("repetitions", 1), ("workers", 1), ("batches", 1), ("seed", 0)):
        if config[key] is not None and config[key] < least:
            raise SettingError(f"{key}: expected at least {least}, got {config[key]}")
    if config.timeout is not None and config.timeout <= 0:
        raise SettingError(f"timeout: expected seconds above 0, got {config.timeout}")


def _cell(config: DictConfig, point: dict[str, Any]) -> Cell:
    """The settings of one point, checked by making its plugins; what the method ignores is left out."""
    if config.samples < 1:
        raise SettingError(f"samples: expected at least 1, got {config.samples}")
    settings = {group: OmegaConf.to_container(config[group], resolve=True) for group in registry.GROUPS}
    plugins = plugins_of(settings)
    problem = plugins["problem"].build()
    plugins["method"].validate(problem, plugins["surrogate"], plugins["optimizer"], config.samples)
    truth = plugins["measurement"].true_values(plugins["problem"], problem)
    settings["samples"] = config.samples
    for part in plugins["method"].ignores:
        settings[part] = None
    parameters = tuple(
        ParameterFacts(parameter.name, parameter.unit, parameter.si_per_unit, truth[parameter.name])
        for parameter in problem.parameters
    )
    place = {"samples": config.samples} | point
    return Cell(place=place, settings=settings, seed=config.seed, parameters=parameters)


def _axes(points: list[dict[str, Any]]) -> tuple[str, ...]:
    """The keys of the grid, samples always first: the columns that tell a table's fields apart."""
    return tuple(dict.fromkeys(["samples", *(key for point in points for key in point)]))

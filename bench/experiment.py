"""From a composed configuration to a plan: one configuration per choice of plugins, typed updates for plain values."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydra.core.config_loader import ConfigLoader
from hydra.core.override_parser.types import Quote, QuotedString
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from bench.config import BenchConfig
from bench.execute import plugins_of
from bench.overrides import Choice, grid_points, parse
from bench.plan import Cell, ParameterFacts, Plan, all_runs, write_plan
from bench.provenance import code_digest, commit, library_versions, used_modules
from bench.records import finished_keys
from bench.tables import PAPER
from bench.work import Job, unfinished
from ksmea import registry
from ksmea.errors import SettingError, unknown

# Settings of the whole experiment, which cannot be an axis of it.
WHOLE = ("name", "repetitions", "output", "paper", "grid")
# Settings of how its jobs work, passed on to them; none of them changes a result.
WORKING = ("batches", "workers", "timeout", "memory", "journal", "share")


@dataclass(frozen=True)
class Experiment:
    """A plan and how its runs are dealt out."""

    plan: Plan
    output: Path
    batches: int
    working: tuple[str, ...]  # overrides for the jobs

    @classmethod
    def compose(cls, loader: ConfigLoader, master: DictConfig, arguments: list[str]) -> Experiment:
        choices = parse(arguments)
        fixed = [choice for choice in choices if len(choice.values) <= 1]
        swept = {choice.key: choice.values for choice in choices if len(choice.values) > 1}
        _check_axes(swept)
        composer = _Composer(loader, master, fixed)
        config = composer.composed({})
        _check_whole(config)
        grid = OmegaConf.to_container(config.grid)
        for block in grid:
            _check_axes(block)
        points = grid_points(grid, swept, {choice.key for choice in fixed})
        modules: dict[str, str] = {}
        cells = tuple(_cell(composer.at(point), point, modules) for point in points)
        versions = library_versions()
        plan = Plan(
            name=config.name,
            paper=config.paper,
            axes=_axes(points),
            command=tuple(arguments),
            commit=commit(),
            versions=versions,
            modules=modules,
            cells=cells,
            runs=all_runs(cells, config.repetitions, versions),
        )
        working = tuple(choice.override.input_line for choice in fixed if choice.key in WORKING)
        return cls(plan, Path(config.output).absolute(), config.batches, working)

    def prepare(self) -> list[list[str]]:
        """Write the plan; the overrides of each job that has work left."""
        write_plan(self.plan, self.output)
        finished = finished_keys(self.output)
        return [
            [f"output={_quoted(self.output)}", f"batch={batch}", *self.working]
            for batch in range(self.batches)
            if unfinished(self.plan.runs[batch :: self.batches], finished)
        ]


def job_of(config: DictConfig) -> Job:
    """The job that a job's configuration describes."""
    return Job(
        output=Path(config.output),
        batch=config.batch,
        batches=config.batches,
        workers=config.workers,
        timeout=config.timeout,
        memory=config.memory,
        journal=config.journal,
        share=tuple(Path(folder) for folder in config.share),
    )


def _quoted(path: Path) -> str:
    """A path as a value in Hydra's grammar."""
    return QuotedString(str(path), Quote.single).with_quotes()


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


def _check_axes(keys: Iterable[str]) -> None:
    for key in keys:
        if key in (*WHOLE, *WORKING, "batch", "experiment"):
            raise SettingError(f"{key}: expected one value for the whole experiment, got several; give one")


def _check_whole(config: DictConfig) -> None:
    known = [field.name for field in dataclasses.fields(BenchConfig)]
    for key in config:
        if key not in (*known, "hydra"):
            raise unknown("setting", str(key), [*known, "experiment"])
    if Path(config.name).name != config.name:
        raise SettingError(f"name: expected the name of a file, got '{config.name}'")
    if config.paper is not None and not (PAPER / f"{config.paper}.csv").is_file():
        raise unknown("table of the paper", config.paper, [path.stem for path in PAPER.glob("*.csv")])
    for key, least in (("repetitions", 1), ("workers", 1), ("batches", 1)):
        if config[key] is not None and config[key] < least:
            raise SettingError(f"{key}: expected at least {least}, got {config[key]}")
    for key in ("timeout", "memory"):
        if config[key] is not None and config[key] <= 0:
            raise SettingError(f"{key}: expected a number above 0, got {config[key]}")
    for folder in config.share:
        if not Path(folder).is_dir():
            raise SettingError(f"share: expected folders of results, found none at {folder}")


def _cell(config: DictConfig, point: dict[str, Any], modules: dict[str, str]) -> Cell:
    """The settings of one point, checked by making its plugins; what the method ignores is left out.

    The modules that it uses are added to `modules`.
    """
    for key, least in (("samples", 1), ("seed", 0)):
        if config[key] < least:
            raise SettingError(f"{key}: expected at least {least}, got {config[key]}")
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
    used = used_modules(settings)
    modules |= used
    place = {"samples": config.samples} | point
    return Cell(place, settings, config.seed, parameters, code_digest(used))


def _axes(points: list[dict[str, Any]]) -> tuple[str, ...]:
    """The keys of the grid, samples always first: the columns that tell a table's fields apart."""
    return tuple(dict.fromkeys(["samples", *(key for point in points for key in point)]))

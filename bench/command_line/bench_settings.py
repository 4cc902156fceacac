"""Settings of the bench itself, set by an experiment or the command line; fields as in a plugin."""

from __future__ import annotations

import dataclasses
from dataclasses import Field, dataclass
from functools import cache
from typing import Any

from ksmea.plugins.names import GROUPS
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class BenchConfig:
    """Settings of the bench itself; the six groups hold plugins, each by default the one named here."""

    name: str = setting("run", "of the experiment, its tables and its results folder")
    plugins: list[str] = setting(
        [], "Python files with plugins, named as their classes are in snake case: [my_optimizer.py]"
    )
    samples: int = setting(100, "initial samples of a surrogate", at_least=1)
    repetitions: int = setting(20, "seeds per field of a table", at_least=0)
    seed: int = setting(0, "of the whole experiment; every repetition and component draws its own from it", at_least=0)
    own_seeds: str | None = setting(
        None,
        "cells that differ in this draw other numbers: label (and axes of the measurement), instance (problem and measurement);"
        " null: all cells of a repetition meet the same noise",
        choices=("instance", "label"),
    )
    workers: int | None = setting(
        None,
        "processes; null: one per core. Where they are at least twice the runs, several share a diagnosis or a location, each"
        " with the whole memory",
        at_least=1,
    )
    timeout: float | None = setting(None, "s per run; null: none", above=0)
    memory: float | None = setting(None, "GB of address space per worker process; null: no limit", above=0)
    journal: bool = setting(
        False,
        "keep finished model evaluations, so that a killed run replays them; CRLBs are not tabled then (for expensive models)",
    )
    share: list[str] = setting([], "results folders whose finished runs of the same key are taken over")
    output: str = setting("results/${name}", "below the working directory")
    units: str = setting(
        "",
        "of vibrations, phases and speeds on pages and in texts: mil_pp,lag or um_0pk,lead,Hz;"
        " empty: as in the measurement's file",
    )
    batches: int = setting(
        1, "jobs that do the runs, each as many as it gets to (a cluster's launcher runs them side by side)", at_least=1
    )
    batch: int = setting(0, "which of them a job is; set by the launcher")
    wait: bool = setting(True, "false: return as soon as the jobs are submitted (hydra/launcher=submitit_slurm)")
    force: bool = setting(False, "true: plan more than 100 000 runs")
    label: str | None = setting(None, "name of a cell, if the grid has one")
    table: str | None = setting(None, "kind of table that is made (bench/reports); null: the study's own")
    paper: str | None = setting(None, "table of the paper to print next to the results")
    figures: list[str] = setting([], "further figures", choices=("updates", "response", "cost", "trace"))
    exact: float | None = setting(
        None, "per cent; count the runs that come so near to all true values, and their updates until then"
    )
    includes: list[str] = setting([], "experiments that make up this one; identical runs are done once")
    standard: dict[str, Any] = setting({}, "{setting of a plugin: value} where the plugin that is chosen has it")
    grid: list[dict[str, Any]] = setting(
        [], "blocks {setting or group: value or values}: products, their union is the experiment"
    )
    add: list[dict[str, Any]] = setting([], "further lines of the grid, for the command line")
    cross: list[dict[str, Any]] = setting(
        [], "blocks that every line of the grid is crossed with, so that a further line need not repeat them"
    )
    problem: Any = "three_disk"
    measurement: Any = "synthetic"
    surrogate: Any = "kriging"
    optimizer: Any = "de"
    method: Any = "ksmea"
    study: Any = "identify"


@cache
def bench_fields() -> dict[str, Field[Any]]:
    """The bench's own settings by name; the six groups of plugins are among them, as fields without help."""
    return {field.name: field for field in dataclasses.fields(BenchConfig)}


@cache
def default_plugins() -> dict[str, str]:
    """The plugin of each group that is taken where nothing is chosen."""
    return {group: str(bench_fields()[group].default) for group in GROUPS}

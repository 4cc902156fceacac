"""The plan: every run of an experiment with its settings, seeds and key. Pure, but for reading and writing the file.

A *cell* is one set of settings, a field of a table; a *run* is a cell with one repetition's seeds.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

SCHEMA = 1
PLAN_FILE = "plan.jsonl"

# Place of each component in the seed sequence [seed, repetition, place]. A component that several methods share
# draws the same numbers for all of them, so that they are compared in pairs; a place is never given to another.
SEED_PLACES = {"noise": 1, "design": 2, "surrogate": 3, "optimizer": 4}


@dataclass(frozen=True)
class ParameterFacts:
    """What tables need to know of an unknown; `truth` in SI."""

    name: str
    unit: str
    si_per_unit: float
    truth: float


@dataclass(frozen=True)
class Cell:
    """One set of settings: where it stands on the experiment's axes, and all that a run of it is computed from."""

    place: Mapping[str, Any]
    settings: Mapping[str, Any]
    seed: int
    parameters: tuple[ParameterFacts, ...]


@dataclass(frozen=True)
class Run:
    key: str
    cell: int
    repetition: int


@dataclass(frozen=True)
class Plan:
    name: str
    paper: str | None
    axes: tuple[str, ...]
    command: tuple[str, ...]
    code: str
    versions: Mapping[str, str]
    cells: tuple[Cell, ...]
    runs: tuple[Run, ...]

    def seeds(self, run: Run) -> dict[str, list[int]]:
        """Entropy of each component's `numpy.random.SeedSequence`."""
        return component_seeds(self.cells[run.cell].seed, run.repetition)


def component_seeds(seed: int, repetition: int) -> dict[str, list[int]]:
    return {component: [seed, repetition, place] for component, place in SEED_PLACES.items()}


def generator(entropy: list[int]) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(entropy))


def make_plan(
    name: str,
    paper: str | None,
    axes: tuple[str, ...],
    command: tuple[str, ...],
    cells: tuple[Cell, ...],
    repetitions: int,
    code: str,
    versions: Mapping[str, str],
) -> Plan:
    """All runs, repetition by repetition, so that a stopped experiment has seen every cell about equally often."""
    runs = tuple(
        Run(run_key(cell, repetition, code, versions), index, repetition)
        for repetition in range(repetitions)
        for index, cell in enumerate(cells)
    )
    return Plan(name, paper, axes, command, code, dict(versions), cells, runs)


def run_key(cell: Cell, repetition: int, code: str, versions: Mapping[str, str]) -> str:
    """Hash of all that a result depends on: settings, seeds, the code that computes it, numerical libraries."""
    content = {
        "settings": cell.settings,
        "seeds": component_seeds(cell.seed, repetition),
        "code": code,
        "versions": versions,
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def write_plan(plan: Plan, output: Path) -> None:
    """Write `plan.jsonl` in one move: a head, a line per cell, a line per run."""
    output.mkdir(parents=True, exist_ok=True)
    partial = output / f"{PLAN_FILE}.{os.getpid()}.tmp"
    partial.write_text("".join(json.dumps(line) + "\n" for line in _lines(plan)), encoding="utf-8")
    os.replace(partial, output / PLAN_FILE)


def _lines(plan: Plan) -> Iterator[dict[str, Any]]:
    head = {key: value for key, value in asdict(plan).items() if key not in ("cells", "runs")}
    yield {"schema": SCHEMA, "line": "plan", **head}
    for cell in plan.cells:
        yield {"line": "cell", **asdict(cell)}
    for run in plan.runs:
        yield {"line": "run", **asdict(run)}


def read_plan(output: Path) -> Plan:
    lines = [json.loads(line) for line in (output / PLAN_FILE).read_text(encoding="utf-8").splitlines()]
    kinds: dict[str, list[dict[str, Any]]] = {"plan": [], "cell": [], "run": []}
    for line in lines:
        kinds[line.pop("line")].append(line)
    head = kinds["plan"][0]
    head.pop("schema")
    cells = tuple(
        Cell(**{**cell, "parameters": tuple(ParameterFacts(**facts) for facts in cell["parameters"])})
        for cell in kinds["cell"]
    )
    return Plan(
        **{**head, "axes": tuple(head["axes"]), "command": tuple(head["command"])},
        cells=cells,
        runs=tuple(Run(**run) for run in kinds["run"]),
    )

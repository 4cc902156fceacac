"""The plan: every run of an experiment with its settings, seeds and key.

Pure, but for reading and writing the file.

A *cell* is one set of settings, a field of a table; a *run* is a cell with one repetition's seeds.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from bench.storage.files import replace_file
from ksmea.errors import SettingError, shortened, visible
from ksmea.plugins import registry
from ksmea.settings.regular_files import open_regular

SCHEMA = 2
PLAN_FILE = "plan.jsonl"
KEY = re.compile(r"[A-Za-z0-9_-]{1,64}")  # of a run: files are named by it
LONGEST_REASON = 200  # characters
LONGEST_NAME = 200  # bytes of an experiment's name; file systems take 255 with what is added to it

# Place of each component in the seed sequence [seed, repetition, place]. A component that several methods share
# draws the same numbers for all of them, so that they are compared in pairs; a place is never given to another.
SEED_PLACES = {"noise": 1, "design": 2, "surrogate": 3, "optimizer": 4, "hidden": 5, "diagnosis": 6}
GLOBAL_PLACE = 7  # of generators that a process shares; no part of a question, which has seed and repetition already


@dataclass(frozen=True)
class ParameterFacts:
    """Facts about an unknown for tables, SI: its true value (None: not known), its CRLB and its limits.

    The CRLB holds for data with this noise; None without noise or true values, or if it is infinite. Older plans have no
    limits.
    """

    name: str
    unit: str
    si_per_unit: float
    truth: float | None
    crlb: float | None = None
    lower: float | None = None
    upper: float | None = None


@dataclass(frozen=True)
class Cell:
    """One set of settings: its place on the experiment's axes, and all that its runs are computed from.

    `code` is the digest of the modules that take part. Without it a key would find results of other code.
    """

    place: Mapping[str, Any]
    settings: Mapping[str, Any]
    seed: int
    parameters: tuple[ParameterFacts, ...]
    code: str

    def chosen(self, group: str) -> str:
        """The name of the plugin that the settings choose in a group; `SettingError` if they choose none."""
        settings = self.settings.get(group)
        if settings is None:
            raise SettingError(f"plan: expected cells with a {group}, got none; give the experiment's command again")
        return str(settings["name"])


@dataclass(frozen=True)
class Run:
    """One planned run: a repetition of a cell.

    `question` is the hash of settings and seeds; `key` is the hash of the question, the code and the libraries'
    versions. A record with this question and another key is a stale answer to it.
    """

    key: str
    question: str
    cell: int
    repetition: int


@dataclass(frozen=True)
class ReportSettings:
    """Output made of the records: the kind of table, the paper's table next to it, and figures.

    `exact` is the error in per cent within which a run counts as exact (None: not counted).
    """

    table: str
    paper: str | None
    figures: tuple[str, ...]
    exact: float | None


@dataclass(frozen=True)
class Plan:
    name: str
    report: ReportSettings
    axes: tuple[str, ...]
    command: tuple[str, ...]
    commit: str
    versions: Mapping[str, str]
    platform: str  # kind of processor as far as rounding depends on it, where it was planned
    modules: Mapping[str, str]  # digests of all modules that take part in any of the runs
    cells: tuple[Cell, ...]
    runs: tuple[Run, ...]
    plugins: Mapping[str, str] = field(
        default_factory=dict
    )  # plain files of plugins by what chooses them: optimizer=mine
    notes: tuple[
        str, ...
    ] = ()  # what is to be told beside all tables, such as that parts of other code were put together

    @property
    def units(self) -> str:
        """Units for pages and texts, from the plan's command; '' for the units of the measurement's file."""
        said = [word.partition("=")[2].strip("'\"") for word in self.command if word.partition("=")[0] == "units"]
        return said[-1] if said else ""

    def seeds(self, run: Run) -> dict[str, list[int]]:
        """Entropy of each component's `numpy.random.SeedSequence`."""
        return component_seeds(self.cells[run.cell].seed, run.repetition)


def component_seeds(seed: int, repetition: int) -> dict[str, list[int]]:
    return {component: [seed, repetition, place] for component, place in SEED_PLACES.items()}


def own_seed(seed: int, data: Mapping[str, Any]) -> int:
    """The seed of a cell where an experiment gives cells with other data their own.

    Made of what says which data they are, so that it stays the same whatever other cells there are.
    """
    return int(_hash([seed, data])[:8], 16)


def global_entropy(seeds: Mapping[str, list[int]]) -> list[int]:
    """Entropy for generators that a process shares, of a run with these seeds.

    Its seed and repetition at their place.
    """
    seed_and_repetition = next(iter(seeds.values()), [0, 0, 0])[:2]
    return [*seed_and_repetition, GLOBAL_PLACE]


def generator(entropy: list[int]) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(entropy))


def all_runs(cells: tuple[Cell, ...], repetitions: int, versions: Mapping[str, str]) -> tuple[Run, ...]:
    """Repetition by repetition, so that a stopped experiment has seen every cell about equally often."""
    settings = [_hash(cell.settings) for cell in cells]
    answering = [answered_by(cell.code, versions) for cell in cells]
    runs = []
    for repetition in range(repetitions):
        for index, cell in enumerate(cells):
            question = _question(settings[index], cell.seed, repetition)
            runs.append(Run(key_of(question, answering[index]), question, index, repetition))
    return tuple(runs)


def question_of(settings: Mapping[str, Any], seed: int, repetition: int) -> str:
    """The hash of a cell's settings and of the seeds of one of its runs."""
    return _question(_hash(settings), seed, repetition)


def _question(settings: str, seed: int, repetition: int) -> str:
    return _hash([settings, component_seeds(seed, repetition)])


def answered_by(code: str, versions: Mapping[str, str]) -> str:
    """The digest of what answers the questions of a cell.

    Code of this digest and these versions of libraries.
    """
    return _hash([code, versions])


def key_of(question: str, answering: str) -> str:
    """The key of a question and of what answers it."""
    return _hash([question, answering])


def _hash(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def write_plan(plan: Plan, output: Path) -> None:
    """Write `plan.jsonl` in one move: a head with the number of runs, a line per cell, a line per run."""
    output.mkdir(parents=True, exist_ok=True)
    head, *lines = plan_lines(plan)
    head["n_run"] = len(plan.runs)
    replace_file(output / PLAN_FILE, "".join(json.dumps(line) + "\n" for line in (head, *lines)).encode())


def plan_lines(plan: Plan) -> Iterator[dict[str, Any]]:
    head = {key: value for key, value in vars(plan).items() if key not in ("cells", "runs")}
    yield {"schema": SCHEMA, "line": "plan", **head, "report": asdict(plan.report)}
    for cell in plan.cells:
        yield {"line": "cell", **asdict(cell)}
    for run in plan.runs:
        yield {"line": "run", **vars(run)}


def read_plan(output: Path) -> Plan:
    path = output / PLAN_FILE
    if not path.exists():
        raise SettingError(
            f"{output}: expected the results of an experiment, found no {PLAN_FILE}; run the experiment first"
        )
    try:
        with open_regular(path) as file:
            return plan_from_lines(json.loads(line.decode()) for line in file)
    except SettingError:  # no regular file
        raise
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        reason = shortened(f"{type(error).__name__}: {error}", LONGEST_REASON)
        raise SettingError(
            f"{path}: expected a plan of schema {SCHEMA}, could not read it ({reason});"
            " give the experiment's command again, it writes the plan anew and keeps the records"
        ) from error


def plan_from_lines(lines: Iterable[dict[str, Any]]) -> Plan:
    """The plan that `plan_lines` has written.

    It has as many of its runs as there are lines of, unless the head has their number. `ValueError` if a field is missing,
    has another type, or does not fit the others.
    """
    lines_by_type: dict[str, list[dict[str, Any]]] = {"plan": [], "cell": [], "run": []}
    for line in lines:
        lines_by_type[line.pop("line")].append(line)
    (head,), cells, runs = lines_by_type["plan"], lines_by_type["cell"], lines_by_type["run"]
    if head.pop("schema") != SCHEMA:
        raise ValueError("the schema is another")
    if (n_run := head.pop("n_run", len(runs))) != len(runs):
        raise ValueError(f"{n_run} runs are planned, and {len(runs)} lines are of runs")
    cells = [{**cell, "parameters": [_facts(facts) for facts in cell["parameters"]]} for cell in cells]
    plan = msgspec.convert({**head, "cells": cells, "runs": runs}, Plan)
    _check_names(plan)
    for number, cell in enumerate(plan.cells):
        _check_cell(cell, f"cell {number}")
    for run in plan.runs:
        if not (0 <= run.cell < len(plan.cells) and run.repetition >= 0 and KEY.fullmatch(run.key)):
            raise ValueError(f"a run is of no cell, or has no key that can name a file: {run.key}")
    _check_questions(plan)
    return plan


def _check_questions(plan: Plan) -> None:
    """Raise `ValueError` if a run does not ask what its cell asks.

    Lines are then missing, doubled or in another order, or settings have been edited.
    """
    settings = [_hash(cell.settings) for cell in plan.cells]
    for run in plan.runs:
        if run.question != _question(settings[run.cell], plan.cells[run.cell].seed, run.repetition):
            raise ValueError(f"run {run.key} is not of its cell")


def _check_names(plan: Plan) -> None:
    """Raise `ValueError` if the plan's name cannot be a file name, or an axis occurs twice."""
    if not is_file_name(plan.name):
        raise ValueError(f"not the name of a file: {plan.name}")
    if len(set(plan.axes)) < len(plan.axes):
        raise ValueError("an axis stands twice")


def is_file_name(name: str) -> bool:
    """Whether an experiment's name can name its files."""
    can_be = name not in ("", ".", "..") and Path(name).name == name and visible(name) == name
    return can_be and len(name.encode()) <= LONGEST_NAME


def _check_cell(cell: Cell, where: str) -> None:
    for group in registry.GROUPS:
        settings = cell.settings.get(group)
        if settings is not None and not (isinstance(settings, dict) and isinstance(settings.get("name"), str)):
            raise ValueError(f"{where}: {group} is not a mapping with a name")
    parts = cell.settings.get("parts", [])
    if not isinstance(parts, list) or not all(isinstance(part, str) for part in parts):
        raise ValueError(f"{where}: its parts are no list of names")
    level = (cell.settings.get("study") or {}).get("level", 0.95)
    if isinstance(level, bool) or not isinstance(level, (int, float)) or not 0 < level < 1:
        raise ValueError(f"{where}: the level of its intervals is not between 0 and 1")
    for axis in ("label", "samples"):
        if isinstance(cell.place.get(axis), (list, dict)):
            raise ValueError(f"{where}: {axis} is not one value")  # noqa: TRY004 – one class for all of a plan
    if cell.seed < 0:
        raise ValueError(f"{where}: the seed is below 0")
    names = [facts.name for facts in cell.parameters]
    if len(set(names)) < len(names) or not all(names):
        raise ValueError(f"{where}: its parameters have no names of their own")
    for facts in cell.parameters:
        numbers = facts.si_per_unit, facts.truth, facts.crlb, facts.lower, facts.upper
        known = [value for value in numbers if value is not None]
        if not all(map(math.isfinite, known)) or facts.si_per_unit <= 0:
            raise ValueError(f"{where}: a number of {facts.name} is not finite, or its unit is not above 0")


def _facts(line: Mapping[str, Any]) -> dict[str, Any]:
    """Facts of an unknown as a plan of any version has them: `crlb` was `bound`."""
    return {"crlb" if name == "bound" else name: value for name, value in line.items()}

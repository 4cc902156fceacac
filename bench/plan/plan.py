"""The plan: every run of an experiment with its settings, seeds and key. Pure, but for reading and writing the file.

A *cell* is one set of settings, a field of a table; a *run* is a cell with one repetition's seeds.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.storage.files import replace_file
from ksmea.errors import SettingError

SCHEMA = 2
PLAN_FILE = "plan.jsonl"

# Place of each component in the seed sequence [seed, repetition, place]. A component that several methods share
# draws the same numbers for all of them, so that they are compared in pairs; a place is never given to another.
SEED_PLACES = {"noise": 1, "design": 2, "surrogate": 3, "optimizer": 4, "hidden": 5, "diagnosis": 6}
GLOBAL_PLACE = 7  # of generators that a process shares; no part of a question, which has seed and repetition already


@dataclass(frozen=True)
class ParameterFacts:
    """What tables need to know of an unknown, SI: its true value (None: not known) and its CRLB for data with this
    noise (None: without noise or true values, or infinite)."""

    name: str
    unit: str
    si_per_unit: float
    truth: float | None
    crlb: float | None = None


@dataclass(frozen=True)
class Cell:
    """One set of settings: where it stands on the experiment's axes, and all that a run of it is computed from.

    `code` is the digest of the modules that take part, without which a key would find results of other code.
    """

    place: Mapping[str, Any]
    settings: Mapping[str, Any]
    seed: int
    parameters: tuple[ParameterFacts, ...]
    code: str


@dataclass(frozen=True)
class Run:
    """`question` is the hash of settings and seeds; `key` that of the question, the code and the libraries' versions.

    A record of the same question with another key is a stale answer to it.
    """

    key: str
    question: str
    cell: int
    repetition: int


@dataclass(frozen=True)
class ReportSettings:
    """What is made of the records: the kind of table, the paper's table beside it, figures, and the error in per cent
    within which a run counts as exact (None: not asked)."""

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
    platform: str  # kind of processor as far as rounding depends on it
    modules: Mapping[str, str]  # digests of all modules that take part in any of the runs
    cells: tuple[Cell, ...]
    runs: tuple[Run, ...]

    def seeds(self, run: Run) -> dict[str, list[int]]:
        """Entropy of each component's `numpy.random.SeedSequence`."""
        return component_seeds(self.cells[run.cell].seed, run.repetition)


def component_seeds(seed: int, repetition: int) -> dict[str, list[int]]:
    return {component: [seed, repetition, place] for component, place in SEED_PLACES.items()}


def global_entropy(seeds: Mapping[str, list[int]]) -> list[int]:
    """Entropy for generators that a process shares, of a run with these seeds: its seed and repetition at their place."""
    seed_and_repetition = next(iter(seeds.values()), [0, 0, 0])[:2]
    return [*seed_and_repetition, GLOBAL_PLACE]


def generator(entropy: list[int]) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(entropy))


def all_runs(cells: tuple[Cell, ...], repetitions: int, versions: Mapping[str, str]) -> tuple[Run, ...]:
    """Repetition by repetition, so that a stopped experiment has seen every cell about equally often."""
    settings = [_hash(cell.settings) for cell in cells]
    runs = []
    for repetition in range(repetitions):
        for index, cell in enumerate(cells):
            question = _hash([settings[index], component_seeds(cell.seed, repetition)])
            runs.append(Run(key_of(question, cell.code, versions), question, index, repetition))
    return tuple(runs)


def key_of(question: str, code: str, versions: Mapping[str, str]) -> str:
    """The key of a question that is answered by code of this digest and these versions of libraries."""
    return _hash([question, _hash([code, versions])])


def _hash(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def write_plan(plan: Plan, output: Path) -> None:
    """Write `plan.jsonl` in one move: a head, a line per cell, a line per run."""
    output.mkdir(parents=True, exist_ok=True)
    replace_file(output / PLAN_FILE, "".join(json.dumps(line) + "\n" for line in plan_lines(plan)).encode())


def plan_lines(plan: Plan) -> Iterator[dict[str, Any]]:
    head = {key: value for key, value in vars(plan).items() if key not in ("cells", "runs")}
    yield {"schema": SCHEMA, "line": "plan", **head, "report": asdict(plan.report)}
    for cell in plan.cells:
        yield {"line": "cell", **asdict(cell)}
    for run in plan.runs:
        yield {"line": "run", **vars(run)}


def read_plan(output: Path) -> Plan:
    path = output / PLAN_FILE
    if not path.is_file():
        raise SettingError(
            f"{output}: expected the results of an experiment, found no {PLAN_FILE}; run the experiment first"
        )
    try:
        with path.open(encoding="utf-8") as file:
            return plan_from_lines(map(json.loads, file))
    except (ValueError, KeyError, TypeError) as error:
        raise SettingError(
            f"{path}: expected a plan of schema {SCHEMA}, could not read it ({type(error).__name__}: {error});"
            " give the experiment's command again, it writes the plan anew and keeps the records"
        ) from error


def plan_from_lines(lines: Iterable[dict[str, Any]]) -> Plan:
    """The plan that `plan_lines` has written, with as many of its runs as there are lines of."""
    kinds: dict[str, list[dict[str, Any]]] = {"plan": [], "cell": [], "run": []}
    for line in lines:
        kinds[line.pop("line")].append(line)
    (head,), cells, runs = kinds["plan"], kinds["cell"], kinds["run"]
    if head.pop("schema") != SCHEMA:
        raise ValueError("the schema is another")
    return Plan(
        **{
            **head,
            "axes": tuple(head["axes"]),
            "command": tuple(head["command"]),
            "report": ReportSettings(**{**head["report"], "figures": tuple(head["report"]["figures"])}),
        },
        cells=tuple(Cell(**{**cell, "parameters": tuple(map(_facts, cell["parameters"]))}) for cell in cells),
        runs=tuple(Run(**run) for run in runs),
    )


def _facts(line: Mapping[str, Any]) -> ParameterFacts:
    """Facts of an unknown as a plan of any version has them: `crlb` was `bound`."""
    return ParameterFacts(**{"crlb" if name == "bound" else name: value for name, value in line.items()})

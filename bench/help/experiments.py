"""Help on an experiment from its file.

It states the question, the settings, the grid, the cost and the files of the experiment.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from bench.command_line.bench_settings import bench_fields, default_plugins
from bench.command_line.config_files import content
from bench.command_line.grid import Block, grid_axes, grid_blocks, grid_points, n_point
from bench.storage.own_files import REFERENCE

OVERRIDE = re.compile(r"override /(\w+)")
APART = ("defaults", "name", "grid", "add", "cross", "includes", "output")  # are told otherwise
MOST_CELLS = 10_000
MOST_AXES = 12  # values of an axis that are listed
OF_FIGURES = {
    "updates": "{name}_updates.png",
    "response": "{name}_response.png",
    "cost": "{name}_cost.csv and .png",
    "trace": "{name}_trace.csv and .png, {name}_stages.csv",
}


def experiment_text(name: str, path: Path) -> str:
    """An experiment's page."""
    said = content(path)
    text = path.read_text(encoding="utf-8-sig")
    lines = [f"+experiment={name}", *(f"  {line}" for line in _remark(text)), ""]
    lines.append(f"  run it:    python -m bench +experiment={name}")
    if included := said.get("includes"):
        return "\n".join(
            [*lines, f"  includes:  {', '.join(included)} (each in a folder of its own below results/{name})"]
        )
    lines.append(f"  plugins:   {' '.join(f'{group}={plugin}' for group, plugin in _plugins(said).items())}")
    if settings := [*_settings({key: value for key, value in said.items() if key not in APART})]:
        lines.append(f"  settings:  {' '.join(settings)}")
    lines += [f"  grid:      {line}" for line in _grid(said)]
    lines.append(f"  cost:      {_cost(name, said)}")
    lines.append(f"  files:     {_files(name, said)}")
    return "\n".join(lines)


def _remark(text: str) -> Iterator[str]:
    """Comment at the beginning of the file."""
    for line in text.splitlines():
        if not line.startswith("#"):
            return
        if not line.startswith("# @package"):
            yield line.removeprefix("#").removeprefix(" ")


def _plugins(said: Mapping[str, Any]) -> dict[str, str]:
    """The plugins where the grid names none."""
    chosen = {**default_plugins()}
    for entry in said.get("defaults", ()):
        for key, value in entry.items() if isinstance(entry, dict) else ():
            if found := OVERRIDE.fullmatch(key):
                chosen[found[1]] = str(value)
    return chosen


def _settings(said: Mapping[str, Any], above: str = "") -> Iterator[str]:
    """Settings of the file, as arguments of a command line."""
    for key, value in said.items():
        if isinstance(value, dict) and key != "standard":
            yield from _settings(value, f"{above}{key}.")
        else:
            yield f"{above}{key}={_word(value)}"


def _word(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_word(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return f"[{','.join(map(_word, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return "null" if value is None else str(value)


def _blocks(said: Mapping[str, Any]) -> list[Block]:
    return grid_blocks(said.get("grid", ()), said.get("add", ()), said.get("cross", ()))


def _n_cell(said: Mapping[str, Any]) -> int:
    """Cells of the grid, each once unless there are too many to look at."""
    n = n_point(blocks := _blocks(said), {}, set())
    return n if n > MOST_CELLS else len(grid_points(blocks, {}, set()))


def _grid(said: Mapping[str, Any]) -> Iterator[str]:
    """The axes of the grid, each with its values."""
    values: dict[str, list[str]] = {}
    for axes in grid_axes(_blocks(said), {}, set()):
        for key, each in axes.items():
            values.setdefault(key, []).extend(map(_word, each))
    for key, listed in ((key, list(dict.fromkeys(words))) for key, words in values.items()):
        more = f" … ({len(listed)} values)" if len(listed) > MOST_AXES else ""
        yield f"{key}: {', '.join(listed[:MOST_AXES])}{more}"


def _cost(name: str, said: Mapping[str, Any]) -> str:
    """Number of runs, and the time that the reference's runs took."""
    if said.get("table") == "settings":
        return "nothing is run"
    n_cell = _n_cell(said)
    repetitions = said.get("repetitions", bench_fields()["repetitions"].default)
    if not isinstance(repetitions, int):
        return f"{_counted(n_cell, 'cell')}, repetitions: {_word(repetitions)}"
    runs = (
        f"{_counted(n_cell * repetitions, 'run')} ({_counted(n_cell, 'cell')} × {_counted(repetitions, 'repetition')})"
    )
    measured = _measured(REFERENCE / f"{name}.runs.csv")
    return f"{runs}{f'; {measured}' if measured else ''}"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _measured(path: Path) -> str:
    """Time that the reference's runs took on one core, as text; '' if it was not recorded."""
    if not path.is_file():
        return ""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    column = next((each for each in ("time", "seconds") if rows and each in rows[0]), None)
    seconds = sum(float(row[column] or 0) for row in rows) if column else 0.0
    if not seconds:
        return ""
    shown = (
        f"{seconds:.0f} s"
        if seconds < 120
        else f"{seconds / 60:.0f} min"
        if seconds < 7200
        else f"{seconds / 3600:.1f} h"
    )
    return f"the {len(rows)} runs of its reference took {shown} of one core"


def _files(name: str, said: Mapping[str, Any]) -> str:
    figures = [OF_FIGURES[figure].format(name=name) for figure in said.get("figures", ()) if figure in OF_FIGURES]
    made = [f"{name}.csv, {name}.png", *figures, "runs.csv, plan.jsonl, records/"]
    report = f", and what report={said['table']} makes" if said.get("table") else ""
    return f"results/{said.get('name', name)}/: {', '.join(made)}{report}"

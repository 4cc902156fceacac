"""Plans of one experiment that was done in several places, as one plan.

Cells at one place on the axes are one cell, and must have equal settings. An axis that some plans lack is filled in
from the settings; if plans have different seeds or plugins, these become an axis. Of a run that several plans have, the
first one with a result is kept. Its key stays, so that it shows if other code or libraries than the first plan's
computed it.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.plan.outside import FILE
from bench.plan.plan import Cell, ParameterFacts, Plan, Run
from ksmea.errors import SettingError, shortened
from ksmea.plugins import registry

SEED = "seed"  # the axis of cells that differ by it
ROUNDING = 1e-9  # relative, of true values that two machines compute
LONGEST_LIST = 300  # characters of what differs


@dataclass(frozen=True)
class Part:
    """A folder of results, its plan, and the keys of its runs that have a result."""

    folder: Path
    plan: Plan
    finished: AbstractSet[str]


def merged_plan(parts: Sequence[Part]) -> Plan:
    """One plan of all cells, in the order of the parts, and runs; `SettingError` if experiments differ."""
    first = parts[0]
    for part in parts[1:]:
        _require_same_experiment(first, part)
    axes = _axes(parts)
    cells, runs = _cells_and_runs(parts, axes)
    plans = [part.plan for part in parts]
    figures = dict.fromkeys(figure for plan in plans for figure in plan.report.figures)
    return dataclasses.replace(
        first.plan,
        report=dataclasses.replace(first.plan.report, figures=tuple(figures)),
        axes=axes,
        command=("merge", *(part.folder.name for part in parts)),
        commit=", ".join(dict.fromkeys(commit for plan in plans for commit in plan.commit.split(", "))),
        modules={name: digest for plan in reversed(plans) for name, digest in plan.modules.items()},
        plugins={word: path for plan in reversed(plans) for word, path in plan.plugins.items()},
        cells=cells,
        runs=runs,
        notes=tuple(dict.fromkeys([*(note for plan in plans for note in plan.notes), *_mixture(plans)])),
    )


def _cells_and_runs(parts: Sequence[Part], axes: tuple[str, ...]) -> tuple[tuple[Cell, ...], tuple[Run, ...]]:
    """Each cell once, in the order of the parts, and its runs, repetition by repetition."""
    finished = {key for part in parts for key in part.finished}
    cells: dict[tuple[str, int], tuple[int, Cell, Path]] = {}  # number, cell and folder by place
    runs: dict[tuple[int, int], Run] = {}  # by repetition and cell
    for part in parts:
        met: Counter[str] = Counter()  # a plan may have a place twice
        numbers = []
        for cell in part.plan.cells:
            placed = dataclasses.replace(cell, place={axis: _at(cell, axis) for axis in axes})
            place = json.dumps(placed.place)
            number, known, folder = cells.setdefault((place, met[place]), (len(cells), placed, part.folder))
            _require_same_cell(known, folder, placed, part.folder)
            met[place] += 1
            numbers.append(number)
        for run in part.plan.runs:
            here = run.repetition, numbers[run.cell]
            if here not in runs or (runs[here].key not in finished and run.key in finished):
                runs[here] = dataclasses.replace(run, cell=numbers[run.cell])
    return tuple(cell for _, cell, _ in cells.values()), tuple(runs[here] for here in sorted(runs))


def _axes(parts: Sequence[Part]) -> tuple[str, ...]:
    """All axes of the parts, and further ones that distinguish their cells.

    These are the plugin groups in which parts differ, if no axis is called `label`, and the seed if one place has
    several.
    """
    axes = dict.fromkeys(axis for part in parts for axis in part.plan.axes)
    differing = [
        axis
        for axis in ([] if "label" in axes else registry.GROUPS)
        if len({frozenset(str(_at(cell, axis)) for cell in each.plan.cells) for each in parts}) > 1
    ]
    found = tuple(dict.fromkeys([*axes, *differing]))
    seeds: dict[str, set[int]] = {}
    for cell in (cell for part in parts for cell in part.plan.cells):
        seeds.setdefault(json.dumps([_at(cell, axis) for axis in found]), set()).add(cell.seed)
    has_several = any(len(each) > 1 for each in seeds.values())
    return (*found, SEED) if has_several and SEED not in found else found


def _at(cell: Cell, axis: str) -> Any:
    """Value of a cell on an axis such as `optimizer` or `optimizer.population`, its own or another plan's."""
    if axis in cell.place:
        return cell.place[axis]
    found: Any = {**cell.settings, SEED: cell.seed}
    for name in axis.split("."):
        found = found.get(name) if isinstance(found, Mapping) else None
    return found.get("name") if isinstance(found, Mapping) else found


def _require_same_experiment(first: Part, other: Part) -> None:
    for what, one, two in zip(("name", "study", "table"), _experiment(first.plan), _experiment(other.plan)):
        if one != two:
            raise SettingError(
                f"merge: expected parts of one experiment, got {what}={one} in {first.folder} and {what}={two} in"
                f" {other.folder}; merge results of one {what}"
            )
    for word in first.plan.plugins.keys() & other.plan.plugins.keys():
        if _file_digest(first.plan, word) != _file_digest(other.plan, word):
            raise SettingError(
                f"merge: expected one file of {word}, got {first.plan.plugins[word]} in {first.folder} and another content"
                f" of {other.plan.plugins[word]} in {other.folder}; rename one of the plugins and do its runs again"
            )


def _experiment(plan: Plan) -> tuple[str, str, str]:
    studies = sorted({(cell.settings.get("study") or {"name": "identify"})["name"] for cell in plan.cells})
    return plan.name, "/".join(studies), plan.report.table


def _file_digest(plan: Plan, word: str) -> str | None:
    return plan.modules.get(FILE + Path(plan.plugins[word]).name)


def _require_same_cell(known: Cell, folder: Path, cell: Cell, other: Path) -> None:
    """Raise `SettingError` if two cells of one place differ in settings or unknowns."""
    one, two = dict(_flat(known.settings)), dict(_flat(cell.settings))
    differing = sorted(name for name in {**one, **two} if one.get(name) != two.get(name))
    place = shortened(", ".join(f"{axis}={value}" for axis, value in cell.place.items()), LONGEST_LIST)
    if differing:
        name = differing[0]
        raise SettingError(
            f"merge: expected the same settings at {place}, got {name}={one.get(name)} in {folder} and"
            f" {name}={two.get(name)} in {other}; do one of them again, or give it a label of its own"
        )
    if len(known.parameters) != len(cell.parameters) or not all(map(_are_alike, known.parameters, cell.parameters)):
        raise SettingError(
            f"merge: expected the same unknowns with the same true values at {place}, got others in {folder} than in"
            f" {other}: their problems have different code; do one of them again"
        )


def _flat(settings: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield before + name, value


def _are_alike(one: ParameterFacts, two: ParameterFacts) -> bool:
    """Whether two unknowns are alike; the CRLB may differ by rounding."""
    if one.truth is None or two.truth is None:
        return one.name == two.name and one.truth == two.truth
    return one.name == two.name and math.isclose(one.truth, two.truth, rel_tol=ROUNDING)


def _mixture(plans: Sequence[Plan]) -> list[str]:
    """One line where the plans were made with other code or libraries; none if they were not."""
    modules = [name for name in _union(plan.modules for plan in plans) if len(_values(name, "modules", plans)) > 1]
    versions = {name: _values(name, "versions", plans) for name in _union(plan.versions for plan in plans)}
    libraries = [f"{name} {' and '.join(each)}" for name, each in versions.items() if len(each) > 1]
    if not modules and not libraries:
        return []
    commits = ", ".join(dict.fromkeys(plan.commit for plan in plans))
    differing = shortened(", ".join([*libraries, *modules]), LONGEST_LIST)
    return [f"runs were computed by different code or libraries (commits {commits}), which differ in {differing}"]


def _union(mappings: Iterable[Mapping[str, str]]) -> list[str]:
    return list(dict.fromkeys(name for mapping in mappings for name in mapping))


def _values(name: str, of: str, plans: Sequence[Plan]) -> list[str]:
    """The different values that plans have of a module or library, in their order."""
    return list(dict.fromkeys(getattr(plan, of)[name] for plan in plans if name in getattr(plan, of)))

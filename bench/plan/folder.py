"""A folder of results belongs to one experiment, one measurement and one problem.

Another one is refused, not written over it.
"""

from __future__ import annotations

import glob
import re
import unicodedata
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path
from typing import Any

from bench.command_line.overrides import path_word
from bench.plan.plan import PLAN_FILE, Cell, Plan, read_plan
from bench.plan.setup import FINGERPRINTS
from ksmea.errors import SettingError, shortened

MOST_BYTES = 200  # of a folder's part; file systems take 255 in all
LONGEST_LIST = 200  # characters of the names of files that an error shows
MOST_PARTS = 6  # of the name of a default folder
MOST_TRIED = 100  # names of a folder
PROBLEM, MEASUREMENT = "problem", "measurement"
FILE = {PROBLEM: "file", MEASUREMENT: "path"}  # the setting that names it


def require_own_folder(plan: Plan, output: Path) -> None:
    """Raise `SettingError` if a folder holds another experiment, measurement or problem.

    Experiments differ by name or study. An experiment with other settings is accepted: its finished runs are kept.
    """
    if (found := _other_plan(plan, output)) is not None:
        raise SettingError(
            f"{output}: expected a folder of {_described(plan)}, got one with results of {_described(found)}, which stay as"
            f" they are; give {path_word('output', _free(plan, found, output))} with this command"
        )


def own_folder(plan: Plan, output: Path) -> Path:
    """Default folder of a plan, or a neighbour named after the difference if it holds other results.

    Differences are of problem, measurement or study: results/run, results/run_pump, results/run_pump_diagnose. No
    command is rejected because of an earlier one.
    """
    folder = output
    for _ in range(MOST_PARTS):
        found = _other_plan(plan, folder)
        if found is None:
            return folder
        folder = folder.with_name(f"{folder.name}_{folder_part(_difference(plan, found))}")
    require_own_folder(plan, output)
    return output


def _other_plan(plan: Plan, output: Path) -> Plan | None:
    """The plan that a folder holds if it is another one by experiment, study, measurement or problem."""
    found = planned_before(output)
    if found is None or not (found.cells and plan.cells):
        return None
    is_same = found.name == plan.name and _studies(found) & _studies(plan)
    return None if is_same and _is_same_file(found, plan) and _is_same_problem(found, plan) else found


def _difference(plan: Plan, found: Plan) -> str:
    """Name part for what differs in a plan: its problem, its measurement or its name, else its studies."""
    if not _is_same_problem(found, plan):
        return Path(_files(plan, PROBLEM)[0]).stem if _files(plan, PROBLEM) else _names(plan)[0]
    if not _is_same_file(found, plan):
        return Path(_files(plan, MEASUREMENT)[0]).stem if _files(plan, MEASUREMENT) else "synthetic"
    return plan.name if plan.name != found.name else "_".join(sorted(_studies(plan)))


def planned_before(output: Path) -> Plan | None:
    """The plan that a folder holds; None without one that can be read, which is written anew."""
    if not (output / PLAN_FILE).is_file():
        return None
    try:
        return read_plan(output)
    except SettingError:  # of an older schema
        return None


def _studies(plan: Plan) -> set[str]:
    """Records older than studies name none."""
    return {(cell.settings.get("study") or {"name": "identify"})["name"] for cell in plan.cells}


def _is_same_file(one: Plan, other: Plan) -> bool:
    """Whether they share a measured file, or one of them has none."""
    shared = _identities(one, MEASUREMENT) & _identities(other, MEASUREMENT)
    return bool(shared) or not (_files(one, MEASUREMENT) and _files(other, MEASUREMENT))


def _is_same_problem(one: Plan, other: Plan) -> bool:
    """Whether two plans share a problem, or one of them has none.

    A problem is compared by its file if it has one, else by its name.
    """
    shared = _identities(one, PROBLEM) & _identities(other, PROBLEM)
    return bool(shared) or not (_names(one) and _names(other))


def _identities(plan: Plan, group: str) -> set[str]:
    """Files by location and content; plugins without a file by name.

    Moving a file keeps its identity, and so does correcting it, but not both at once.
    """
    contents = {cell.settings.get(FINGERPRINTS[group]) for cell in plan.cells}
    places = {str(Path(path).expanduser().absolute()) for path in _files(plan, group)}
    without = {
        cell.settings[group]["name"] for cell in plan.cells if cell.settings.get(group) and not _file(cell, group)
    }
    return {each for each in contents if each} | places | (without if group == PROBLEM else set())


def _file(cell: Cell, group: str) -> str:
    """The name of a file as it was given; '' without one."""
    return str((cell.settings.get(group) or {}).get(FILE[group]) or "")


def _files(plan: Plan, group: str) -> list[str]:
    return _each(plan, lambda cell: _file(cell, group))


def _names(plan: Plan) -> list[str]:
    """Problems by name, with the file of one that has it."""
    return _each(
        plan,
        lambda cell: " ".join(filter(None, [(cell.settings.get(PROBLEM) or {}).get("name"), _file(cell, PROBLEM)])),
    )


def _each(plan: Plan, name_of: Callable[[Cell], str]) -> list[str]:
    return [each for each in dict.fromkeys(map(name_of, plan.cells)) if each]


def _described(plan: Plan) -> str:
    """For example 'identify (study=identify, problem=rotor pump.yaml, run_up.csv)'."""
    problems = [f"problem={name}" for name in _names(plan)]
    said = ", ".join(["study=" + "/".join(sorted(_studies(plan))), *problems, *_files(plan, MEASUREMENT)])
    return f"{plan.name} ({shortened(said, LONGEST_LIST)})"


def _free(plan: Plan, found: Plan, output: Path) -> str:
    """A folder that is not there yet, named after what is other in the plan.

    Its problem, its measurement or its name.
    """
    name = f"{output.name}_{folder_part(_difference(plan, found))}"
    places = (output.with_name(each) for each in (name, *(f"{name}_{number}" for number in range(2, MOST_TRIED))))
    free = next((each for each in places if not each.exists()), output.with_name(f"{name}_{MOST_TRIED}"))
    return str(free.relative_to(Path.cwd()) if free.is_relative_to(Path.cwd()) else free)


def folder_part(name: str) -> str:
    """A name as a part of a folder's: letters of any script, digits, points and hyphens.

    All else is an underscore.

    >>> folder_part("<b>Ümlaut (2)")
    '_b_Ümlaut_2_'
    """
    part = re.sub(r"[^\w.-]+", "_", unicodedata.normalize("NFC", name))
    return part.encode()[:MOST_BYTES].decode(errors="ignore")


def of_file(measurement: Any) -> str:
    """Folder name suffix of a measured file; '' without a file.

    The suffix is '_run_up' for runs/run_up.csv and '_runs' for runs/*.csv.
    """
    path = (measurement or {}).get("path") or ""
    folder = Path(*takewhile(lambda part: not glob.has_magic(part), Path(path).parts))
    name = folder.name if glob.has_magic(path) else Path(path).stem
    return f"_{folder_part(name)}" if name else ""

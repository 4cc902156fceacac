"""A folder of results belongs to one experiment and one measurement: another one is refused, not written over it."""

from __future__ import annotations

from pathlib import Path

from bench.plan.plan import PLAN_FILE, Plan, read_plan
from ksmea.errors import SettingError, shortened

LONGEST_LIST = 200  # characters of the names of files that an error shows
MEASUREMENT_FILE = "measurement_fingerprint"  # where settings keep the hash of a measured file


def require_own_folder(plan: Plan, output: Path) -> None:
    """Raise `SettingError` where a folder holds another experiment (by name or study) or another measurement. The same
    experiment with other settings is welcome: its finished runs are kept."""
    if not (output / PLAN_FILE).is_file():
        return
    try:
        found = read_plan(output)
    except SettingError:  # of an older schema: it is written anew
        return
    is_same = found.name == plan.name and _studies(found) & _studies(plan)
    is_same_file = bool(_measured(found) & _measured(plan)) or not (_files(found) and _files(plan))
    if found.cells and plan.cells and not (is_same and is_same_file):
        raise SettingError(
            f"{output}: expected a folder of {_described(plan)}, got one with results of {_described(found)};"
            " choose another output=DIR"
        )


def _studies(plan: Plan) -> set[str]:
    """Records older than studies name none."""
    return {(cell.settings.get("study") or {"name": "identify"})["name"] for cell in plan.cells}


def _files(plan: Plan) -> list[str]:
    """Names of the files that were measured, as they were given."""
    paths = [cell.settings["measurement"].get("path") for cell in plan.cells if cell.settings.get("measurement")]
    return list(dict.fromkeys(path for path in paths if path))


def _measured(plan: Plan) -> set[str]:
    """The files themselves: where they lie, and what they hold, so that neither moving nor correcting one makes another."""
    contents = {cell.settings.get(MEASUREMENT_FILE) for cell in plan.cells}
    return {str(Path(path).expanduser().absolute()) for path in _files(plan)} | {each for each in contents if each}


def _described(plan: Plan) -> str:
    """For example 'identify (study=identify, run_up.csv)'."""
    return f"{plan.name} ({shortened(', '.join(['study=' + '/'.join(sorted(_studies(plan))), *_files(plan)]), LONGEST_LIST)})"

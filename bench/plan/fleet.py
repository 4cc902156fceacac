"""Fleet: `measurement.path=fleet/*.csv` measures a file of each machine.

Each file is a cell of the experiment.

A pattern is one of the shell (`*`, `?`, `[ab]`, `**` for all folders below). Where `problem.file` is a pattern too, each machine
has a rotor of its own: the file that fits it and has the stem of the measurement, `fleet/*.yaml` next to `fleet/*.csv`.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

from bench.command_line.overrides import Choice
from bench.plan.folder import LONGEST_LIST
from bench.plan.plan import Plan
from ksmea.errors import SettingError, shortened

MEASURED, ROTOR = "measurement.path", "problem.file"


def fleet_axes(choices: Iterable[Choice]) -> dict[str, tuple[str, ...]]:
    """Files of a fleet, as named on the command line, and each file's rotor if a pattern gives the rotors.

    Files found by a pattern are sorted by name. Empty without a pattern, if fewer than two files are given.

    Raises `SettingError` if a pattern finds no file, or one of several files does not exist.
    """
    given = {choice.key: choice.values for choice in choices if choice.key in (MEASURED, ROTOR)}
    paths = [str(path) for path in given.get(MEASURED, ())]
    if not any(map(_is_pattern, paths)) and len(paths) < 2:
        return {}
    files = tuple(dict.fromkeys(file for path in paths for file in _found(path)))
    rotors = [str(path) for path in given.get(ROTOR, ())]
    if len(rotors) != 1 or not _is_pattern(rotors[0]):
        return {MEASURED: files}
    return {MEASURED: files, ROTOR: tuple(_rotor_of(file, rotors[0]) for file in files)}


def with_rotors(points: Sequence[Mapping[str, Any]], axes: Mapping[str, tuple[str, ...]]) -> list[dict[str, Any]]:
    """The points of a grid over files, with the rotor of each where it has one of its own."""
    rotor_of = dict(zip(axes[MEASURED], axes[ROTOR])) if ROTOR in axes else {}
    own = [{ROTOR: rotor_of[file]} if (file := point.get(MEASURED)) in rotor_of else {} for point in points]
    return [{**point, **rotor} for point, rotor in zip(points, own)]


def is_of_fleet(plan: Plan) -> bool:
    """Whether each file that a plan measures has cells of its own."""
    return MEASURED in plan.axes


def _is_pattern(path: str) -> bool:
    """Whether a path is to be searched for; a file that has such a name is meant itself."""
    return glob.has_magic(path) and not Path(path).expanduser().exists()


def _found(path: str) -> list[str]:
    if not _is_pattern(path):
        if not Path(path).expanduser().exists():
            raise _none_found(path, "a file")
        return [path]
    found = [each for each in glob.glob(os.path.expanduser(path), recursive=True) if Path(each).is_file()]
    if not found:
        raise _none_found(path, "files")
    return sorted(found)


def _rotor_of(file: str, pattern: str) -> str:
    """The rotor's file with the stem of a measurement."""
    fitting = [rotor for rotor in _found(pattern) if Path(rotor).stem == Path(file).stem]
    if len(fitting) != 1:
        raise SettingError(
            f"expected one rotor named as {file} among {pattern}, got {len(fitting)}; name them alike, or give one"
            " rotor for all",
            setting=ROTOR,
        )
    return fitting[0]


def _none_found(path: str, what: str) -> SettingError:
    """Error for a missing file: it lists the files in the folder before the path's first wildcard."""
    plain = Path(*takewhile(lambda part: not glob.has_magic(part), Path(path).expanduser().parts))
    folder = plain if glob.has_magic(path) else plain.parent
    if not folder.is_dir():
        return SettingError(
            f"expected {what} {path}, found no folder {folder} (working directory: {Path.cwd()})", setting=MEASURED
        )
    names = ", ".join(sorted(each.name for each in folder.iterdir() if each.is_file()))
    return SettingError(
        f"expected {what} {path}, found none; the files in {folder} are: {shortened(names, LONGEST_LIST) or 'none'}",
        setting=MEASURED,
    )

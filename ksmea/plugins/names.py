"""Names of plugins: what is registered under which, and where it comes from.

No plugin is imported for that.

[project.entry-points."ksmea.optimizers"]
mine = "my_package.mine:Mine"
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from importlib.metadata import Distribution, EntryPoint, entry_points
from pathlib import Path

PROJECT = "ksmea-bench"
GROUPS = {
    "problem": "ksmea.problems",
    "measurement": "ksmea.measurements",
    "surrogate": "ksmea.surrogates",
    "optimizer": "ksmea.optimizers",
    "method": "ksmea.methods",
    "study": "ksmea.studies",
}
FURTHER = {  # not parts of a run: chosen inside the settings of others, or made of records afterwards
    "effect": "ksmea.effects",
    "report": "ksmea.reports",
}


_in_files: dict[Path, list[EntryPoint]] = {}  # what this process has registered from files


class SharedName(EntryPoint):
    """A name that several packages register.

    It is refused where it is chosen, none of them stands in for another.
    """

    def __init__(self, points: Sequence[EntryPoint]) -> None:
        super().__init__(points[0].name, points[0].value, points[0].group)
        packages = (f"{package(point)} ({point.value})" for point in points)
        vars(self).update(packages=" and ".join(packages))

    @property
    def refusal(self) -> str:
        return (
            f"expected one package that registers this name, got {vars(self)['packages']}; rename it in one of them or"
            " uninstall that one"
        )


class BrokenName(EntryPoint):
    """A name in a plain file that cannot be loaded.

    It is refused where it is chosen, and stops nothing else.
    """

    def __init__(self, name: str, group: str, refusal: str) -> None:
        super().__init__(name, "broken:broken", group)
        vars(self).update(refusal=refusal)

    @property
    def refusal(self) -> str:
        return str(vars(self)["refusal"])


@cache
def registered(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group ('optimizer', …) by name, in alphabetical order.

    A name of this project stays its own.
    """
    by_name: dict[str, list[EntryPoint]] = {}
    for point in _points(group):
        by_name.setdefault(point.name, []).append(point)
    for name, points in by_name.items():
        by_name[name] = [point for point in points if package(point) == PROJECT] or points
    return {name: points[0] if len(points) == 1 else SharedName(points) for name, points in by_name.items()}


def left_out(group: str) -> list[EntryPoint]:
    """Entry points of other packages that are ignored: a plugin of this project has their name."""
    return [point for point in _points(group) if package(point) != PROJECT == package(registered(group)[point.name])]


def add_file(path: Path, points: Sequence[EntryPoint]) -> None:
    """Register what a file holds next to what is installed."""
    _in_files[path] = list(points)
    registered.cache_clear()


def is_added(path: Path) -> bool:
    return path in _in_files


def plugins_in_files() -> Iterator[tuple[Path, str, str]]:
    """File, group and name of every plugin that was registered from a file."""
    groups = {where: group for group, where in (GROUPS | FURTHER).items()}
    yield from ((path, groups[each.group], each.name) for path, found in _in_files.items() for each in found)


def origin(group: str, name: str) -> str:
    """Origin of a plugin: its package with the version, or its file."""
    files = (str(path) for path, *chosen in plugins_in_files() if chosen == [group, name])
    return next(files, origin_of(registered(group)[name]))


def origin_of(point: EntryPoint) -> str:
    """The package that an entry point comes from, with the version."""
    return f"{package(point)} {point.dist.version}" if point.dist else package(point)


def _points(group: str) -> list[EntryPoint]:
    """Entry points of a group, from packages and from files, by their names."""
    where = (GROUPS | FURTHER)[group]
    in_files = [each for found in _in_files.values() for each in found if each.group == where]
    return sorted([*entry_points(group=where), *in_files], key=lambda point: point.name)


def package(point: EntryPoint) -> str:
    """The package that an entry point belongs to; '?' if it was registered from a file."""
    return _name(point.dist) if point.dist else "?"


@cache
def _name(package: Distribution) -> str:
    return package.name  # which reads its metadata, each time

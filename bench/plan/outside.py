"""Code from outside the project that a run uses: packages or files of its plugins and their imports.

Modules of a plugin's distribution count if the plugin imports them (`bench.plan.provenance`), so that an edit of one plugin leaves
results of the others fresh. Its data files count all, since it is not visible from outside which of them a result depends on; so do
all modules if one of those imported loads others by names that it does not spell out. Documentation does not count. Of
requirements, and of packages imported without being required, name and version count; if a version says nothing – an
editable install, a folder on the path – the content of the files does, as of a plugin that is a plain file. The numerical
libraries are in every key already.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import Distribution, PackageNotFoundError, distribution, entry_points, packages_distributions
from pathlib import Path, PurePosixPath

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from bench.plan.sources import DIGITS, read_source
from ksmea.plugins import registry
from ksmea.plugins.files import OURS, brought_along, digests, imported, loads_by_name
from ksmea.plugins.registry import PROJECT

NUMERICAL = ("numpy", "scipy", "scikit-learn", "pyswarms", "deap")
IN_EVERY_KEY = frozenset([PROJECT, *NUMERICAL])
LEFT_OUT = (".pyc", ".pyo", ".pth")  # what Python itself writes, and where an installer says that files lie elsewhere
DOCUMENTATION = (".md", ".rst")
PLAIN = ("", ".txt")
ABOUT = ("README", "LICENSE", "LICENCE", "CHANGELOG", "CHANGES", "NOTICE", "AUTHORS")
DISTRIBUTION, FILE = "distribution ", "file "  # how names of versions and of hashes begin


def outside_code(
    modules: Iterable[str], plugin_files: Iterable[Path] = (), imported_files: Iterable[Path] = ()
) -> dict[str, str]:
    """Versions of distributions and hashes of files, by name, that plugins from outside use.

    The plugins are given by their modules and plain files; the project's own plugins add no entry. `imported_files` are
    the files of the modules that the plugins import from their own distributions.
    """
    packages = frozenset(module.partition(".")[0] for module in modules) - {*OURS}
    return dict(_outside_code(packages, frozenset(plugin_files), frozenset(imported_files)))


def packages_of_plugin(module: str) -> frozenset[str]:
    """Top-level packages of the distribution of a plugin's module; its own package alone without one."""
    package = module.partition(".")[0]
    owner = None if package in OURS else _owner(package)
    return frozenset({package} if owner is None else {package, *_packages(owner)})


def is_distribution(name: str) -> bool:
    """Whether a name of `outside_code` stands for a distribution, with a version as its value."""
    return name.startswith(DISTRIBUTION)


def is_file(name: str) -> bool:
    return name.startswith(FILE)


@cache
def _outside_code(
    packages: frozenset[str], plugin_files: frozenset[Path], imported_files: frozenset[Path]
) -> dict[str, str]:
    found: dict[str, str] = {}
    done: set[str] = set()
    pending = [(package, False) for package in _imported(imported_files)]
    for path in plugin_files:
        found |= {FILE + name: digest for name, digest in digests(path).items()}
        beside = brought_along(path)
        done |= {PurePosixPath(name).parts[0].removesuffix(".py") for name in beside}
        pending += [(package, False) for package in _imported(beside.values())]
    pending += [(package, True) for package in sorted(packages)]  # taken first: what is a plugin's own is done then
    all_modules = any(map(loads_by_name, imported_files))
    while pending:
        package, is_plugin = pending.pop()
        if package in done or package in OURS or package in sys.stdlib_module_names:
            continue
        done |= packages_of_plugin(package) if is_plugin else {package}
        owner = _owner(package)
        if owner is not None and _name(owner) in IN_EVERY_KEY:
            continue
        files = _folder(package) if owner is None else _files(owner, package)
        if is_plugin:
            files = {name: path for name, path in files.items() if all_modules or path.suffix != ".py"}
        elif owner is not None and _installed_files(owner):
            files = {}
        for each in [] if owner is None else [owner, *_required(owner)]:
            found[DISTRIBUTION + _name(each)] = each.version
            if each is not owner and not _installed_files(each):
                files |= _files(each)
        for name, path in files.items():
            found[FILE + name] = _digest(path)
        pending += [(package, False) for package in _imported(files.values())]
    return dict(sorted(found.items()))


@cache
def _owner(package: str) -> Distribution | None:
    """The distribution that a top-level package belongs to, by its plugins or by its files."""
    for group in (registry.GROUPS | registry.FURTHER).values():
        for point in entry_points(group=group):
            if point.dist is not None and point.module.partition(".")[0] == package:
                return point.dist
    names = _distributions_of_packages().get(package)
    return distribution(names[0]) if names else None


@cache
def _distributions_of_packages() -> Mapping[str, list[str]]:
    return packages_distributions()


def _name(owner: Distribution) -> str:
    return canonicalize_name(owner.name)


def _required(owner: Distribution) -> list[Distribution]:
    """Installed distributions that a distribution requires, directly or indirectly.

    The numerical libraries and the project are left out.
    """
    found: dict[str, Distribution] = {}
    pending = [owner]
    while pending:
        for text in pending.pop().requires or ():
            requirement = Requirement(text)
            name = canonicalize_name(requirement.name)
            if name in found or name in IN_EVERY_KEY or name == _name(owner):
                continue
            if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
                continue
            try:
                found[name] = distribution(name)
            except PackageNotFoundError:
                continue  # nothing that is not there is computed with
            pending.append(found[name])
    return list(found.values())


def _files(owner: Distribution, package: str | None = None) -> dict[str, Path]:
    """Files of a distribution by name: as its record has them, else those in the folders of its packages."""
    if recorded := _installed_files(owner):
        return recorded
    packages = [*_packages(owner), *([] if package is None else [package])]
    return {name: path for each in dict.fromkeys(packages) for name, path in _folder(each).items()}


def _packages(owner: Distribution) -> list[str]:
    """Top-level packages of a distribution.

    They are taken from its files, else from its own list or its entry points.
    """
    names = [
        PurePosixPath(name).parts[0].removesuffix(".py") for name in _installed_files(owner) if name.endswith(".py")
    ]
    names += (owner.read_text("top_level.txt") or "").split()
    names += [point.module.partition(".")[0] for point in owner.entry_points]
    return [name for name in dict.fromkeys(names) if name not in OURS]


def _digest(path: Path) -> str:
    """Hash of a file's content; for Python, of its syntax tree, which comments do not change."""
    content = path.read_bytes()
    if path.suffix == ".py":
        with suppress(SyntaxError, ValueError, RecursionError):
            return read_source(content).digest
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def _installed_files(owner: Distribution) -> dict[str, Path]:
    """Files that an installer has copied, by name; empty if they lie in a source tree."""
    if owner.read_text("RECORD") is None or json.loads(owner.read_text("direct_url.json") or "{}").get(
        "dir_info", {}
    ).get("editable"):
        return {}
    found = {}
    for path in owner.files or ():
        top = path.parts[0]
        if top.endswith(".dist-info") or top in ("..", "/") or _is_left_out(path):
            continue
        place = Path(str(owner.locate_file(path)))
        if place.is_file():
            found[str(path)] = place
    return found


def _folder(package: str) -> dict[str, Path]:
    """All files below a top-level package's folder by name, or the one file that it is."""
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        return {}
    if spec is None:
        return {}
    if spec.submodule_search_locations is None:
        return {Path(spec.origin).name: Path(spec.origin)} if spec.origin and Path(spec.origin).is_file() else {}
    found = {}
    for folder in spec.submodule_search_locations:
        for path in sorted(Path(folder).rglob("*")):
            name = PurePosixPath(package, path.relative_to(folder).as_posix())
            if path.is_file() and not _is_left_out(name):
                found[str(name)] = path
    return found


def _is_left_out(path: PurePosixPath) -> bool:
    is_documentation = path.suffix in DOCUMENTATION or (path.suffix in PLAIN and path.stem.upper() in ABOUT)
    return is_documentation or path.suffix in LEFT_OUT or "__pycache__" in path.parts


def _imported(files: Iterable[Path]) -> list[str]:
    """Top-level packages that the Python files among `files` import."""
    names = (name for path in files if path.suffix == ".py" for name in imported(path))
    return list(dict.fromkeys(name.partition(".")[0] for name in names))

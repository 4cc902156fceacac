"""Plugins in plain files: plugin classes of a file, their names, and the files that they import.

A file is imported as the module of its name, and may import what lies next to it. Every public class in it that
subclasses a contract is a plugin. The plugin's name is the name of the class in snake case: `RandomSearch` is
`random_search`, `CMAES` is `cmaes`.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType, ModuleType

from ksmea.errors import PluginFailure, SettingError
from ksmea.plugins.effect import Effect
from ksmea.plugins.first_import import require_importable, undisturbed
from ksmea.plugins.identification import Method
from ksmea.plugins.module_files import source_file
from ksmea.plugins.optimizer import Optimizer
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.plugins.surrogate import Surrogate
from ksmea.settings.settings import Settings

OURS = ("bench", "ksmea", "measurements", "optimizers", "problems", "surrogates")  # packages of this project
OF_THE_BENCH = ("study", "report")  # these make and read what lies in folders of results: they come from packages alone
NEXT_WORD = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
PYTHON_WRITES = (".pyc", ".pyo")
IMPORTERS = ("import_module", "__import__")
RUNNERS = ("exec", "eval")
LOADERS = frozenset(
    [
        "importlib.machinery",
        "importlib.metadata",
        "importlib.resources",
        "importlib.util",
        "hydra.utils",
        "imp",
        "lazy_loader",
        "pkg_resources",
        "pkgutil",
        "pydoc",
        "runpy",
        "zipimport",
    ]
)
DIGITS = 12  # of the hash of a file
DEEPEST = 8  # classes between a plugin and its contract

CONTRACTS: Mapping[str, type[Settings]] = MappingProxyType(
    {  # what a plugin of each group subclasses; studies and reports have contracts of the bench's own on top
        "problem": ProblemSettings,
        "measurement": MeasurementSource,
        "surrogate": Surrogate,
        "optimizer": Optimizer,
        "method": Method,
        "effect": Effect,
        "study": Settings,
        "report": Settings,
    }
)


@dataclass(frozen=True)
class FoundPlugin:
    """A plugin in a file: its group, the name to choose it by, and its class."""

    group: str
    name: str
    plugin: type


def plugins_of_file(path: Path) -> list[FoundPlugin]:
    """The plugins of a file, which is executed for that; `SettingError` if it cannot be, or has none."""
    module = _loaded(path)
    own = [each for each in vars(module).values() if isinstance(each, type) and each.__module__ == module.__name__]
    found = [
        FoundPlugin(group, snake_case(each.__name__), each)
        for each in own
        for group, contract in CONTRACTS.items()
        if group not in OF_THE_BENCH and issubclass(each, contract) and not each.__name__.startswith("_")
    ]
    if not found:
        contracts = ", ".join(CONTRACTS[group].__name__ for group in CONTRACTS if group not in OF_THE_BENCH)
        raise SettingError(
            f"{path}: expected a class that subclasses one of {contracts} of the package ksmea, got none; add one",
            setting="plugins",
        )
    return found


def classes_in(path: Path) -> list[tuple[str, str]]:
    """Group and name of each plugin that a file's text defines by its base class, without executing it.

    Empty for a file without any, or one that cannot be read.
    """
    tree = _tree(path)
    classes = [each.name for each in tree.body if isinstance(each, ast.ClassDef) and not each.name.startswith("_")]
    found = [(_group_of(tree, name, DEEPEST), snake_case(name)) for name in classes]
    return [(group, name) for group, name in found if group]


def _group_of(tree: ast.Module, name: str, depth: int) -> str:
    """The group that a class in a file's text is a plugin of, by its bases, also imported ones.

    '' for any other class.
    """
    groups = {contract.__name__: group for group, contract in CONTRACTS.items() if group not in OF_THE_BENCH}
    if name in groups:
        return groups[name]
    for node in tree.body if depth else []:
        if isinstance(node, ast.ClassDef) and node.name == name:
            bases = [ast.unparse(base).partition("[")[0].rpartition(".")[2] for base in node.bases]
            return next((group for base in bases if (group := _group_of(tree, base, depth - 1))), "")
        if isinstance(node, ast.ImportFrom) and name in [alias.asname or alias.name for alias in node.names]:
            file = source_file(node.module) if node.module else None
            return "" if file is None else _group_of(_tree(file), name, depth - 1)
    return ""


def _tree(path: Path) -> ast.Module:
    """The syntax tree of a file; an empty one if it is no Python."""
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    except (OSError, SyntaxError, ValueError, RecursionError):
        return ast.Module([], [])


def snake_case(name: str) -> str:
    """Plugin name of a class: the name of the class in snake case.

    >>> [snake_case(name) for name in ("RandomSearch", "CMAES", "RK4TwoDisk")]
    ['random_search', 'cmaes', 'rk4_two_disk']
    """
    return NEXT_WORD.sub("_", name).lower()


def digests(path: Path) -> dict[str, str]:
    """Hash by name of a plugin's file and of all that it imports from next to it. Nothing is executed."""
    return {name: hashlib.sha256(each.read_bytes()).hexdigest()[:DIGITS] for name, each in brought_along(path).items()}


def brought_along(path: Path) -> dict[str, Path]:
    """A plugin's file, and the modules and packages next to it that it imports, by name.

    Packages come with all their files. Raises `SettingError` if the file does not exist.
    """
    if not path.is_file():
        raise SettingError(f"expected a Python file, found none at {path}; give its path", setting="plugins")
    found = {path.name: path}
    pending = [path]
    while pending:
        for module in imported(pending.pop()):
            for each in _beside(path.parent, module):
                name = each.relative_to(path.parent).as_posix()
                if name not in found:
                    found[name] = each
                    pending += [each] if each.suffix == ".py" else []
    return dict(sorted(found.items()))


def imported(source: Path) -> Iterator[str]:
    """Modules that a file imports, also by a name that it spells out; none of one that is no Python."""
    try:
        tree = ast.parse(source.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError, RecursionError):
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and _called(node) in IMPORTERS and (name := _spelt_out(node)):
            yield name


def loads_by_name(source: Path) -> bool:
    """Whether a file may import modules by names that it does not spell out.

    Its imports then cannot be read from it: it does so, or imports all names of a package, or has other means of that.
    """
    try:
        tree = ast.parse(source.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError, RecursionError):
        return True
    nodes = list(ast.walk(tree))
    calls = [node for node in nodes if isinstance(node, ast.Call) and _called(node) in IMPORTERS]
    spelt_out = {id(call.func) for call in calls if _spelt_out(call)}
    return any(_may_load_by_name(node) for node in nodes if id(node) not in spelt_out)


def _may_load_by_name(node: ast.AST) -> bool:
    if isinstance(node, ast.Name):
        return node.id in (*IMPORTERS, *RUNNERS)
    if isinstance(node, ast.Attribute):
        return node.attr in IMPORTERS or (
            isinstance(node.value, ast.Name) and f"{node.value.id}.{node.attr}" in LOADERS
        )
    if isinstance(node, ast.Import):
        return any(alias.name in LOADERS for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        names = [f"{node.module}.{alias.name}" for alias in node.names if not node.level]
        renamed = any(alias.name in IMPORTERS and alias.asname for alias in node.names)
        return (
            renamed or any(alias.name == "*" for alias in node.names) or not LOADERS.isdisjoint([node.module, *names])
        )
    return False


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def _spelt_out(call: ast.Call) -> str:
    """The absolute name that a call of an importer has as its first argument; '' if it has another one."""
    name = call.args[0].value if call.args and isinstance(call.args[0], ast.Constant) else ""
    return name if isinstance(name, str) and not name.startswith(".") else ""


def _beside(folder: Path, module: str) -> list[Path]:
    """Files of a module, or of the whole package that it is in; empty if the folder does not have them."""
    top, *_ = parts = module.split(".")
    if top in OURS or top in sys.stdlib_module_names:
        return []
    if (folder / top / "__init__.py").is_file() or (
        len(parts) > 1 and folder.joinpath(*parts).with_suffix(".py").is_file()
    ):
        files = (each for each in (folder / top).rglob("*") if each.is_file())
        return [each for each in files if each.suffix not in PYTHON_WRITES]
    return [folder / f"{top}.py"] if (folder / f"{top}.py").is_file() else []


def _loaded(path: Path) -> ModuleType:
    """The module that a file is.

    Its folder comes last on Python's path, so that nothing in it hides what is installed.
    """
    if not path.is_file():
        raise SettingError(f"expected a Python file, found none at {path}; give its path", setting="plugins")
    if path.suffix != ".py" or not path.stem.isidentifier():
        raise SettingError(
            f"expected a file named as a module is, as my_optimizer.py, got {path.name}; rename it", setting="plugins"
        )
    folder = str(path.parent)
    if folder not in sys.path:
        sys.path.append(folder)
    importlib.invalidate_caches()
    for name in dict.fromkeys(Path(each).parts[0].removesuffix(".py") for each in brought_along(path)):
        _require_own_name(path, name)
    if path.stem not in sys.modules:
        require_importable(str(path), lambda: importlib.import_module(path.stem), setting="plugins")
    try:
        with undisturbed():
            return importlib.import_module(path.stem)
    except (Exception, SystemExit) as error:
        raise PluginFailure(f"{path} cannot be loaded: {one_line(error)}", setting="plugins") from error


def _require_own_name(path: Path, name: str) -> None:
    """Raise `SettingError` if Python finds another module of a name than the one next to a plugin's file."""
    try:
        spec = find_spec(name)
    except ValueError:  # the module that was started
        spec = None
    places = [] if spec is None else [spec.origin, *(spec.submodule_search_locations or ())]
    place = next((Path(each) for each in places if each and Path(each).exists()), None)
    beside = [path.parent / each for each in (f"{name}.py", f"{name}/__init__.py", name)]
    if place is None or not any(each.exists() and place.samefile(each) for each in beside):
        raise SettingError(
            f"{path.parent / name}: expected a name that no other module has, but Python takes {name} from"
            f" {place or 'elsewhere'}; rename it",
            setting="plugins",
        )


def one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def require_same(path: Path, planned: Mapping[str, str]) -> None:
    """Raise `SettingError` if a file, or one that it imports from next to it, differs from the plan."""
    if changed := [name for name, digest in digests(path).items() if planned.get(name) != digest]:
        raise SettingError(
            f"{path}: expected what the experiment was planned with, but {', '.join(changed)} has changed; give"
            " the experiment's command again",
            setting="plugins",
        )

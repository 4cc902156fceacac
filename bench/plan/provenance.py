"""Provenance of a result: its modules without comments, and the versions of libraries."""

from __future__ import annotations

import hashlib
import platform
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any

import scipy.linalg  # noqa: F401 – its own linear algebra is loaded with it, and named too
from threadpoolctl import threadpool_info

from bench.plan.outside import DISTRIBUTION, NUMERICAL, outside_code, packages_of_plugin
from bench.plan.sources import Source, absolute, kept_sources
from bench.storage.content_cache import KeptByContent
from bench.storage.own_files import checkout_commit
from ksmea.plugins import registry
from ksmea.plugins.files import OURS, brought_along, imported
from ksmea.plugins.module_files import source_file
from ksmea.settings.settings import Settings

SHOWN = "ksmea.show"  # texts, tables and figures of results: nothing in it is computed with
ENTRANCE = "bench.jobs.execute"  # where a run begins
OPTIONAL = ("cma",)  # numerical libraries of an extra: their versions belong to runs that import them
NO_FILES: Mapping[str, str] = MappingProxyType({})
PARTS = "parts"  # key of a run's settings for the plugins that its own are made of, as `group=name`


def used_modules(settings: Mapping[str, Any], plugins: Mapping[str, str] = NO_FILES) -> dict[str, str]:
    """Digest by name of every module that a run with these settings executes.

    Its plugins, and all that they and the run itself import, of this project and of the packages that the plugins come
    from; with these, what else they bring along from outside (`bench.plan.outside`). `plugins` are the plain files of
    plugins by what chooses them, `optimizer=mine`. Files are read and never executed, as settings may come from a
    received folder. `SettingError` for a plugin that is not registered.
    """
    chosen = _chosen(settings)
    own = [registry.modules_of(*word.split("=", 1)) for word in chosen if word not in plugins]
    installed = dict.fromkeys(chain.from_iterable(own))
    return dict(_used_modules(tuple(installed), frozenset(Path(plugins[word]) for word in chosen if word in plugins)))


def plugin_files(settings: Mapping[str, Any]) -> dict[str, str]:
    """Plain files of the plugins that a run with these settings is made of, by what chooses them."""
    chosen = _chosen(settings)
    in_files = {f"{group}={name}": str(path) for path, group, name in registry.plugins_in_files()}
    return {word: path for word, path in in_files.items() if word in chosen}


def outside_plugins(settings: Mapping[str, Any]) -> list[str]:
    """Plugins that a run with these settings is made of and that are not this project's, as `group=name`."""
    return sorted(word for word in _chosen(settings) if registry.is_outside(*word.split("=", 1)))


def mentions(settings: Mapping[str, Any], word: str) -> bool:
    """Whether a run's settings choose a plugin or hold its name anywhere.

    A choice is `group=name`; a list of effects holds names.
    """
    name = word.partition("=")[2]
    pending: list[Any] = [settings]
    while pending:
        value = pending.pop()
        pending += value.values() if isinstance(value, Mapping) else value if isinstance(value, (list, tuple)) else []
        if isinstance(value, str) and value in (word, name):
            return True
    return False


def _chosen(settings: Mapping[str, Any]) -> list[str]:
    """Plugins that a run with these settings is made of, as `group=name`.

    Settings of earlier versions name parts by modules; they are passed over: what was computed by those versions is
    stale in any case.
    """
    own = [f"{group}={settings[group]['name']}" for group in registry.GROUPS if settings.get(group) is not None]
    return [*own, *(part for part in settings.get(PARTS, ()) if "=" in part)]


@cache
def _used_modules(plugins: tuple[str, ...], files: frozenset[Path]) -> dict[str, str]:
    packages = frozenset([*OURS, *(package for name in plugins for package in packages_of_plugin(name))])
    of_outside: list[Path] = []
    found: dict[str, str] = {}
    in_files = (source for path in files for source in brought_along(path).values() if source.suffix == ".py")
    of_files = (name for source in in_files for name in imported(source) if name.partition(".")[0] in packages)
    pending = [ENTRANCE, *plugins, *of_files]
    while pending:
        name = pending.pop()
        if name not in found and (said := _said_by(name)) is not None:
            found[name] = said.digest
            found.update((DISTRIBUTION + module, version(module)) for module in said.imports if module in OPTIONAL)
            imports = said.imports
            if name.partition(".")[0] not in OURS and (file := _file_of(name)) is not None:
                of_outside.append(file)
                imports = (*imports, *imported(file), *_parents(name))
            pending.extend(
                module
                for module in imports
                if module.partition(".")[0] in packages and not (module + ".").startswith(SHOWN + ".")
            )
    _kept_sources().keep()
    return dict(sorted(found.items())) | outside_code(plugins, files, of_outside)


def _parents(module: str) -> list[str]:
    """The packages that a module lies in: Python executes them, and all that they import, before it."""
    parts = module.split(".")
    return [".".join(parts[:length]) for length in range(1, len(parts))]


def names_of_parts(plugins: Iterable[Settings]) -> list[str]:
    """Plugins that plugins are made of, as `group=name`.

    An extended problem's baseline problem, its effects.
    """
    return sorted({"=".join(registry.name_of(part)) for plugin in plugins for part in plugin.parts})


def code_digest(modules: Mapping[str, str]) -> str:
    return hashlib.sha256("".join(f"{name}:{digest}\n" for name, digest in modules.items()).encode()).hexdigest()[:16]


@cache
def _said_by(module: str) -> Source | None:
    """Digest and imports, by full names, of a module; None if it is not a module of Python source."""
    file = _file_of(module)
    if file is None:
        return None
    try:
        said = _kept_sources().of(file.read_bytes())
    except SyntaxError as error:
        error.filename = str(file)
        raise
    imports = (absolute(each, module, file.name == "__init__.py") for each in said.imports)
    return Source(said.digest, tuple(dict.fromkeys(imports)))


@cache
def _file_of(module: str) -> Path | None:
    """The file of a module; None for what is not a module of Python source."""
    return source_file(module)


@cache
def _kept_sources() -> KeptByContent[Source]:
    return kept_sources()


@cache
def library_versions() -> dict[str, str]:
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"python": python, **{name: version(name) for name in NUMERICAL}}


@cache
def platform_name() -> str:
    """Kind of processor and kernels of the linear algebra here, for example 'x86_64 SkylakeX'.

    Rounding depends on it.
    """
    kernels = sorted({str(pool.get("architecture", "?")) for pool in threadpool_info() if pool["user_api"] == "blas"})
    return " ".join([platform.machine(), *kernels])


@cache
def commit() -> str:
    """Commit of this checkout, followed by '+' if files differ from it; else the package's version."""
    return checkout_commit() or version("ksmea-bench")

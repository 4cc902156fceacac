"""What a result was computed by: the modules that take part in it, without their comments, and the libraries' versions."""

from __future__ import annotations

import hashlib
import importlib.util
import platform
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

import scipy.linalg  # noqa: F401 – its own linear algebra is loaded with it, and named too
from threadpoolctl import threadpool_info

from bench.plan.outside import DISTRIBUTION, NUMERICAL, outside_code
from bench.plan.sources import Source, absolute, kept_sources
from bench.storage.content_cache import KeptByContent
from bench.storage.own_files import checkout_commit
from ksmea.plugins import registry
from ksmea.plugins.files import OURS, brought_along, imported
from ksmea.settings.settings import Settings

SHOWN = "ksmea.show"  # texts, tables and figures of results: nothing in it is computed with
ENTRANCE = "bench.jobs.execute"  # where a run begins
OPTIONAL = ("cma",)  # numerical libraries of an extra: their versions belong to runs that import them
NO_FILES: Mapping[str, str] = MappingProxyType({})
PARTS = "parts"  # where a run's settings keep the modules of plugins that its own are made of


def used_modules(settings: Mapping[str, Any], plugins: Mapping[str, str] = NO_FILES) -> dict[str, str]:
    """Digest by name of every module that a run with these settings executes: its plugins, and all that they and the
    run itself import, of this project and of the packages that the plugins come from; with these, what else they bring along
    from outside (`bench.plan.outside`). `plugins` are the plain files of plugins by what chooses them, `optimizer=mine`;
    they are read and not executed."""
    by_module = {Path(path).stem: Path(path) for path in plugins.values()}
    chosen = [(group, settings[group]["name"]) for group in registry.GROUPS if settings.get(group) is not None]
    modules = [
        Path(plugins[word]).stem
        if (word := f"{group}={name}") in plugins
        else registry.plugin_class(group, name).__module__
        for group, name in chosen
    ]
    modules += settings.get(PARTS, ())
    installed = tuple(module for module in modules if module not in by_module)
    return dict(_used_modules(installed, frozenset(by_module[module] for module in modules if module in by_module)))


def plugin_files(settings: Mapping[str, Any]) -> dict[str, str]:
    """Plain files of the plugins that a run with these settings is made of, by what chooses them."""
    modules = settings.get(PARTS, ())
    return {
        f"{group}={name}": str(path)
        for path, group, name in registry.plugins_in_files()
        if path.stem in modules or (settings.get(group) or {}).get("name") == name
    }


@cache
def _used_modules(plugins: tuple[str, ...], files: frozenset[Path]) -> dict[str, str]:
    packages = frozenset([*OURS, *(name.partition(".")[0] for name in plugins)])
    found: dict[str, str] = {}
    in_files = (source for path in files for source in brought_along(path).values() if source.suffix == ".py")
    of_files = (name for source in in_files for name in imported(source) if name.partition(".")[0] in OURS)
    pending = [ENTRANCE, *plugins, *of_files]
    while pending:
        name = pending.pop()
        if name not in found and (said := _said_by(name)) is not None:
            found[name] = said.digest
            found.update((DISTRIBUTION + module, version(module)) for module in said.imports if module in OPTIONAL)
            pending.extend(
                module
                for module in said.imports
                if module.partition(".")[0] in packages and not (module + ".").startswith(SHOWN + ".")
            )
    _kept_sources().keep()
    return dict(sorted(found.items())) | outside_code(plugins, files)


def modules_of_parts(plugins: Iterable[Settings]) -> list[str]:
    """Modules of the plugins that plugins are made of: an extended problem's baseline problem, its effects."""
    return sorted({type(part).__module__ for plugin in plugins for part in plugin.parts})


def code_digest(modules: Mapping[str, str]) -> str:
    return hashlib.sha256("".join(f"{name}:{digest}\n" for name, digest in modules.items()).encode()).hexdigest()[:16]


@cache
def _said_by(module: str) -> Source | None:
    """What the file of a module says, by full names; None for what is no module of Python source."""
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, AttributeError, ValueError):
        return None
    if spec is None or not spec.origin or not spec.origin.endswith(".py"):
        return None
    file = Path(spec.origin)
    try:
        said = _kept_sources().of(file.read_bytes())
    except SyntaxError as error:
        error.filename = str(file)
        raise
    imports = (absolute(each, module, file.name == "__init__.py") for each in said.imports)
    return Source(said.digest, tuple(dict.fromkeys(imports)))


@cache
def _kept_sources() -> KeptByContent[Source]:
    return kept_sources()


@cache
def library_versions() -> dict[str, str]:
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"python": python, **{name: version(name) for name in NUMERICAL}}


@cache
def platform_name() -> str:
    """Kind of processor and kernels of the linear algebra here, for example 'x86_64 SkylakeX': what rounding depends on."""
    kernels = sorted({str(pool.get("architecture", "?")) for pool in threadpool_info() if pool["user_api"] == "blas"})
    return " ".join([platform.machine(), *kernels])


@cache
def commit() -> str:
    """The commit of this checkout, '+' behind it where files differ from it; the package's version where there is none."""
    return checkout_commit() or version("ksmea-bench")

"""What a result was computed by: the source of the packages that compute, and the numerical libraries' versions."""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ksmea import registry

ROOT = Path(__file__).resolve().parents[1]
COMPUTING = ("ksmea", "problems", "surrogates", "optimizers", "bench/execute.py", "bench/synthetic.py")
NUMERICAL = ("numpy", "scipy", "scikit-learn", "pyswarms", "deap")


def code_digest(settings: Iterable[Mapping[str, Any]]) -> str:
    """Hash of all source files that take part in the runs, the files of outside plugins among them."""
    plugins = {
        (group, run[group]["name"]) for run in settings for group in registry.GROUPS if run.get(group) is not None
    }
    files = {Path(inspect.getfile(registry.plugin_class(*plugin))).resolve() for plugin in plugins}
    for place in COMPUTING:
        files.update(path for path in [ROOT / place, *(ROOT / place).rglob("*.py")] if path.is_file())
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(_content(path))
    return digest.hexdigest()[:16]


@cache
def _content(path: Path) -> bytes:
    return path.read_bytes()


def library_versions() -> dict[str, str]:
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"python": python, **{name: version(name) for name in NUMERICAL}}

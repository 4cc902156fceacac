"""Table of the properties that the contract tests of `ksmea.testing` check.

It has the first line of each docstring.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator

import ksmea.testing
from docstring_text import cell
from plugin_pages import table


def contract_tests_text() -> str:
    """One row per property.

    A module of `ksmea.testing` holds properties of one kind of plugin, or several.
    """
    return table(("properties of", "property", "meaning"), _rows())


def _rows() -> Iterator[tuple[str, str, str]]:
    for module in pkgutil.iter_modules(ksmea.testing.__path__):
        found = vars(importlib.import_module(f"ksmea.testing.{module.name}"))
        for name, function in found.items():
            if _is_property(function) and function.__module__ == f"ksmea.testing.{module.name}":
                first = (inspect.getdoc(function) or "").partition("\n\n")[0]
                yield module.name, f"`{name}`", cell(" ".join(first.split()))


def _is_property(value: object) -> bool:
    """Whether a value is a check: a function of one case that returns None."""
    if not inspect.isfunction(value) or value.__name__.startswith("_"):
        return False
    signature = inspect.signature(value)
    return list(signature.parameters) == ["case"] and signature.return_annotation in (None, "None")

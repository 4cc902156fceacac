"""Errors that speak to the user, and the one that ends a spent budget."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class SettingError(ValueError):
    """A setting, name or file that cannot be used: one line saying what was expected, what came and what to try."""


class BudgetSpent(Exception):
    """Raised by an objective whose evaluations are used up.

    It derives from `Exception` alone: the optimisation libraries swallow some of the more special classes.
    """


def unknown(kind: str, name: str, known: Iterable[str]) -> SettingError:
    """The error for a name that nobody knows, with the nearest known one and then all of them.

    >>> str(unknown("optimizer", "dee", ["de", "pso"]))
    "unknown optimizer 'dee'; did you mean 'de'? known: de, pso"
    """
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.4)
    hint = f"did you mean '{close[0]}'? " if close else ""
    return SettingError(f"unknown {kind} '{name}'; {hint}known: {', '.join(names) or 'none'}")

"""Errors that speak to the user, and the one that ends a spent budget."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

LONGEST_QUOTE = 40  # characters of a wrong value that an error repeats


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


def described(value: Any) -> str:
    """A wrong value as an error shows it: short and on one line.

    >>> described([]), described("many"), described(None)
    ('an empty list', "'many'", 'nothing')
    """
    if value is None:
        return "nothing"
    if isinstance(value, (dict, list)):
        kind = "mapping" if isinstance(value, dict) else "list"
        return f"a {kind}" if value else f"an empty {kind}"
    return shortened(repr(value))


def shortened(text: str) -> str:
    """A text on one line, cut to what an error quotes."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST_QUOTE else line[:LONGEST_QUOTE] + "…"

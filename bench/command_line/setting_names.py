"""Names of settings that nobody knows: the nearest one, or the plugin that has it."""

from __future__ import annotations

from collections.abc import Iterable

from bench.command_line.source_settings import source_settings
from ksmea.errors import nearest
from ksmea.plugin_names import GROUPS, registered


def unknown_key(key: str, names: Iterable[str]) -> str:
    """The line for a setting that is none of `names`, the nearest of them first."""
    parent, _, name = key.rpartition(".")
    known = sorted(names)
    path = f"{parent}." if parent else ""
    if (others := plugins_with(parent, name)) and name not in known:
        has = " and ".join(f"{parent}={other}" for other in others)
        hint = (
            f"{has} {'has' if len(others) == 1 else 'have'} it, what is chosen has not; choose that, or leave it out; "
        )
    else:
        close = nearest(name, known)
        hint = f"did you mean '{path}{close}'? " if close is not None else ""
    return f"unknown setting '{key}'; {hint}known: {', '.join(known)}"


def plugins_with(group: str, setting: str) -> list[str]:
    """The plugins of a group whose source has a setting; none where it is no group."""
    names = registered(group) if group in GROUPS else ()
    return [name for name in names if setting in (source_settings(group, name) or ())]

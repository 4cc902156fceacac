"""Plugins from outside that cannot be used: a sweep goes on without them, and says why.

One whose import fails, hangs or crashes, whose settings cannot be offered, or that raises while its cells are planned costs its own cells. A
command that chooses nothing else is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

from bench.command_line.schema import plugin_schema
from bench.plan.provenance import mentions
from ksmea.errors import PluginFailure, SettingError
from ksmea.plugins import registry
from ksmea.plugins.files import one_line
from ksmea.plugins.first_import import undisturbed, without_children

Point = dict[str, Any]


def why_unusable(group: str, name: object) -> str:
    """Why a plugin from outside cannot be chosen; '' if it can, or is this project's."""
    if not isinstance(name, str) or not registry.is_outside(group, name):
        return ""
    try:
        plugin_schema(group, name)
    except SettingError as error:
        return str(error)
    return ""


def with_usable(points: Sequence[Point]) -> tuple[list[Point], list[str]]:
    """The points whose plugins can be chosen, and a line for each other plugin.

    Raises `SettingError` if no point is left.
    """
    chosen = {(group, name) for point in points for group, name in point.items() if group in registry.GROUPS}
    reasons = {each: reason for each in sorted(chosen, key=str) if (reason := why_unusable(*each))}
    kept = [point for point in points if reasons.keys().isdisjoint(point.items())] if reasons else list(points)
    if points and not kept:
        raise PluginFailure(next(iter(reasons.values())))
    return kept, list(map(_line, reasons.values()))


@contextmanager
def planning(settings: Mapping[str, Any]) -> Iterator[None]:
    """Context in which errors of plugins from outside become a `PluginFailure` that names them.

    Changes that they make in this process are undone, and processes that they start end.
    """
    theirs = outside_in(settings)
    try:
        with ExitStack() as stack:
            if theirs:
                stack.enter_context(without_children())
                stack.enter_context(undisturbed())
            yield
    except SettingError:
        raise
    except (Exception, SystemExit) as error:
        if not theirs:
            raise
        raise PluginFailure(
            f"{' '.join(theirs)}: expected cells that can be planned, got {one_line(error)}; BENCH_TRACEBACK=1 shows where"
        ) from error


def outside_in(settings: Mapping[str, Any]) -> list[str]:
    """Plugins from outside that settings name, effects too, as `group=name`."""
    every = [(group, name) for group in (*registry.GROUPS, *registry.FURTHER) for name in registry.registered(group)]
    theirs = [f"{group}={name}" for group, name in every if registry.is_outside(group, name)]
    return [word for word in theirs if mentions(settings, word)]


def left_out_lines(reasons: Sequence[PluginFailure]) -> list[str]:
    """A line for each different reason."""
    return list(dict.fromkeys(_line(str(reason)) for reason in reasons))


def _line(reason: str) -> str:
    return f"left out: {reason}"

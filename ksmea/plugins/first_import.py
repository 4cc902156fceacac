"""The import of a plugin from outside.

Tried in a process of its own, and without effect on anything but what it adds.

An import runs code of other people in the process that plans all runs. So it is tried in a fork first, which may hang, exit or crash
without harm. After the import itself, the working directory, the environment, numpy's handling of floating-point errors, the recursion limit
and the functions and classes of the numerical libraries and of this project are as they were: what one plugin changes must not
change the numbers of another. A worker process runs plugins of one kind alone (`bench.jobs.pool`), and imports at once.
"""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from types import ModuleType
from typing import Any

import numpy as np

from ksmea.errors import PluginFailure, shortened
from ksmea.numerics.parallel import CAN_FORK, descendants, end

SECONDS = "KSMEA_IMPORT_SECONDS"  # environment variable: how long an import may take
MOST_SECONDS = 60.0
LONGEST_REASON = 300  # characters
OURS = ("ksmea", "bench", "problems", "measurements", "surrogates", "optimizers")
PROTECTED = ("numpy", "scipy", *OURS)
PROTECTED_MODULES = ("math", "random", "json", "os", "time")

MISSING = object()

State = list[tuple[Any, dict[str, Any]]]  # modules and classes with their members


def require_importable(what: str, load: Callable[[], object], setting: str = "") -> None:
    """Raise `PluginFailure` if an import fails, hangs or ends its process; it is tried in a fork.

    Nothing is tried in a worker process, or on a system without forks.
    """
    reason = _tried("import", load, float(os.environ.get(SECONDS, MOST_SECONDS)))
    if reason:
        raise PluginFailure(f"{what} cannot be loaded: {reason}", setting=setting)


def require_survived(what: str, action: Callable[[], object]) -> None:
    """Raise `PluginFailure` if an action ends its process; it is tried in a fork.

    An error that it raises is raised again by whoever does it then.
    """

    def survived() -> None:
        with suppress(Exception):
            action()

    if reason := _tried("planning", survived, None):
        raise PluginFailure(f"{what}: {reason}")


def _tried(noun: str, action: Callable[[], object], seconds: float | None) -> str:
    """Why an action failed in a fork; '' if it did not, or nothing can be tried here."""
    if not CAN_FORK or multiprocessing.parent_process() is not None:
        return ""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        _try(action, writing)
    os.close(writing)
    try:
        return _reason(noun, child, reading, seconds)
    finally:
        os.close(reading)


def _try(load: Callable[[], object], writing: int) -> None:
    """The life of the fork: it imports, says in a line what was wrong, and ends."""
    said = b"."
    try:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        silent = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(silent, stream)
        load()
    except BaseException as error:
        said = shortened(f"{type(error).__name__}: {error}", LONGEST_REASON).encode()
    finally:
        end(descendants(os.getpid()))
        with suppress(OSError):
            os.write(writing, said)
        os._exit(0)


def _reason(noun: str, child: int, reading: int, seconds: float | None) -> str:
    """Reason why the action in the fork failed; '' if it did not."""
    try:
        has_answer = bool(select.select([reading], [], [], seconds)[0])
        said = os.read(reading, 4 * LONGEST_REASON).decode(errors="replace") if has_answer else None
    finally:
        end([*descendants(child), child])
        _, status = os.waitpid(child, 0)
    if said is None:
        return f"its {noun} did not end within {seconds:g} s ({SECONDS} sets another limit)"
    if said:
        return "" if said == "." else said
    ended = os.waitstatus_to_exitcode(status)
    return f"its {noun} ended the process by {signal.Signals(-ended).name if ended < 0 else f'exit code {ended}'}"


@contextmanager
def without_children() -> Iterator[None]:
    """End all processes started in the block with it, except the resource tracker of multiprocessing."""
    before = descendants(os.getpid())
    try:
        yield
    finally:
        tracker = getattr(resource_tracker, "_resource_tracker", None)
        kept = {*before, getattr(tracker, "_pid", None)}
        end(each for each in descendants(os.getpid()) if each not in kept)


@contextmanager
def undisturbed(libraries: bool = True) -> Iterator[None]:
    """The state of the process is as before after the block.

    `libraries`: functions and classes of libraries too, which takes hundredths of a second.
    """
    folder, environment, errors, limit = os.getcwd(), dict(os.environ), np.geterr(), sys.getrecursionlimit()
    streams = sys.stdin, sys.stdout, sys.stderr
    before = _state() if libraries else []
    try:
        yield
    finally:
        with suppress(OSError):
            os.chdir(folder)
        if dict(os.environ) != environment:
            os.environ.clear()
            os.environ.update(environment)
        sys.stdin, sys.stdout, sys.stderr = streams
        np.seterr(**errors)
        sys.setrecursionlimit(limit)
        _restore(before)


def _state() -> State:
    """Functions and classes in the modules of libraries and of this project, with methods of its classes."""
    modules = [each for name, each in list(sys.modules.items()) if isinstance(each, ModuleType) and _is_protected(name)]
    found: State = [(each, _callable(vars(each))) for each in modules]
    classes = {value for _, members in found for value in members.values() if isinstance(value, type)}
    own = [each for each in classes if str(each.__module__).partition(".")[0] in OURS]
    return [*found, *((each, _callable(vars(each))) for each in own)]


def _callable(members: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in members.items() if callable(value) or isinstance(value, property)}


def _is_protected(module: str) -> bool:
    return module.partition(".")[0] in PROTECTED or module in PROTECTED_MODULES


def _restore(before: State) -> None:
    for place, members in before:
        now = vars(place)
        for name, value in members.items():
            if now.get(name, MISSING) is not value:
                setattr(place, name, value)

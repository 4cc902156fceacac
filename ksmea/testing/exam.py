"""An exam: the properties that every plugin of a kind must keep, each a test of its own.

An exam is made of a case (the plugin and what its author states of it) and of the functions that check one property each.
A function that returns has found its property kept.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, ParamSpec, TypeVar

from ksmea.errors import SettingError
from ksmea.settings.settings import Settings


class ExamFailed(AssertionError):
    """Failed properties of a plugin: expected, got, and what to do."""


def require(holds: object, expected: str, got: object, do: str) -> None:
    """Raise `ExamFailed` unless a property holds."""
    __tracebackhide__ = True  # from pytest, which then shows the property
    if not holds:
        raise ExamFailed(" ".join(f"expected {expected}, got {got}; {do}".split()))


@dataclass(frozen=True)
class Case:
    """A plugin that sits an exam; subclasses add what its author states."""

    contract: ClassVar[type[Settings]]
    plugin: Settings

    def __post_init__(self) -> None:
        if not isinstance(self.plugin, self.contract):
            name = self.contract.__name__
            raise SettingError(
                f"expected an instance of a subclass of ksmea.{name}, got {self.plugin!r}; make it one, such as"
                f" class Mine({name}), and hand over Mine()"
            )


Stated = ParamSpec("Stated")
Sitting = TypeVar("Sitting", bound=Case)


@dataclass(frozen=True)
class Exam(Generic[Stated, Sitting]):
    """The exam of one kind of plugins.

    `case` is made of the plugin and of what is stated of it, and `properties` says which properties apply to it.

        check_optimizer(Mine())                    # in a script: raises `ExamFailed` with all that Mine does not keep
        test_mine = check_optimizer.tests(Mine())  # in a test file: one test for each property, by pytest
    """

    case: Callable[Stated, Sitting]
    properties: Callable[[Sitting], Sequence[Callable[[Sitting], None]]]

    def __call__(self, *args: Stated.args, **stated: Stated.kwargs) -> None:
        case = self.case(*args, **stated)
        properties = self.properties(case)
        failures = [text for text in (_failure(each, case) for each in properties) if text]
        if failures:
            name = type(case.plugin).__name__
            raise ExamFailed("\n".join([f"{name} fails {len(failures)} of {len(properties)} properties", *failures]))

    def tests(self, *args: Stated.args, **stated: Stated.kwargs) -> Callable[[Callable[[Sitting], None]], None]:
        """A test function for pytest, which runs it once for each property under the property's name."""
        import pytest  # only who asks for tests needs it

        case = self.case(*args, **stated)
        properties = self.properties(case)

        def test(kept: Callable[[Sitting], None]) -> None:
            sit(kept, case)

        return pytest.mark.parametrize("kept", properties, ids=[each.__name__ for each in properties])(test)


def sit(kept: Callable[[Any], None], case: Case) -> None:
    """Check one property; whatever else the plugin raises is a failure that quotes the property."""
    __tracebackhide__ = True
    own = os.getpid()
    try:
        kept(case)
        _end_if_forked(own)
    except ExamFailed:
        _end_if_forked(own)
        raise
    except Exception as error:
        _end_if_forked(own)
        raise ExamFailed(
            f"expected that {_statement(kept)}, got {type(error).__name__}: {error}; mend where it is raised"
        ) from error


def _end_if_forked(own: int) -> None:
    """End a process that a plugin has forked and that returns too: the exam is sat once."""
    if os.getpid() != own:
        os._exit(0)


def _failure(kept: Callable[[Any], None], case: Case) -> str:
    """Name and reason of a property that a plugin does not keep, on one line; '' where it keeps it."""
    try:
        sit(kept, case)
    except ExamFailed as failed:
        return f"{kept.__name__}: {' '.join(str(failed).split())}"
    return ""


def _statement(kept: Callable[[Any], None]) -> str:
    """The property in words: its docstring as part of a sentence."""
    text = " ".join((kept.__doc__ or kept.__name__).split()).rstrip(".")
    return text[0].lower() + text[1:]

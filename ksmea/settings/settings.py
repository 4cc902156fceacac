"""Settings of plugins: frozen dataclasses whose fields carry help, unit, source and legal range.

A plugin's settings are its dataclass fields. `setting` writes one, `Settings` checks them all when an instance is
made, so a plugin built by hand is as safe as one that came from a command line.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
import typing
from abc import ABC
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cache
from typing import Any

from ksmea.errors import SettingError, described, unknown
from ksmea.settings.types import in_words, is_of


def setting(
    default: Any,
    help: str,
    *,
    unit: str = "",
    source: str = "",
    at_least: float | None = None,
    above: float | None = None,
    at_most: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """Dataclass field with its documentation and legal range.

    Args:
        default: default value; a mutable one is copied per instance. None is legal if the field's type admits it.
        help: noun phrase for the help and the documentation.
        unit: unit of the value.
        source: paper or standard that the default or the setting comes from.
        at_least: smallest legal number; on a list of each entry, like the other ranges.
        above: limit that numbers must exceed.
        at_most: largest legal number.
        choices: legal values, or legal entries of a list.

    Returns:
        Field for the body of a dataclass.

    >>> @dataclass(frozen=True)
    ... class Probe(Settings):
    ...     position: float = setting(0.1, "position on the shaft", unit="m", at_least=0)
    >>> Probe(position=-1.0)
    Traceback (most recent call last):
    ksmea.errors.SettingError: position: expected a number at least 0, got -1.0
    """
    limits = {"at_least": at_least, "above": above, "at_most": at_most}
    metadata = {"help": help, "unit": unit, "source": source, "choices": choices, **limits}
    if isinstance(default, (list, dict)):
        return dataclasses.field(default_factory=lambda: default.copy(), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def part(help: str, *, at_least: float | None = None) -> Any:
    """Dataclass field that holds a part of a method: another plugin, or the number of samples.

    A run chooses parts next to the settings (`surrogate=kriging samples=40`), so that they are no settings of the method itself.

    Args:
        help: noun phrase for the help and the documentation.
        at_least: smallest legal number.
    """
    return dataclasses.field(metadata={"help": help, "is_part": True, "at_least": at_least})


def own_fields(settings: type) -> list[dataclasses.Field[Any]]:
    """The fields of a plugin that are its own settings, its parts left out."""
    return [field for field in dataclasses.fields(settings) if not field.metadata.get("is_part")]


def part_fields(settings: type) -> list[dataclasses.Field[Any]]:
    """The fields of a plugin that hold its parts."""
    return [field for field in dataclasses.fields(settings) if field.metadata.get("is_part")]


@dataclass(frozen=True)
class Settings(ABC):  # noqa: B024 – the contracts that derive from it have abstract methods
    """Base of settings that checks each field's type and range.

    A subclass is a frozen dataclass whose fields are made by `setting`; it overrides `check` for conditions between fields.

    Raises:
        SettingError: a value is not of the field's type, range or choices, or `check` raises it.
    """

    def __post_init__(self) -> None:
        require_free_names(type(self))
        check_values(type(self), vars(self))
        self.check()

    def check(self) -> None:  # noqa: B027 – may be left out
        """Check conditions between fields.

        Default: none.

        Raises:
            SettingError: the fields do not fit each other.
        """

    def fingerprint(self) -> str:
        """Hash of the content of a file that the settings name but do not hold.

        If it changes, results are stale.

        Default: '', they name none.
        """
        return ""

    def seeded(self, seed: int) -> AbstractContextManager[None]:
        """Seed the generators that a library shares globally (torch, …) for a block, and restore them.

        Default: nothing to seed; `random` and `numpy.random` are always seeded.

        Args:
            seed: seed of the block.
        """
        return nullcontext()

    @property
    def parts(self) -> Sequence[Settings]:
        """Plugins that take part without being chosen by the run itself, such as effects.

        Default: empty.
        """
        return ()


RESERVED = {
    "name": "by which the plugin itself is chosen",
    "check": "which checks the settings",
    "fingerprint": "which is the hash of a file that the settings name",
    "seeded": "which seeds the generators of a library",
    "parts": "which are plugins that take part",
}


@cache
def require_free_names(settings: type) -> None:
    """Raise `SettingError` if a setting has a name that every plugin uses for something else."""
    for each in own_fields(settings):
        if each.name in RESERVED:
            raise SettingError(
                f"{settings.__name__}: expected another name of a setting than '{each.name}', {RESERVED[each.name]}; rename it,"
                f" such as {each.name}_of_library"
            )


def check_values(settings: type, values: Mapping[str, Any]) -> None:
    """Raise `SettingError` if a value by the name of its setting has a wrong type, range or choice."""
    for name, hint, metadata in _checked_fields(settings):
        if name in values:
            _check_field(name, hint, metadata, values[name])


@cache
def _checked_fields(settings: type) -> tuple[tuple[str, Any, Mapping[str, Any]], ...]:
    """Name, type and metadata of each field; of a class whose types cannot be resolved any type is taken."""
    try:
        hints = typing.get_type_hints(settings)
    except NameError:  # made inside a function, of types that are known there alone
        hints = {}
    return tuple((field.name, hints.get(field.name, Any), field.metadata) for field in dataclasses.fields(settings))


def expected_range(metadata: Any) -> str:
    """Accepted values of a field in words: 'a number above 0 and at most 2'."""
    limits = []
    if metadata.get("above") is not None:
        limits.append(f"above {metadata['above']:g}")
    if metadata.get("at_least") is not None:
        limits.append(f"at least {metadata['at_least']:g}")
    if metadata.get("at_most") is not None:
        limits.append(f"at most {metadata['at_most']:g}")
    return " and ".join(limits)


def _check_field(name: str, hint: Any, metadata: Mapping[str, Any], value: Any) -> None:
    if not is_of(value, hint):
        raise SettingError(f"expected {in_words(hint)}, got {described(value)}", setting=name)
    choices = metadata.get("choices")
    entries = value if isinstance(value, (list, tuple)) else [value]
    for entry in entries:
        if choices and entry is not None and entry not in choices:
            wrong = unknown(f"value for {name}:", str(entry), choices)
            wrong.setting = name
            raise wrong
        if isinstance(entry, numbers.Real) and not isinstance(entry, bool) and not _in_range(entry, metadata):
            legal = expected_range(metadata) or "that is finite"
            raise SettingError(f"expected a number {legal}, got {entry}", setting=name)


def _in_range(value: numbers.Real, metadata: Any) -> bool:
    above, at_least, at_most = (metadata.get(key) for key in ("above", "at_least", "at_most"))
    return (
        math.isfinite(value)
        and (above is None or value > above)
        and (at_least is None or value >= at_least)
        and (at_most is None or value <= at_most)
    )

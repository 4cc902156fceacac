"""Settings of plugins: frozen dataclasses whose fields carry their documentation, unit, source and legal range.

A plugin's settings are its dataclass fields. `setting` writes one, `Settings` checks them all when an instance is
made, so a plugin built by hand is as safe as one that came from a command line.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
from dataclasses import dataclass
from typing import Any

from ksmea.errors import SettingError, unknown


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
    """A dataclass field with its documentation and legal range; a mutable default is copied per instance.

    `None` is legal where the field's type admits it; ranges then apply to other values only. A range on a list
    applies to each of its entries.
    """
    limits = {"at_least": at_least, "above": above, "at_most": at_most}
    metadata = {"help": help, "unit": unit, "source": source, "choices": choices, **limits}
    if isinstance(default, (list, dict)):
        return dataclasses.field(default_factory=lambda: default.copy(), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Settings:
    """Base of settings that checks each field's range; override `check` for conditions between fields."""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            _check_field(field, getattr(self, field.name))
        self.check()

    def check(self) -> None:
        """Raise `SettingError` where the fields do not fit each other."""


def expected_range(metadata: Any) -> str:
    """What a field accepts, in words: 'a number above 0 and at most 2'."""
    limits = []
    if metadata.get("above") is not None:
        limits.append(f"above {metadata['above']:g}")
    if metadata.get("at_least") is not None:
        limits.append(f"at least {metadata['at_least']:g}")
    if metadata.get("at_most") is not None:
        limits.append(f"at most {metadata['at_most']:g}")
    return " and ".join(limits)


def _check_field(field: dataclasses.Field, value: Any) -> None:
    choices = field.metadata.get("choices")
    if choices and value is not None and value not in choices:
        raise unknown(f"value for {field.name}:", str(value), choices)
    entries = value if isinstance(value, (list, tuple)) else [value]
    for entry in entries:
        if isinstance(entry, numbers.Real) and not isinstance(entry, bool) and not _in_range(entry, field.metadata):
            raise SettingError(
                f"{field.name}: expected a number {expected_range(field.metadata) or 'that is finite'}, got {entry}"
            )


def _in_range(value: float, metadata: Any) -> bool:
    above, at_least, at_most = (metadata.get(key) for key in ("above", "at_least", "at_most"))
    return (
        math.isfinite(value)
        and (above is None or value > above)
        and (at_least is None or value >= at_least)
        and (at_most is None or value <= at_most)
    )

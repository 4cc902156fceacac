"""Records: what a study found, as frozen data that go to JSON and come back.

A record's fields are plain numbers, texts, tuples, mappings and further frozen dataclasses; arrays are nested tuples. JSON
has no infinity: what is not finite, as the open end of an interval, is None.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import msgspec

from ksmea.arrays import Array
from ksmea.errors import SettingError

DRAWN_DIGITS = 5  # of what is only drawn


@dataclass(frozen=True)
class Record:
    """Base of the records of studies.

    Fields that came later have a default, so that older records stay readable; `upgraded` adapts data if a field
    changed its name or form.
    """

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """Record that JSON data hold.

        Args:
            data: JSON data; entries that belong to other things (a run's key, its session) are ignored.

        Raises:
            SettingError: the data do not have the record's fields.
        """
        try:
            record = msgspec.convert(cls.upgraded(data), cls)
        except (
            ValueError,
            TypeError,
            LookupError,
            AttributeError,
            RecursionError,
        ) as error:  # the latter of `upgraded`
            raise SettingError(f"{cls.__name__}: expected its fields, could not read them: {error}") from error
        record.check()
        return record

    def check(self) -> None:
        """Check fields that were read.

        Default: they always fit each other.

        Raises:
            SettingError: fields do not fit each other.
        """

    def to_data(self) -> dict[str, Any]:
        """JSON data: mappings, lists, numbers, texts and None."""
        data: dict[str, Any] = msgspec.to_builtins(self, enc_hook=_builtin)
        return data

    def shown_data(self) -> dict[str, Any]:
        """Data for files: `to_data`, the most important values first. Default: `to_data`."""
        return self.to_data()

    @classmethod
    def upgraded(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Data of any version that ever wrote them in the present form.

        Args:
            data: JSON data of a record.
        """
        return data


def finite(value: float) -> float | None:
    """A number as JSON has it: None if it is infinite or none."""
    return float(value) if math.isfinite(value) else None


def rounded(value: float, digits: int = DRAWN_DIGITS) -> float:
    return float(f"{value:.{digits}g}")


def series(values: Array) -> tuple[float, ...]:
    """Numbers (n,) to the digits that a figure shows."""
    return tuple(map(rounded, values.tolist()))


def renamed(data: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Older data with the present names of fields."""
    return {names.get(name, name): value for name, value in data.items()}


def _builtin(value: Any) -> Any:
    """Numbers and arrays of numpy as numbers and lists of Python."""
    return value.tolist()

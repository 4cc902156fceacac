"""Effects hidden in synthetic data: in the data, but not in the fitted model."""
# Shorter than 40 lines: one record a file.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ksmea.records.record import Record


@dataclass(frozen=True)
class TrueValue(Record):
    """The true value of an unknown of a hidden effect, in its unit."""

    name: str
    unit: str
    value: float

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.4g} {self.unit}"


@dataclass(frozen=True)
class HiddenEffect(Record):
    """An effect that synthetic data hide, by its registered name, with its location in words."""

    effect: str
    location: str
    parameters: tuple[TrueValue, ...]

    def __str__(self) -> str:
        return f"{self.effect} ({self.location}): {', '.join(map(str, self.parameters))}"

    @classmethod
    def upgraded(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        return {"location": data.get("place"), **data}

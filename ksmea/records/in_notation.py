# Shorter than 40 lines: what four records share, and no other has.
"""Records that are shown in the units and names of a measurement's own file."""

from __future__ import annotations

import dataclasses
from typing import Any, Self

from ksmea.measurement.notation import Notation
from ksmea.records.record import Record


@dataclasses.dataclass(frozen=True)
class InNotation(Record):
    """Base of records with a field `notation`, and perhaps a `location` that has one too."""

    def shown_in(self, words: str) -> Self:
        """The record, and its location, to be shown in other units.

        Args:
            words: units such as 'mil_pp,lag' (`ksmea.measurement.notation.Notation.with_words`).
        """
        own: Any = self
        changed: dict[str, Any] = {"notation": own.notation.with_words(words)}
        if (location := getattr(own, "location", None)) is not None:
            changed["location"] = location.shown_in(words)
        return dataclasses.replace(self, **changed)


def without_default_notation(data: dict[str, Any], notation: Notation) -> dict[str, Any]:
    """JSON data of a record; without the notation if it is the default one, as older records have them."""
    return {name: each for name, each in data.items() if name != "notation" or notation != Notation()}

"""Numbers that are known to a tolerance, as sentences and a table.

They state the evidence of the data on them, and their influence on intervals.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

import pandas as pd

from ksmea.records.identification import ParameterRecord
from ksmea.records.inputs import InputRecord, Origin
from ksmea.show.text import in_columns, with_error


class HasOrigin(Protocol):
    """An unknown and the origin of its uncertainty."""

    @property
    def name(self) -> str: ...
    @property
    def origin(self) -> Origin | None: ...


MOST_LISTED = 6  # numbers that the text lists, those that moved most
HALF = 0.5  # of a variance: from where on inputs are named before noise


def lines(inputs: Sequence[InputRecord], parameters: Sequence[ParameterRecord] = ()) -> Iterator[str]:
    """Sentences on numbers that are known to a tolerance and on what they do to the intervals of unknowns."""
    if not inputs:
        return
    yield (
        f"Values and intervals allow for {len(inputs)} numbers that are known to a tolerance, as stated in the rotor file;"
        f" the data tell more of {sum(each.is_seen for each in inputs)} of them."
    )
    yield from contradictions(inputs)
    yield from (f"  {line}" for line in origins(parameters))


def contradictions(inputs: Sequence[InputRecord]) -> Iterator[str]:
    """A sentence for each number that the data contradict, the largest pull first."""
    for each in sorted(inputs, key=lambda one: -abs(one.pull)):
        if each.is_contradicted:
            yield (
                f"The data contradict the {each.words}: {_found(each)} {each.unit} found, {_stated(each)} {each.unit} stated"
                f" (pull {each.pull:+.1f}); check it, or give it a larger sd."
            )


def origins(parameters: Sequence[HasOrigin]) -> Iterator[str]:
    """A sentence for each unknown on what its variance comes from."""
    for each in parameters:
        if each.origin is None or not each.origin.shares:
            continue
        words, share = each.origin.shares[0]
        inputs = each.origin.of_inputs
        said = (
            f"{each.name}: {100 * inputs:.0f} % of its variance by these numbers, {100 * (1 - inputs):.0f} % by noise"
        )
        advice = (
            f"; measure the {words} better ({100 * share:.0f} %)"
            if inputs > HALF
            else "; measure more or with less noise"
        )
        yield said + advice


def table(inputs: Sequence[InputRecord]) -> pd.DataFrame:
    """A row per number that the data see, the largest pull first."""
    seen = sorted((each for each in inputs if each.is_seen), key=lambda each: -abs(each.pull))
    rows = [[each.words, _stated(each), _found(each), f"{each.pull:+.1f}", each.unit] for each in seen]
    return pd.DataFrame(rows, columns=["number", "stated", "found", "pull", "unit"])


def text(inputs: Sequence[InputRecord]) -> str:
    """Sentences and the numbers that moved most, for a diagnosis."""
    if not inputs:
        return ""
    found = table(inputs)
    listed = f"\n{in_columns(found.head(MOST_LISTED))}" if len(found) else ""
    return "\n".join(lines(inputs)) + listed


def _found(each: InputRecord) -> str:
    return with_error(each.value / each.si_per_unit, each.sd / each.si_per_unit)


def _stated(each: InputRecord) -> str:
    return with_error(each.stated / each.si_per_unit, each.stated_sd / each.si_per_unit)

"""What a fleet's table says of one machine: its diagnosis or its identification in a row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.records.identification import IdentificationRecord, ParameterRecord
from ksmea.show import diagnosis_text, identification_text
from ksmea.show.location_words import in_short
from ksmea.show.text import noise_parts, number, with_ends
from ksmea.units import MICROMETRE

NOT_EXPLAINED = "not explained"
EXPLAINED = "explained"
JOINED = "; "  # remarks in a cell of a table


@dataclass(frozen=True)
class Value:
    """An unknown of one machine in its unit; an end of its interval that is open is not a number."""

    name: str
    unit: str
    value: float
    low: float
    high: float

    def __str__(self) -> str:
        has_interval = not np.isnan([self.low, self.high]).all()
        return with_ends(self.value, self.low, self.high) if has_interval else number(self.value)


@dataclass(frozen=True)
class MachineRow:
    """One machine: its finding in a word, what its row says beside that, its unknowns, noise and remarks, and all of it as
    text. Noise is the relative part, and the floor in m."""

    finding: str
    facts: dict[str, str | float | None]
    values: tuple[Value, ...]
    noise: tuple[float, float] | None
    remarks: tuple[str, ...]
    text: str

    def columns(self) -> dict[str, Any]:
        """Its columns in the CSV file, numbers as numbers."""
        relative, floor = (None, None) if self.noise is None else self.noise
        return {
            **self.facts,
            "noise_pct": None if relative is None else 100 * relative,
            "noise_um": None if floor is None else floor / MICROMETRE,
            **{
                f"{each.name}{end}": number
                for each in self.values
                for end, number in (("", each.value), ("_low", each.low), ("_high", each.high))
            },
            "remarks": JOINED.join(self.remarks),
        }

    def shown(self) -> dict[str, str]:
        """Its columns in tables for people."""
        return {
            **{name: said if isinstance(said, str) else number(said, 2) for name, said in self.facts.items()},
            "noise": "–" if self.noise is None else noise_parts(*self.noise),
            **self.shown_values(),
            "remarks": JOINED.join(self.remarks),
        }

    def shown_values(self) -> dict[str, str]:
        """Those of its unknowns, for example {'kxx (MN/m)': '50.03 [49.99, 50.06]'}."""
        return {f"{each.name} ({each.unit})": str(each) for each in self.values}


def diagnosed(record: DiagnosisRecord) -> MachineRow:
    """Verdict, cause with its location and sizes, and the unknowns under the model that is believed."""
    noise = diagnosis_text.believed_noise(record)
    added = [each.after for each in record.coefficients if each.before is None and each.after is not None]
    sizes = [f"{each.name} {_estimate(each)} {each.unit}" for each in added] if record.is_explained else []
    facts: dict[str, str | float | None] = {
        "verdict": record.verdict,
        "cause": _cause(record),
        "location": _location(record),
        "size": JOINED.join(sizes),
        "lack_of_fit_p": record.lack_of_fit.before.p,
    }
    values = tuple(map(_estimate, _believed(record)))
    level = (noise.relative, noise.floor)
    return MachineRow(record.verdict, facts, values, level, record.remarks, diagnosis_text.text(record))


def identified(record: IdentificationRecord) -> MachineRow:
    """Whether the model explains the data, and every unknown."""
    test, effort, data = record.lack_of_fit, record.intervals, record.data
    fit = "not tested" if test is None else NOT_EXPLAINED if test.rejected else EXPLAINED
    facts: dict[str, str | float | None] = {"fit": fit, "lack_of_fit_p": None if test is None else test.p}
    noise = None if effort is None else (effort.noise.relative, effort.noise.floor)
    remarks = () if data is None else data.remarks
    values = tuple(map(_parameter, record.parameters))
    return MachineRow(fit, facts, values, noise, remarks, identification_text.text(record))


def _cause(record: DiagnosisRecord) -> str:
    """The effects that are named; of explanations that the data do not tell apart, each."""
    if record.verdict == "ambiguous":
        labels = dict.fromkeys(each.label for each in record.explanations)
        return " or ".join(labels or record.ambiguity_group)
    return " and ".join(record.named)


def _location(record: DiagnosisRecord) -> str:
    if record.verdict == "located" and record.location is not None:
        return in_short(record.location)
    return " and ".join(effect.location for effect in record.applied if record.is_explained)


def _believed(record: DiagnosisRecord) -> Sequence[EstimateRecord]:
    """The unknowns of the model as given: beside what was found, averaged where several explanations were."""
    if record.averaged is not None:
        return record.averaged.coefficients
    if record.verdict == "located" and record.location is not None:
        return [each.plain if each.over_sites is None else each.over_sites for each in record.location.coefficients]
    own = [each for each in record.coefficients if each.before is not None]
    believed = [each.after if record.is_explained else each.before for each in own]
    return [each for each in believed if each is not None]


def _estimate(found: EstimateRecord) -> Value:
    low, high = (np.nan if end is None else end for end in (found.low, found.high))
    return Value(found.name, found.unit, found.value, low, high)


def _parameter(found: ParameterRecord) -> Value:
    return Value(found.name, found.unit, *(found.in_unit(value) for value in (found.value, found.low, found.high)))

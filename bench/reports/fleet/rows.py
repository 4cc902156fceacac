"""Row of a fleet's table: diagnosis or identification of one machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ksmea.measurement.notation import Notation
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import EstimateRecord, Shown
from ksmea.records.identification import IdentificationRecord
from ksmea.show import diagnosis_text, identification_text
from ksmea.show.location_words import in_short
from ksmea.show.readings import PLAIN
from ksmea.show.text import noise_parts, number, with_ends
from ksmea.units import MICROMETRE

NOT_EXPLAINED = "not explained"
EXPLAINED = "explained"
JOINED = "; "  # remarks in a cell of a table


@dataclass(frozen=True)
class MachineRow:
    """Machine of a fleet: finding, row, unknowns, noise, remarks and text.

    Noise is the relative part, and the floor in m. `shown_facts` are in the `notation` of the file.
    """

    finding: str
    facts: dict[str, str | float | None]
    values: Mapping[str, Shown]  # by name
    noise: tuple[float, float] | None
    remarks: tuple[str, ...]
    text: str
    notation: Notation = PLAIN
    shown_facts: Mapping[str, str] = field(default_factory=dict)

    def columns(self) -> dict[str, Any]:
        """Its columns in the CSV file, numbers as numbers."""
        relative, floor = (None, None) if self.noise is None else self.noise
        return {
            **self.facts,
            "noise_pct": None if relative is None else 100 * relative,
            "noise_um": None if floor is None else floor / MICROMETRE,
            **{
                f"{name}{end}": number
                for name, each in self.values.items()
                for end, number in (("", each.value), ("_low", each.low), ("_high", each.high))
            },
            "remarks": JOINED.join(self.remarks),
        }

    def shown(self) -> dict[str, str]:
        """Its columns in tables for people."""
        return {
            **{name: said if isinstance(said, str) else number(said, 2) for name, said in self.facts.items()},
            **self.shown_facts,
            "noise": "–" if self.noise is None else noise_parts(*self.noise, self.notation),
            **self.shown_values(),
            "remarks": JOINED.join(self.remarks),
        }

    def shown_values(self) -> dict[str, str]:
        """Unknowns with their intervals as text, for example {'kxx (MN/m)': '50.03 [49.99, 50.06]'}."""
        return {f"{name} ({each.unit})": _said(each) for name, each in self.values.items()}


def diagnosed(record: DiagnosisRecord) -> MachineRow:
    """Verdict, cause with its location and sizes, and the unknowns of the accepted model, else as given."""
    noise = diagnosis_text.believed_noise(record)
    added = [each.after for each in record.coefficients if each.before is None and each.after is not None]
    sizes = [f"{each.name} {_said(each.shown)} {each.unit}" for each in added] if record.is_explained else []
    facts: dict[str, str | float | None] = {
        "verdict": record.verdict,
        "cause": _cause(record),
        "location": _location(record, PLAIN),
        "size": JOINED.join(sizes),
        "lack_of_fit_p": record.lack_of_fit.before.p,
    }
    values = {each.name: each.shown for each in _believed(record)}
    level = (noise.relative, noise.floor)
    said = {"location": _location(record, record.notation)}
    text = diagnosis_text.text(record)
    return MachineRow(record.verdict, facts, values, level, record.remarks, text, record.notation, said)


def identified(record: IdentificationRecord) -> MachineRow:
    """Whether the model explains the data, and every unknown."""
    test, effort, data = record.lack_of_fit, record.intervals, record.data
    fit = "not tested" if test is None else NOT_EXPLAINED if test.rejected else EXPLAINED
    facts: dict[str, str | float | None] = {"fit": fit, "lack_of_fit_p": None if test is None else test.p}
    noise = None if effort is None else (effort.noise.relative, effort.noise.floor)
    remarks = (*(() if data is None else data.remarks), *record.remarks)
    values = {each.name: each.shown for each in record.parameters}
    return MachineRow(fit, facts, values, noise, remarks, identification_text.text(record), record.notation)


def _cause(record: DiagnosisRecord) -> str:
    """The effects that are named; of explanations that the data do not tell apart, each."""
    if record.verdict == "ambiguous":
        labels = dict.fromkeys(each.label for each in record.explanations)
        return " or ".join(labels or record.ambiguity_group)
    return " and ".join(record.named)


def _location(record: DiagnosisRecord, notation: Notation) -> str:
    if record.verdict == "located" and record.location is not None:
        return in_short(record.location)
    return " and ".join(notation.name(effect.location) for effect in record.applied if record.is_explained)


def _believed(record: DiagnosisRecord) -> Sequence[EstimateRecord]:
    """The unknowns of the model as given.

    Next to what was found, averaged where several explanations were.
    """
    if record.averaged is not None:
        return record.averaged.coefficients
    if record.verdict == "located" and record.location is not None:
        return [each.plain if each.over_sites is None else each.over_sites for each in record.location.coefficients]
    own = [each for each in record.coefficients if each.before is not None]
    believed = [each.after if record.is_explained else each.before for each in own]
    return [each for each in believed if each is not None]


def _said(found: Shown) -> str:
    return with_ends(found.value, found.low, found.high) if found.has_interval else number(found.value)

"""Which effects a figure ranks, by ΔBIC, and what it says of each."""
# Shorter than 40 lines: pages and figures share it.

from __future__ import annotations

from ksmea.records.diagnosis import DiagnosisRecord, TrialRecord

QUANTITY = "ΔBIC in favour of the effect"
LINEAR = 10.0  # of ΔBIC: the axis is linear up to here to both sides, and logarithmic beyond
NAMED, AS_WELL, OTHER = "named", "explains the data about as well", "other effects"


def best_trials(record: DiagnosisRecord) -> list[TrialRecord]:
    """The trial of each effect at its best location, in the order of the ranking."""
    best: dict[str, TrialRecord] = {}
    for trial in record.ranking:
        best.setdefault(trial.effect, trial)
    return list(best.values())


def standing(record: DiagnosisRecord, effect: str) -> str:
    """Whether an effect is named, explains the data about as well, or is one of the others: with a misfit that is large enough,
    nearly every effect lowers the deviance significantly."""
    if effect in record.named:
        return NAMED
    return AS_WELL if effect in record.ambiguity_group else OTHER

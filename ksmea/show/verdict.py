"""The verdict of a diagnosis in a line."""

from __future__ import annotations

from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.show.location_words import in_short, over_the_shaft


def verdict_line(record: DiagnosisRecord) -> str:
    """The verdict and what it names or locates, for example 'Verdict: named – runout (at 0.1 m)', and whether left-out data
    fail to confirm it."""
    return f"{_verdict(record)}{_doubt(record)}"


def headline(record: DiagnosisRecord) -> str:
    """The same with what explains the data as well."""
    stated = {*record.named, *(each.label for each in record.explanations[:1])}  # the first is the best one
    others = [each for each in alike(record) if each not in stated]
    also = f", or as well {' or '.join(others)}" if record.verdict == "ambiguous" and others else ""
    return f"{_verdict(record)}{also}{_doubt(record)}"


def _verdict(record: DiagnosisRecord) -> str:
    if record.verdict == "located" and record.location is not None:
        return f"Verdict: located – an unknown {in_short(record.location)}"
    if record.verdict == "misread":
        return f"Verdict: misread – {record.reading.split(':')[0]}"
    if record.verdict == "unknown" and record.location is not None and record.location.is_spread:
        return f"Verdict: unknown – {over_the_shaft(record.location)}"
    return f"Verdict: {record.verdict}" + (f" – {applied(record)}" if record.is_explained else "")


def _doubt(record: DiagnosisRecord) -> str:
    gain = record.predictive_gain
    is_doubtful = record.is_explained and gain is not None and not gain.is_supported
    return "; left-out data do not confirm it" if is_doubtful else ""


def applied(record: DiagnosisRecord) -> str:
    """The effects of the extended model with their locations."""
    return " and ".join(f"{effect.name} ({effect.location})" for effect in record.applied)


def alike(record: DiagnosisRecord) -> tuple[str, ...]:
    """The effects, or where these explain the data the pairs of them, that explain the data about as well."""
    pairs = dict.fromkeys(each.label for each in record.explanations if len(each.effects) > 1)
    return tuple(pairs) or record.ambiguity_group

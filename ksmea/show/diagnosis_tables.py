"""The tables of a diagnosis as text and pages show them: every number as its interval lets it be told, '–' where there is none."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from ksmea.records.diagnosis import DiagnosisRecord, TrialRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.show.text import number, of_chances, value_and_ends, with_ends


def ranking_table(trials: Sequence[TrialRecord]) -> pd.DataFrame:
    """A row per effect at a location, with the sizes of its unknowns."""
    head = ["effect", "location", "ΔBIC", "p", "size"]
    return pd.DataFrame([[*_evidence(each), ", ".join(map(sized, each.parameters))] for each in trials], columns=head)


def trials_table(trials: Sequence[TrialRecord]) -> pd.DataFrame:
    """A row per unknown of each effect at each location."""
    head = [
        "rank",
        "effect",
        "location",
        "ΔBIC",
        "p",
        "unknown",
        "size",
        "interval",
        "unit",
        "kind",
        "at limit",
        "deviance drop",
    ]
    rows = [
        [
            *(str(rank), *_evidence(each), part.name, *_in_columns(part), part.unit, part.interval),
            *("yes" if part.at_limit else "no", f"{each.deviance_drop:.1f}"),
        ]
        for rank, each in enumerate(trials, start=1)
        for part in each.parameters
    ]
    return pd.DataFrame(rows, columns=head)


def unknowns_table(record: DiagnosisRecord) -> pd.DataFrame:
    """Every unknown of the model as given; beside it, where an extension explains the data, with that (`after`), with the
    extension's own, and averaged over all explanations where there are several. Intervals are those of models that are not rejected."""
    if all(row.after is None for row in record.coefficients):
        own = [row.before for row in record.coefficients if row.before is not None]
        if record.is_rejected:
            return pd.DataFrame([[each.name, number(each.value), each.unit] for each in own], columns=["unknown", "value", "unit"])
        rows = [[each.name, *_in_columns(each), each.unit] for each in own]
        return pd.DataFrame(rows, columns=["unknown", "value", "interval", "unit"])
    averaged = averaged_values(record)
    columns = {
        "unknown": [row.name for row in record.coefficients],
        "before": [_cell(row.before, with_interval=not record.is_rejected) for row in record.coefficients],
        "after": [_cell(row.after, with_interval=record.is_explained) for row in record.coefficients],
    }
    if averaged:
        columns["averaged"] = [_cell(averaged.get(row.name)) for row in record.coefficients]
    return pd.DataFrame(columns | {"unit": [_unit(row.before, row.after) for row in record.coefficients]})


def averaged_values(record: DiagnosisRecord) -> dict[str, EstimateRecord]:
    """Unknowns averaged over all explanations, by name; empty where there is one."""
    return {} if record.averaged is None else {each.name: each for each in record.averaged.coefficients}


def sized(part: EstimateRecord) -> str:
    """For example 'mass 1.20 [1.10, 1.30] kg'."""
    return f"{part.name} {_cell(part)} {part.unit}"


def _evidence(trial: TrialRecord) -> list[str]:
    return [trial.effect, trial.location, f"{trial.delta_bic:.1f}", of_chances(trial.p)]


def _cell(estimated: EstimateRecord | None, *, with_interval: bool = True) -> str:
    """A value, with its interval unless the model is rejected: that of a wrong model misleads."""
    if estimated is None:
        return "–"
    return with_ends(estimated.value, estimated.low, estimated.high) if with_interval else number(estimated.value)


def _in_columns(estimated: EstimateRecord) -> tuple[str, str]:
    return value_and_ends(estimated.value, estimated.low, estimated.high)


def _unit(*estimated: EstimateRecord | None) -> str:
    return next((each.unit for each in estimated if each is not None), "")

"""The tables of a diagnosis as text and pages show them.

Numbers to the digits that their intervals support, '–' for missing ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pandas as pd

from ksmea.records.diagnosis import DiagnosisRecord, TrialRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.show import location_text
from ksmea.show.charts.responses import AS_GIVEN, WITH_CAUSE
from ksmea.show.text import in_columns, number, of_chances, value_and_ends, with_ends

FEW = 3  # sizes of an effect in a line


def ranking_table(trials: Sequence[TrialRecord], *, with_intervals: bool = True) -> pd.DataFrame:
    """A row per effect at a location, with the sizes of its unknowns."""
    head, shown = ["effect", "location", "ΔBIC", "p", "size"], sized if with_intervals else _about
    return pd.DataFrame([[*_evidence(each), _sizes(each.parameters, shown)] for each in trials], columns=head)


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
    """Every unknown of the model as given.

    If an extension explains the data, also with that, with the extension's own, and averaged over all
    explanations where there are several. Intervals belong to models that are not rejected.
    """
    if all(row.after is None for row in record.coefficients):
        if record.is_rejected:
            return _of_rejected(record)
        own = [row.before for row in record.coefficients if row.before is not None]
        rows = [[each.name, *_in_columns(each), each.unit] for each in own]
        return pd.DataFrame(rows, columns=["unknown", "value", "interval", "unit"])
    averaged = averaged_values(record)
    columns = {
        "unknown": [row.name for row in record.coefficients],
        AS_GIVEN: [_cell(row.before, with_interval=not record.is_rejected) for row in record.coefficients],
        WITH_CAUSE: [_cell(row.after, with_interval=record.is_explained) for row in record.coefficients],
    }
    if averaged:
        columns["averaged"] = [_cell(averaged.get(row.name)) for row in record.coefficients]
    return pd.DataFrame(columns | {"unit": [_unit(row.before, row.after) for row in record.coefficients]})


def _of_rejected(record: DiagnosisRecord) -> pd.DataFrame:
    """Every unknown of the model as given, without its interval."""
    own = [row.before for row in record.coefficients if row.before is not None]
    return pd.DataFrame(
        [[each.name, number(each.value), each.unit] for each in own], columns=["unknown", "value", "unit"]
    )


def averaged_values(record: DiagnosisRecord) -> dict[str, EstimateRecord]:
    """Unknowns averaged over all explanations, by name; empty where there is one."""
    return {} if record.averaged is None else {each.name: each for each in record.averaged.coefficients}


def sized(part: EstimateRecord) -> str:
    """For example 'mass 1.20 [1.10, 1.30] kg'."""
    return f"{part.name} {_cell(part)} {part.unit}"


def _about(part: EstimateRecord) -> str:
    """For example 'mass 1.2 kg'."""
    return f"{part.name} {number(part.value, 3)} {part.unit}"


def _sizes(parts: Sequence[EstimateRecord], shown: Callable[[EstimateRecord], str]) -> str:
    """The first FEW sizes of an effect, and how many follow."""
    more = [f"and {len(parts) - FEW} more"] if len(parts) > FEW else []
    return ", ".join([*map(shown, parts[:FEW]), *more])


def _evidence(trial: TrialRecord) -> list[str]:
    return [trial.effect, trial.location, f"{trial.delta_bic:.1f}", of_chances(trial.p)]


def _cell(estimated: EstimateRecord | None, *, with_interval: bool = True) -> str:
    """A value, with its interval unless the model is rejected: intervals of a wrong model mislead."""
    if estimated is None:
        return "–"
    return with_ends(estimated.value, estimated.low, estimated.high) if with_interval else number(estimated.value)


def _in_columns(estimated: EstimateRecord) -> tuple[str, str]:
    return value_and_ends(estimated.value, estimated.low, estimated.high)


def _unit(*estimated: EstimateRecord | None) -> str:
    return next((each.unit for each in estimated if each is not None), "")


def values_beside(record: DiagnosisRecord) -> list[str]:
    """Unknowns fitted with something unknown, which hold whatever its cause.

    They are given for a cause that is located, or ambiguous.
    """
    if record.location is None or record.verdict not in ("located", "ambiguous") or not record.location.is_local:
        return []
    return [f"Values whatever the cause is:\n{table}" for table in location_text.coefficients(record.location)]


def values_of_rejected(record: DiagnosisRecord) -> str:
    """Unknowns of the model as given where it is rejected and nothing explains the data.

    They have no intervals, which do not exist for a wrong model.
    """
    if record.verdict != "unknown" or (record.location is not None and record.location.force is not None):
        return ""  # values beside what is unknown stand with the location
    table = in_columns(_of_rejected(record))
    return f"Values of the model as given, which is rejected; no interval holds for them:\n{table}" if table else ""

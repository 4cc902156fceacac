"""Values of a diagnosis as a table.

Each unknown by the accepted model, with its interval and its change by the cause.
"""

from __future__ import annotations

import pandas as pd

from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.show.diagnosis_findings import TIMES, beside
from ksmea.show.diagnosis_tables import averaged_values
from ksmea.show.statements import ANGLE, value_columns
from ksmea.show.text import number

LARGE_MOVE = 2.0  # from where on a move is said as a ratio


def value_table(record: DiagnosisRecord) -> pd.DataFrame:
    """Unknowns by the accepted model: value, interval, relative half-width, and shift by the cause.

    For a located cause they are fitted with it. A rejected model has values alone: intervals of a wrong model mislead.
    """
    averaged = averaged_values(record)
    rows = [
        {"": each.name, "value": value, "95 %": interval, "±": relative, "unit": each.unit}
        for each in beside(record)
        for value, interval, relative in [value_columns(each.shown)]
    ]
    for row in record.coefficients if not rows else ():
        if row.before is None:
            continue
        accepted = averaged.get(row.name) if averaged else row.after if record.is_explained else row.before
        accepted = accepted or row.before
        own = {"": row.name, "value": "", "95 %": "", "±": ""}
        if record.is_unexplained or (record.is_explained and row.after is None):
            rows.append(own | {"value": number(accepted.value), "unit": accepted.unit, "95 %": "wrong model"})
            continue
        value, interval, relative = value_columns(accepted.shown)
        own |= {"value": value, "95 %": interval, "±": relative, "unit": accepted.unit}
        if record.is_explained:
            own["moved by the cause"] = _moved(row.before, accepted)
        rows.append(own)
    frame = pd.DataFrame(rows)
    is_wrong = record.is_unexplained and not beside(record)
    return frame.drop(columns="±") if is_wrong and not frame.empty else frame


def _moved(before: EstimateRecord, accepted: EstimateRecord) -> str:
    """Change of a value by the cause: '−12 %', '× 3.1', of an angle '+15°' the short way round."""
    if accepted.unit == ANGLE:
        turned = (accepted.value - before.value + 180) % 360 - 180
        return f"{number(turned, 2, '+').replace('-', '−')}°"
    if not before.value:
        return ""
    ratio = accepted.value / before.value
    moved = number(100 * (ratio - 1), 2, "+").replace("-", "−")
    return f"{TIMES} {number(ratio, 2)}" if ratio > LARGE_MOVE else f"{moved} %"

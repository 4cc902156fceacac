"""Values of a diagnosis as a table.

Each unknown by the accepted model, with its interval and its change by the cause.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import EstimateRecord, Shown
from ksmea.show.diagnosis_findings import DEGREES, TIMES, beside
from ksmea.show.diagnosis_tables import averaged_values
from ksmea.show.statements import half_width, rounded
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
        for value, interval, relative in [_in_columns(each.shown)]
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
        value, interval, relative = _in_columns(accepted.shown)
        own |= {"value": value, "95 %": interval, "±": relative, "unit": accepted.unit}
        if record.is_explained:
            own["moved by the cause"] = _moved(row.before, accepted)
        rows.append(own)
    frame = pd.DataFrame(rows)
    is_wrong = record.is_unexplained and not beside(record)
    return frame.drop(columns="±") if is_wrong and not frame.empty else frame


def _in_columns(shown: Shown) -> tuple[str, str, str]:
    """Value, interval and relative half-width: ('50.05', '± 0.05', '0.1 %'), or ('0.9', 'above 0.66', '').

    An angle has no relative half-width: its zero is a convention.
    """
    half = half_width(shown)
    if half is None:
        return number(shown.value, 3), "not determined", ""
    if np.isfinite([shown.low, shown.high]).all():
        share = f"{number(100 * half / abs(shown.value), 2)} %" if shown.value and shown.unit != DEGREES else ""
        return rounded(shown.value, half), f"± {rounded(half, half)}", share
    word, end = ("above", shown.low) if np.isfinite(shown.low) else ("below", shown.high)
    return rounded(shown.value, half), f"{word} {rounded(end, half)}", ""


def _moved(before: EstimateRecord, accepted: EstimateRecord) -> str:
    """Change of a value by the cause: '−12 %', '× 3.1', of an angle '+15°' the short way round."""
    if accepted.unit == DEGREES:
        turned = (accepted.value - before.value + 180) % 360 - 180
        return f"{number(turned, 2, '+').replace('-', '−')}°"
    if not before.value:
        return ""
    ratio = accepted.value / before.value
    moved = number(100 * (ratio - 1), 2, "+").replace("-", "−")
    return f"{TIMES} {number(ratio, 2)}" if ratio > LARGE_MOVE else f"{moved} %"

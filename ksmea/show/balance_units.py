"""A balancing in the units and names of a notation, for texts, tables and charts.

Vibrations, their angles and the names of channels are converted. Angles of weights are places on the rotor: they count in
the direction of rotation in any notation. Speeds stay in rad/s.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ksmea.measurement.notation import LAG, Notation
from ksmea.records.balancing import BalanceRecord, CorrectionRecord, EntryRecord, PolarRecord
from ksmea.show.readings import deviation_unit, speed_digits, speed_unit, vibration_unit
from ksmea.units import MICROMETRE


def in_units(record: BalanceRecord, notation: Notation) -> BalanceRecord:
    """Copy of a record to be shown, with vibrations in the unit of a notation instead of µm.

    >>> from ksmea.measurement.notation import Notation
    >>> shown = _polar(PolarRecord(25.4, 30.0, 12.7, 38.1, 20.0, 50.0), Notation("mil", "pp", "lag"))
    >>> round(shown.size, 9), shown.angle, shown.angle_low, shown.angle_high
    (2.0, 330.0, 310.0, 340.0)
    """
    return replace(
        record,
        entries=tuple(_entry(each, notation) for each in record.entries),
        bare=_polars(record.bare, notation),
        planes=tuple(replace(plane, coefficients=_polars(plane.coefficients, notation)) for plane in record.planes),
        correction=_correction(record.correction, notation),
        spread=tuple(
            replace(
                each,
                entry=_entry(each.entry, notation),
                spread=_size(each.spread, notation),
                drift=_size(each.drift, notation),
                repeats=_size(each.repeats, notation),
            )
            for each in record.spread
        ),
        entry_misfits=tuple(
            replace(
                each,
                entry=_entry(each.entry, notation),
                measured=_polar(each.measured, notation),
                expected=_polar(each.expected, notation),
            )
            for each in record.entry_misfits
        ),
        drift=tuple(
            replace(
                each,
                entry=_entry(each.entry, notation),
                real=tuple(value * _scale(notation) for value in each.real),
                imaginary=tuple(value * _scale(notation) for value in each.imaginary),
            )
            for each in record.drift
        ),
    )


def influence_unit(weights: str, notation: Notation) -> str:
    """Unit of influence coefficients of weights in a unit.

    >>> from ksmea.measurement.notation import Notation
    >>> influence_unit("g mm", Notation()), influence_unit("oz in", Notation("mil", "pp"))
    ('µm/(g mm)', 'mil pp/(oz in)')
    """
    return f"{deviation_unit(notation)}/({weights})"


def entry_name(entry: EntryRecord, notation: Notation) -> str:
    """Speed and channel of an entry, for example '1005 rpm, 3X'."""
    return f"{speed_digits(entry.speed / speed_unit(notation), notation)} {notation.speed}, {entry.channel}"


def _correction(found: CorrectionRecord, notation: Notation) -> CorrectionRecord:
    return replace(
        found,
        bare=_polars(found.bare, notation),
        left=_polars(found.left, notation),
        left_common=_polars(found.left_common, notation),
        left_split=_polars(found.left_split, notation),
    )


def _entry(entry: EntryRecord, notation: Notation) -> EntryRecord:
    return replace(entry, channel=notation.name(entry.channel))


def _polars(values: Iterable[PolarRecord], notation: Notation) -> tuple[PolarRecord, ...]:
    return tuple(_polar(each, notation) for each in values)


def _polar(value: PolarRecord, notation: Notation) -> PolarRecord:
    """Size and angle with their intervals; a lag from 0 to 360, a lead as it stands in the record."""
    size, low, high = value.size * _scale(notation), _size(value.low, notation), _size(value.high, notation)
    if notation.phase != LAG:
        return replace(value, size=size, low=low, high=high)
    angle = notation.angle(value.angle)
    turned = [None if end is None else angle + value.angle - end for end in (value.angle_high, value.angle_low)]
    return PolarRecord(size, angle, low, high, *turned)


def _size(value: float | None, notation: Notation) -> float | None:
    return None if value is None else value * _scale(notation)


def _scale(notation: Notation) -> float:
    """Units of the notation in a µm 0-peak; exactly 1 without a notation."""
    return MICROMETRE / vibration_unit(notation)

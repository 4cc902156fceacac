"""A record as JSON for people and other programs: every number with its unit beside it, and as texts show it.

The fields of the record stay as they are, so that `from_data` reads it back, and neighbours are added to them:
`floor` (m) has `floor_unit` ("m") and `floor_um`; a value in SI beside `unit` and `si_per_unit` is in `in_unit` too. A file says
at its top which way the values of its unknowns have their unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any

from ksmea.records.record import Record
from ksmea.show.units_of_records import IN_UNIT, STATUS, UNITS, Quantity

OTHERS = "other numbers have theirs beside them (`floor_unit`) or in their name (`floor_um`), or have none"
IN_SI = f"values of unknowns are in SI, and under `in_unit` in their `unit`; {OTHERS}"
BESIDE_UNIT = f"values of unknowns are in the `unit` beside them; {OTHERS}"

PAIR = 2  # numbers up to which a list is told in the units of texts too; curves are not


def with_units(record: Record) -> dict[str, Any]:
    """What `record.told()` has, the units, and first how they are given; a record of which no unit is known as it is.

    >>> from ksmea.records.estimate import NoiseLevelRecord
    >>> with_units(NoiseLevelRecord(0.05, 2e-8))["floor_um"]
    0.02
    """
    told: dict[str, Any] = record.told()
    labelled = _labelled(record, told)
    is_si = any(type(each) in IN_UNIT for each in getattr(record, "parameters", ()))
    return told if labelled == told else {"units": IN_SI if is_si else BESIDE_UNIT, **labelled}


def _labelled(value: Any, data: Any) -> Any:
    """JSON data of a value, with the neighbours of every field in it that is a record."""
    if isinstance(value, Mapping) and isinstance(data, dict):
        return {name: _labelled(value.get(name), part) for name, part in data.items()}
    if isinstance(value, tuple) and isinstance(data, (list, tuple)):
        return [_labelled(*each) for each in zip(value, data)] if any(map(is_dataclass, value)) else data
    if not is_dataclass(value) or not isinstance(data, dict):
        return data
    found: dict[str, Any] = {}
    for name, part in data.items():
        found[name] = _labelled(getattr(value, name, None), part)
        if part not in (None, [], ()) and (quantity := _quantity(value, name)) is not None:
            found[f"{name}_unit"] = quantity.unit
            if quantity.shown and (shown := _in_unit(part, quantity.size)) is not None:
                found[f"{name}_{quantity.shown}"] = shown
        if status := STATUS.get((type(value), name)):
            found[f"{name}_status"] = status(value)
    if names := IN_UNIT.get(type(value), ()):
        found["in_unit"] = {name: _in_unit(getattr(value, name), data["si_per_unit"]) for name in names}
    return found


def _quantity(record: Any, name: str) -> Quantity | None:
    told = UNITS.get(type(record), {}).get(name)
    return told if told is None or isinstance(told, Quantity) else told(record)


def _in_unit(value: Any, size: float) -> Any:
    """A number, or one of a pair, in a unit of this size in SI; None of what is neither."""
    if isinstance(value, (list, tuple)):
        parts = [_in_unit(each, size) for each in value] if 0 < len(value) <= PAIR else [None]
        return None if None in parts else parts
    return None if value is None or isinstance(value, (bool, str)) else value / size

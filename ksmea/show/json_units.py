"""Record as JSON for people and other programs: every number with its unit, and as texts show it.

The fields of the record stay as they are, so that `from_data` reads it back, and neighbours are added to them:
`floor` (m) has `floor_unit` ("m") and `floor_um`; a value in SI with `unit` and `si_per_unit` is in `in_unit` too. The top of a
file states which of the two holds for its unknowns. Units stand in the types of fields (`ksmea.units.Quantity`); a field of a type
without one has no unit, has a field `unit` next to it, or has it in its name (`seconds`, `reduction_pct`). Where null alone would not
say why there is nothing, a property `…_status` of the record does. `IN_UNIT` of a record names what is in SI next to `unit` and
`si_per_unit`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from ksmea.records.record import Record
from ksmea.units import Quantity

Rule = Quantity | Callable[[Any], Quantity | None]

OTHERS = "other numbers have a unit next to them (`floor_unit`), in their name (`floor_um`), or no unit"
IN_SI = f"values of unknowns are in SI, and under `in_unit` in their `unit`; {OTHERS}"
BESIDE_UNIT = f"values of unknowns are in the `unit` next to them; {OTHERS}"

PAIR = 2  # numbers up to which a list is told in the units of texts too; curves are not


def with_units(record: Record) -> dict[str, Any]:
    """Data of `record.shown_data()` with units, preceded by how they are given.

    Unchanged if no unit is known.

    >>> from ksmea.records.estimate import NoiseLevelRecord
    >>> with_units(NoiseLevelRecord(0.05, 2e-8))["floor_um"]
    0.02
    """
    data: dict[str, Any] = record.shown_data()
    labelled = _labelled(record, data)
    is_si = any(hasattr(each, "IN_UNIT") for each in getattr(record, "parameters", ()))
    return data if labelled == data else {"units": IN_SI if is_si else BESIDE_UNIT, **labelled}


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
        if status := getattr(value, f"{name}_status", None):
            found[f"{name}_status"] = status
    if names := getattr(value, "IN_UNIT", ()):
        found["in_unit"] = {name: _in_unit(getattr(value, name), data["si_per_unit"]) for name in names}
    return found


@cache
def units_of(record: type) -> Mapping[str, Rule]:
    """Unit of each field and property of a dataclass whose type has one, or the function that gives it.

    The function is of a result.
    """
    hints = get_type_hints(record, include_extras=True)
    for name, member in inspect.getmembers(record, lambda member: isinstance(member, property)):
        hints[name] = get_type_hints(member.fget, include_extras=True).get("return")
    return {name: rule for name, hint in hints.items() if (rule := _rule(hint)) is not None}


def _rule(hint: Any) -> Rule | None:
    """Unit of the first annotated part of a type."""
    if get_origin(hint) is Annotated:
        own: Rule = hint.__metadata__[0]
        return own
    return next((rule for part in get_args(hint) if (rule := _rule(part)) is not None), None)


def _quantity(record: Any, name: str) -> Quantity | None:
    rule = units_of(record.__class__).get(name)
    return rule if rule is None or isinstance(rule, Quantity) else rule(record)


def _in_unit(value: Any, size: float) -> Any:
    """A number, or one of a pair, in a unit of this size in SI; None of what is neither."""
    if isinstance(value, (list, tuple)):
        parts = [_in_unit(each, size) for each in value] if 0 < len(value) <= PAIR else [None]
        return None if None in parts else parts
    return None if value is None or isinstance(value, (bool, str)) else value / size

"""Unknowns of a rotor file, and the numbers of the rotor that each sets.

Examples are `bearing 2 kxx` and `support 1 mass`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from ksmea.errors import described, unknown
from ksmea.problem.parameters import Parameter, Prior
from ksmea.settings.document import Block, Units
from ksmea.units import Unit
from problems.rotor.finite_elements.bearing import COEFFICIENTS
from problems.rotor.response.unknown_checks import numbers_set_by
from problems.rotor.response.unknowns import (
    FACTORS,
    PEDESTAL_PARTS,
    UNBALANCE_PARTS,
    BearingTarget,
    PedestalTarget,
    Target,
    UnbalanceTarget,
    Unknown,
)
from problems.rotor_document.bearings import QUANTITY_OF_PART
from problems.rotor_document.stated_numbers import deviation

FACTOR = "factor"  # the quantity of a number without unit
LARGEST_FACTOR = 1e6
IN_WORDS = {f"{name.removesuffix('_factor')} factor": name for name in FACTORS}  # as a file says them
OF_ENTRIES = [f"{name} factor" for name in COEFFICIENTS]  # left out where all that may be set is listed
PARTS = {  # what a target may set of which thing
    "bearing": (*COEFFICIENTS, *IN_WORDS),
    "seal": (*COEFFICIENTS, *IN_WORDS),
    "support": PEDESTAL_PARTS,
    "unbalance": UNBALANCE_PARTS,
}
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def read_unknowns(
    blocks: Sequence[Block], units: Units, counts: Mapping[str, int]
) -> tuple[tuple[Unknown, ...], dict[str, float]]:
    """The unknowns, and the reference values of all that have one, SI.

    `counts` says how many of each thing there are.
    """
    unknowns: list[Unknown] = []
    reference: dict[str, float] = {}
    owners: dict[object, str] = {}
    for block in blocks:
        block.check_keys(("name", "lower", "upper", "sets"), ["reference", "value", "sd"])
        name = block.text("name")
        if not NAME.fullmatch(name):
            raise block.error("name", f"expected letters, digits and _ after a letter, got {described(name)}")
        if name in (item.parameter.name for item in unknowns):
            raise block.error("name", f"expected each name once, got '{name}' again")
        targets, quantity = _targets(block, counts, owners)
        owners |= {number: name for target in targets for number in numbers_set_by(target)}
        if quantity == FACTOR:
            unit = Unit("times table", 1.0)
            lower = block.number("lower", at_least=0)
            upper = block.number("upper", above=lower, at_most=LARGEST_FACTOR)
            value = block.number("reference", at_least=lower, at_most=upper) if "reference" in block.values else None
        else:
            unit = units.unit(quantity)
            lower = units.value(block, "lower", quantity, **({"at_least": 0} if quantity == "unbalance" else {}))
            upper = units.value(block, "upper", quantity, above=lower)
            has_value = "reference" in block.values
            value = units.value(block, "reference", quantity, at_least=lower, at_most=upper) if has_value else None
        parameter = Parameter(name, unit.name, unit.si, lower * unit.si, upper * unit.si, prior=_prior(block, unit))
        unknowns.append(Unknown(parameter, targets))
        if value is not None:
            reference[name] = value * unit.si
    return tuple(unknowns), reference


def _prior(block: Block, unit: Unit) -> Prior | None:
    """Prior of an unknown, value and standard deviation before any measurement.

    None if the file has no prior.
    """
    given = [key for key in ("value", "sd") if key in block.values]
    if not given:
        return None
    if len(given) < 2:
        missing = "sd" if given == ["value"] else "value"
        raise block.error(missing, f"expected a number with {given[0]}, got nothing; give both or none")
    value = block.number("value", unit.name, at_least=block.number("lower"), at_most=block.number("upper"))
    sd = deviation(block, "sd", value)
    if not sd:
        raise block.error("sd", "expected more than 0; an exact number is not an unknown")
    return Prior(value * unit.si, sd * unit.si)


def _targets(block: Block, counts: Mapping[str, int], owners: Mapping[object, str]) -> tuple[tuple[Target, ...], str]:
    """All that an unknown sets, and its quantity."""
    targets: list[Target] = []
    quantities: list[str] = []
    owners = dict(owners)
    for number, entry in enumerate(block.entries("sets"), start=1):
        key = f"sets[{number}]"
        target, quantity = _target(block, key, entry, counts)
        for each in numbers_set_by(target):
            if each in owners:
                raise block.error(
                    key, f"expected each number to be set once, got {described(entry)}, which {owners[each]} sets"
                )
            owners[each] = block.values["name"]
        targets.append(target)
        quantities.append(quantity)
        if quantities[-1] != quantities[0]:
            raise block.error(key, f"expected a {quantities[0]} as in the first entry, got {described(entry)}")
    return tuple(targets), quantities[0]


def _target(block: Block, key: str, entry: object, counts: Mapping[str, int]) -> tuple[Target, str]:
    """`bearing 2 kxx`: the thing, which one of them in the file's order, and what of it."""
    words = entry.split(maxsplit=2) if isinstance(entry, str) else []
    if len(words) != 3:
        raise block.error(key, f"expected such as 'bearing 1 kxx' or 'unbalance 1 phase', got {described(entry)}")
    thing, number, part = words
    if thing not in counts:
        raise block.error(key, unknown("thing", thing, counts))
    count = counts[thing]
    if not (number.isascii() and number.isdigit() and len(number) < 6 and 1 <= int(number) <= count):
        raise block.error(key, f"expected a {thing} from 1 to {count}, got {described(number)}")
    if part not in PARTS[thing]:
        known = [each for each in PARTS[thing] if each not in OF_ENTRIES]
        raise block.error(key, unknown(f"part of {thing}", part, known))
    index = int(number) - 1
    if thing == "unbalance":
        return UnbalanceTarget(index, part), QUANTITY_OF_PART[part]
    if thing == "support":
        return PedestalTarget(index, part), "mass" if part == "mass" else QUANTITY_OF_PART[part]
    index += counts["bearing"] if thing == "seal" else 0
    if part in IN_WORDS:
        return BearingTarget(index, IN_WORDS[part]), FACTOR
    return BearingTarget(index, part), QUANTITY_OF_PART[part]

"""Numbers of a rotor file that are not exact, as unknowns of its rotor.

They have the quantity that each sets, its unit, and its name for people.

With limits a number is unknown and searched; with a standard deviation alone it is known to a tolerance
(`problems/rotor/inputs/uncertain.py`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from ksmea.errors import unknown
from ksmea.measurement.channel import Channel, named
from ksmea.problem.parameters import Parameter, Prior, name_at
from ksmea.settings.document import Block, Units
from ksmea.units import DEGREE, Unit
from problems.rotor.finite_elements.bearing import COEFFICIENTS
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import CouplingSegment, Material
from problems.rotor.inputs.numbers import ProbeNumber, RotorNumber
from problems.rotor.inputs.places import Place
from problems.rotor.inputs.probe_places import READINGS, ProbePlace
from problems.rotor.inputs.tolerances import IN_WORDS, NONE, TYPICAL, Tolerances, known_to, material_places, named_by
from problems.rotor.inputs.uncertain import UncertainNumbers
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
from problems.rotor_document.shaft import PAIRS
from problems.rotor_document.stated_numbers import StatedNumber, deviation

PLAIN = Unit("1", 1.0)
TIMES = Unit("times", 1.0)
SECOND, PER_SECOND = Unit("s", 1.0), Unit("1/s", 1.0)
LENGTHS = {  # diameters are radii of the rotor
    **dict.fromkeys(
        (
            "outer_diameter",
            "inner_diameter",
            "outer_diameter_right",
            "inner_diameter_right",
            "stiffness_outer_diameter",
        ),
        0.5,
    ),
    "thickness": 1.0,
}
QUANTITIES = {
    **QUANTITY_OF_PART,
    **dict.fromkeys(("position", *LENGTHS), "length"),
    "young_modulus": "modulus",
    "density": "density",
    "mass": "mass",
    "polar_inertia": "inertia",
    "diametral_inertia": "inertia",
    "axial_force": "force",
}
UNITS = {
    "poisson_ratio": PLAIN,
    "loss_factor": PLAIN,
    "shear_coefficient": PLAIN,
    "internal_damping": SECOND,
    "standing_damping": PER_SECOND,
    "gain": TIMES,
    **dict.fromkeys(FACTORS, TIMES),
}
LINEAR = ("young_modulus", "density", "mass", "polar_inertia", "diametral_inertia")
POSITIVE = (*LINEAR, *LENGTHS, "shear_coefficient", "magnitude")
OF_SEGMENT = (
    "outer_diameter", "inner_diameter", "outer_diameter_right", "inner_diameter_right", "stiffness_outer_diameter", "axial_force",
    "internal_damping", "loss_factor", "shear_coefficient",
)  # fmt: skip
OF_LAYER = OF_SEGMENT[:4]
OF_DISK = (
    "position",
    "mass",
    "polar_inertia",
    "diametral_inertia",
    "standing_damping",
    "outer_diameter",
    "inner_diameter",
    "thickness",
)
OF_RING = ("outer_diameter", "inner_diameter", "thickness")
Item = TypeVar("Item", Unknown, RotorNumber, ProbeNumber)
OF_TOLERANCES = {"probe_position": "length", "direction": "angle"}


@dataclass(frozen=True)
class Inexact:
    """Unknowns that the numbers of a file make.

    They are unknowns of bearings and unbalance, of the rotor and of its probes, to be searched; and numbers that are
    known to a tolerance.
    """

    unknowns: tuple[Unknown, ...] = ()
    numbers: tuple[RotorNumber, ...] = ()
    probes: tuple[ProbeNumber, ...] = ()
    uncertain: UncertainNumbers = field(default_factory=UncertainNumbers)


@dataclass(frozen=True)
class _Reader:
    units: Units
    rotor: Rotor
    channels: Sequence[Channel]
    materials: Mapping[str, Material]

    def parameter(self, stated: StatedNumber, name: str, words: str) -> Parameter:
        """The unknown that a number is, with its prior and limits."""
        unit, value = self.unit(stated), self.value(stated)
        prior = Prior(value, stated.sd * unit.si) if stated.sd else None
        if stated.limits is None:
            assert prior is not None, "a number that is exact"
            above = 0.0 if stated.key in POSITIVE else -math.inf
            return known_to(name, words, (unit.name, unit.si), prior, above=above)
        lower, upper = (limit * unit.si for limit in stated.limits)
        return Parameter(name, unit.name, unit.si, lower, upper, prior=prior, words=words)

    def unit(self, stated: StatedNumber) -> Unit:
        if stated.key == "direction":
            return self.units.unit("angle") if "angle" in self.units.header.values else Unit("deg", DEGREE)
        if "standing_damping" in stated.path and stated.key in ("mass", "stiffness"):
            return PER_SECOND if stated.key == "mass" else SECOND
        if stated.path[-2:-1] == ("coupling",):
            return self.units.unit(PAIRS[stated.key])
        if stated.key in UNITS:
            return UNITS[stated.key]
        if stated.key not in QUANTITIES:
            raise _refusal(stated)
        return self.units.unit(QUANTITIES[stated.key])

    def value(self, stated: StatedNumber) -> float:
        """SI."""
        if isinstance(stated.value, str):
            return Channel(0.0, stated.value).angle * DEGREE
        return float(stated.value) * self.unit(stated).si

    def target(self, stated: StatedNumber) -> tuple[Target, str] | None:
        """Target that a number of a bearing, a support or an unbalance sets, and its name in words.

        None for any other number.
        """
        thing, index, *rest = stated.path
        if not isinstance(index, int):
            return None
        place = index + (len(self.rotor.bearings) if thing == "seals" else 0)
        name = f"{str(thing).removesuffix('s')} {index + 1}"
        if thing in ("bearings", "seals") and stated.key in (*COEFFICIENTS, *FACTORS) and len(rest) == 1:
            return BearingTarget(place, stated.key), f"{stated.key.replace('_', ' ')} of {name}"
        if rest[:1] == ["support"] and stated.key in PEDESTAL_PARTS:
            return PedestalTarget(place, stated.key), f"{stated.key} of support {index + 1}"
        if thing == "unbalance" and stated.key in UNBALANCE_PARTS:
            return UnbalanceTarget(index, stated.key), f"{stated.key} of unbalance {index + 1}"
        return None

    def places(self, stated: StatedNumber) -> tuple[tuple[Place, ...], str]:
        """Places of a number in the rotor, and its name in words."""
        thing, index, *rest = stated.path
        key = stated.key
        words = key.replace("_", " ")
        if thing == "materials" and len(rest) == 1 and key in ("young_modulus", "density", "poisson_ratio"):
            return material_places(self.rotor, self.materials[str(index)], key), f"{IN_WORDS.get(key, key)} of {index}"
        if not isinstance(index, int):
            raise _refusal(stated)
        number = f"{THINGS.get(str(thing), str(thing))} {index + 1}"
        if thing == "shaft":
            return self._of_segment(stated, index, rest), f"{words} of {number}"
        if thing in ("disks", "masses") and key in OF_DISK and len(rest) == 1:
            return self._of_disk(stated, str(thing), index), f"{words} of {number}"
        if thing in ("bearings", "seals") and rest == ["position"]:
            return (Place((str(thing), index, "offset")),), f"position of {number}"
        if thing == "bearings" and rest == ["support", "loss_factor"]:
            return (Place(("bearings", index, "pedestal", "loss_factor")),), f"loss factor of support {index + 1}"
        if thing == "unbalance" and rest == ["position"]:
            return (Place(("unbalance", index, "position")),), f"position of {number}"
        if thing == "couplings" and rest == ["position"]:
            return (Place(("couplings", index)),), f"position of {number}"
        raise _refusal(stated)

    def _of_segment(self, stated: StatedNumber, index: int, rest: list[str | int]) -> tuple[Place, ...]:
        key = stated.key
        if rest == [key] and key in OF_SEGMENT:
            field_name = key.replace("diameter", "radius")
            return (Place(("segments", index, field_name), LENGTHS.get(key, 1.0)),)
        if rest[:1] == ["layers"] and key in OF_LAYER and isinstance(layer := rest[1], int):
            return (Place(("segments", index, "layers", layer, key.replace("diameter", "radius")), 0.5),)
        if rest[:1] == ["standing_damping"]:
            return (Place(("segments", index, "standing_damping", ("mass", "stiffness").index(key))),)
        if rest[:1] == ["coupling"] and isinstance(self.rotor.segments[index], CouplingSegment) and rest[1:] == [key]:
            return tuple(Place(("segments", index, key, side)) for side in (0, 1))
        raise _refusal(stated)

    def _of_disk(self, stated: StatedNumber, thing: str, index: int) -> tuple[Place, ...]:
        key = stated.key
        if key == "position":
            return (Place((thing, index, "offset")),)
        if key in OF_RING:
            return (Place((thing, index, "ring", key.replace("diameter", "radius")), LENGTHS[key]),)
        return (Place((thing, index, key)),)


THINGS = {
    "shaft": "segment",
    "disks": "disk",
    "masses": "mass",
    "bearings": "bearing",
    "seals": "seal",
    "couplings": "coupling",
}


def _refusal(stated: StatedNumber) -> Exception:
    return stated.block.error(
        "", f"expected a plain number, since {stated.key} cannot have a tolerance; give it exactly"
    )


def read_inexact(
    stated: Sequence[StatedNumber],
    document: Block,
    units: Units,
    rotor: Rotor,
    channels: Sequence[Channel],
    materials: Mapping[str, Material],
) -> Inexact:
    """The unknowns that numbers of a file make which are not exact."""
    reader = _Reader(units, rotor, channels, materials)
    of_probes = [each for each in stated if each.path[0] == "probes"]
    probes, exact_probes = _probes(reader, of_probes)
    unknowns: list[Unknown] = []
    numbers: list[RotorNumber] = []
    exact: set[Place] = set()
    for each in stated:
        if each.path[0] == "probes":
            continue
        found = reader.target(each)
        if found is not None:
            target, words = found
            if each.sd or each.limits:
                parameter = reader.parameter(each, named_by(words), words)
                unknowns.append(Unknown(parameter, (target,)))
            continue
        places, words = reader.places(each)
        if not (each.sd or each.limits):
            exact |= set(places)
            continue
        parameter = reader.parameter(each, named_by(words), words)
        linear = each.key in LINEAR and each.path[0] in ("materials", "disks", "masses")
        numbers.append(RotorNumber(parameter, reader.value(each), places, linear))
    return Inexact(
        _of_kind(unknowns, is_input=False),
        _of_kind(numbers, is_input=False),
        _of_kind(probes, is_input=False),
        UncertainNumbers(
            _of_kind(unknowns, is_input=True),
            _of_kind(numbers, is_input=True),
            _of_kind(probes, is_input=True),
            read_tolerances(document, units),
            frozenset(exact),
            exact_probes,
            dict(materials),
        ),
    )


def _of_kind(items: Sequence[Item], *, is_input: bool) -> tuple[Item, ...]:
    """The numbers that are searched, or the numbers that are only known to a tolerance."""
    return tuple(item for item in items if item.parameter.is_input == is_input)


def _probes(reader: _Reader, stated: Sequence[StatedNumber]) -> tuple[list[ProbeNumber], tuple[ProbePlace, ...]]:
    """Numbers of probes: one position for all at a plane, gains and directions of each."""
    found: dict[ProbePlace, ProbeNumber] = {}
    sizes: dict[ProbePlace, float | None] = {}
    for each in stated:
        index = each.path[1]
        assert isinstance(index, int), "a list of probes"
        channel = reader.channels[index]
        if each.key not in READINGS:
            raise _refusal(each)
        if each.key == "gain" and each.value != 1:
            raise each.block.error(
                "value", f"expected 1, got {each.value:g}; divide the measured values by the gain that is known"
            )
        direction = None if each.key == "position" else channel.direction
        at = f"at {channel.position:g} m"
        place = ProbePlace(each.key, channel.position, direction)
        if place in sizes:
            if sizes[place] != each.sd:
                raise each.block.error(
                    "sd", f"expected the sd of the other probe {at}, {sizes[place]:g}, got {each.sd:g}"
                )
            continue
        sizes[place] = each.sd
        if not (each.sd or each.limits):
            continue
        if direction is None:
            name, words = name_at("probe_position", at), f"position of the probes {at}"
        else:
            name = name_at(f"{each.key}_{direction}", at)
            words = f"{each.key} of {named(direction)} {at}"
        parameter = reader.parameter(each, name, words)
        found[place] = ProbeNumber(parameter, reader.value(each), place)
    exact = tuple(place for place in sizes if place not in found)
    return list(found.values()), exact


def read_tolerances(document: Block, units: Units) -> Tolerances:
    """`tolerances: typical`, or a map of the tolerances that differ from it.

    `NONE` for a file without the key.
    """
    if "tolerances" not in document.values:
        return NONE
    if isinstance(document.values["tolerances"], str):
        document.choice("tolerances", "tolerances", ("typical",))
        return TYPICAL
    block = document.block("tolerances")
    known = [each.name for each in dataclasses.fields(Tolerances)]
    changed = {}
    for key in block.values:
        if key not in known:
            raise block.error("", unknown("tolerance", str(key), known))
        if key in OF_TOLERANCES:
            changed[key] = units.quantity(block, key, OF_TOLERANCES[key], at_least=0)
        else:
            changed[key] = deviation(block, key, 1.0)
    return dataclasses.replace(TYPICAL, **changed)

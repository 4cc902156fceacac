"""What a rotor file says, made into a rotor with its unknowns, speeds and channels; docs/examples/rotor.yaml shows it.

Whatever is not named as optional there has to be in the file: nothing is guessed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import described, unknown
from ksmea.measurement.channel import DIRECTIONS, Channel, direction_at
from ksmea.problem.parameters import Parameter
from ksmea.settings.document import Block, Units, inside
from ksmea.units import GIGAPASCAL
from problems.rotor.finite_elements.bearing import COEFFICIENTS, DAMPINGS, MASSES, STIFFNESSES, Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import share_elements
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import UNBALANCE_PARTS, BearingTarget, Target, UnbalanceTarget, Unknown
from problems.rotor_settings import MAX_ELEMENTS, MAX_SPEEDS, MAX_SUPPORTS, MAX_THINGS, check_ports, check_size

MAX_ANGLE = 360.0  # degrees

THINNEST_WALL = 1e-6  # of the outer diameter; differences of squares lose thinner ones
LONGEST_SHAFT = 50.0  # m; more, and moduli beyond those of soft plastics and of diamond, are slips in a unit
LEAST_MODULUS, LARGEST_MODULUS = 1 * GIGAPASCAL, 1500 * GIGAPASCAL
OPTIONAL_COEFFICIENTS = ("kxy", "kyx", "cxy", "cyx", *MASSES)  # none unless given
PARTS = {"bearing": COEFFICIENTS, "unbalance": UNBALANCE_PARTS}  # what a target may set of which thing
QUANTITY_OF_PART = {
    **dict.fromkeys(STIFFNESSES, "stiffness"),
    **dict.fromkeys(DAMPINGS, "damping"),
    **dict.fromkeys(MASSES, "mass"),
    "magnitude": "unbalance",
    "phase": "angle",
}
RING = ("position", "outer_diameter", "inner_diameter", "thickness", "material")
WEIGHED = ("position", "mass", "polar_inertia", "diametral_inertia")
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True, eq=False)
class RotorDescription:
    """All that a rotor file says, SI."""

    problem: RotorProblem
    reference: Mapping[str, float]  # of the unknowns that have one


def read_description(document: Block, mesh: int | None) -> RotorDescription:
    """The description in a document; `mesh` elements replace those in the file."""
    document.check_keys(
        ("units", "materials", "shaft", "bearings", "unbalance", "speeds", "probes", "unknowns"), ["disks"]
    )
    _check_counts(document)
    units = Units.of(document.block("units"))
    materials = _materials(document.block("materials"), units)
    segments = _shaft(document.blocks("shaft"), units, materials, mesh)
    speed = _speeds(document, units)
    n_element = sum(segment.n_element for segment in segments)
    inside(document, "", lambda: check_size(n_element, len(speed)))
    shaft = inside(document, "shaft", lambda: Rotor(segments))
    disks = [_disk(block, units, materials, shaft) for block in _optional_blocks(document, "disks")]
    bearings, planes = document.blocks("bearings"), document.blocks("unbalance")
    unknowns, reference = _unknowns(document.blocks("unknowns"), units, {"bearing": bearings, "unbalance": planes})
    owners = {target: item.parameter.name for item in unknowns for target in item.targets}
    rotor = Rotor(
        segments,
        tuple(disks),
        tuple(_bearing(block, units, shaft, index, owners) for index, block in enumerate(bearings)),
        tuple(_plane(block, units, shaft, index, owners) for index, block in enumerate(planes)),
    )
    channels = _channels(document.blocks("probes"), units, shaft)
    counts = {"n_bearing": len(bearings), "n_plane": len(planes), "n_probe": len(channels)}
    inside(document, "", lambda: check_ports(n_element, len(speed), **counts))
    problem = inside(document, "", lambda: RotorProblem(rotor, unknowns, speed, channels))
    return RotorDescription(problem, reference)


def _check_counts(document: Block) -> None:
    """Raise `SettingError` where there is more of something than any rotor has, before anything is made of it."""
    limits = dict.fromkeys(("disks", "probes", "unknowns", "materials"), MAX_THINGS)
    limits |= dict.fromkeys(("bearings", "unbalance"), MAX_SUPPORTS)
    for key, most in {**limits, "shaft": MAX_ELEMENTS, "speeds": MAX_SPEEDS}.items():
        value = document.values.get(key)
        if isinstance(value, (list, dict)) and len(value) > most:
            raise document.error(key, f"expected at most {most} entries, got {len(value)}; take fewer")


def _optional_blocks(document: Block, key: str) -> list[Block]:
    return document.blocks(key) if key in document.values else []


def _materials(block: Block, units: Units) -> dict[str, Material]:
    for name in block.values:
        if not isinstance(name, str):
            raise block.error("", f"expected names of materials that are texts, got {described(name)}")
    return {name: _material(block.block(name), units) for name in block.values}


def _material(block: Block, units: Units) -> Material:
    block.check_keys(("young_modulus", "density", "poisson_ratio"))
    modulus = units.quantity(block, "young_modulus", "modulus", above=0)
    if not LEAST_MODULUS <= modulus <= LARGEST_MODULUS:
        raise block.error(
            "young_modulus",
            f"expected {LEAST_MODULUS / GIGAPASCAL:g} to {LARGEST_MODULUS / GIGAPASCAL:g} GPa, got {modulus / GIGAPASCAL:g}"
            " GPa, which is implausible (steel has 210); check units.modulus",
        )
    density = units.quantity(block, "density", "density", above=0)
    return Material(modulus, density, block.number("poisson_ratio", above=-1, at_most=0.5))


def _shaft(
    blocks: Sequence[Block], units: Units, materials: Mapping[str, Material], mesh: int | None
) -> tuple[ShaftSegment, ...]:
    for block in blocks:
        block.check_keys(("length", "outer_diameter", "material", "elements"), ["inner_diameter"])
    lengths = [units.quantity(block, "length", "length", above=0) for block in blocks]
    given = [block.whole("elements", MAX_ELEMENTS) for block in blocks]
    if sum(lengths) > LONGEST_SHAFT:
        raise blocks[0].error(
            "length",
            f"expected segments of at most {LONGEST_SHAFT:g} m together, got {sum(lengths):g} m, which is implausible; check"
            " units.length",
        )
    counts = given if mesh is None else share_elements(mesh, lengths)
    return tuple(
        ShaftSegment(length, outer, material=_material_of(block, materials), n_element=count, inner_radius=inner)
        for block, length, count in zip(blocks, lengths, counts, strict=True)
        for outer, inner in [_radii(block, units)]
    )


def _radii(block: Block, units: Units) -> tuple[float, float]:
    """Outer and inner radius, m."""
    outer = units.quantity(block, "outer_diameter", "length", above=0)
    inner = units.quantity(block, "inner_diameter", "length", at_least=0) if "inner_diameter" in block.values else 0.0
    if inner > outer * (1 - THINNEST_WALL):
        sizes = [described(block.values[key]) for key in ("outer_diameter", "inner_diameter")]
        raise block.error("inner_diameter", f"expected less than the outer_diameter, {sizes[0]}, got {sizes[1]}")
    return outer / 2, inner / 2


def _material_of(block: Block, materials: Mapping[str, Material]) -> Material:
    return materials[block.choice("material", "material", materials)]


def _disk(block: Block, units: Units, materials: Mapping[str, Material], shaft: Rotor) -> Disk:
    """A ring of a material, or a mass with its inertias."""
    has_mass = any(key in block.values for key in WEIGHED[1:])
    if has_mass and any(key in block.values for key in RING[1:]):
        raise block.error("", f"expected either {', '.join(RING[1:])} or {', '.join(WEIGHED[1:])}, got some of both")
    block.check_keys(WEIGHED if has_mass else RING)
    position = _position(block, units, shaft, "disk", needs_node=True)
    if has_mass:
        return Disk(
            position,
            mass=units.quantity(block, "mass", "mass", above=0),
            polar_inertia=units.quantity(block, "polar_inertia", "inertia", at_least=0),
            diametral_inertia=units.quantity(block, "diametral_inertia", "inertia", at_least=0),
        )
    outer, inner = _radii(block, units)
    return Disk.from_geometry(
        position,
        outer_radius=outer,
        inner_radius=inner,
        thickness=units.quantity(block, "thickness", "length", above=0),
        density=_material_of(block, materials).density,
    )


def _bearing(block: Block, units: Units, shaft: Rotor, index: int, owners: Mapping[Target, str]) -> Bearing:
    estimated = _estimated(block, {name: BearingTarget(index, name) for name in COEFFICIENTS}, owners)
    required = [name for name in COEFFICIENTS if name not in OPTIONAL_COEFFICIENTS and name not in estimated]
    block.check_keys(["position", *required], OPTIONAL_COEFFICIENTS)
    position = _position(block, units, shaft, "bearing", needs_node=True)
    given = [name for name in COEFFICIENTS if name in block.values]
    numbers: dict[str, Any] = {name: units.quantity(block, name, QUANTITY_OF_PART[name]) for name in given}
    return Bearing(position, **numbers)


def _plane(block: Block, units: Units, shaft: Rotor, index: int, owners: Mapping[Target, str]) -> UnbalancePlane:
    estimated = _estimated(block, {part: UnbalanceTarget(index, part) for part in UNBALANCE_PARTS}, owners)
    block.check_keys(["position", *(part for part in UNBALANCE_PARTS if part not in estimated)])
    position = _position(block, units, shaft, "unbalance", needs_node=False)
    limits = {"magnitude": {"at_least": 0}, "phase": {}}
    given = [part for part in UNBALANCE_PARTS if part in block.values]
    return UnbalancePlane(
        position, **{part: units.quantity(block, part, QUANTITY_OF_PART[part], **limits[part]) for part in given}
    )


def _estimated(block: Block, targets: Mapping[str, Target], owners: Mapping[Target, str]) -> list[str]:
    """The keys of a block that an unknown sets, none of which may have a value of its own."""
    estimated = [key for key, target in targets.items() if target in owners]
    for key in estimated:
        if key in block.values:
            raise block.error(
                key, f"expected no value, since unknown {owners[targets[key]]} sets it; remove one of them"
            )
    return estimated


def _position(block: Block, units: Units, shaft: Rotor, what: str, *, needs_node: bool) -> float:
    position = units.quantity(block, "position", "length")
    check = shaft.node_at if needs_node else shaft.require_on_shaft
    inside(block, "position", lambda: check(position, what))
    return position


def _speeds(document: Block, units: Units) -> Array:
    """(n_speed,) rad/s: a list, or a band with its ends and their number."""
    unit = units.unit("speed")
    value = document.values["speeds"]
    if isinstance(value, list):
        entries = document.entries("speeds")
        listed = Block(
            document.file, document.path, {f"speeds[{n}]": entry for n, entry in enumerate(entries, start=1)}
        )
        speeds = [units.value(listed, key, "speed", above=0) for key in listed.values]
        for key, before, speed in zip(list(listed.values)[1:], speeds, speeds[1:]):
            if speed <= before:
                raise document.error(key, f"expected speeds that rise, got {speed:g} after {before:g}")
        return unit.si * np.array(speeds)
    block = document.block("speeds")
    block.check_keys(("from", "to", "number"))
    first, n_speed = units.value(block, "from", "speed", above=0), block.whole("number", MAX_SPEEDS)
    last = units.value(block, "to", "speed", **{"above" if n_speed > 1 else "at_least": first})
    return unit.si * np.linspace(first, last, n_speed)


def _channels(blocks: Sequence[Block], units: Units, shaft: Rotor) -> tuple[Channel, ...]:
    channels: list[Channel] = []
    for block in blocks:
        block.check_keys(("position", "direction"))
        position = _position(block, units, shaft, "probe", needs_node=False)
        channel = Channel(position, _direction(block))
        if channel in channels:
            raise block.error("", f"expected each probe once, got {channel} again; remove it")
        channels.append(channel)
    return tuple(channels)


def _direction(block: Block) -> str:
    """x, y, or an angle in degrees from x towards y."""
    if isinstance(block.values["direction"], (int, float)):
        return direction_at(block.number("direction", "deg", at_least=-MAX_ANGLE, at_most=MAX_ANGLE))
    return block.choice("direction", "direction", DIRECTIONS)


def _unknowns(
    blocks: Sequence[Block], units: Units, things: Mapping[str, Sequence[Block]]
) -> tuple[tuple[Unknown, ...], dict[str, float]]:
    """The unknowns, and the reference values of those that have one, SI."""
    unknowns: list[Unknown] = []
    reference: dict[str, float] = {}
    owners: dict[Target, str] = {}
    for block in blocks:
        block.check_keys(("name", "lower", "upper", "sets"), ["reference"])
        name = block.text("name")
        if not NAME.fullmatch(name):
            raise block.error("name", f"expected letters, digits and _ after a letter, got {described(name)}")
        if name in (item.parameter.name for item in unknowns):
            raise block.error("name", f"expected each name once, got '{name}' again")
        targets, quantity = _targets(block, things, owners)
        owners |= dict.fromkeys(targets, name)
        unit = units.unit(quantity)
        lower = units.value(block, "lower", quantity, **({"at_least": 0} if quantity == "unbalance" else {}))
        upper = units.value(block, "upper", quantity, above=lower)
        unknowns.append(Unknown(Parameter(name, unit.name, unit.si, lower * unit.si, upper * unit.si), targets))
        if "reference" in block.values:
            reference[name] = units.quantity(block, "reference", quantity, at_least=lower, at_most=upper)
    return tuple(unknowns), reference


def _targets(
    block: Block, things: Mapping[str, Sequence[Block]], owners: Mapping[Target, str]
) -> tuple[tuple[Target, ...], str]:
    """What an unknown sets, and the quantity that all of it is."""
    targets: list[Target] = []
    quantities: list[str] = []
    for number, entry in enumerate(block.entries("sets"), start=1):
        key = f"sets[{number}]"
        target, part = _target(block, key, entry, things)
        if target in owners or target in targets:
            owner = owners.get(target, block.values["name"])
            raise block.error(key, f"expected each number to be set once, got {described(entry)}, which {owner} sets")
        targets.append(target)
        quantities.append(QUANTITY_OF_PART[part])
        if quantities[-1] != quantities[0]:
            raise block.error(key, f"expected a {quantities[0]} as in the first entry, got {described(entry)}")
    return tuple(targets), quantities[0]


def _target(block: Block, key: str, entry: object, things: Mapping[str, Sequence[Block]]) -> tuple[Target, str]:
    """`bearing 2 kxx`: the thing, which one of them in the file's order, and what of it."""
    words = entry.split() if isinstance(entry, str) else []
    if len(words) != 3:
        raise block.error(key, f"expected such as 'bearing 1 kxx' or 'unbalance 1 phase', got {described(entry)}")
    thing, number, part = words
    if thing not in things:
        raise block.error(key, unknown("thing", thing, things))
    count = len(things[thing])
    if not (number.isascii() and number.isdigit() and len(number) < 6 and 1 <= int(number) <= count):
        raise block.error(key, f"expected a {thing} from 1 to {count}, got {described(number)}")
    if part not in PARTS[thing]:
        raise block.error(key, unknown(f"part of {thing}", part, PARTS[thing]))
    index = int(number) - 1
    return (BearingTarget(index, part) if thing == "bearing" else UnbalanceTarget(index, part)), part

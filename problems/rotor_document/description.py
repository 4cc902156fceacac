"""Contents of a rotor file as a rotor with its unknowns, speeds and channels.

Docs/examples/rotor.yaml is an example.

Whatever is not named as optional there has to be in the file: nothing is guessed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, described
from ksmea.measurement.channel import DIRECTIONS, Channel, direction_at
from ksmea.problem.parameters import Parameter, Prior
from ksmea.settings.document import Block, Units, inside
from problems.rotor.finite_elements.bearing import Bearing, mirrored_bearing
from problems.rotor.finite_elements.data import HousingProbe, Rotor
from problems.rotor.inputs.numbers import ProbeNumber, RotorNumbers
from problems.rotor.inputs.probe_places import ProbePlace
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, PedestalTarget, Target, Unknown, changes_sign
from problems.rotor_document.bearings import read_bearing, read_plane, read_seal
from problems.rotor_document.shaft import position_of, read_disk, read_mass, read_materials, read_shaft
from problems.rotor_document.stated_numbers import split
from problems.rotor_document.tables import RotorSheets
from problems.rotor_document.uncertain import Inexact, read_inexact
from problems.rotor_document.unknowns import read_unknowns
from problems.rotor_settings import MAX_ELEMENTS, MAX_SPEEDS, MAX_SUPPORTS, MAX_THINGS, check_ports, check_size

MAX_ANGLE = 360.0  # degrees
ROTATIONS = ("x to y", "y to x")
REQUIRED = ("units", "materials", "shaft", "speeds")
OPTIONAL = (
    "disks",
    "masses",
    "bearings",
    "seals",
    "couplings",
    "unbalance",
    "probes",
    "unknowns",
    "rotation",
    "tolerances",
)


@dataclass(frozen=True, eq=False)
class RotorDescription:
    """All that a rotor file says, SI."""

    problem: RotorProblem
    reference: Mapping[str, float]  # of the unknowns that have one
    tables: Mapping[str, bytes]  # files that it names, by path


def read_description(document: Block, mesh: int | None, sheets: RotorSheets) -> RotorDescription:
    """The description in a document; `mesh` elements replace those in the file."""
    document.check_keys(REQUIRED, OPTIONAL)
    _check_counts(document)
    document, stated = split(document)
    units = Units.of(document.block("units"))
    named = document.block("materials")
    materials = read_materials(named, units)
    segments = read_shaft(document.blocks("shaft"), units, materials, named, mesh)
    speed = _speeds(document, units)
    n_element = sum(segment.n_element for segment in segments)
    inside(document, "", lambda: check_size(n_element, len(speed)))
    shaft = inside(document, "shaft", lambda: Rotor(segments))
    bearings, seals, planes = (_blocks(document, key) for key in ("bearings", "seals", "unbalance"))
    counts = {"bearing": len(bearings), "unbalance": len(planes), "seal": len(seals), "support": len(bearings)}
    unknowns, reference = read_unknowns(_blocks(document, "unknowns"), units, counts)
    owners: dict[Target, str] = {target: item.parameter.name for item in unknowns for target in item.targets}
    probes = _blocks(document, "probes")
    channels = _channels(probes, units, shaft)
    rotor = Rotor(
        segments,
        tuple(read_disk(block, units, materials, shaft) for block in _blocks(document, "disks")),
        tuple(read_bearing(block, units, shaft, index, owners, sheets) for index, block in enumerate(bearings)),
        tuple(read_plane(block, units, shaft, index, owners) for index, block in enumerate(planes)),
        seals=tuple(
            read_seal(block, units, shaft, index, owners, sheets)
            for index, block in enumerate(seals, start=len(bearings))
        ),
        couplings=tuple(_coupling(block, units, shaft) for block in _blocks(document, "couplings")),
        housing_probes=_housing_probes(probes, channels, bearings),
        masses=tuple(read_mass(block, units, shaft) for block in _blocks(document, "masses")),
    )
    n_bearing = len(bearings) + _further_unknown(owners, len(bearings))
    sizes = {"n_bearing": n_bearing, "n_plane": len(planes), "n_probe": len(channels)}
    inside(document, "", lambda: check_ports(len(speed), **sizes))
    inexact = read_inexact(stated, document, units, rotor, channels, materials)
    unknowns = (*unknowns, *inexact.unknowns)
    if "rotation" in document.values and document.choice("rotation", "sense of rotation", ROTATIONS) == ROTATIONS[1]:
        rotor, channels = mirrored(rotor), tuple(map(_mirrored_channel, channels))
        unknowns, reference = inside(document, "rotation", lambda: _mirrored_unknowns(unknowns, reference))
        inexact = inside(document, "rotation", lambda: _mirrored_inexact(inexact))
    uncertain = inexact.uncertain if inexact.uncertain.are_there else None
    problem = inside(
        document, "", lambda: RotorProblem(rotor, unknowns, speed, channels, uncertain=uncertain, is_as_drawn=True)
    )
    if inexact.numbers or inexact.probes:
        problem = problem.with_effects((RotorNumbers(inexact.numbers, inexact.probes),))
    return RotorDescription(problem, reference, sheets.read)


def _check_counts(document: Block) -> None:
    """Raise `SettingError` if there are more parts of a kind than any rotor has.

    It is raised before anything is made of them.
    """
    limits = dict.fromkeys(("disks", "masses", "probes", "unknowns", "materials", "couplings"), MAX_THINGS)
    limits |= dict.fromkeys(("bearings", "seals", "unbalance"), MAX_SUPPORTS)
    for key, most in {**limits, "shaft": MAX_ELEMENTS, "speeds": MAX_SPEEDS}.items():
        value = document.values.get(key)
        if isinstance(value, (list, dict)) and len(value) > most:
            raise document.error(key, f"expected at most {most} entries, got {len(value)}; take fewer")


def _further_unknown(targets: Iterable[Target], n_bearing: int) -> int:
    """Seals and supports with unknown numbers; known ones are part of the shaft as the response sees it."""
    supports = {each.bearing for each in targets if isinstance(each, PedestalTarget)}
    seals = {each.bearing for each in targets if isinstance(each, BearingTarget) and each.bearing >= n_bearing}
    return len(supports) + len(seals)


def _blocks(document: Block, key: str) -> list[Block]:
    """The mappings of a list that may be empty or left out."""
    return document.blocks(key) if document.values.get(key, []) != [] else []


def _coupling(block: Block, units: Units, shaft: Rotor) -> float:
    block.check_keys(("position",))
    return position_of(block, units, shaft, "coupling", needs_node=False)


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
        block.check_keys(("position", "direction"), ["relative_to", "gain"])
        if "gain" in block.values and block.number("gain") != 1:
            raise block.error(
                "gain", "expected 1, or its tolerance; divide the measured values by a gain that is known"
            )
        position = position_of(block, units, shaft, "probe", needs_node=False)
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


def _housing_probes(
    blocks: Sequence[Block], channels: Sequence[Channel], of_bearings: Sequence[Block]
) -> tuple[HousingProbe, ...]:
    """Probes that say `relative_to: bearing 1`.

    If all at a place are relative to one bearing, others in a measurement are too.
    """
    found = []
    bearings = [_bearing_of(block, of_bearings) for block in blocks]
    for channel, bearing in zip(channels, bearings):
        beside = {own for own, other in zip(bearings, channels) if other.position == channel.position}
        if bearing is not None:
            found.append(HousingProbe(channel.position, None if len(beside) == 1 else channel.direction, bearing))
    return tuple(dict.fromkeys(found))


def _bearing_of(block: Block, of_bearings: Sequence[Block]) -> int | None:
    """The bearing, by its index, whose housing carries a probe; None: it is fixed to the ground."""
    if "relative_to" not in block.values:
        return None
    n_bearing = len(of_bearings)
    thing, _, number = block.text("relative_to").partition(" ")
    if thing != "bearing" or not (
        number.isascii() and number.isdigit() and len(number) < 6 and 1 <= int(number) <= n_bearing
    ):
        given = described(block.values["relative_to"])
        raise block.error("relative_to", f"expected a bearing from 1 to {n_bearing}, such as 'bearing 1', got {given}")
    if "support" not in of_bearings[int(number) - 1].values:
        raise block.error(
            "relative_to",
            f"expected a bearing on a support, got bearing {number} without one; give it a support, or leave relative_to out",
        )
    return int(number) - 1


def mirrored(rotor: Rotor) -> Rotor:
    """A rotor that turns from y to x, seen with y reversed, so that it turns from x to y."""

    def each(bearings: Sequence[Bearing]) -> tuple[Bearing, ...]:
        return tuple(map(mirrored_bearing, bearings))

    planes = tuple(replace(plane, phase=-plane.phase) for plane in rotor.unbalance)
    probes = tuple(
        replace(probe, direction=_mirrored_direction(probe.direction)) if probe.direction else probe
        for probe in rotor.housing_probes
    )
    return replace(
        rotor, bearings=each(rotor.bearings), seals=each(rotor.seals), unbalance=planes, housing_probes=probes
    )


def _mirrored_direction(direction: str) -> str:
    return direction_at(-Channel(0.0, direction).angle)


def _mirrored_channel(channel: Channel) -> Channel:
    return replace(channel, direction=_mirrored_direction(channel.direction))


def _mirrored_unknowns(
    unknowns: Sequence[Unknown], reference: Mapping[str, float]
) -> tuple[tuple[Unknown, ...], dict[str, float]]:
    """Unknowns that change sign with y have limits and reference values of the other sign."""
    found, values = [], dict(reference)
    for item in unknowns:
        own = item.parameter
        signs = {changes_sign(target) for target in item.targets}
        if len(signs) > 1:
            raise SettingError(
                f"expected unknowns that set either cross-coupled coefficients or direct ones, got {own.name}, which ties both;"
                " describe the rotor with y reversed, and leave rotation out"
            )
        if True in signs:
            own = _reversed(own)
            if own.name in values:
                values[own.name] = -values[own.name]
        found.append(Unknown(own, item.targets))
    return tuple(found), values


def _reversed(parameter: Parameter) -> Parameter:
    """The unknown with the other sign."""
    prior = parameter.prior and Prior(-parameter.prior.value, parameter.prior.sd)
    return replace(parameter, lower=-parameter.upper, upper=-parameter.lower, prior=prior)


def _mirrored_inexact(inexact: Inexact) -> Inexact:
    """Numbers seen with y reversed.

    Directions of probes change sign, as do unknowns of bearings and unbalance.
    """

    def probes(own: Sequence[ProbeNumber]) -> tuple[ProbeNumber, ...]:
        return tuple(map(_mirrored_probe, own))

    uncertain = inexact.uncertain
    uncertain = replace(
        uncertain,
        unknowns=_mirrored_unknowns(uncertain.unknowns, {})[0],
        probes=probes(uncertain.probes),
        exact_probes=tuple(map(_mirrored_place, uncertain.exact_probes)),
    )
    return replace(inexact, probes=probes(inexact.probes), uncertain=uncertain)


def _mirrored_probe(number: ProbeNumber) -> ProbeNumber:
    place = _mirrored_place(number.place)
    if place.reading != "direction":
        return replace(number, place=place)
    return replace(number, parameter=_reversed(number.parameter), stated=-number.stated, place=place)


def _mirrored_place(place: ProbePlace) -> ProbePlace:
    return replace(place, direction=place.direction and _mirrored_direction(place.direction))

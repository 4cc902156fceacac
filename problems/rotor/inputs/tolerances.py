"""Tolerances of ordinary drawings, catalogues and calibrations.

They are for all numbers of a rotor that state none of their own.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from ksmea.measurement.channel import Channel, named
from ksmea.problem.parameters import Parameter, Prior, name_at
from ksmea.units import DEGREE, MILLIMETRE
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material
from problems.rotor.inputs.numbers import ProbeNumber, RotorNumber
from problems.rotor.inputs.places import Place, material_paths
from problems.rotor.inputs.probe_places import ProbePlace

REACH = 6.0  # standard deviations to either side within which a number is searched
TIMES = "times"  # the unit of a factor
IN_WORDS = {"young_modulus": "Young’s modulus", "poisson_ratio": "Poisson’s ratio"}  # of a material, where they differ


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations of the numbers of a machine as drawn.

    Relative ones, positions in m and angles in rad; 0: exact.

    Young's modulus of steel is 200 to 215 GPa; masses of disks follow from drawings to some per cent with their blades and keys; API
    670 lets an eddy-current probe err by 5 %; probes are set to angles by eye.
    """

    young_modulus: float = 0.02
    density: float = 0.01
    mass: float = 0.01
    inertia: float = 0.03
    probe_position: float = 3 * MILLIMETRE
    gain: float = 0.02
    plane_gain: float = 0.0
    direction: float = 2 * DEGREE

    @property
    def relative(self) -> tuple[str, ...]:
        return ("young_modulus", "density", "mass", "inertia", "gain", "plane_gain")


TOLERANCES = ("typical", "none")  # by name, in settings
TYPICAL = Tolerances()
NONE = Tolerances(**dict.fromkeys((field.name for field in dataclasses.fields(Tolerances)), 0.0))


def known_to(
    name: str, words: str, unit: tuple[str, float], prior: Prior, *, above: float = -float("inf")
) -> Parameter:
    """A number known to a tolerance.

    Searched within `REACH` standard deviations, above a physical limit (SI).
    """
    reach = REACH * prior.sd
    lower = prior.value - reach
    if lower <= above:
        lower = above + (prior.value - above) / 100
    return Parameter(name, *unit, lower, prior.value + reach, prior=prior, words=words, is_input=True)


def rotor_numbers(rotor: Rotor, tolerances: Tolerances, materials: Mapping[str, Material]) -> Iterator[RotorNumber]:
    """Numbers of materials by name, and of disks, with these tolerances."""
    for name, material in materials.items():
        for field, unit in (("young_modulus", ("GPa", 1e9)), ("density", ("kg/m3", 1.0))):
            sd = getattr(tolerances, field) * getattr(material, field)
            places = material_places(rotor, material, field)
            if sd and places:
                words = f"{IN_WORDS.get(field, field)} of {name}"
                parameter = known_to(named_by(words), words, unit, Prior(getattr(material, field), sd), above=0.0)
                yield RotorNumber(parameter, getattr(material, field), places, is_linear=True)
    for number, disk in enumerate(rotor.disks, start=1):
        yield from _of_disk(number, disk, tolerances)


def named_by(words: str) -> str:
    """One word: 'outer diameter of segment 3' as segment_3_outer_diameter."""
    quantity, _, thing = words.replace("’", "").partition(" of ")
    return name_at(thing.replace(" ", "_"), quantity.lower())


def _of_disk(number: int, disk: Disk, tolerances: Tolerances) -> Iterator[RotorNumber]:
    for quantity, sd, fields in (
        ("mass", tolerances.mass, ("mass",)),
        ("inertia", tolerances.inertia, ("polar_inertia", "diametral_inertia")),
    ):
        places = tuple(
            Place(("disks", number - 1, field), getattr(disk, field)) for field in fields if getattr(disk, field)
        )
        if sd and places:
            words = f"{'mass' if quantity == 'mass' else 'moments of inertia'} of disk {number}"
            parameter = known_to(f"disk_{number}_{quantity}", words, (TIMES, 1.0), Prior(1.0, sd), above=0.0)
            yield RotorNumber(parameter, 1.0, places, is_linear=True)


def material_places(rotor: Rotor, material: Material, field: str) -> tuple[Place, ...]:
    """Places of a material's modulus or density in a rotor.

    Segments, their layers, rings of the same density.
    """
    paths = [(*path, field) for path, each in material_paths(rotor) if each == material]
    if field == "density":
        paths += [
            ("disks", index, "ring", "density")
            for index, disk in enumerate(rotor.disks)
            if disk.ring is not None and disk.ring.density == material.density
        ]
    return tuple(map(Place, paths))


def probe_numbers(channels: Sequence[Channel], tolerances: Tolerances) -> Iterator[ProbeNumber]:
    """Position and gain of each plane, gain and direction of each probe, with these tolerances."""
    for plane in dict.fromkeys(channel.position for channel in channels):
        at = f"at {plane:g} m"
        if sd := tolerances.probe_position:
            words = f"position of the probes {at}"
            yield probe_number(
                "position", name_at("probe_position", at), words, ("mm", MILLIMETRE), Prior(plane, sd), plane
            )
        if sd := tolerances.plane_gain:
            words = f"gain of all probes {at}"
            yield probe_number("gain", name_at("plane_gain", at), words, (TIMES, 1.0), Prior(1.0, sd), plane)
        there = [channel for channel in channels if channel.position == plane]
        for direction, angle in {channel.direction: channel.angle for channel in there}.items():
            which = f"{named(direction)} {at}"
            name = f"{direction} {at}"
            if sd := tolerances.gain:
                prior = Prior(1.0, sd)
                yield probe_number(
                    "gain", name_at("gain", name), f"gain of {which}", (TIMES, 1.0), prior, plane, direction
                )
            if sd := tolerances.direction:
                prior = Prior(angle * DEGREE, sd)
                words = f"direction of {which}"
                yield probe_number(
                    "direction", name_at("direction", name), words, ("deg", DEGREE), prior, plane, direction
                )


def probe_number(
    reading: str,
    name: str,
    words: str,
    unit: tuple[str, float],
    prior: Prior,
    position: float,
    direction: str | None = None,
) -> ProbeNumber:
    parameter = known_to(name, words, unit, prior)
    return ProbeNumber(parameter, prior.value, ProbePlace(reading, position, direction))

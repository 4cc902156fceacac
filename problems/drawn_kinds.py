"""Machines of five kinds, drawn from ranges, on which a diagnosis is counted.

They are machines of others, not the rotor that the diagnosis was built on.

Between bearings, with one overhung disk, with a disk on either overhang, a small rig with a flexible shaft, and a long shaft with many
disks and two critical speeds in its band. Bearings of one kind, of each its own, or of one alone are unknown, of two or three bearings;
unbalance is in one disk or two. Two to four planes have two probes each, at a right angle to each other and any angle to x.
Each draw is made anew until it is sound (`problems/drawn.py`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.channel import Channel, direction_at
from ksmea.problem.parameters import Parameter
from problems.drawn_machine import (
    ANISOTROPY,
    DENSITY,
    FULL_TURN,
    POISSON_RATIO,
    QUANTITY_BY_LETTER,
    RIG,
    YOUNG_MODULUS,
    Machine,
)
from problems.drawn_numbers import UNITS, Range, limited_about, log_uniform, rounded
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import uniform_shaft
from problems.rotor.finite_elements.segments import Disk, Material
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Target, UnbalanceTarget, Unknown

SHORT = 0.03, 0.12  # of an overhang without a disk, parts of the span; a disk on one sits at its end
BETWEEN = 0.15, 0.85  # of the span, evenly: where disks between bearings may sit
UNLIKE = 0.5, 2.0  # of one bearing in parts of another
N_ELEMENT = 24
N_SPEED = 40, 70
BAND_FROM, BAND_TO = (0.3, 0.7), (1.1, 1.6)  # of the first, and of the last critical speed that is to lie in the band
PLANES = 2, 4
SETS = ("alike", "each", "one")  # of bearings whose unknowns are free
TWO_UNBALANCES = 0.3  # chance of unbalance in two disks


@dataclass(frozen=True)
class Kind(Machine):
    """Ranges of a kind of machine, SI. `overhung` are the ends that carry a disk outside of the bearings."""

    n_disk: tuple[int, int]  # between the bearings
    overhung: tuple[bool, bool] = (False, False)  # left, right
    overhang: Range = (0.2, 0.45)  # with a disk, parts of the span
    n_critical: int = 1  # in the band at least
    middle_bearing: float = 0.0  # chance of a third one


MACHINE = Kind(
    shaft_radius=(0.03, 0.06),
    span=(0.6, 1.6),
    disk_radius=(0.10, 0.20),
    disk_thickness=(0.03, 0.07),
    stiffness=(1e7, 1.2e8),
    damping=(2e3, 4e4),
    unbalance=(3e-5, 5e-4),
    fastest=4000.0,
    n_disk=(1, 3),
)
KINDS = {
    "between_bearings": MACHINE,
    "overhung": replace(MACHINE, n_disk=(0, 1), overhung=(False, True)),
    "two_overhangs": replace(MACHINE, n_disk=(0, 1), overhung=(True, True), overhang=(0.15, 0.35)),
    "flexible_rig": Kind(**{**vars(RIG), "unbalance": (1e-5, 1e-4)}, n_disk=(1, 2)),
    "long": replace(
        MACHINE,
        shaft_radius=(0.05, 0.09),
        span=(2.2, 4.0),
        disk_radius=(0.16, 0.30),
        unbalance=(1e-4, 1e-3),
        n_disk=(4, 7),
        n_critical=3,  # those in x and y of the first mode, and one of the second
        middle_bearing=0.3,
    ),
}


def drawn_of_kind(name: str, rng: np.random.Generator) -> tuple[RotorProblem, Mapping[str, float]] | None:
    """A machine and the true values of its unknowns, SI; None where its band would lack critical speeds."""
    kind = KINDS[name]
    rotor, disks = _rotor(kind, rng)
    unknowns, true, rotor = _with_unknowns(kind, rotor, disks, rng)
    channels = _probes(rotor.length, rng)
    problem = RotorProblem(rotor, unknowns, np.array([kind.fastest]), channels, is_as_drawn=True)
    first, last, n_speed = log_uniform(BAND_FROM, rng), log_uniform(BAND_TO, rng), int(rng.integers(*N_SPEED) + 1)
    criticals = problem.critical_speeds(np.array([true[item.parameter.name] for item in unknowns]), kind.fastest)
    if len(criticals) < kind.n_critical:
        return None
    ends = rounded(first * criticals[0]), rounded(last * criticals[kind.n_critical - 1])
    return replace(problem, speed=np.linspace(*ends, n_speed)), true


def _rotor(kind: Kind, rng: np.random.Generator) -> tuple[Rotor, list[float]]:
    """Shaft and disks on nominal bearings, and where the disks sit, m."""
    span = log_uniform(kind.span, rng)
    before, after = (span * log_uniform(kind.overhang if carries else SHORT, rng) for carries in kind.overhung)
    length = rounded(before + span + after)
    n_disk = int(rng.integers(kind.n_disk[0], kind.n_disk[1] + 1))
    shares = (np.arange(n_disk) + rng.uniform(0.25, 0.75, n_disk)) / max(n_disk, 1)
    low, high = BETWEEN
    between = [rounded(before + span * (low + (high - low) * share)) for share in shares]
    disks = [*([0.0] if kind.overhung[0] else []), *between, *([length] if kind.overhung[1] else [])]
    supports = [rounded(before), rounded(before + span)]
    if rng.random() < kind.middle_bearing:
        supports.insert(1, rounded(before + span * rng.uniform(0.4, 0.6)))
    radius = log_uniform(kind.shaft_radius, rng)
    material = Material(log_uniform(YOUNG_MODULUS, rng), DENSITY, POISSON_RATIO)
    rings = tuple(_disk(kind, place, radius, rng) for place in disks)
    segments = uniform_shaft(length, (*supports, *disks), N_ELEMENT, radius=radius, material=material)
    return Rotor(segments, rings, tuple(map(Bearing, supports))), disks


def _disk(kind: Kind, place: float, radius: float, rng: np.random.Generator) -> Disk:
    return Disk.from_geometry(
        place,
        outer_radius=max(log_uniform(kind.disk_radius, rng), 1.5 * radius),
        inner_radius=radius,
        thickness=log_uniform(kind.disk_thickness, rng),
        density=DENSITY,
    )


def _with_unknowns(
    kind: Kind, rotor: Rotor, disks: Sequence[float], rng: np.random.Generator
) -> tuple[tuple[Unknown, ...], dict[str, float], Rotor]:
    """Unknowns of some bearings and of one unbalance or two, true values, and the rotor.

    The rotor has all that is known.
    """
    true, targets = {}, dict[str, tuple[Target, ...]]()
    free, n = SETS[rng.integers(len(SETS))], len(rotor.bearings)
    k, c = log_uniform(kind.stiffness, rng), log_uniform(kind.damping, rng)
    ratios = [1.0, *(1.0 if free == "alike" else log_uniform(UNLIKE, rng) for _ in range(n - 1))]
    in_y = {letter: log_uniform(ANISOTROPY, rng) for letter in "kc"}
    bearings = []
    for index, (bearing, ratio) in enumerate(zip(rotor.bearings, ratios)):
        in_x = {"k": k * ratio, "c": c * ratio}
        own = {f"{letter}xx": rounded(in_x[letter]) for letter in "kc"}
        own |= {f"{letter}yy": rounded(in_x[letter] * in_y[letter]) for letter in "kc"}
        if free == "one" and index:
            kxx, kyy, cxx, cyy = (own[name] for name in ("kxx", "kyy", "cxx", "cyy"))
            bearings.append(replace(bearing, kxx=kxx, kyy=kyy, cxx=cxx, cyy=cyy))
            continue
        bearings.append(bearing)
        for name in own:
            key = name if free == "alike" else f"{name}{index + 1}"
            true[key] = own[name]
            targets[key] = (*targets.get(key, ()), BearingTarget(index, name))
    chosen = sorted(rng.permutation(len(disks))[: 1 + (len(disks) > 1 and rng.random() < TWO_UNBALANCES)])
    planes = [UnbalancePlane(disks[index]) for index in chosen]
    for number, _ in enumerate(planes):
        true[f"u{number + 1}"] = log_uniform(kind.unbalance, rng)
        targets[f"u{number + 1}"] = (UnbalanceTarget(number),)
    if len(planes) > 1:
        true["phase2"], targets["phase2"] = rounded(rng.uniform(*FULL_TURN)), (UnbalanceTarget(1, "phase"),)
    unknowns = tuple(Unknown(_parameter(name, true, rng), targets[name]) for name in true)
    return unknowns, true, replace(rotor, bearings=tuple(bearings), unbalance=tuple(planes))


def _parameter(name: str, true: Mapping[str, float], rng: np.random.Generator) -> Parameter:
    quantity = QUANTITY_BY_LETTER[name[0]]
    if quantity == "angle":
        return Parameter(name, *UNITS[quantity], *FULL_TURN)
    return limited_about(name, quantity, true[name], rng)


def _probes(length: float, rng: np.random.Generator) -> tuple[Channel, ...]:
    """Two probes in each plane, each plane in a part of the shaft of its own."""
    n_plane = int(rng.integers(PLANES[0], PLANES[1] + 1))
    places: Array = (np.arange(n_plane) + rng.uniform(0.15, 0.85, n_plane)) / n_plane * length
    channels = []
    for place in places.tolist():
        angle = float(rng.integers(-180, 180))
        channels += [Channel(rounded(place), direction_at(angle + turn)) for turn in (0.0, 90.0)]
    return tuple(channels)

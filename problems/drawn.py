"""Rotors drawn from ranges, for comparing methods on many machines.

No method can be tuned to one of them.

An instance is drawn by a generator that its family, its set and its number alone seed, and rounded to four digits: it is the same
on every machine. The ranges lie about published rotors: the three-disk rotor of Table 1 and the RK-4 rigs (`problems/three_disk.py`,
`rk4.py`, `rk4_two_disk.py`). A draw that is not sound is drawn anew:

- it has a critical speed, by which its band is set;
- it is stable up to its highest speed;
- amplitudes with 5 % noise tell at least half of its unknowns within half of their values (Cramér–Rao lower bound, 1 σ), an angle
  within half a radian, and leave no direction of the unknowns open.

The band ends below the first critical speed in about one draw of ten, as it does on machines that may not run faster.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.likelihood.fisher import UNKNOWABLE, whitened_sensitivity
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins.source import ProblemSettings
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from problems.drawn_kinds import KINDS, drawn_of_kind
from problems.drawn_machine import (
    ANISOTROPY,
    DENSITY,
    FULL_TURN,
    POISSON_RATIO,
    QUANTITY_BY_LETTER,
    RIG,
    TURBINE,
    YOUNG_MODULUS,
    Machine,
)
from problems.drawn_numbers import UNITS, limited_about, log_uniform, rounded
from problems.drawn_parts import PARTS, Draw, in_order, with_parts
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import share_elements, uniform_shaft
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.inputs.tolerances import TOLERANCES, TYPICAL
from problems.rotor.inputs.uncertain import UncertainNumbers
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Target, UnbalanceTarget, Unknown
from problems.rotor_settings import channels_of

OVERHANG = 0.03, 0.15  # of the shaft beyond each bearing, parts of the span
DISK_PLACE = 0.25, 0.75  # of a disk in its share of the span, evenly
CROSS_COUPLING = (
    -0.3,
    0.3,
)  # of √(kxx kyy), evenly; alike in both directions, as of a bearing with inclined axes: stable
N_ELEMENT = 16  # two at least between neighbouring things, mostly three

# Either way, evenly, of the root of the product of the upper limits of kxx and kyy: it tells nothing that these do not.
CROSS_LIMITS = 0.35, 0.6

BAND_FROM, BAND_TO = (0.3, 0.8), (0.9, 3.0)  # ends of the speeds in parts of the first critical speed
N_SPEED = 12, 30  # evenly; the paper has 53, which cost a surrogate of the response more and tell little more here
PROBES = {1: ((0.1, 0.9),), 2: ((0.1, 0.45), (0.55, 0.9))}  # where they look in parts of the shaft, evenly

SOUND_NOISE, SOUND_CRLB, SOUND_SHARE = 0.05, 0.5, 0.5
MAX_DRAWS = 200


def _both(*coefficients: str) -> tuple[Target, ...]:
    return tuple(BearingTarget(bearing, name) for bearing in (0, 1) for name in coefficients)


@dataclass(frozen=True)
class Family:
    """A kind of machine with its unknowns; the unknowns of bearings apply to both alike."""

    machine: Machine
    n_disk: int
    unknowns: Mapping[str, tuple[Target, ...]]
    directions: tuple[str, ...] = ("x", "y")


FOUR = {name: _both(name) for name in ("kxx", "kyy", "cxx", "cyy")}
ONE_UNBALANCE: dict[str, tuple[Target, ...]] = {"u": (UnbalanceTarget(0),)}
# Amplitudes do not tell the phase of all unbalance: that of the first disk is known.
TWO_UNBALANCES: dict[str, tuple[Target, ...]] = {
    "u1": (UnbalanceTarget(0),),
    "u2": (UnbalanceTarget(1),),
    "phase2": (UnbalanceTarget(1, "phase"),),
}
FAMILIES = {
    "isotropic": Family(RIG, 1, {"k": _both("kxx", "kyy"), "c": _both("cxx", "cyy"), **ONE_UNBALANCE}, ("x",)),
    "one_disk": Family(RIG, 1, FOUR | ONE_UNBALANCE),
    "three_disk": Family(TURBINE, 3, FOUR | ONE_UNBALANCE),
    "cross_coupled": Family(TURBINE, 3, FOUR | {"kxy": _both("kxy", "kyx")} | ONE_UNBALANCE),
    "two_disk": Family(RIG, 2, FOUR | TWO_UNBALANCES),
}


@dataclass(frozen=True)
class Drawn(ProblemSettings):
    """A rotor drawn from the ranges of its family.

    Shaft, disks, bearings, unbalance, probes, speeds, search limits.
    """

    family: str = setting(
        "three_disk",
        "what is drawn and unknown: isotropic (a rig with one disk: k, c and u), one_disk (the same with kxx, kyy, cxx, cyy and"
        " u), three_disk (a machine, the same five), cross_coupled (with kxy = kyx too), two_disk (a rig: kxx, kyy, cxx, cyy,"
        " two unbalances and the phase between them); and the kinds of machines on which a diagnosis is counted"
        " (problems/drawn_kinds.py): between_bearings, overhung, two_overhangs, flexible_rig, long",
        choices=(*FAMILIES, *KINDS),
    )
    instance: int = setting(0, "number of the draw", at_least=0)
    held_back: bool = setting(
        False, "draw from another stream of the same ranges, which no method is developed on: for the final ranking"
    )
    machine_parts: list[str] = setting(
        [],
        "parts of real machines: tables (bearings as tables over speed, a factor on each unknown), seals (a known one"
        " with cross-coupling), supports (of known stiffness or, as likely, unknown), layers (a sleeve); in any order",
        choices=tuple(PARTS),
    )
    tolerances: str = setting(
        "none",
        "of the numbers of the rotor and of its probes: none, all are exact, or typical (docs/tolerances.md)",
        choices=TOLERANCES,
    )

    mesh: int | None = setting(None, "elements of the shaft; null: as drawn", at_least=1)

    def check(self) -> None:
        if self.family in KINDS and self.machine_parts:
            raise SettingError(
                f"machine_parts: expected none with family={self.family}, got {', '.join(self.machine_parts)}; take one of"
                f" {', '.join(FAMILIES)}"
            )

    def build(self) -> RotorProblem:
        """The problem; its rotor carries no values of the unknowns."""
        problem = drawn(self.family, self.held_back, self.instance, in_order(self.machine_parts)).problem
        if self.mesh is not None:
            problem = replace(problem, rotor=_meshed(problem.rotor, self.mesh))
        return (
            replace(problem, uncertain=UncertainNumbers(tolerances=TYPICAL))
            if self.tolerances == "typical"
            else problem
        )

    def reference(self) -> dict[str, float]:
        """The values that were drawn, SI."""
        return dict(drawn(self.family, self.held_back, self.instance, in_order(self.machine_parts)).true)


@dataclass(frozen=True, eq=False)
class Instance:
    """A problem and the true values of its unknowns, SI."""

    problem: RotorProblem
    true: Mapping[str, float]

    @property
    def x(self) -> Array:  # (d,) SI
        return np.array([self.true[name] for name in self.problem.parameters.names])


@cache
def drawn(family: str, held_back: bool, number: int, parts: tuple[str, ...] = ()) -> Instance:
    """The first sound draw of an instance with further parts, which are in the order of `PARTS`."""
    entropy = [*family.encode(), int(held_back), number, *" ".join(parts).encode()]
    rng = np.random.default_rng(np.random.SeedSequence(entropy))
    for _ in range(MAX_DRAWS):
        if family in KINDS:
            of_kind = drawn_of_kind(family, rng)
            found = None if of_kind is None else Instance(*of_kind)
        else:
            found = _with_band(_any_draw(FAMILIES[family], parts, rng), FAMILIES[family], rng)
        if found is not None and is_sound(found):
            return found
    raise ArithmeticError(f"{family} {number}: expected a sound draw, got none in {MAX_DRAWS}")


def _meshed(rotor: Rotor, n_element: int) -> Rotor:
    """The rotor with so many elements, shared by length: no draw depends on it."""
    counts = share_elements(n_element, [segment.length for segment in rotor.segments])
    shaft = [each for each in rotor.segments if isinstance(each, ShaftSegment)]  # no drawn one has couplings
    segments = tuple(replace(each, n_element=count) for each, count in zip(shaft, counts, strict=True))
    return replace(rotor, segments=segments)


def is_sound(instance: Instance) -> bool:
    """Whether it is stable and half of its unknowns can be found (above)."""
    problem, x = instance.problem, instance.x
    if not problem.is_stable(x):
        return False
    response, sensitivity = problem.linearised(x)
    scale = [1.0 if item.is_full_turn else abs(value) for item, value in zip(problem.parameters, x)]
    whitened = whitened_sensitivity(response, sensitivity * scale, Noise(SOUND_NOISE, 0.0), Observable.AMPLITUDE)
    _, singular, directions = np.linalg.svd(whitened, full_matrices=False)
    if singular[-1] <= UNKNOWABLE * singular[0]:
        return False
    crlb = np.linalg.norm(directions / singular[:, None], axis=0)
    return bool(np.mean(crlb < SOUND_CRLB) >= SOUND_SHARE)


def _any_draw(family: Family, parts: tuple[str, ...], rng: np.random.Generator) -> Instance:
    """A rotor with true values and limits of its unknowns, seen by its probes at its highest speed alone."""
    machine = family.machine
    span = log_uniform(machine.span, rng)
    before, after = (span * log_uniform(OVERHANG, rng) for _ in range(2))
    bearings = rounded(before), rounded(before + span)
    share = span / family.n_disk
    disks = [rounded(before + share * (number + rng.uniform(*DISK_PLACE))) for number in range(family.n_disk)]
    length, radius = rounded(before + span + after), log_uniform(machine.shaft_radius, rng)
    material = Material(log_uniform(YOUNG_MODULUS, rng), DENSITY, POISSON_RATIO)
    unbalanced = disks if "u2" in family.unknowns else [disks[rng.integers(len(disks))]]
    phases = [rounded(rng.uniform(*FULL_TURN)) for _ in unbalanced]
    rotor = Rotor(
        segments=uniform_shaft(length, (*bearings, *disks), N_ELEMENT, radius=radius, material=material),
        disks=tuple(
            Disk.from_geometry(
                position,
                outer_radius=log_uniform(machine.disk_radius, rng),
                inner_radius=radius,
                thickness=log_uniform(machine.disk_thickness, rng),
                density=DENSITY,
            )
            for position in disks
        ),
        bearings=tuple(Bearing(position) for position in bearings),
        unbalance=tuple(UnbalancePlane(position, phase=phase) for position, phase in zip(unbalanced, phases)),
    )
    true = _true_values(machine, rng) | {"phase2": phases[-1]}
    true = {name: true[name] for name in family.unknowns}
    places = PROBES[int(rng.integers(1, 1 + len(PROBES)))]
    probes = [rounded(length * rng.uniform(*place)) for place in places]
    limited: dict[str, Parameter] = {}
    for name in family.unknowns:
        limited[name] = _parameter(name, true, limited, rng)
    unknowns = tuple(Unknown(limited[name], targets) for name, targets in family.unknowns.items())
    draw = with_parts(Draw(rotor, unknowns, true, machine.fastest), parts, rng)
    speed, channels = np.array([machine.fastest]), channels_of(probes, family.directions)
    return Instance(RotorProblem(draw.rotor, draw.unknowns, speed, channels), draw.true)


def _with_band(instance: Instance, family: Family, rng: np.random.Generator) -> Instance | None:
    """The instance with its speeds about the first critical one; None if it has none."""
    criticals = instance.problem.critical_speeds(instance.x, family.machine.fastest)
    first, last, n_speed = (
        log_uniform(BAND_FROM, rng),
        log_uniform(BAND_TO, rng),
        int(rng.integers(N_SPEED[0], N_SPEED[1] + 1)),
    )
    if not len(criticals):
        return None
    speed = np.linspace(rounded(first * criticals[0]), rounded(last * criticals[0]), n_speed)
    return replace(instance, problem=replace(instance.problem, speed=speed))


def _true_values(machine: Machine, rng: np.random.Generator) -> dict[str, float]:
    """A value of each unknown of any family, SI."""
    k, c = log_uniform(machine.stiffness, rng), log_uniform(machine.damping, rng)
    kyy, cyy = (rounded(value * log_uniform(ANISOTROPY, rng)) for value in (k, c))
    kxy = rounded(rng.uniform(*CROSS_COUPLING) * math.sqrt(k * kyy))
    u1, u2 = (log_uniform(machine.unbalance, rng) for _ in range(2))
    return {"k": k, "c": c, "kxx": k, "cxx": c, "kyy": kyy, "cyy": cyy, "kxy": kxy, "u": u1, "u1": u1, "u2": u2}


def _parameter(
    name: str, true: Mapping[str, float], before: Mapping[str, Parameter], rng: np.random.Generator
) -> Parameter:
    """An unknown with its limits; those before it have theirs."""
    quantity = QUANTITY_BY_LETTER[name[0]]
    if quantity == "angle":
        lower, upper = FULL_TURN
    elif name == "kxy":
        largest = math.sqrt(before["kxx"].upper * before["kyy"].upper)
        lower, upper = (sign * rounded(rng.uniform(*CROSS_LIMITS) * largest) for sign in (-1, 1))
    else:
        return limited_about(name, quantity, true[name], rng)
    return Parameter(name, *UNITS[quantity], lower, upper)

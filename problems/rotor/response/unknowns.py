"""Unknowns of a rotor: each sets one or more of its numbers; their impedances, for surrogates.

An unknown with several targets ties them: two equal bearings have one kxx that sets both.
"""

from __future__ import annotations

import dataclasses
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError, unknown
from ksmea.problem.parameters import Parameter
from ksmea.problem.response_structure import UnknownImpedance
from problems.rotor.finite_elements.bearing import COEFFICIENTS, DAMPINGS, STIFFNESSES
from problems.rotor.finite_elements.data import Rotor

UNBALANCE_PARTS = ("magnitude", "phase")
CARTESIAN_PARTS = ("x", "y")  # in their place: the components at 0° and at 90°, of either sign


@dataclass(frozen=True)
class BearingTarget:
    """One coefficient of one bearing, by the bearing's index in `Rotor.bearings`."""

    bearing: int
    coefficient: str

    def __post_init__(self) -> None:
        if self.coefficient not in COEFFICIENTS:
            raise unknown("bearing coefficient", self.coefficient, COEFFICIENTS)


@dataclass(frozen=True)
class UnbalanceTarget:
    """The magnitude (kg m), the phase (rad) or a Cartesian component (kg m) of the unbalance in one plane, by its index in
    `Rotor.unbalance`."""

    plane: int
    part: str = "magnitude"

    def __post_init__(self) -> None:
        known = (*UNBALANCE_PARTS, *CARTESIAN_PARTS)
        if self.part not in known:
            raise unknown("part of an unbalance", self.part, known)

    @property
    def turns(self) -> bool:
        """Whether it frees the angle of its plane, alone or with the other component."""
        return self.part != "magnitude"


@dataclass(frozen=True)
class OriginTarget:
    """An angle (rad) added to the phases of all unbalance: where the measured phases begin."""


Target = BearingTarget | UnbalanceTarget | OriginTarget


@dataclass(frozen=True)
class Unknown:
    """A parameter and all that it sets."""

    parameter: Parameter
    targets: tuple[Target, ...]


@dataclass(frozen=True, eq=False)
class Inputs:
    """The numbers of a rotor that unknowns may set, for a batch of parameter sets."""

    coefficients: Array  # (n, n_bearing, 12) in the order of COEFFICIENTS, N/m, N s/m, kg
    unbalance: Array  # (n, n_plane, 2): magnitude in kg m, phase in rad
    origin: Array  # (n,) rad, by which all phases are turned

    @property
    def complex_unbalance(self) -> ComplexArray:  # (n, n_plane) kg m
        return self.unbalance[..., 0] * np.exp(1j * self.unbalance[..., 1])

    def bearings_at(self, speed: Array) -> tuple[Array, Array, Array]:
        """Stiffness N/m, damping N s/m and mass kg at spin speeds (n_speed,) rad/s, (n_bearing, 2, 2, n, n_speed) each; the last axis is 1
        if they are equal at all speeds, as they are now. Responses, loads and free motion take bearings from here; the dense route
        and modes take them from `rotor_at`."""
        n, n_bearing = self.coefficients.shape[:2]
        parts = self.coefficients.transpose(1, 2, 0).reshape(
            n_bearing, len(COEFFICIENTS) // len(STIFFNESSES), 2, 2, n, 1
        )
        return parts[:, 0], parts[:, 1], parts[:, 2]


def inputs_at(rotor: Rotor, unknowns: Sequence[Unknown], x: Array) -> Inputs:
    """The rotor's own numbers with the unknowns' values (n, d) put in."""
    coefficients = np.array([[getattr(bearing, name) for name in COEFFICIENTS] for bearing in rotor.bearings])
    unbalance = np.array([[getattr(plane, part) for part in UNBALANCE_PARTS] for plane in rotor.unbalance])
    inputs = Inputs(np.tile(coefficients, (len(x), 1, 1)), np.tile(unbalance, (len(x), 1, 1)), np.zeros(len(x)))
    components: dict[int, ComplexArray] = defaultdict(lambda: np.zeros(len(x), dtype=complex))
    for column, item in enumerate(unknowns):
        for target in item.targets:
            if isinstance(target, BearingTarget):
                inputs.coefficients[:, target.bearing, COEFFICIENTS.index(target.coefficient)] = x[:, column]
            elif isinstance(target, OriginTarget):
                inputs.origin[:] = x[:, column]
            elif target.part in CARTESIAN_PARTS:
                components[target.plane] += (1 if target.part == "x" else 1j) * x[:, column]
            else:
                inputs.unbalance[:, target.plane, UNBALANCE_PARTS.index(target.part)] = x[:, column]
    for plane, vector in components.items():
        inputs.unbalance[:, plane] = np.stack([np.abs(vector), np.angle(vector)], axis=-1)
    inputs.unbalance[:, :, 1] += inputs.origin[:, None]  # after all phases are set
    return inputs


def rotor_at(rotor: Rotor, unknowns: Sequence[Unknown], x: Array) -> Rotor:
    """The rotor with one set of values (d,) put in."""
    inputs = inputs_at(rotor, unknowns, np.asarray(x, dtype=float)[None])
    numbers: list[dict[str, Any]] = [
        dict(zip(COEFFICIENTS, map(float, values), strict=True)) for values in inputs.coefficients[0]
    ]
    bearings = tuple(dataclasses.replace(bearing, **own) for bearing, own in zip(rotor.bearings, numbers, strict=True))
    unbalance = tuple(
        dataclasses.replace(plane, **dict(zip(UNBALANCE_PARTS, map(float, values), strict=True)))
        for plane, values in zip(rotor.unbalance, inputs.unbalance[0], strict=True)
    )
    return dataclasses.replace(rotor, bearings=bearings, unbalance=unbalance)


def check_unknowns(rotor: Rotor, unknowns: Sequence[Unknown]) -> None:
    """Raise `SettingError` where an unknown points at nothing, or two point at the same number."""
    owner: dict[Target, str] = {}
    for item in unknowns:
        name = item.parameter.name
        if not item.targets:
            raise SettingError(f"unknown {name}: expected at least one target, got none")
        for target in item.targets:
            _check_target(rotor, name, target)
            if target in owner:
                raise SettingError(
                    f"unknown {name}: {target} is already set by {owner[target]}; tie them in one unknown"
                )
            owner[target] = name


def _check_target(rotor: Rotor, name: str, target: Target) -> None:
    if isinstance(target, OriginTarget):
        return
    if isinstance(target, BearingTarget):
        thing, index, count = "bearing", target.bearing, len(rotor.bearings)
    else:
        thing, index, count = "unbalance plane", target.plane, len(rotor.unbalance)
    if not 0 <= index < count:
        raise SettingError(f"unknown {name}: expected a {thing} from 0 to {count - 1}, got {index}")


def unknown_impedances(unknowns: Sequence[Unknown]) -> tuple[UnknownImpedance, ...]:
    """Each pair of an unknown stiffness and damping that entries of bearings are set by, or the one of them that is unknown, with
    the number of these entries."""
    setters: dict[tuple[int, int], list[str]] = defaultdict(
        lambda: ["", ""]
    )  # by bearing and place in its 2 × 2 matrix
    for item in unknowns:
        for target in item.targets:
            if isinstance(target, BearingTarget):
                for part, names in enumerate((STIFFNESSES, DAMPINGS)):
                    if target.coefficient in names:
                        setters[target.bearing, names.index(target.coefficient)][part] = item.parameter.name
    pairs = Counter((stiffness, damping) for stiffness, damping in setters.values())
    return tuple(UnknownImpedance(*pair, n_port) for pair, n_port in pairs.items())

"""A rotor with unknowns, at given speeds and channels: the data of a problem, without what effects change of them.

Sign convention: a real response is Re(q e^{iΩt}), m 0-peak; the shaft turns from +x to +y.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from ksmea.problem.parameters import Parameters
from problems.rotor.finite_elements.bearing import COEFFICIENTS, STIFFNESSES
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.response.receptance import Impedance, Reduction, reduce_rotor
from problems.rotor.response.unknowns import BearingTarget, Inputs, Unknown, check_unknowns, inputs_at, rotor_at


@dataclass(frozen=True, eq=False)
class RotorModel:
    """Whatever values the unknowns have in the given rotor are replaced by the middle of their limits, so that a model
    cannot carry the values that are to be identified."""

    rotor: Rotor
    unknowns: tuple[Unknown, ...]  # of the rotor itself
    speed: Array  # (n_speed,) rad/s
    channels: tuple[Channel, ...]

    def __post_init__(self) -> None:
        _check(self.rotor, self.unknowns, self.speed, self.channels)
        middle = (self.own.lower + self.own.upper) / 2
        object.__setattr__(self, "rotor", rotor_at(self.rotor, self.unknowns, middle))
        object.__setattr__(self, "unknowns", tuple(self.unknowns))
        speed = np.array(self.speed, dtype=float)
        speed.setflags(write=False)
        object.__setattr__(self, "speed", speed)
        object.__setattr__(self, "channels", tuple(self.channels))

    @cached_property
    def own(self) -> Parameters:
        """The unknowns of the rotor itself, without effects."""
        return Parameters(tuple(item.parameter for item in self.unknowns))

    def inputs(self, x: Array) -> Inputs:
        """The rotor's numbers at sets (n, d) of its own unknowns, SI."""
        return inputs_at(self.rotor, self.unknowns, x)

    def rotor_at(self, x: Array) -> Rotor:
        """The rotor at values (d,) of its own unknowns, SI."""
        return rotor_at(self.rotor, self.unknowns, x)

    @cached_property
    def reduction(self) -> Reduction:
        """The rotor seen from its ports, with the bearings of the middle of the limits as nominal ones."""
        return reduce_rotor(self.rotor, impedances_of(self.rotor, self.unknowns), self.speed, self.channels)

    def loaded(self, loads: tuple[Load, ...]) -> Reduction:
        """The reduction with columns for unit loads, if any, behind the columns of the unbalance planes."""
        if not loads:
            return self.reduction
        if loads not in self._loaded_reductions:
            forces = unit_loads(self.rotor, loads, len(self.speed))
            impedances = self.reduction.impedances
            self._loaded_reductions[loads] = reduce_rotor(self.rotor, impedances, self.speed, self.channels, forces)
        return self._loaded_reductions[loads]

    @cached_property
    def _loaded_reductions(self) -> dict[tuple[Load, ...], Reduction]:
        return {}

    @cached_property
    def reductions_beside_effects(self) -> OrderedDict[Hashable, Reduction]:
        """Kept for effects that leave the rotor and its loads as they are, by what they make of it."""
        return OrderedDict()


def checked_sets(x: Array, parameters: Parameters) -> Array:
    """Parameter sets (n, d), if that is what they are."""
    x = np.asarray(x, dtype=float)
    if x.ndim != 2 or x.shape[1] != len(parameters):
        raise SettingError(
            f"parameter sets: expected an array (n, {len(parameters)}) in the order"
            f" {', '.join(parameters.names)}, got shape {x.shape}"
        )
    return x


def finite(values: ComplexArray) -> ComplexArray:
    """The values, where all of them are finite."""
    if not np.all(np.isfinite(values)):
        raise np.linalg.LinAlgError(
            "unbalance response is not finite: a parameter is not, or the rotor is undamped at a critical speed"
        )
    return values


def impedances_of(rotor: Rotor, unknowns: Sequence[Unknown]) -> tuple[Impedance, ...]:
    """All direct impedances, and those cross-coupled ones that are given or unknown."""
    unknown = {
        impedance_of(target) for item in unknowns for target in item.targets if isinstance(target, BearingTarget)
    }
    return tuple(
        Impedance(index, row, column)
        for index, bearing in enumerate(rotor.bearings)
        for row in range(2)
        for column in range(2)
        if row == column
        or bearing.stiffness[row, column]
        or bearing.damping[row, column]
        or bearing.mass[row, column]
        or Impedance(index, row, column) in unknown
    )


def impedance_of(target: BearingTarget) -> Impedance:
    """The impedance that a coefficient of a bearing is part of."""
    return Impedance(target.bearing, *divmod(COEFFICIENTS.index(target.coefficient) % len(STIFFNESSES), 2))


def _check(rotor: Rotor, unknowns: Sequence[Unknown], speed: Array, channels: Sequence[Channel]) -> None:
    if not rotor.bearings or not rotor.unbalance:
        raise SettingError(
            "rotor: expected at least one bearing and one unbalance plane,"
            f" got {len(rotor.bearings)} and {len(rotor.unbalance)}"
        )
    if not unknowns:
        raise SettingError("unknowns of a rotor: expected at least one, got none")
    check_unknowns(rotor, unknowns)
    speed = np.asarray(speed)
    if speed.ndim != 1 or not len(speed) or not np.all(np.isfinite(speed) & (speed > 0)):
        raise SettingError(
            f"speeds: expected a list of numbers above 0 rad/s, got {speed}; unbalance does nothing at rest"
        )
    if not channels:
        raise SettingError("channels: expected at least one, got none")
    for channel in channels:
        rotor.require_on_shaft(channel.position, "sensor")

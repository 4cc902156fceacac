"""A rotor with unknowns, at given speeds and channels.

The data of a problem, without what effects change of them.

Sign convention: a real response is Re(q e^{iΩt}), m 0-peak; the shaft turns from +x to +y.
"""

from __future__ import annotations

import cmath
from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.numerics.differences import Kept, recent
from ksmea.problem.load import Load
from ksmea.problem.parameters import Parameters
from problems.rotor.finite_elements.bearing import Bearing, numbers_of
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.response.links import Impedance
from problems.rotor.response.receptance import FactoredShaft, Reduction, reduce_rotor
from problems.rotor.response.unknown_checks import check_unknowns
from problems.rotor.response.unknowns import (
    BearingTarget,
    Inputs,
    PedestalTarget,
    RotorNumbers,
    Unknown,
    complex_unbalance_at,
    inputs_at,
    rotor_at,
    unbalance_and_slopes,
)

Values = TypeVar("Values", Array, ComplexArray)

MAX_FACTORED = 3  # kept of rotors with their factors, which differ in the impedances that effects set


@dataclass(frozen=True, eq=False)
class RotorModel:
    """Rotor model without values of the unknowns.

    Values that the unknowns have in the given rotor are replaced by the midpoints of their limits, so that a model
    cannot carry the values that are to be identified.
    """

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
        return inputs_at(self._numbers, x)

    def complex_unbalance(self, x: Array) -> ComplexArray:
        """Unbalance of each plane at sets (n, d) of its own unknowns, (n, n_plane) kg m."""
        return complex_unbalance_at(self._numbers, x)

    def unbalance_and_slopes(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Unbalance of each plane at one set (d,), (n_plane,) kg m, and its derivatives, (n_plane, d)."""
        return unbalance_and_slopes(self._numbers, x)

    @cached_property
    def _numbers(self) -> RotorNumbers:
        return RotorNumbers.of(self.rotor, self.unknowns)

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
    def slopes_beside_effects(self) -> OrderedDict[Hashable, Any]:
        """Derivatives of the rotor's matrices with respect to unknowns of effects, kept.

        `problems/rotor/extension/rotor_slopes.py` uses them.
        """
        return OrderedDict()

    @cached_property
    def reductions_beside_effects(self) -> OrderedDict[Hashable, Reduction]:
        """Kept for effects that leave the rotor and its loads as they are, by what they make of it."""
        return OrderedDict()

    @cached_property
    def local_changes(self) -> Kept[Hashable, Any]:
        """Kept for effects that change the rotor at a few degrees of freedom.

        `problems/rotor/extension/local_change.py` makes them.
        """
        return Kept()

    def factored(self, impedances: tuple[Impedance, ...]) -> FactoredShaft | None:
        """The rotor about nominal values of impedances, for effects that load or read it.

        None if it is too large to be kept.
        """
        make = partial(FactoredShaft.of, self.rotor, impedances, self.speed)
        return recent(self._factored, impedances, make, MAX_FACTORED)

    @cached_property
    def _factored(self) -> Kept[tuple[Impedance, ...], FactoredShaft | None]:
        return Kept()


def checked_sets(x: Array, parameters: Parameters) -> Array:
    """Parameter sets (n, d), if that is what they are."""
    x = np.asarray(x, dtype=float)
    if x.ndim != 2 or x.shape[1] != len(parameters):
        raise SettingError(
            f"parameter sets: expected an array (n, {len(parameters)}) in the order"
            f" {', '.join(parameters.names)}, got shape {x.shape}"
        )
    return x


def finite(values: Values) -> Values:
    """The parameters or responses, where all of them are finite."""
    squares = np.vdot(values, values)  # finite only if each value is, in a third of the time
    if not (cmath.isfinite(squares) or np.isfinite(values).all()):
        raise np.linalg.LinAlgError(
            "unbalance response is not finite: a parameter is not, or the rotor is undamped at a critical speed"
        )
    return values


def impedances_of(rotor: Rotor, unknowns: Sequence[Unknown], *, of_all_bearings: bool = False) -> tuple[Impedance, ...]:
    """Impedances that may differ from nominal.

    They are of each bearing, seal or pedestal of which a number is unknown, or of all bearings and of these seals and
    pedestals: all direct impedances and the given or unknown cross-coupled ones.
    """
    targets = [target for item in unknowns for target in item.targets]
    unknown = [
        {(target.bearing, column % 4) for target in targets if isinstance(target, kind) for column in target.columns}
        for kind in (BearingTarget, PedestalTarget)
    ]
    every = set(range(len(rotor.bearings))) if of_all_bearings else set()
    films, pedestals = (sorted({bearing for bearing, _ in each}) for each in unknown)
    films = sorted({*films, *every})
    parts = [(bearing, False) for bearing in films] + [(bearing, True) for bearing in pedestals]
    found = []
    for link, (bearing, is_pedestal) in enumerate(parts):
        given = _given(rotor.supported[bearing], is_pedestal)
        found += [
            Impedance(bearing, *divmod(entry, 2), link=link, of_pedestal=is_pedestal)
            for entry in range(4)
            if entry in (0, 3) or given[entry] or (bearing, entry) in unknown[is_pedestal]
        ]
    return tuple(found)


def _given(bearing: Bearing, is_pedestal: bool) -> Array:
    """Entries of the 2 × 2 matrices of a bearing or of its pedestal that are not 0, (4,)."""
    if not is_pedestal:
        rows = [numbers_of(bearing), *(bearing.table.rows if bearing.table is not None else ())]
        return np.any(np.reshape(rows, (-1, 4)), axis=0)
    assert bearing.pedestal is not None, "a bearing without a support"
    is_measured = bearing.pedestal.dynamic_stiffness is not None
    return np.any(np.reshape(numbers_of(bearing.pedestal), (-1, 4)), axis=0) | is_measured


def _check(rotor: Rotor, unknowns: Sequence[Unknown], speed: Array, channels: Sequence[Channel]) -> None:
    for probe in rotor.housing_probes:
        if not 0 <= probe.bearing < len(rotor.supported) or rotor.supported[probe.bearing].pedestal is None:
            raise SettingError(
                f"probe at {probe.position:g} m: expected a bearing with a support to be relative to, got bearing"
                f" {probe.bearing + 1}; give that bearing a support, or measure against the ground"
            )
    check_unknowns(rotor, unknowns)
    speed = np.asarray(speed)
    if speed.ndim != 1 or not len(speed) or not np.all(np.isfinite(speed) & (speed > 0)):
        raise SettingError(
            f"speeds: expected a list of numbers above 0 rad/s, got {speed}; unbalance does nothing at rest"
        )
    for channel in channels:
        rotor.require_on_shaft(channel.position, "sensor")

"""A rotor with unknown bearing coefficients and unbalance, as a problem for identification.

Sign convention: a real response is Re(q e^{iΩt}), m 0-peak; the shaft turns from +x to +y.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from ksmea.problem.parameters import PHASE_ORIGIN, Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.problem.response_structure import UnknownImpedance
from ksmea.rotordynamics.free_rotor import Rotordynamic
from ksmea.rotordynamics.modes import Campbell, Mode
from ksmea.units import GRAM_MILLIMETRE
from problems.rotor.finite_elements.data import DAMPINGS, STIFFNESSES, Rotor, UnbalancePlane
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.free_motion.critical_speeds import critical_speeds
from problems.rotor.free_motion.free_motion import N_MODE, FreeMotion
from problems.rotor.free_motion.modes import campbell_diagram, natural_modes
from problems.rotor.free_motion.stability import growth_rate, low_modes, searched_speed
from problems.rotor.response import dense
from problems.rotor.response.receptance import Impedance, Reduction, reduce_rotor
from problems.rotor.response.unknowns import (
    CARTESIAN_PARTS,
    BearingTarget,
    Inputs,
    OriginTarget,
    UnbalanceTarget,
    Unknown,
    check_unknowns,
    inputs_at,
    rotor_at,
    unknown_impedances,
)

CHUNK_BYTES = 2**20  # of the largest temporary array of a batch: about what a core's own cache holds


@dataclass(frozen=True, eq=False)
class RotorProblem(Problem, Rotordynamic):
    """The unbalance response of a rotor at given speeds and channels as a function of its unknowns.

    Whatever values the unknowns have in the given rotor are replaced by the middle of their limits, so that a
    problem cannot carry the values that are to be identified.
    """

    rotor: Rotor
    unknowns: tuple[Unknown, ...]
    speed: Array  # (n_speed,) rad/s
    channels: tuple[Channel, ...]

    def __post_init__(self) -> None:
        _check(self.rotor, self.unknowns, self.speed, self.channels)
        middle = (self.parameters.lower + self.parameters.upper) / 2
        object.__setattr__(self, "rotor", rotor_at(self.rotor, self.unknowns, middle))
        object.__setattr__(self, "unknowns", tuple(self.unknowns))
        speed = np.array(self.speed, dtype=float)
        speed.setflags(write=False)
        object.__setattr__(self, "speed", speed)
        object.__setattr__(self, "channels", tuple(self.channels))

    @cached_property
    def parameters(self) -> Parameters:
        return Parameters(tuple(item.parameter for item in self.unknowns))

    @cached_property
    def reduction(self) -> Reduction:
        """The rotor seen from its ports, with the bearings of the middle of the limits as nominal ones."""
        return reduce_rotor(self.rotor, impedances_of(self.rotor, self.unknowns), self.speed, self.channels)

    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_speed, n_channel), m."""
        x = checked_sets(x, self.parameters)
        response = np.empty((len(x), len(self.speed), len(self.channels)), dtype=complex)
        n_chunk = max(1, CHUNK_BYTES // self.reduction.receptance.nbytes)
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            for start in range(0, len(x), n_chunk):
                chunk = slice(start, start + n_chunk)
                inputs = inputs_at(self.rotor, self.unknowns, x[chunk])
                # by rank-one updates, as reference results were: `motion_with` is faster and differs by rounding
                per_unbalance = self.reduction.unit_response(*self._impedance_parts(inputs))
                response[chunk] = combined(per_unbalance, inputs.complex_unbalance)
        return finite(response)

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        return True

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit."""
        return self._linearised(self.reduction, x)[1][:, :, 0]

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        return self._linearised(self._loaded(tuple(loads)), x)

    def _linearised(self, reduction: Reduction, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Motion under the unbalance and under each further load of a reduction, (n_speed, n_channel, 1 + n_load), and ∂/∂x of them.

        From D q = f: ∂q/∂z_rc = −D⁻¹ e_r q_c for an impedance, D⁻¹ ∂f/∂x for an unbalance.
        """
        inputs = inputs_at(self.rotor, self.unknowns, checked_sets(np.asarray(x)[None], self.parameters))
        stiffness, damping = (part[:, 0] for part in self._impedance_parts(inputs))
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            receptance = reduction.full_receptance(stiffness, damping)
        n_port, n_plane = reduction.n_port, len(self.rotor.unbalance)
        per_port, per_unbalance = receptance[n_port:, :n_port], receptance[n_port:, n_port : n_port + n_plane]
        of_unbalance = np.einsum("rus,u->rs", receptance[:, n_port : n_port + n_plane], inputs.complex_unbalance[0])
        columns = np.concatenate([of_unbalance[:, None], receptance[:, n_port + n_plane :]], axis=1)
        at_ports, seen = columns[:n_port], columns[n_port:]  # (…, 1 + n_load, n_speed)
        change = np.zeros((len(self.unknowns), *seen.shape), dtype=complex)
        for index, target in ((index, target) for index, item in enumerate(self.unknowns) for target in item.targets):
            if isinstance(target, OriginTarget):
                change[index, :, 0] += 1j * seen[:, 0]
            elif isinstance(target, UnbalanceTarget):
                change[index, :, 0] += per_unbalance[:, target.plane] * _unbalance_change(inputs, target)
            else:
                impedance = _impedance_of(target)
                factor = 1.0 if target.coefficient in STIFFNESSES else 1j * self.speed
                change[index] -= per_port[:, impedance.row_port, None] * (factor * at_ports[impedance.column_port])
        ordered = seen.transpose(2, 0, 1), change.transpose(3, 1, 2, 0)
        # What follows runs over the unknowns, which lie together in memory then
        return finite(np.ascontiguousarray(ordered[0])), finite(np.ascontiguousarray(ordered[1]))

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        """(n, d) SI → response to unit loads, (n, n_speed, n_channel, n_load) m per N or N m."""
        return self.response_and_per_load(x, loads)[1]

    def response_and_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        x = checked_sets(x, self.parameters)
        reduction = self._loaded(tuple(loads))
        response = np.empty((len(x), len(self.speed), len(self.channels)), dtype=complex)
        per_load = np.empty((*response.shape, len(loads)), dtype=complex)
        n_chunk = max(1, CHUNK_BYTES // reduction.receptance.nbytes)
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            for start in range(0, len(x), n_chunk):
                chunk = slice(start, start + n_chunk)
                inputs = inputs_at(self.rotor, self.unknowns, x[chunk])
                columns = reduction.motion_with(*self._impedance_parts(inputs), inputs.complex_unbalance)
                response[chunk], per_load[chunk] = columns[..., 0], columns[..., 1:]
        return finite(response), finite(per_load)

    def _loaded(self, loads: tuple[Load, ...]) -> Reduction:
        """The reduction with columns for unit loads, if any, behind those of the unbalance planes."""
        if not loads:
            return self.reduction
        if loads not in self._loaded_reductions:
            forces = unit_loads(self.rotor, loads, len(self.speed))
            impedances = self.reduction.impedances
            reduction = reduce_rotor(self.rotor, impedances, self.speed, self.channels, forces)
            self._loaded_reductions[loads] = reduction
        return self._loaded_reductions[loads]

    @cached_property
    def reductions_beside_effects(self) -> OrderedDict[Hashable, Reduction]:
        """Kept for effects that leave the rotor and its loads as they are, by what they make of it."""
        return OrderedDict()

    @cached_property
    def _loaded_reductions(self) -> dict[tuple[Load, ...], Reduction]:
        return {}

    def at(self, speed: Array, channels: Sequence[Channel]) -> RotorProblem:
        """The same rotor at other speeds (rad/s) and channels."""
        return dataclasses.replace(self, speed=speed, channels=tuple(channels))

    @property
    def sites(self) -> Array:
        """The nodes of the shaft, (n,) m."""
        return self.rotor.node_positions

    @property
    def landmarks(self) -> dict[str, float]:
        """Its bearings and disks, numbered from the left, m."""
        return {
            f"{name} {number}": position
            for name, parts in (("bearing", self.rotor.bearings), ("disk", self.rotor.disks))
            for number, position in enumerate(sorted({part.position for part in parts}), start=1)
        }

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> RotorProblem:
        """The same rotor with a known unbalance (kg m, rad) added at a position (m)."""
        added = UnbalancePlane(position, magnitude, phase)
        rotor = dataclasses.replace(self.rotor, unbalance=(*self.rotor.unbalance, added))
        return dataclasses.replace(self, rotor=rotor)

    def with_unknown_unbalance(self, position: float, names: tuple[str, str], at_most: float) -> RotorProblem:
        """The same rotor with an unbalance of unknown size and angle at a position (m): two unknowns more, its components at
        0° and 90° within ± `at_most` (kg m)."""
        plane = len(self.rotor.unbalance)
        rotor = dataclasses.replace(self.rotor, unbalance=(*self.rotor.unbalance, UnbalancePlane(position)))
        added = (
            Unknown(Parameter(name, "g mm", GRAM_MILLIMETRE, -at_most, at_most), (UnbalanceTarget(plane, part),))
            for name, part in zip(names, CARTESIAN_PARTS, strict=True)
        )
        return dataclasses.replace(self, rotor=rotor, unknowns=(*self.unknowns, *added))

    def unbalance(self, x: Array) -> dict[float, complex]:
        """At values x (d,) SI, by position (m): kg m, angles from where those of `with_unbalance` count."""
        inputs = inputs_at(self.rotor, self.unknowns, checked_sets(np.asarray(x)[None], self.parameters))
        found: dict[float, complex] = {}
        for plane, size in zip(self.rotor.unbalance, inputs.complex_unbalance[0] * np.exp(-1j * inputs.origin[0])):
            found[plane.position] = found.get(plane.position, 0.0) + complex(size)
        return found

    @property
    def unknown_impedances(self) -> tuple[UnknownImpedance, ...]:
        return unknown_impedances(self.unknowns)

    @property
    def has_free_phase(self) -> bool:
        """Whether the phases of all unbalance are unknown."""
        targets = {target for item in self.unknowns for target in item.targets}
        turning = {target.plane for target in targets if isinstance(target, UnbalanceTarget) and target.turns}
        return OriginTarget() in targets or len(turning) == len(self.rotor.unbalance)

    def with_phase_origin(self) -> RotorProblem:
        """With the phase of all unbalance unknown. One and a half turns: each angle lies a quarter turn or more from the
        limits at least once, so that no search ends at a limit that is none."""
        if self.has_free_phase:
            return self
        origin = Parameter(PHASE_ORIGIN, "deg", np.pi / 180, -1.5 * np.pi, 1.5 * np.pi)
        return dataclasses.replace(self, unknowns=(*self.unknowns, Unknown(origin, (OriginTarget(),))))

    def dense_response(self, x: Array) -> ComplexArray:
        """`response` by the dense route, one solve with the whole rotor per set and speed: slow, for comparison."""
        rotors = (rotor_at(self.rotor, self.unknowns, row) for row in checked_sets(x, self.parameters))
        return np.stack([dense.dense_response(rotor, self.speed, self.channels) for rotor in rotors])

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        """Speeds (rad/s) up to `highest`, or up to the problem's highest, at which a damped natural frequency equals the
        spin speed, rising, at values x (d,) SI."""
        limit = float(np.max(self.speed)) if highest is None else highest
        return critical_speeds(self._rotor_at(x), limit)

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """The oscillating modes at values x (d,) SI and a spin speed (rad/s), the first `n_mode` or all."""
        return natural_modes(self._rotor_at(x), speed, n_mode)

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        """Natural frequencies and damping ratios of the first modes over spin speeds (n_speed,) rad/s."""
        return campbell_diagram(self._rotor_at(x), np.asarray(speed, dtype=float), n_mode)

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """The largest real part of any damped eigenvalue at values x (d,) SI, (n_speed,) 1/s, at spin speeds (rad/s)."""
        speed = np.asarray(speed, dtype=float)
        inputs = inputs_at(self.rotor, self.unknowns, checked_sets(np.asarray(x)[None], self.parameters))
        parts = inputs.coefficients[0].reshape(-1, 2, 2, 2)  # bearing, stiffness or damping, row, column
        over_speed = np.broadcast_to(parts, (len(speed), *parts.shape))
        low = low_modes(self.rotor, searched_speed(self.speed, speed))
        return growth_rate(low, speed, over_speed[:, :, 0], over_speed[:, :, 1])

    def free_rotor(self, x: Array, highest: float) -> FreeMotion:
        """The rotor at values x (d,) SI with its free motions up to a frequency and spin speed (rad/s)."""
        rotor = self._rotor_at(x)
        low = low_modes(self.rotor, highest, least=N_MODE)
        stiffness = np.array([bearing.stiffness for bearing in rotor.bearings])
        damping = np.array([bearing.damping for bearing in rotor.bearings])

        def bearings_at(speed: Array) -> tuple[Array, Array]:
            shape = (len(speed), *stiffness.shape)
            return np.broadcast_to(stiffness, shape), np.broadcast_to(damping, shape)

        return FreeMotion(rotor, self.channels, lambda speed: low, bearings_at)

    def _rotor_at(self, x: Array) -> Rotor:
        return rotor_at(self.rotor, self.unknowns, checked_sets(np.asarray(x)[None], self.parameters)[0])

    def _impedance_parts(self, inputs: Inputs) -> tuple[Array, Array]:
        """Stiffness and damping of the reduction's impedances, (n_impedance, n) each."""
        bearing = [impedance.bearing for impedance in self.reduction.impedances]
        entry = np.array([2 * impedance.row + impedance.column for impedance in self.reduction.impedances])
        return inputs.coefficients[:, bearing, entry].T, inputs.coefficients[:, bearing, entry + len(STIFFNESSES)].T


def checked_sets(x: Array, parameters: Parameters) -> Array:
    """Parameter sets (n, d), if that is what they are."""
    x = np.asarray(x, dtype=float)
    if x.ndim != 2 or x.shape[1] != len(parameters):
        raise SettingError(
            f"parameter sets: expected an array (n, {len(parameters)}) in the order"
            f" {', '.join(parameters.names)}, got shape {x.shape}"
        )
    return x


def combined(per_unbalance: ComplexArray, unbalance: ComplexArray) -> ComplexArray:
    """Σ over planes of the response per unbalance (n_channel, n_plane, n, n_speed) times the unbalance (n, n_plane),
    → (n, n_speed, n_channel)."""
    total = np.sum(per_unbalance * unbalance.T[:, :, None], axis=1)
    return total.transpose(1, 2, 0)


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
        _impedance_of(target) for item in unknowns for target in item.targets if isinstance(target, BearingTarget)
    }
    return tuple(
        Impedance(index, row, column)
        for index, bearing in enumerate(rotor.bearings)
        for row in range(2)
        for column in range(2)
        if row == column
        or bearing.stiffness[row, column]
        or bearing.damping[row, column]
        or Impedance(index, row, column) in unknown
    )


def _unbalance_change(inputs: Inputs, target: UnbalanceTarget) -> complex:
    """∂(m e e^{iφ})/∂x of a plane for what an unknown sets of it."""
    if target.part == "phase":
        return 1j * complex(inputs.complex_unbalance[0, target.plane])
    if target.part == "magnitude":
        return complex(np.exp(1j * inputs.unbalance[0, target.plane, 1]))
    return complex(np.exp(1j * inputs.origin[0])) * (1 if target.part == "x" else 1j)


def _impedance_of(target: BearingTarget) -> Impedance:
    names = STIFFNESSES if target.coefficient in STIFFNESSES else DAMPINGS
    return Impedance(target.bearing, *divmod(names.index(target.coefficient), 2))


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

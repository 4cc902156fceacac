"""Motion and free motion of a rotor with unknowns.

The contract, and the rotor as it is, without effects.

Bearings enter by their impedances at each spin speed. The response follows by rank-one updates of the receptances between
ports, its derivatives in closed form from the updated receptances.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.problem.load import Load
from ksmea.problem.parameters import Parameters
from problems.rotor.finite_elements.bearing import COEFFICIENTS
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.free_motion.free_motion import FreeMotion
from problems.rotor.response import dense
from problems.rotor.response.model import RotorModel, finite
from problems.rotor.response.polynomial import (
    LinearImpedance,
    ResponsePolynomial,
    has_few_monomials,
    response_polynomial,
)
from problems.rotor.response.receptance import Reduction
from problems.rotor.response.unknowns import (
    BearingTarget,
    Inputs,
    PedestalTarget,
    columns_at,
)

CHUNK_BYTES = 2**20  # of the largest temporary array of a batch: about what a core's own cache holds


class Physics(ABC):
    """Motion of a rotor. Sets x (n, d) and points x (d,) hold the values of all unknowns, SI."""

    @property
    @abstractmethod
    def parameters(self) -> Parameters:
        """All unknowns, first the unknowns of the rotor itself."""

    @property
    def costly(self) -> Indices:
        """Indices of the unknowns that change the rotor itself."""
        return np.empty(0, dtype=int)

    def parts(self, x: Array) -> tuple[Array, list[Array]]:
        """Values (n, …) of the rotor's own unknowns, and of the unknowns of each effect.

        Default: it has no effect.
        """
        return x, []

    @abstractmethod
    def response(self, x: Array) -> ComplexArray:
        """(n, n_speed, n_channel), m."""

    @abstractmethod
    def load_response(self, x: Array, loads: tuple[Load, ...]) -> ComplexArray:
        """Response to unit loads, (n, n_speed, n_channel, n_load) m per N or N m."""

    def with_loads(self, x: Array, loads: tuple[Load, ...]) -> tuple[ComplexArray, ComplexArray]:
        """Both. Default: one after the other."""
        return self.response(x), self.load_response(x, loads)

    @abstractmethod
    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n_speed, n_channel) and sensitivity (n_speed, n_channel, d), m per SI unit."""

    def sensitivity(self, x: Array) -> ComplexArray:
        return self.linearised(x)[1]

    def linearised_per_load(self, x: Array, loads: tuple[Load, ...]) -> tuple[ComplexArray, ComplexArray] | None:
        """Columns (n_speed, n_channel, 1 + n_load) and their derivatives (…, d).

        Default: None, by differences only.
        """
        return None

    @abstractmethod
    def linearises_cheaply(self, loads: Sequence[Load]) -> bool: ...

    @abstractmethod
    def dense_response(self, x: Array) -> ComplexArray:
        """`response` by solving with the whole rotor."""

    @abstractmethod
    def free_motion(self, x: Array, highest: float, n_mode: int) -> FreeMotion:
        """Rotor with its free vibrations up to a frequency and spin speed (rad/s).

        It has this number of modes or more.
        """

    @abstractmethod
    def unbalance(self, x: Array) -> dict[float, complex]:
        """By position (m), kg m; angles count from the angle 0 of the model."""


@dataclass(frozen=True, eq=False)
class PlainPhysics(Physics):
    """A rotor without effects."""

    model: RotorModel

    @property
    def parameters(self) -> Parameters:
        return self.model.own

    def response(self, x: Array) -> ComplexArray:
        """Response as a ratio of polynomials where these have few terms, else by rank-one updates.

        `Reduction.motion_on` is faster than updates and differs by rounding.
        """
        polynomial = self._polynomial
        if polynomial is not None:
            return finite(_in_chunks(self._by_polynomial, finite(x), polynomial.nbytes_per_set))
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            return finite(_in_chunks(self._by_updates, x, self.model.reduction.receptance.nbytes))

    def _by_updates(self, x: Array) -> ComplexArray:
        reduction, inputs = self.model.reduction, self.model.inputs(x)
        per_unbalance = reduction.response_per_load(_impedances(reduction, inputs))
        return _combined(per_unbalance, inputs.complex_unbalance)

    def _by_polynomial(self, x: Array) -> ComplexArray:
        assert self._polynomial is not None, "an exact polynomial"
        return self._polynomial.response(x, self.model.complex_unbalance(x))

    @cached_property
    def _polynomial(self) -> ResponsePolynomial | None:
        """None if it would have too many terms."""
        model, reduction = self.model, self.model.reduction
        scale = np.maximum(np.abs(model.own.lower), np.abs(model.own.upper))
        scale[scale == 0] = 1
        slopes: dict[tuple[int, int], dict[int, ComplexArray]] = {
            (item.row_port, item.column_port): {} for item in reduction.impedances
        }
        for index, item in enumerate(model.unknowns):
            for row, column, slope in (
                each for target in item.targets for each in self._impedance_changes.get(target, [])
            ):
                of_port = slopes[row, column]
                of_port[index] = of_port.get(index, 0) + scale[index] * slope
        n_plane = len(model.rotor.unbalance)
        n_value = len(model.speed) * len(model.channels) * n_plane
        if not has_few_monomials([list(each) for each in slopes.values()], n_value):
            return None
        without = _impedances(reduction, model.inputs(np.zeros((1, len(scale)))))[:, 0]
        impedances = [LinearImpedance(*each) for each in zip(without, slopes.values(), strict=True)]
        return response_polynomial(reduction, impedances, scale, n_plane)

    def with_loads(self, x: Array, loads: tuple[Load, ...]) -> tuple[ComplexArray, ComplexArray]:
        model, reduction = self.model, self.model.loaded(loads)
        response = np.empty((len(x), len(model.speed), len(model.channels)), dtype=complex)
        per_load = np.empty((*response.shape, len(loads)), dtype=complex)
        with np.errstate(divide="ignore", invalid="ignore"):
            for chunk in _chunks(len(x), reduction.receptance.nbytes):
                inputs = model.inputs(x[chunk])
                columns = reduction.motion_on(_impedances(reduction, inputs), inputs.complex_unbalance)
                response[chunk], per_load[chunk] = columns[..., 0], columns[..., 1:]
        return finite(response), finite(per_load)

    def load_response(self, x: Array, loads: tuple[Load, ...]) -> ComplexArray:
        return self.with_loads(x, loads)[1]

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        if self._polynomial is None:
            columns, change = self.linearised_per_load(x, ())
            return columns[:, :, 0], change[:, :, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            response, sensitivity = self._polynomial.linearised(x, *self.model.unbalance_and_slopes(x))
        return finite(response), finite(sensitivity)

    def linearised_per_load(self, x: Array, loads: tuple[Load, ...]) -> tuple[ComplexArray, ComplexArray]:
        """From D q = f: ∂q/∂z_rc = −D⁻¹ e_r q_c for an impedance, D⁻¹ ∂f/∂x for an unbalance."""
        model, reduction, inputs = self.model, self.model.loaded(loads), self.model.inputs(x[None])
        with np.errstate(divide="ignore", invalid="ignore"):
            receptance = reduction.receptance_on(_impedances(reduction, inputs)[:, 0])
        n_port, n_plane = reduction.n_port, len(model.rotor.unbalance)
        per_port, per_unbalance = receptance[n_port:, :n_port], receptance[n_port:, n_port : n_port + n_plane]
        unbalance, unbalance_slopes = model.unbalance_and_slopes(x)
        of_unbalance = np.einsum("rus,u->rs", receptance[:, n_port : n_port + n_plane], unbalance)
        columns = np.concatenate([of_unbalance[:, None], receptance[:, n_port + n_plane :]], axis=1)
        at_ports, seen = columns[:n_port], columns[n_port:]  # (…, 1 + n_load, n_speed)
        change = np.zeros((len(model.unknowns), *seen.shape), dtype=complex)
        change[:, :, 0] = np.einsum("rus,ud->drs", per_unbalance, unbalance_slopes)
        for index, target in ((index, target) for index, item in enumerate(model.unknowns) for target in item.targets):
            for row, column, slope in self._impedance_changes.get(target, []):
                change[index] -= per_port[:, row, None] * (slope * at_ports[column])
        ordered = seen.transpose(2, 0, 1), change.transpose(3, 1, 2, 0)
        # What follows runs over the unknowns, which lie together in memory then
        return finite(np.ascontiguousarray(ordered[0])), finite(np.ascontiguousarray(ordered[1]))

    @cached_property
    def _impedance_changes(self) -> dict[object, list[tuple[int, int, ComplexArray]]]:
        reduction, rotor = self.model.reduction, self.model.rotor
        targets = (target for item in self.model.unknowns for target in item.targets)
        return {
            each: impedance_changes(reduction, rotor, each)
            for each in targets
            if isinstance(each, (BearingTarget, PedestalTarget))
        }

    def linearises_cheaply(self, loads: Sequence[Load]) -> bool:
        return True

    def dense_response(self, x: Array) -> ComplexArray:
        model = self.model
        return np.stack([dense.dense_response(model.rotor_at(row), model.speed, model.channels) for row in x])

    def free_motion(self, x: Array, highest: float, n_mode: int) -> FreeMotion:
        model, inputs = self.model, self.model.inputs(x[None])
        return FreeMotion(
            partial(model.rotor_at, x),
            model.rotor,
            model.channels,
            partial(bearing_matrices, inputs),
            highest,
            n_mode,
            pedestals=inputs.pedestals_of(0),
        )

    def unbalance(self, x: Array) -> dict[float, complex]:
        inputs = self.model.inputs(x[None])
        found: dict[float, complex] = {}
        for plane, size in zip(
            self.model.rotor.unbalance, inputs.complex_unbalance[0] * np.exp(-1j * inputs.origin[0])
        ):
            found[plane.position] = found.get(plane.position, 0.0) + complex(size)
        return found


def impedance_changes(
    reduction: Reduction, rotor: Rotor, target: BearingTarget | PedestalTarget
) -> list[tuple[int, int, ComplexArray]]:
    """Changes of impedances per number that an unknown sets.

    Row and column of their ports, and ∂z/∂x (n_speed,).
    """
    speed, bearing = reduction.speed, rotor.supported[target.bearing]
    elastic = 1.0 + 0j
    if isinstance(target, PedestalTarget) and bearing.pedestal is not None:
        elastic = complex(1, bearing.pedestal.loss_factor)
    slopes = np.array([np.full(len(speed), elastic), 1j * speed, -(speed**2)])  # of K, C, M
    is_factor = isinstance(target, BearingTarget) and target.is_factor
    tables = columns_at(bearing, speed) if is_factor else np.ones((len(COEFFICIENTS), 1))
    ports = {
        (item.row, item.column): (item.row_port, item.column_port)
        for item in reduction.impedances
        if item.bearing == target.bearing and item.of_pedestal == isinstance(target, PedestalTarget)
    }
    return [
        (*ports[divmod(column % 4, 2)], slopes[column // 4] * (tables[column] if is_factor else 1.0))
        for column in target.columns
        if divmod(column % 4, 2) in ports
    ]


def bearing_matrices(inputs: Inputs, speed: Array) -> tuple[Array, Array, Array]:
    """Stiffness N/m, damping N s/m and mass kg of bearings and seals at one set of values.

    They are (n_speed, n_supported, 2, 2) each.
    """
    parts = [np.moveaxis(part[:, :, :, 0], -1, 0) for part in inputs.bearings_at(speed)]
    shape = len(speed), *parts[0].shape[1:]
    stiffness, damping, mass = (np.broadcast_to(part, shape) for part in parts)
    return stiffness, damping, mass


def _in_chunks(response: Callable[[Array], ComplexArray], x: Array, nbytes: int) -> ComplexArray:
    """The response of a batch x (n, d), of which each set takes so many bytes."""
    if len(x) * nbytes <= CHUNK_BYTES:
        return response(x)
    return np.concatenate([response(x[chunk]) for chunk in _chunks(len(x), nbytes)])


def _chunks(n: int, nbytes: int) -> list[slice]:
    """Parts of a batch of n sets, of which each takes so many bytes."""
    n_chunk = max(1, CHUNK_BYTES // max(1, nbytes))
    return [slice(start, start + n_chunk) for start in range(0, n, n_chunk)]


def _impedances(reduction: Reduction, inputs: Inputs) -> ComplexArray:
    """Impedances of the reduction, (n_impedance, n, n_speed) N/m."""
    stiffness, damping, mass = inputs.bearings_at(reduction.speed)
    n_film = len(reduction.entries[0])
    shape = len(reduction.impedances), len(inputs.origin), len(reduction.speed)
    found = np.empty(shape, dtype=complex)
    found.real[:n_film] = stiffness[reduction.entries]
    np.multiply(damping[reduction.entries], reduction.speed, out=found.imag[:n_film])
    if inputs.own.has_mass:
        found.real[:n_film] -= mass[reduction.entries] * reduction.speed**2
    of_pedestals = reduction.of_pedestals
    pedestals = inputs.pedestal_impedances((item.bearing for item in of_pedestals), reduction.speed)
    for index, item in enumerate(of_pedestals, start=n_film):
        found[index] = pedestals[item.bearing][item.row, item.column]
    return found


def _combined(per_unbalance: ComplexArray, unbalance: ComplexArray) -> ComplexArray:
    """Sum over planes of the response per unbalance times the unbalance (n, n_plane).

    The response is (n_channel, n_plane, n, n_speed), the sum (n, n_speed, n_channel).
    """
    total = np.sum(per_unbalance * unbalance.T[:, :, None], axis=1)
    return np.ascontiguousarray(total.transpose(1, 2, 0))

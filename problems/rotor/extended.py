"""A rotor with effects that its baseline model lacks, as a problem like any other.

The unknowns of the effects follow those of the rotor. An effect may change the rotor itself (which costs a reduction
anew per value), the impedances of its bearings at each speed, the forces on it, also those that follow a law of its
motion, and what the probes make of that; all but the first are as cheap as a change of bearings.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.load import Load
from ksmea.parameters import Parameters
from ksmea.proxy import ProblemProxy
from problems.rotor import dense
from problems.rotor.assembly import assemble_free, node_dof
from problems.rotor.data import COEFFICIENTS, STIFFNESSES, Rotor
from problems.rotor.extended_sensitivity import differenced, linearised
from problems.rotor.hooks import RotorHooks
from problems.rotor.loads import unit_loads
from problems.rotor.problem import RotorProblem, checked_sets, combined, finite, impedances_of
from problems.rotor.receptance import Impedance, Reduction, reduce_rotor
from problems.rotor.run_up import Sweep, parabola, sweep_change
from problems.rotor.site_law import Force, SiteLaw, attached, dense_parts, with_forces
from problems.rotor.stability import growth_rate, low_modes, searched_speed
from problems.rotor.support import Support, in_series
from problems.rotor.synchronous_poles import Poles, block_diagonal, poles_on, spectrum, unit_force
from problems.rotor.unbalance import complex_unbalance, force_per_unbalance
from problems.rotor.unknowns import Unknown, inputs_at, rotor_at

CHUNK_BYTES = 2**22  # of the largest temporary array of a batch: with fewer, hooks of effects cost as much as the rotor
MAX_REDUCTIONS = 64  # kept of rotors that an effect has changed


@dataclass(frozen=True, eq=False)
class ExtendedProblem(ProblemProxy):
    """A rotor problem with effects."""

    base: RotorProblem
    effects: tuple[RotorHooks, ...]

    def __post_init__(self) -> None:
        names = self.parameters.names
        for name in names:
            if names.count(name) > 1:
                raise SettingError(
                    f"effects: expected each unknown once, got {name} again; take one of the two effects"
                )
        nonlinear = [site.law.name for effect in self.effects if (site := effect.site_law()) and not site.is_linear]
        if nonlinear and self._sweeps(self._parts(np.zeros((1, len(self.parameters))))[1]):
            raise SettingError(
                f"effects: expected forces that are linear in the motion beside a sweep of the speed, got {nonlinear[0]}"
            )

    @cached_property
    def parameters(self) -> Parameters:
        return Parameters(
            (*self.base.parameters, *(item for effect in self.effects for item in effect.parameters(self.base)))
        )

    @property
    def behind(self) -> Problem:
        return self.base

    def around(self, behind: Problem) -> Problem:
        return dataclasses.replace(self, base=cast(RotorProblem, behind))

    @property
    def machine(self) -> Problem:
        return self

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        return change(self)

    def going(self, direction: str) -> ExtendedProblem:
        return dataclasses.replace(self, effects=tuple(effect.going(direction) for effect in self.effects))

    # Of a rotor with effects nobody knows the modes: they are not those of the rotor behind.
    critical_speeds = Problem.critical_speeds
    modes = Problem.modes
    campbell = Problem.campbell
    stability_threshold = Problem.stability_threshold  # by its own growth rate
    is_stable = Problem.is_stable

    @property
    def rotor(self) -> Rotor:
        return self.base.rotor

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Those of the rotor itself."""
        return self.base.unknowns

    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_speed, n_channel), m."""
        return self._rotor_by_rotor(x, (len(self.channels),), (), self._reduced_response)

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        """(n, d) SI → response to unit loads, (n, n_speed, n_channel, n_load) m per N or N m."""
        return self._rotor_by_rotor(x, (len(self.channels), len(loads)), tuple(loads), self._reduced_load_response)

    def _rotor_by_rotor(
        self,
        x: Array,
        shape: tuple[int, ...],
        loads: tuple[Load, ...],
        evaluate: Callable[[Reduction, Array], ComplexArray],
    ) -> ComplexArray:
        """What is evaluated of sets (n, d), (n, n_speed, *shape), with one reduction for all that change the rotor
        alike."""
        x = checked_sets(x, self.parameters)
        found = np.empty((len(x), len(self.speed), *shape), dtype=complex)
        changing = x[:, self.costly]
        _, group = np.unique(changing, axis=0, return_inverse=True) if changing.size else (None, np.zeros(len(x), int))
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            for index in range(int(group.max(initial=-1)) + 1):
                rows = np.flatnonzero(group == index)
                reduction = self.reduction(tuple(changing[rows[0]]), loads)
                n_chunk = max(1, CHUNK_BYTES // reduction.receptance.nbytes)
                for start in range(0, len(rows), n_chunk):
                    chunk = rows[start : start + n_chunk]
                    found[chunk] = evaluate(reduction, x[chunk])
        return finite(found)

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit."""
        return self.linearised(x)[1]

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response and sensitivity by one solution; of a sweep of the speed by central differences inside the limits."""
        [x] = checked_sets(np.asarray(x)[None], self.parameters)
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            by = differenced if self._sweeps(self._parts(x[None])[1]) else linearised
            response, sensitivity = by(self, x)
        return finite(response), finite(sensitivity)

    def dense_response(self, x: Array) -> ComplexArray:
        """`response` by the dense route, the whole rotor per set and speed: slow, for comparison and for making data."""
        return np.concatenate([self._dense(row[None]) for row in checked_sets(x, self.parameters)])

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """The largest real part of any damped eigenvalue at values x (d,) SI, (n_speed,) 1/s, at spin speeds (rad/s)."""
        speed = np.asarray(speed, dtype=float)
        own, of_effects = self._parts(checked_sets(np.asarray(x)[None], self.parameters))
        coefficients = inputs_at(self.base.rotor, self.base.unknowns, own).coefficients
        impedance = np.moveaxis(self._bearing_impedance(coefficients, speed, of_effects)[:, :, :, 0], -1, 0)
        rotor = self.rotor_with(np.asarray(x))
        forces = [force for force in self._forces(of_effects) if force[0].is_linear and force[0].law.follows_motion]
        low = low_modes(rotor, searched_speed(self.speed, speed), tuple(site.position for site, _ in forces))
        for index, force in enumerate(forces):
            low = low.with_attached(index, *attached(force, speed))
        damping = impedance.imag / speed[:, None, None, None]
        return growth_rate(low, speed, impedance.real, damping, self._supports(of_effects))

    def unbalance(self, x: Array) -> dict[float, complex]:
        """That of the rotor itself, and of effects that are unbalance too, by position (m), kg m."""
        own, of_effects = self._parts(checked_sets(np.asarray(x)[None], self.parameters))
        found = self.base.unbalance(own[0])
        origin = inputs_at(self.base.rotor, self.base.unknowns, own).origin[0]
        for effect, values in zip(self.effects, of_effects):
            for position, size in effect.unbalance(values[0]).items():
                found[position] = found.get(position, 0.0) + size * complex(np.exp(-1j * origin))
        return found

    @cached_property
    def _columns(self) -> list[Indices]:
        """Where the unknowns of the rotor itself lie, then those of each effect."""
        counts = [len(self.base.parameters), *(len(effect.parameters(self.base)) for effect in self.effects)]
        return np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])

    def _parts(self, x: Array) -> tuple[Array, list[Array]]:
        """The values (n, …) of the rotor's own unknowns, and those of each effect."""
        own, *of_effects = (x[:, columns] for columns in self._columns)
        return own, of_effects

    @cached_property
    def costly(self) -> Indices:
        """Indices of the unknowns that change the rotor itself."""
        changing = [columns for effect, columns in zip(self.effects, self._columns[1:]) if effect.changes_rotor]
        return np.concatenate(changing) if changing else np.empty(0, dtype=int)

    @cached_property
    def impedances(self) -> tuple[Impedance, ...]:
        """All that the rotor's own unknowns or an effect may set."""
        needed = set(impedances_of(self.base.rotor, self.base.unknowns))
        if any(effect.couples_axes for effect in self.effects):
            bearings = range(len(self.base.rotor.bearings))
            needed |= {Impedance(bearing, row, column) for bearing in bearings for row in (0, 1) for column in (0, 1)}
        return tuple(sorted(needed, key=lambda item: (item.bearing, item.row, item.column)))

    @cached_property
    def _reductions(self) -> OrderedDict[tuple[tuple[float, ...], tuple[Load, ...]], Reduction]:
        return OrderedDict()

    def reduction(self, changing: tuple[float, ...], loads: tuple[Load, ...]) -> Reduction:
        """The rotor, as its effects have changed it, seen from its ports; columns of unit loads come last."""
        kept, key = self._reductions, (changing, loads)
        if key not in kept:
            rotor = self._changed_rotor(self.base.rotor, np.array(changing))
            forces = self.further_forces(rotor, loads)
            kept[key] = reduce_rotor(rotor, self.impedances, self.speed, self.seen_channels, forces, banded=True)
            if len(kept) > MAX_REDUCTIONS:
                kept.popitem(last=False)
        kept.move_to_end(key)
        return kept[key]

    def further_forces(self, rotor: Rotor, loads: tuple[Load, ...]) -> ComplexArray | None:
        """Nodal forces (n_speed, n_dof, n) of all loads beside the unbalance planes: those of effects, unit ones at the sites of
        laws, and the given ones."""
        forces = [] if (own := self._loads(rotor)) is None else [own]
        units = (*(load for each in self.site_laws for load in each.loads), *loads)
        forces += [unit_loads(rotor, units, len(self.speed))] if units else []
        return np.concatenate(forces, axis=2) if forces else None

    def rotor_with(self, x: Array) -> Rotor:
        """The rotor as effects change it at values (d,) SI; its bearings and unbalance are nominal."""
        return self._changed_rotor(self.base.rotor, x[self.costly])

    def _changed_rotor(self, rotor: Rotor, values: Array) -> Rotor:
        start = 0
        for effect in self.effects:
            if effect.changes_rotor:
                count = len(effect.parameters(self.base))
                rotor = effect.rotor(rotor, values[start : start + count])
                start += count
        return rotor

    def _loads(self, rotor: Rotor) -> ComplexArray | None:
        loads = [effect.loads(rotor, self.speed) for effect in self.effects if effect.has_loads]
        return np.concatenate(loads, axis=2) if loads else None

    def _sizes(self, of_effects: list[Array]) -> list[ComplexArray]:
        return [effect.load_sizes(values) for effect, values in zip(self.effects, of_effects) if effect.has_loads]

    @cached_property
    def site_laws(self) -> tuple[SiteLaw, ...]:
        """The laws of forces that effects add at sites, in the order in which they enter."""
        return tuple(site for site, _ in self._forces([np.empty(0)] * len(self.effects)))

    def _forces(self, of_effects: list[Array]) -> list[Force]:
        """These with their coefficients."""
        sites = ((effect.site_law(), values) for effect, values in zip(self.effects, of_effects))
        return sorted(((site, values) for site, values in sites if site), key=lambda force: not force[0].is_linear)

    def _motion(self, reduction: Reduction, x: Array) -> tuple[ComplexArray, list[Array]]:
        """Motion and responses to unit loads at the seen channels, (n, n_speed, n_seen, 1 + n_load), and the values of each
        effect."""
        of_effects = self._parts(x)[1]
        impedance, sizes = self.impedances_and_sizes(x)
        per_load, n_own = reduction.response_per_load(impedance), sizes.shape[1]
        motion = combined(per_load[:, :n_own], sizes)
        columns = np.concatenate([motion[..., None], per_load[:, n_own:].transpose(2, 3, 0, 1)], axis=-1)
        columns = with_forces(columns, self._forces(of_effects), self.seen_channels, self.speed)
        columns[..., 0] += self._sweep_change(x)
        return columns, of_effects

    def shown(self, columns: ComplexArray, x: Array) -> ComplexArray:
        """What the probes show (n, n_speed, n_channel), m, of motion and responses to unit forces at the sites of laws
        (n, n_speed, n_seen, 1 + n_site_load), with these forces acting, for sets (n, d)."""
        of_effects = self._parts(x)[1]
        acting = with_forces(columns, self._forces(of_effects), self.seen_channels, self.speed)
        return self._observed(acting[..., 0], of_effects)

    @property
    def shows_motion(self) -> bool:
        """Whether no force follows a law and the probes show the motion as it is."""
        return not self.site_laws and all(type(each).observed is RotorHooks.observed for each in self.effects)

    def _reduced_response(self, reduction: Reduction, x: Array) -> ComplexArray:
        columns, of_effects = self._motion(reduction, x)
        return self._observed(columns[..., 0], of_effects)

    def _reduced_load_response(self, reduction: Reduction, x: Array) -> ComplexArray:
        columns, of_effects = self._motion(reduction, x)
        motion = np.moveaxis(columns[..., 1:], -1, 0)  # (n_load, n, n_speed, n_seen)
        at_rest = self._observed(np.zeros(motion.shape[1:], dtype=complex), of_effects)  # runout is read at rest too
        return np.stack([self._observed(each, of_effects) - at_rest for each in motion], axis=-1)

    def impedances_and_sizes(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """For sets (n, d), effects and supports included: the impedances (n_impedance, n, n_speed), N/m, and how large the
        unbalance of each plane and each load of effects are, (n, n_plane + n_load)."""
        own, of_effects = self._parts(x)
        inputs = inputs_at(self.base.rotor, self.base.unknowns, own)
        seen = self._impedance_seen(inputs.coefficients, self.speed, of_effects)
        sizes = np.concatenate([inputs.complex_unbalance, *self._sizes(of_effects)], axis=1)
        return np.stack([seen[item.bearing, item.row, item.column] for item in self.impedances]), sizes

    def _impedance_seen(self, coefficients: Array, speed: Array, of_effects: list[Array]) -> ComplexArray:
        """Impedances that the shaft feels at the ports, (n_bearing, 2, 2, n, n_speed) N/m, from coefficients
        (n, n_bearing, 8), effects and supports included."""
        impedance = self._bearing_impedance(coefficients, speed, of_effects)
        for support in self._supports(of_effects):
            impedance = in_series(impedance, support.compliance(speed))
        return impedance

    def _bearing_impedance(self, coefficients: Array, speed: Array, of_effects: list[Array]) -> ComplexArray:
        """The same of the bearings alone, at spin speeds (n_speed,) rad/s."""
        n, n_bearing = coefficients.shape[:2]
        split = np.moveaxis(coefficients, 0, -1).reshape(n_bearing, len(COEFFICIENTS) // len(STIFFNESSES), 2, 2, n, 1)
        impedance = split[:, 0] + 1j * speed * split[:, 1]
        for effect, values in self._in_stages(of_effects):
            impedance = effect.impedance(impedance, speed, values)
        return impedance

    def _supports(self, of_effects: list[Array]) -> list[Support]:
        """What carries the bearings, from the bearing to the ground."""
        found = (effect.support(values) for effect, values in self._in_stages(of_effects))
        return [support for support in found if support is not None]

    @cached_property
    def seen_channels(self) -> tuple[Channel, ...]:
        """The channels, and behind them those that effects make them of, or whose motion a force may follow."""
        needed = dict.fromkeys(channel for effect in self.effects for channel in effect.needed_channels(self.channels))
        needed |= dict.fromkeys(channel for each in self.site_laws for channel in each.channels)
        return (*self.channels, *(channel for channel in needed if channel not in self.channels))

    def _observed(self, response: ComplexArray, of_effects: list[Array]) -> ComplexArray:
        """What the probes show of the motion (n, n_speed, n_seen) at the seen channels."""
        for effect, values in self._in_stages(of_effects):
            response = effect.observed(response, self.seen_channels, self.speed, values)
        return response[..., : len(self.channels)]

    def _in_stages(self, of_effects: list[Array]) -> list[tuple[RotorHooks, Array]]:
        """The effects with their values in the order in which they act."""
        return sorted(zip(self.effects, of_effects), key=lambda pair: pair[0].stage)

    def _dense(self, x: Array) -> ComplexArray:
        """One set (1, d) without any reduction."""
        own, of_effects = self._parts(x)
        rotor = self._changed_rotor(rotor_at(self.base.rotor, self.base.unknowns, own[0]), x[0, self.costly])
        coefficients = inputs_at(self.base.rotor, self.base.unknowns, own).coefficients
        impedance = self._impedance_seen(coefficients, self.speed, of_effects)
        stiffness = dense.dynamic_stiffness(assemble_free(rotor), self.speed)
        for bearing, values in zip(rotor.bearings, impedance[:, :, :, 0]):  # (2, 2, n_speed)
            lateral = node_dof(rotor.node_at(bearing.position, "bearing"))[:2]
            stiffness[:, lateral[:, None], lateral] += np.moveaxis(values, -1, 0)
        force = force_per_unbalance(rotor, self.speed) @ complex_unbalance(rotor)
        if (loads := self._loads(rotor)) is not None:
            force = force + loads @ np.concatenate(self._sizes(of_effects), axis=1)[0]
        forces = self._forces(of_effects)
        for each in forces:
            if each[0].is_linear:
                added_stiffness, added_force = dense_parts(rotor, each, self.speed)
                stiffness, force = stiffness + added_stiffness, force + added_force
        others = [each for each in forces if not each[0].is_linear]
        units = [np.broadcast_to(site.rows(rotor).T, (*force.shape, 2)) for site, _ in others]
        motion = dense.channel_rows(rotor, self.seen_channels) @ np.linalg.solve(
            stiffness, np.concatenate([force[..., None], *units], axis=2)
        )
        columns = with_forces(motion[None], others, self.seen_channels, self.speed)
        return self._observed(columns[..., 0] + self._sweep_change(x), of_effects)

    def _sweep_change(self, x: Array) -> ComplexArray:
        """What a sweep of the speed adds to the motion at the seen channels, (n, n_speed, n_seen) m, for sets (n, d) with the
        same rotor."""
        change = np.zeros((len(x), len(self.speed), len(self.seen_channels)), dtype=complex)
        for sweep in self._sweeps(self._parts(x)[1]):
            moving = np.flatnonzero(sweep.acceleration)
            if len(moving):
                swept = Sweep(sweep.acceleration[moving], sweep.highest)
                change[moving] = sweep_change(self._poles(x[moving], swept), self.speed, swept)
        return change

    def _sweeps(self, of_effects: list[Array]) -> list[Sweep]:
        found = (effect.sweep(values) for effect, values in zip(self.effects, of_effects))
        return [sweep for sweep in found if sweep is not None]

    def _poles(self, x: Array, sweep: Sweep) -> Poles:
        """Those of the motion at the seen channels, for sets (n, d) with the same rotor."""
        own, of_effects = self._parts(x)
        inputs = inputs_at(self.base.rotor, self.base.unknowns, own)
        rotor, nodes = self.rotor_with(x[0]), sweep.nodes
        force = nodes[:, None, None] ** 2 * (inputs.complex_unbalance @ unit_force(rotor).T)  # (3, n, n_dof)
        for effect, values in zip(self.effects, of_effects):
            if effect.has_loads:
                force = force + np.moveaxis(effect.loads(rotor, nodes) @ effect.load_sizes(values).T, 1, 2)
        impedance = list(self._impedance_seen(inputs.coefficients, nodes, of_effects).transpose(0, 4, 3, 1, 2))
        positions = []
        for site, coefficients in self._forces(of_effects):
            force = force + np.stack([site.at_rest(each[None], nodes) for each in coefficients], axis=1) @ site.rows(
                rotor
            )
            if site.law.follows_motion:
                positions.append(site.position)
                impedance.append(np.stack([site.stiffness(each[None], nodes) for each in coefficients], axis=1))
        nominal = spectrum(rotor, searched_speed(nodes, nodes), self.seen_channels, tuple(positions))
        return poles_on(nominal, parabola(block_diagonal(impedance), nodes), parabola(force, nodes), sweep.reach)

"""Response of a rotor with effects that its baseline model lacks.

An effect may change the rotor itself (which requires another reduction for each value), the impedances of its bearings at each
speed, the forces on it, including forces that follow a law of its motion, and the readings of the probes. All but the first are
as cheap as a change of bearings.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.nonlinear.laws import NonlinearLaw
from ksmea.numerics.differences import differenced, recent
from ksmea.plugins.effect import Effect
from ksmea.plugins.files import snake_case
from ksmea.problem.load import Load
from ksmea.rotordynamics.layout import EffectMark
from problems.rotor.extension.extended_sensitivity import STEP, linearised
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.extension.nonlinear_sites import dense_motion, responses_at_order, with_nonlinear_forces
from problems.rotor.extension.run_up import Sweep, parabola, sweep_change
from problems.rotor.extension.site_law import attached, with_linear_forces
from problems.rotor.extension.synchronous_poles import Poles, block_diagonal, poles_on, spectrum, unit_force
from problems.rotor.extension.turning import HIGHEST, TurningEffects, TurningShaft
from problems.rotor.extension.with_effects import MAX_REDUCTIONS, RotorWithEffects
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance
from problems.rotor.free_motion.free_motion import FreeMotion
from problems.rotor.free_motion.stability import searched_speed
from problems.rotor.response.links import condensed, read_housings
from problems.rotor.response.model import finite
from problems.rotor.response.physics import Physics, bearing_matrices
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.receptance import Reduction

CHUNK_BYTES = 2**22  # of the largest temporary array of a batch: with fewer, hooks of effects cost as much as the rotor
MAX_SITE_MOTIONS = 8  # kept, which sensitivities start from
MAX_LINEARISED = 8  # kept of responses with their sensitivities: several fits start where another one has ended


@dataclass(frozen=True, eq=False)
class ExtendedPhysics(RotorWithEffects, Physics):
    """Motion of a rotor with effects.

    If several steady-state responses exist, it is the response of a slow run, or the one next to `near` (n_speed,
    n_order, n_unit), m: the motion of the sites of forces that depend on it.
    """

    near: ComplexArray | None = None

    def __post_init__(self) -> None:
        d = len(self.parameters)  # each unknown has a name of its own, or this raises
        sweeps = self.sweeps(self.parts(np.zeros((1, d)))[1])
        if sweeps and read_housings(self.base.rotor, self.seen_channels):
            raise SettingError(
                "effects: expected probes against the ground together with a sweep of the speed, got some on housings"
            )
        laws = [site.law for effect in self.effects if (site := effect.site_law())]
        if sweeps and (own := [law.name for law in laws if law.has_own_mode]):
            raise SettingError(
                f"effects: expected forces without a mode of their own together with a sweep of the speed, got {own[0]}"
            )
        nonlinear = [law.name for law in laws if isinstance(law, NonlinearLaw)]
        if nonlinear and (self._turning.are_there or sweeps):
            beside = "a stiffness that turns with the shaft" if self._turning.are_there else "a sweep of the speed"
            raise SettingError(
                f"effects: expected forces that are linear in the motion together with {beside}, got {nonlinear[0]}"
            )

    @cached_property
    def _turning(self) -> TurningEffects:
        return TurningEffects(self.effects)

    def response(self, x: Array) -> ComplexArray:
        return self._rotor_by_rotor(x, (len(self.base.channels),), (), self._reduced_response)

    def response_next_to(self, x: Array, points: Array) -> ComplexArray:
        """Response (n, n_speed, n_channel), m, at points (n, d) SI.

        If several steady-state responses exist, it is the one next to the response at x (d,).
        """
        if self._is_nonlinear and tuple(x) not in self._site_motions:
            self.response(x[None])
        return self._rotor_by_rotor(
            points,
            (len(self.base.channels),),
            (),
            partial(self._reduced_response, near=self._site_motions.get(tuple(x))),
        )

    def with_loads(self, x: Array, loads: tuple[Load, ...]) -> tuple[ComplexArray, ComplexArray]:
        """By one reduction if unknowns change the rotor, so that each value costs one."""
        if not len(self.costly):
            return super().with_loads(x, loads)
        shape = (len(self.base.channels), 1 + len(loads))
        both = self._rotor_by_rotor(x, shape, loads, self._reduced_columns)
        return both[..., 0], both[..., 1:]

    def load_response(self, x: Array, loads: tuple[Load, ...]) -> ComplexArray:
        return self._rotor_by_rotor(x, (len(self.base.channels), len(loads)), loads, self._reduced_load_response)

    def _rotor_by_rotor(
        self,
        x: Array,
        shape: tuple[int, ...],
        loads: tuple[Load, ...],
        evaluate: Callable[[Reduction, Array], ComplexArray],
    ) -> ComplexArray:
        """Results of `evaluate` for sets (n, d), (n, n_speed, *shape).

        There is one reduction for all sets that change the rotor alike.
        """
        found = np.empty((len(x), len(self.base.speed), *shape), dtype=complex)
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

    def linearises_cheaply(self, loads: Sequence[Load]) -> bool:
        return self._has_one_solution and (not loads or len(self.costly) > 0)

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response and sensitivity by one solution, or else by central differences inside the limits."""
        return recent(self._linearised, tuple(x), partial(self._linearised_at, x), MAX_LINEARISED)

    def _linearised_at(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        with np.errstate(divide="ignore", invalid="ignore"):  # `finite` speaks of it instead
            if self._has_one_solution:
                response, sensitivity = (each[:, :, 0] for each in linearised(self, x))
            else:
                response, sensitivity = self._by_differences(x)
        for each in (response, sensitivity):
            finite(each).flags.writeable = False  # others may be given it too
        return response, sensitivity

    def linearised_per_load(self, x: Array, loads: tuple[Load, ...]) -> tuple[ComplexArray, ComplexArray] | None:
        if not (loads and len(self.costly) and self._has_one_solution):
            return None
        with np.errstate(divide="ignore", invalid="ignore"):
            columns, change = linearised(self, x, loads)
        return finite(columns), finite(change)

    def _by_differences(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Central differences of the whole response."""
        parameters = self.parameters
        around = partial(self.response_next_to, x)
        return differenced(around, x, STEP * parameters.width, parameters.lower, parameters.upper)

    @cached_property
    def _linearised(self) -> OrderedDict[tuple[float, ...], tuple[ComplexArray, ComplexArray]]:
        return OrderedDict()

    @cached_property
    def _has_one_solution(self) -> bool:
        """Whether one solution of D q = f at 1X is all of the motion, on a chain from bearing to bearing.

        The changed rotor must stay such a chain.
        """
        of_effects = self.parts(np.zeros((1, len(self.parameters))))[1]
        chain = not (self.couples_bearings and len(self.costly))
        return chain and not (self._turning.are_there or self._is_nonlinear or self.sweeps(of_effects))

    @cached_property
    def _is_nonlinear(self) -> bool:
        """Whether a force depends on the motion of its site otherwise than linearly."""
        return bool(self.forces(self.parts(np.zeros((1, len(self.parameters))))[1])[1])

    def dense_response(self, x: Array) -> ComplexArray:
        return np.concatenate([self._dense(row[None]) for row in x])

    def free_motion(self, x: Array, highest: float, n_mode: int) -> FreeMotion:
        """Free vibration of the rotor with all that is linear in the motion and does not turn with the shaft."""
        base = self.base
        own, of_effects = self.parts(x[None])
        inputs, (linear, nonlinear) = base.inputs(own), self.forces(of_effects)
        moved = [force for force in linear if force[0].law.follows_motion]
        resonant = [site.law.name for site, _ in moved if site.law.has_own_mode]

        def made() -> Rotor:
            rotor = self.changed_rotor(base.rotor_at(own[0]), x[self.costly])
            return _with_unbalance_of_effects(rotor, self, of_effects)

        def bearings_at(speed: Array) -> tuple[Array, Array, Array]:
            impedance = np.moveaxis(self.bearing_impedance(inputs, speed, of_effects)[:, :, :, 0], -1, 0)
            mass = bearing_matrices(inputs, speed)[2]
            if (added := self.bearing_inertia(of_effects)) is not None:
                mass = mass + added[..., 0] * (np.arange(mass.shape[1]) < len(base.rotor.bearings))[:, None, None]
            return impedance.real, impedance.imag / speed[:, None, None, None], mass

        return FreeMotion(
            made,
            self.rotor_with(x),
            base.channels,
            bearings_at,
            highest,
            n_mode,
            tuple((force[0].position, partial(attached, force)) for force in moved if not force[0].law.has_own_mode),
            tuple(self.supports(of_effects)),
            inputs.pedestals_of(0),
            tuple(_mark(effect, base) for effect in self.effects),
            (
                *_left_out(self, [site.law.name for site, _ in nonlinear]),
                *(f"Free motions leave out the {law}, which has a mode of its own." for law in resonant),
            ),
        )

    def unbalance(self, x: Array) -> dict[float, complex]:
        """Unbalance of the rotor itself, and of effects that are unbalance too."""
        own, of_effects = self.parts(x[None])
        found = dict(self.base.unbalance(own[0]))
        origin = self.base.inputs(own).origin[0]
        for effect, values in zip(self.effects, of_effects):
            for position, size in effect.unbalance(values[0]).items():
                found[position] = found.get(position, 0.0) + size * complex(np.exp(-1j * origin))
        return found

    def _motion(
        self, reduction: Reduction, x: Array, near: ComplexArray | None = None
    ) -> tuple[ComplexArray, list[Array]]:
        """Motion and responses to unit loads at the seen channels, and each effect's values.

        They are (n, n_speed, n_seen, 1 + n_load). `near` is as in `with_nonlinear_forces`; its result for one set is
        kept.
        """
        of_effects = self.parts(x)[1]
        impedance, sizes = self.impedances_and_sizes(x)
        columns, n_own = reduction.motion_on(impedance, sizes), sizes.shape[1]
        (linear, nonlinear), seen = self.forces(of_effects), self.seen_channels
        columns = with_linear_forces(columns, linear, seen, self.base.speed)

        def at_order(order: int) -> ComplexArray:
            further = self.reduction(tuple(x[0, self.costly]), (), order)
            units = further.response_per_load(self.impedances_and_sizes(x, order)[0])[:, n_own:]
            return responses_at_order(units.transpose(2, 3, 0, 1), linear, len(seen), self.base.speed, order)

        near = self.near if near is None else near
        columns, at_sites = with_nonlinear_forces(columns, nonlinear, seen, self.base.speed, at_order, near)
        if at_sites is not None and len(x) == 1:
            recent(self._site_motions, tuple(x[0]), lambda: at_sites[0], MAX_SITE_MOTIONS)
        if self._turning.are_there:
            columns[..., 0] = self._turning_motion(x, sizes)
        columns[..., 0] += self._sweep_change(x)
        return columns, of_effects

    def _turning_motion(self, x: Array, sizes: ComplexArray) -> ComplexArray:
        """Motion at the seen channels if a stiffness turns with the shaft, (n, n_speed, n_seen).

        The sets share a rotor.
        """
        of_effects = self.parts(x)[1]
        make = partial(self._turning_shaft, self.rotor_with(x[0]), x[0, self.costly])
        shaft = recent(self._turning_shafts, tuple(x[0, self.costly]), make, MAX_REDUCTIONS)
        entries = [self.impedances_and_sizes(x, reduction.harmonic)[0] for reduction in shaft.reductions]
        return shaft.motion(entries, self._turning.acting(shaft.rotor, of_effects, sizes, self.forces(of_effects)[0]))

    @cached_property
    def _site_motions(self) -> OrderedDict[tuple[float, ...], ComplexArray]:
        """Motion of the sites of forces that are not linear in the motion, by values of the unknowns."""
        return OrderedDict()

    @cached_property
    def _turning_shafts(self) -> OrderedDict[tuple[float, ...], TurningShaft]:
        return OrderedDict()

    def _turning_shaft(self, rotor: Rotor, changing: Array) -> TurningShaft:
        sites, seen = self.site_laws, self.channels_with(changing)
        return self._turning.shaft(rotor, self.impedances, self.base.speed, seen, self.loads(rotor), sites)

    def _reduced_response(self, reduction: Reduction, x: Array, near: ComplexArray | None = None) -> ComplexArray:
        columns, of_effects = self._motion(reduction, x, near)
        return self.observed(columns[..., 0], of_effects)

    def _reduced_columns(self, reduction: Reduction, x: Array) -> ComplexArray:
        """Response and responses to unit loads."""
        return np.concatenate(
            [self._reduced_response(reduction, x)[..., None], self._reduced_load_response(reduction, x)], axis=-1
        )

    def _reduced_load_response(self, reduction: Reduction, x: Array) -> ComplexArray:
        columns, of_effects = self._motion(reduction, x)
        if self._turning.are_there:
            raise SettingError("effects: expected none that turns together with unit loads, got one; take it out")
        motion = np.moveaxis(columns[..., 1:], -1, 0)  # (n_load, n, n_speed, n_seen)
        at_rest = self.observed(np.zeros(motion.shape[1:], dtype=complex), of_effects)  # runout is read at rest too
        return np.stack([self.observed(each, of_effects) - at_rest for each in motion], axis=-1)

    def _dense(self, x: Array) -> ComplexArray:
        """One set (1, d) without any reduction."""
        own, of_effects = self.parts(x)
        rotor = self.changed_rotor(self.base.rotor_at(own[0]), x[0, self.costly])
        inputs = self.base.inputs(own)

        def bearings(harmonic: float) -> ComplexArray:
            return self.port_impedance(inputs, self.base.speed, of_effects, harmonic)[:, :, 0]

        force = force_per_unbalance(rotor, self.base.speed) @ complex_unbalance(rotor)
        if (loads := self.loads(rotor)) is not None:
            force = force + loads @ np.concatenate(self.sizes(of_effects), axis=1)[0]
        forces = self.forces(of_effects)
        if self._turning.are_there:
            acting = self._turning.acting(rotor, of_effects, np.empty((1, 0), complex), forces[0])
            at_orders = [bearings(order) for order in range(HIGHEST + 1)]
            motion = self._turning_shaft(rotor, x[0, self.costly]).dense_motion(at_orders, acting, force)
        else:
            seen = self.seen_channels, self.channels_with(x[0, self.costly])
            motion = dense_motion(rotor, self.base.speed, seen, bearings, force, forces)
        return self.observed(motion[None] + self._sweep_change(x), of_effects)

    def _sweep_change(self, x: Array) -> ComplexArray:
        """Change of the motion at the seen channels by a sweep of the speed, (n, n_speed, n_seen) m.

        It is for sets (n, d) that share a rotor.
        """
        change = np.zeros((len(x), len(self.base.speed), len(self.seen_channels)), dtype=complex)
        for sweep in self.sweeps(self.parts(x)[1]):
            moving = np.flatnonzero(sweep.acceleration)
            if len(moving):
                swept = Sweep(sweep.acceleration[moving], sweep.highest)
                change[moving] = sweep_change(self._poles(x[moving], swept), self.base.speed, swept)
        return change

    def _poles(self, x: Array, sweep: Sweep) -> Poles:
        """Poles of the motion at the seen channels, for sets (n, d) with the same rotor."""
        own, of_effects = self.parts(x)
        inputs = self.base.inputs(own)
        rotor, nodes = self.rotor_with(x[0]), sweep.nodes
        force = nodes[:, None, None] ** 2 * (inputs.complex_unbalance @ unit_force(rotor).T)  # (3, n, n_dof)
        for effect, values in zip(self.effects, of_effects):
            if effect.has_loads:
                force = force + np.moveaxis(effect.loads(rotor, nodes) @ effect.load_sizes(values).T, 1, 2)
        on_ground = [(index, inputs.pedestal_impedance(index, nodes)) for index, _ in inputs.pedestals_of(0)]
        felt, _ = condensed(self.port_impedance(inputs, nodes, of_effects), on_ground)
        impedance = [felt.transpose(3, 2, 0, 1)]
        positions = []
        for site, coefficients in self.forces(of_effects)[0]:
            at_rest = np.stack([site.at_rest(each[None], nodes) for each in coefficients], axis=1)
            force = force + at_rest @ site.rows(rotor)
            if site.law.follows_motion:
                positions.append(site.position)
                impedance.append(np.stack([site.stiffness(each[None], nodes) for each in coefficients], axis=1))
        seen = self.channels_with(x[0, self.costly])
        nominal = spectrum(rotor, searched_speed(nodes, nodes), seen, tuple(positions))
        return poles_on(nominal, parabola(block_diagonal(impedance), nodes), parabola(force, nodes), sweep.reach)


def _with_unbalance_of_effects(rotor: Rotor, problem: RotorWithEffects, of_effects: Sequence[Array]) -> Rotor:
    """The rotor with what of its effects is unbalance too."""
    added = [
        UnbalancePlane(position, abs(size), float(np.angle(size)))
        for effect, values in zip(problem.effects, of_effects)
        for position, size in effect.unbalance(values[0]).items()
    ]
    return dataclasses.replace(rotor, unbalance=(*rotor.unbalance, *added))


def _mark(effect: RotorHooks, problem: RotorProblem) -> EffectMark:
    places = effect.places(problem) if isinstance(effect, Effect) else ()
    return EffectMark(snake_case(type(effect).__name__).replace("_", " "), str(effect), tuple(places))


def _left_out(problem: RotorWithEffects, laws: Sequence[str]) -> tuple[str, ...]:
    """Remarks on effects that a linear eigenproblem at a constant speed cannot include."""
    turning = [_mark(effect, problem.base).name for effect in problem.effects if effect.turns]
    remarks = [f"Free motions leave out {each}, whose stiffness turns with the shaft." for each in turning]
    return (*remarks, *(f"Free motions leave out the {law} force, which is not linear in the motion." for law in laws))

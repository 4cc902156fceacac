"""Rotor with unknown bearing coefficients and unbalance as a problem.

It may have effects.

The unknowns of effects follow the unknowns of the rotor itself. Its motion is computed by its `physics`: without effects in
`problems.rotor.response.physics`, else by the physics that the effects name (`problems.rotor.extension.extended`).

Sign convention: a real response is Re(q e^{iΩt}), m 0-peak; the shaft turns from +x to +y.
"""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.measurement.campaign import Run
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from ksmea.problem.parameters import PHASE_ORIGIN, Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.problem.response_structure import UnknownImpedance
from ksmea.rotordynamics.stability import scanned_speeds
from ksmea.rotordynamics.whirl import Campbell, Mode, Rotordynamic
from ksmea.units import GRAM_MILLIMETRE
from problems.rotor.finite_elements.data import UnbalancePlane
from problems.rotor.free_motion.critical_speeds import critical_speeds
from problems.rotor.free_motion.free_motion import N_MODE, FreeMotion
from problems.rotor.free_motion.modes import campbell_diagram, natural_modes
from problems.rotor.free_motion.stability import MIN_MODES, searched_speed
from problems.rotor.response.model import RotorModel, checked_sets
from problems.rotor.response.physics import Physics, PlainPhysics
from problems.rotor.response.unknowns import CARTESIAN_PARTS, OriginTarget, UnbalanceTarget, Unknown, unknown_impedances


class EffectOnRotor(Protocol):
    """Effect as a rotor uses it; its hooks are called by the physics that it names."""

    def physics(self, plain: Any, effects: tuple[Any, ...], near: ComplexArray | None) -> Physics:
        """The physics of a rotor without effects, its effects, and a motion as of `Problem.next_to`."""

    def going(self, run: Run) -> Self: ...

    def holding_inputs(self, theta: Array) -> Self: ...


class KnownToTolerance(Protocol):
    """Numbers of a rotor that have a prior (`problems/rotor/inputs/uncertain.py`)."""

    def joint(self, problem: Any) -> Any:
        """The problem with these as unknowns."""


@dataclass(frozen=True, eq=False)
class RotorProblem(RotorModel, Problem, Rotordynamic):
    """The unbalance response of a rotor at given speeds and channels as a function of its unknowns.

    If a nonlinear effect has several steady motions, it has the one that a slow run leads to, or the one next to `near`
    (n_speed, n_order, n_unit), m, the motion of the sites of its forces.
    """

    effects: tuple[EffectOnRotor, ...] = ()
    near: ComplexArray | None = None
    uncertain: KnownToTolerance | None = None
    is_as_drawn: bool = (
        False  # its numbers are those of a drawing, which a machine may differ from; a published rotor's are exact
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        len(self.parameters)  # each unknown has a name of its own, or this raises

    @property
    def plain(self) -> RotorProblem:
        """The rotor without its effects."""
        return self._plain if self.effects else self

    @cached_property
    def _plain(self) -> RotorProblem:
        return dataclasses.replace(self, effects=(), near=None)

    def with_effects(self, effects: Sequence[EffectOnRotor], near: ComplexArray | None = None) -> RotorProblem:
        """This rotor with these effects alone; it shares what has been computed of the rotor itself."""
        made = copy.copy(self.plain)
        vars(made).update(effects=tuple(effects), near=near, _plain=self.plain)
        vars(made).pop("joint", None)  # that of the plain rotor
        len(made.parameters)
        return made

    @cached_property
    def joint(self) -> RotorProblem:
        """This problem with the numbers that are known to a tolerance as unknowns; itself if no number is."""
        if self.uncertain is None:
            return self
        made: RotorProblem = self.uncertain.joint(self)
        return made

    @property
    def as_stated(self) -> RotorProblem:
        return self if self.uncertain is None else self._changed(uncertain=None)

    def holding_inputs(self, x: Array) -> RotorProblem:
        own, of_effects = self.physics.parts(self._point(x)[None])
        plain, is_input = self.plain, [item.parameter.is_input for item in self.plain.unknowns]
        inputs, others = (
            tuple(item for item, each in zip(plain.unknowns, is_input) if each == wanted) for wanted in (True, False)
        )
        if inputs:
            rotor = dataclasses.replace(plain, unknowns=inputs, uncertain=None).rotor_at(own[0, is_input])
            plain = dataclasses.replace(plain, rotor=rotor, unknowns=others, uncertain=None)
        effects = [effect.holding_inputs(theta[0]) for effect, theta in zip(self.effects, of_effects, strict=True)]
        return plain.with_effects(effects, self.near)

    def _changed(self, **changes: Any) -> RotorProblem:
        plain = dataclasses.replace(self.plain, **changes)
        return plain.with_effects(self.effects) if self.effects else plain

    @property
    def physics(self) -> Physics:
        return self._physics_of_effects if self.effects else self._plain_physics

    @cached_property
    def _plain_physics(self) -> PlainPhysics:
        return PlainPhysics(self)

    @cached_property
    def _physics_of_effects(self) -> Physics:
        return self.effects[0].physics(self.plain, self.effects, self.near)

    @property
    def parameters(self) -> Parameters:
        return self._physics_of_effects.parameters if self.effects else self.own

    @property
    def costly(self) -> Indices:
        return self.physics.costly

    def _checked(self, x: Array) -> Array:
        return checked_sets(x, self.parameters)

    def _point(self, x: Array) -> Array:
        return self._checked(np.asarray(x)[None])[0]

    def response(self, x: Array) -> ComplexArray:
        return self.physics.response(self._checked(x))

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        return self.physics.linearises_cheaply(loads)

    def sensitivity(self, x: Array) -> ComplexArray:
        return self.physics.sensitivity(self._point(x))

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        return self.physics.linearised(self._point(x))

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        found = self.physics.linearised_per_load(self._point(x), tuple(loads))
        return super().linearised_per_load(x, loads) if found is None else found

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self.response_and_per_load(x, loads)[1]

    def response_and_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        return self.physics.with_loads(self._checked(x), tuple(loads))

    def dense_response(self, x: Array) -> ComplexArray:
        return self.physics.dense_response(self._checked(x))

    def growth_rate(self, x: Array, speed: Array) -> Array:
        speed = np.asarray(speed, dtype=float)
        highest = searched_speed(self.speed, speed)
        return self.physics.free_motion(self._point(x), highest, MIN_MODES).growth_rate(speed)

    def is_stable(self, x: Array) -> bool:
        """Whether the rotor is stable at x (d,) up to its highest speed.

        False for masses that are not positive definite, which no rotor has.
        """
        try:
            return self._is_passive(x, float(np.max(self.speed))) or super().is_stable(x)
        except np.linalg.LinAlgError:
            return False

    def stability_threshold(self, x: Array, highest: float) -> float:
        return np.inf if self._is_passive(x, highest) else super().stability_threshold(x, highest)

    def _is_passive(self, x: Array, highest: float) -> bool:
        """Whether nothing can feed a free motion, as far as that is known without eigenvalues.

        Free rotors have zeros among them, which rounding makes positive.
        """
        speed = scanned_speeds(highest)
        return self.physics.free_motion(self._point(x), float(speed[-1]), MIN_MODES).is_passive(speed)

    def free_rotor(self, x: Array, highest: float) -> FreeMotion:
        return self.physics.free_motion(self._point(x), highest, N_MODE)

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        highest = float(np.max(self.speed)) if highest is None else highest
        if self.effects:
            return self.free_rotor(x, highest).critical_speeds(highest)
        return critical_speeds(self.rotor_at(self._point(x)), highest)

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        if self.effects:
            return self.free_rotor(x, max(speed, float(np.max(self.speed)))).natural_modes(speed, n_mode)
        return natural_modes(self.rotor_at(self._point(x)), speed, n_mode)

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        speed = np.asarray(speed, dtype=float)
        if self.effects:
            return self.free_rotor(x, max(float(np.max(speed)), float(np.max(self.speed)))).campbell(speed, n_mode)
        return campbell_diagram(self.rotor_at(self._point(x)), speed, n_mode)

    def unbalance(self, x: Array) -> Mapping[float, complex]:
        return self.physics.unbalance(self._point(x))

    @property
    def unknown_impedances(self) -> tuple[UnknownImpedance, ...]:
        return unknown_impedances(self.unknowns) if len(self.parameters) == len(self.own) else ()

    def at(self, speed: Array, channels: Sequence[Channel]) -> RotorProblem:
        return self._changed(speed=speed, channels=tuple(channels))

    def going(self, run: Run) -> RotorProblem:
        effects = [effect.going(run) for effect in self.effects]
        return self.with_effects(effects, self.near) if self.effects else self

    def next_to(self, motion: ComplexArray) -> RotorProblem:
        return self.with_effects(self.effects, motion[:, None]) if self.effects else self

    @property
    def missing(self) -> tuple[str, ...]:
        parts = {"bearings": self.rotor.bearings, "unbalance": self.rotor.unbalance, "unknowns": self.unknowns}
        return tuple(name for name, own in parts.items() if not own)

    def remarks_at(self, speed: Array) -> tuple[str, ...]:
        return self.rotor.tables_beyond(np.asarray(speed))

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
        added = UnbalancePlane(position, magnitude, phase)
        rotor = dataclasses.replace(self.rotor, unbalance=(*self.rotor.unbalance, added))
        return self._changed(rotor=rotor)

    def with_unknown_unbalance(self, position: float, names: tuple[str, str], at_most: float) -> RotorProblem:
        plane = len(self.rotor.unbalance)
        rotor = dataclasses.replace(self.rotor, unbalance=(*self.rotor.unbalance, UnbalancePlane(position)))
        added = (
            Unknown(Parameter(name, "g mm", GRAM_MILLIMETRE, -at_most, at_most), (UnbalanceTarget(plane, part),))
            for name, part in zip(names, CARTESIAN_PARTS, strict=True)
        )
        return self._changed(rotor=rotor, unknowns=(*self.unknowns, *added))

    @property
    def has_free_phase(self) -> bool:
        """Whether the phases of all unbalance are unknown."""
        targets = {target for item in self.unknowns for target in item.targets}
        turning = {target.plane for target in targets if isinstance(target, UnbalanceTarget) and target.turns}
        return OriginTarget() in targets or len(turning) == len(self.rotor.unbalance)

    def with_phase_origin(self) -> RotorProblem:
        """This problem with the phase of all unbalance unknown.

        Limits are one and a half turns apart: each angle lies a quarter turn or more from the limits at least once, so
        that no search ends at a limit without physical meaning.
        """
        if self.has_free_phase:
            return self
        origin = Parameter(PHASE_ORIGIN, "deg", np.pi / 180, -1.5 * np.pi, 1.5 * np.pi)
        return self._changed(unknowns=(*self.unknowns, Unknown(origin, (OriginTarget(),))))

"""Free motions of a rotor with effects: what is linear in the motion and does not turn with the shaft takes part."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.plugins.effect import Effect
from ksmea.plugins.files import snake_case
from ksmea.rotordynamics.layout import EffectMark
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.extension.site_law import attached
from problems.rotor.extension.with_effects import RotorWithEffects
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.free_motion.free_motion import N_MODE, FreeMotion
from problems.rotor.free_motion.stability import LowModes, low_modes
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import inputs_at, rotor_at


def free_motion_with_effects(problem: RotorWithEffects, x: Array, highest: float) -> FreeMotion:
    """The free motions at values x (d,) SI of all unknowns, true up to a frequency and spin speed (rad/s)."""
    base, x = problem.base, np.asarray(x)
    own, of_effects = problem.parts(x[None])
    coefficients = inputs_at(base.rotor, base.unknowns, own).coefficients
    rotor = problem.changed_rotor(rotor_at(base.rotor, base.unknowns, own[0]), x[problem.costly])
    linear, nonlinear = problem.forces(of_effects)
    forces = [force for force in linear if force[0].law.follows_motion]
    low = low_modes(problem.rotor_with(x), highest, tuple(site.position for site, _ in forces), N_MODE)

    def low_at(speed: Array) -> LowModes:
        with_forces = low
        for index, force in enumerate(forces):
            with_forces = with_forces.with_attached(index, *attached(force, speed))
        return with_forces

    def bearings_at(speed: Array) -> tuple[Array, Array]:
        impedance = np.moveaxis(problem.bearing_impedance(coefficients, speed, of_effects)[:, :, :, 0], -1, 0)
        return impedance.real, impedance.imag / speed[:, None, None, None]

    return FreeMotion(
        _with_unbalance_of_effects(rotor, problem, of_effects),
        base.channels,
        low_at,
        bearings_at,
        tuple(problem.supports(of_effects)),
        tuple(_mark(effect, base) for effect in problem.effects),
        _left_out(problem, [site.law.name for site, _ in nonlinear]),
    )


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
    """What no linear eigenproblem at a constant speed has."""
    turning = [_mark(effect, problem.base).name for effect in problem.effects if effect.turns]
    remarks = [f"Free motions leave out {each}, whose stiffness turns with the shaft." for each in turning]
    return (*remarks, *(f"Free motions leave out the {law} force, which is not linear in the motion." for law in laws))

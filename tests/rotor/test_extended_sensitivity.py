"""Sensitivities of extended rotors against differences of their whole response, which share no derivative with them."""

import itertools

import numpy as np
import pytest

from ksmea.nonlinear.laws import LAWS, MOMENT_LAWS, NonlinearLaw
from ksmea.numerics.differences import central_differences
from ksmea.plugins import registry
from problems.three_disk import ThreeDisk

PLAIN = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=14).build()
LINEAR = [key for key, law in LAWS.items() if not isinstance(law, NonlinearLaw)]
FORCES = [*itertools.product(LINEAR, (0.77,)), *itertools.product(MOMENT_LAWS, (0.5,))]
JUMPING = (
    "bilinear_stiffness",
    "clearance_rub",
)  # its motion jumps where curves fold over, all over its limits: there is no slope
NAMES = [name for name in registry.registered("effect") if name not in ("local_force", "run_up_acceleration", *JUMPING)]
PAIRS = [
    ("mass", "residual_bow"),
    ("youngs_modulus", "flexible_pedestal"),
    ("internal_damping", "probe_rotation"),
    ("mass", "disk_mass"),
    ("standing_damping", "youngs_modulus"),
    ("disk_mass", "hub_stiffening"),
]


def effect(name, **settings):
    return registry.create("effect", name, settings)


def with_effects(*effects):
    problem = PLAIN
    for each in effects:
        problem = each.added_to(problem)
    return problem


def located(name):
    return effect(name).locations(PLAIN)[0]


PROBLEMS = {
    **{name: with_effects(located(name)) for name in NAMES},
    **{f"{law} at {at}": with_effects(effect("local_force", law=law, position=at)) for law, at in FORCES},
    **{" and ".join(pair): with_effects(*map(located, pair)) for pair in PAIRS},
    "mass and spring": with_effects(located("mass"), effect("local_force", law="spring", position=0.77)),
}


def step_of(problem):
    """In parts of each unknown's range; longer where the rotor is reduced anew at each point, which costs digits."""
    return 3e-5 if len(problem.costly) else 5e-6


def fourth_order(problem, x):
    """Differences of the whole response of fourth order, extrapolated from two steps."""
    parameters, step = problem.parameters, step_of(problem)

    def slope(part):
        differences = central_differences(x, part * parameters.width, parameters.lower, parameters.upper)
        return differences.derivative(problem.response(differences.points))

    return (4 * slope(step) - slope(2 * step)) / 3


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS)
def test_it_is_the_slope_of_the_response(problem):
    # Differences have errors of rounding / step, 1e-12 / 5e-6 or 1e-11 / 3e-5 of the response, and next to a resonance that is 1e-3
    # of an unknown's range wide those of laws have (1e-6 / 1e-3)². Some unknowns, as the inertia of a small disk, hardly move it.
    rng = np.random.default_rng(0)
    for u in rng.uniform(0.2, 0.8, (3, len(problem.parameters))):
        x = problem.parameters.to_si(u)
        response, found = problem.linearised(x)
        expected = fourth_order(problem, x)
        [alone] = problem.response(x[None])
        rounding = 1e-11 * np.abs(alone).max() / (step_of(problem) * problem.parameters.width)
        error = np.abs(found - expected).max(axis=(0, 1)) / (np.abs(expected).max(axis=(0, 1)) + rounding / 2e-6)
        assert error.max() < 2e-6, problem.parameters.names[int(np.argmax(error))]
        assert np.abs(response - alone).max() < 1e-9 * np.abs(alone).max()  # by another elimination


def test_at_a_limit_it_is_the_slope_into_the_box():
    problem = PROBLEMS["flexible_pedestal"]
    x = np.concatenate([PLAIN.parameters.to_si(np.full(len(PLAIN.parameters), 0.4)), np.zeros(4)])
    parameters = problem.parameters
    ahead = central_differences(x, 1e-6 * parameters.width, parameters.lower, parameters.upper)
    change = np.abs(problem.sensitivity(x) - ahead.derivative(problem.response(ahead.points))) * parameters.width
    # Both are of first order there, over the same step, 1e-6 of a softest pedestal that is ten times as soft as a bearing of 46 MN/m;
    # without a compliance the mass does nothing.
    assert change.max() < 1e-3 * np.abs(problem.sensitivity(x) * parameters.width).max()

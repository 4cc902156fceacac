"""Passive rotors: what is called so has no growing motion by its eigenvalues, and what can grow is never called so."""

import dataclasses

import numpy as np
import pytest

from ksmea.plugins import registry
from ksmea.problem.problem import Problem
from problems.rotor.finite_elements.bearing import Support
from problems.rotor.free_motion.stability import is_passive
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.9], n_speed=9)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])
NOTHING = np.zeros((2, 2))


@pytest.mark.parametrize(
    "name", sorted(set(registry.registered("effect")) - {"local_force"})
)  # has a place if it is given one
def test_no_eigenvalue_contradicts_it(name):
    """By all eigenvalues, at sizes from a hundredth of the limits to all of them."""
    rng = np.random.default_rng(1)
    problem = registry.create("effect", name, {}).locations(PLAIN)[0].added_to(PLAIN)
    limits = problem.parameters.items[len(REFERENCE) :]
    for part in (0.01, 0.1, 1.0):
        sizes = [rng.uniform(each.lower, each.upper) * part for each in limits]
        x = np.concatenate([REFERENCE * rng.uniform(0.7, 1.3, len(REFERENCE)), sizes])
        assert problem.is_stable(x) == Problem.is_stable(problem, x)


@pytest.mark.parametrize("name", ["runout", "mass", "flexible_pedestal", "speed_dependent_stiffness", "youngs_modulus"])
def test_effects_that_feed_nothing_take_no_eigenvalues(name, monkeypatch):
    problem = registry.create("effect", name, {}).locations(PLAIN)[0].added_to(PLAIN)
    monkeypatch.setattr(type(problem), "growth_rate", lambda *_: pytest.fail("eigenvalues were asked for"))
    limits = problem.parameters.items[len(REFERENCE) :]
    assert problem.is_stable(np.concatenate([REFERENCE, [each.upper / 2 for each in limits]]))


@pytest.mark.parametrize("change", [{"internal_damping": 1e-7}, {"axial_force": -1.0}])
def test_a_shaft_that_may_feed_a_motion_is_not_passive(change):
    assert is_passive(PLAIN.rotor, [np.eye(2)], [np.eye(2)], [NOTHING])
    assert not is_passive(dataclasses.replace(PLAIN.rotor, **change), [np.eye(2)], [np.eye(2)], [NOTHING])


@pytest.mark.parametrize(
    ("spring", "damper"),
    [
        ([[1.0, 0.1], [-0.1, 1.0]], NOTHING),  # circulatory
        ([[1.0, 2.0], [2.0, 1.0]], NOTHING),  # eigenvalues 3 and −1
        ([[1.0, 0.0], [0.0, -1e-9]], NOTHING),
        (NOTHING, [[1.0, 2.0], [2.0, 1.0]]),
    ],
)
def test_springs_and_dampers_that_feed_a_motion_are_not_passive(spring, damper):
    assert not is_passive(PLAIN.rotor, [np.array(spring)], [np.array(damper)], [NOTHING])


def test_damping_beside_the_diagonal_that_does_no_work_is_passive():
    """c_xy = −c_yx is gyroscopic."""
    assert is_passive(PLAIN.rotor, [np.eye(2)], [np.array([[0.0, 3.0], [-3.0, 0.0]])], [NOTHING])


def test_a_support_with_a_negative_compliance_is_not_passive():
    support = Support(np.full((2, 1), 1e-9), np.zeros(1), 0.02)
    assert is_passive(PLAIN.rotor, [np.eye(2)], [NOTHING], [NOTHING], [support])
    assert not is_passive(
        PLAIN.rotor, [np.eye(2)], [NOTHING], [NOTHING], [dataclasses.replace(support, spring=-support.spring)]
    )

"""Rotors that differ at few degrees of freedom, by their receptances there, against solutions of the whole shaft."""

import dataclasses

import numpy as np
import pytest

from ksmea.plugins import registry
from problems.rotor.extension.extended_sensitivity import linearised
from problems.rotor.extension.local_change import MOST_DOF, LocalChanges
from problems.rotor.extension.matrix_slope import MatrixSlope
from problems.rotor.finite_elements.assembly import assemble_differing, assemble_free
from problems.rotor.finite_elements.data import Hub
from problems.rotor.response.dense import dynamic_stiffness
from problems.rotor.response.model import impedances_of
from problems.rotor.response.receptance import reduce_rotor
from problems.three_disk import ThreeDisk

PLAIN = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=14).build()
LOSSY = dataclasses.replace(
    PLAIN,
    rotor=dataclasses.replace(
        PLAIN.rotor, segments=tuple(dataclasses.replace(each, loss_factor=0.01) for each in PLAIN.rotor.segments)
    ),
)
LOCAL = ("disk_mass", "disk_inertia", "disk_position", "hub_stiffening", "disk_mass and hub_stiffening")
ELSEWHERE = ("mass", "youngs_modulus", "bearing_position", "probe_position", "disk_mass and residual_bow")
IS_LINEAR = [
    name for name in registry.registered("effect") if getattr(registry.plugin_class("effect", name), "is_linear", False)
]
PARTS = ("mass", "damping", "gyroscopic", "stiffness", "circulatory")


def extended(names, problem=PLAIN):
    """A rotor, else the three-disk rotor, with effects at a point (d,) SI at which none of them is zero."""
    for name in names.split(" and "):
        problem = registry.create("effect", name, {}).locations(problem)[0].added_to(problem)
    return problem, problem.parameters.to_si(np.random.default_rng(0).uniform(0.6, 0.9, len(problem.parameters)))


def changes_of(problem, x):
    return problem.physics.at_changes(tuple(x[problem.costly]), ())


@pytest.mark.parametrize("plain", [PLAIN, LOSSY], ids=["elastic", "hysteretic"])
@pytest.mark.parametrize("names", LOCAL)
def test_receptances_at_the_change_give_what_the_whole_shaft_gives(names, plain, monkeypatch):
    problem, x = extended(names, plain)
    changes, _ = changes_of(problem, x)
    assert 0 < len(changes.dof) <= MOST_DOF
    response, slope = linearised(problem.physics, x)
    expected = problem.dense_response(x[None])[0]
    monkeypatch.setattr(type(problem.physics), "at_changes", lambda self, changing, loads: None)
    whole_response, whole_slope = linearised(problem.physics, x)
    scale = np.abs(whole_slope).max(axis=(0, 1))
    # Rounding times the condition of a rotor near its resonances, as of all routes
    assert np.abs(response[..., 0] - expected).max() < 1e-9 * np.abs(expected).max()
    assert np.abs(response - whole_response).max() < 1e-9 * np.abs(expected).max()
    assert np.all(np.abs(slope - whole_slope).max(axis=(0, 1)) < 1e-7 * scale)


@pytest.mark.parametrize("names", ELSEWHERE)
def test_what_changes_more_than_a_few_places_is_solved_whole(names):
    problem, x = extended(names)
    assert changes_of(problem, x) is None


@pytest.mark.parametrize(("position", "is_local"), [(0.1, True), (0.15, False)])
def test_a_probe_inside_a_thicker_element_is_read_by_the_whole_shaft(position, is_local):
    """Shear, and so the shape functions inside an element, depend on its radius; at a node nothing does."""
    first, *others = PLAIN.rotor.segments
    thin = dataclasses.replace(PLAIN.rotor, segments=(dataclasses.replace(first, n_element=2), *others))
    first = dataclasses.replace(thin.segments[0], outer_radius=1.1 * first.outer_radius)
    thick = dataclasses.replace(thin, segments=(first, *others))
    channels = [dataclasses.replace(PLAIN.channels[0], position=position)]
    impedances = impedances_of(PLAIN.rotor, PLAIN.unknowns)

    def seen(forces, rows):
        return reduce_rotor(thin, impedances, PLAIN.speed, channels, forces, rows=rows)

    found = LocalChanges.between(thin, [thick], seen, channels, (), len(PLAIN.speed))
    assert (found is not None) == is_local


@pytest.mark.parametrize("name", IS_LINEAR)
def test_matrices_are_linear_in_effects_that_say_so(name):
    """Differences between any two values are alike: rounding of 1e-16 of the matrices over a step of a tenth of the range."""
    problem, _ = extended(name)
    lower, upper = (limits[problem.costly] for limits in (problem.parameters.lower, problem.parameters.upper))
    at = [problem.physics.changed_rotor(PLAIN.rotor, lower + part * (upper - lower)) for part in (0.2, 0.3, 0.9)]
    first, second = (MatrixSlope.between(*pair, step) for pair, step in ((at[:2], 0.1), (at[1:], 0.6)))
    assert list(first.matrices) == list(second.matrices)
    assert first.matrices
    for part in first.matrices:
        whole = np.abs(getattr(assemble_free(at[0]), part)).max()
        assert np.abs(first.matrices[part] - second.matrices[part]).max() < 1e-13 * whole
    assert np.all(problem.physics.linear[problem.costly])


def test_effects_that_multiply_what_others_change_are_not_linear_together():
    problem, _ = extended("mass and disk_mass")
    assert not np.any(problem.physics.linear)


def test_hysteretic_damping_that_one_rotor_lacks_is_part_of_their_difference():
    found = MatrixSlope.between(PLAIN.rotor, LOSSY.rotor, 1.0)
    elastic, lossy = (dynamic_stiffness(assemble_free(each.rotor), PLAIN.speed) for each in (PLAIN, LOSSY))
    own = np.ix_(range(len(PLAIN.speed)), found.dof, found.dof)
    assert np.any(lossy != elastic)
    # Rounding of a difference: 1e-16 of the largest entries
    tolerance = 1e-14 * np.abs(lossy).max()
    assert found.dynamic_stiffness(PLAIN.speed) == pytest.approx((lossy - elastic)[own], abs=tolerance)


@pytest.mark.parametrize("hubs", [((0.2, 0.02, 0.5),), ((0.2, 0.02, 0.5), (0.2, 0.02, 0.5)), ((0.5, 0.4, 1.0),)])
def test_hubs_change_the_matrices_of_the_segments_that_they_reach_alone(hubs):
    one = dataclasses.replace(PLAIN.rotor, hubs=(Hub(0.2, 0.02, 0.5),))
    other = dataclasses.replace(one, hubs=(*one.hubs, *(Hub(*each) for each in hubs)))
    dof, before, after = assemble_differing(one, other)
    whole_before, whole_after = assemble_free(one), assemble_free(other)
    for part in PARTS:
        expected = getattr(whole_after, part) - getattr(whole_before, part)
        found = np.zeros_like(expected)
        found[np.ix_(dof, dof)] = getattr(after, part) - getattr(before, part)
        assert found == pytest.approx(expected, abs=1e-12 * np.abs(getattr(whole_after, part)).max())
    assert np.any(before.stiffness != after.stiffness)

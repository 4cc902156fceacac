"""Responses to unit loads: the reduction against the dense route, with and without effects, and what is refused."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.numerics.differences import CUBE_STEP, differenced
from ksmea.plugins import registry
from ksmea.problem.load import Load
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.response import dense
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.77], n_speed=20).build()
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
LOADS = [Load(0.0, "x"), Load(0.33, "y"), Load(0.5, "x", "moment"), Load(1.0, "y", "moment")]


def test_the_reduced_response_to_loads_is_the_dense_one():
    x = np.stack([TRUTH, PROBLEM.parameters.upper])
    for row, found in zip(x, PROBLEM.load_response(x, LOADS)):
        rotor = rotor_at(PROBLEM.rotor, PROBLEM.unknowns, row)
        stiffness = dense.dynamic_stiffness(assemble(rotor), PROBLEM.speed)
        motion = np.linalg.solve(stiffness, unit_loads(rotor, LOADS, len(PROBLEM.speed)))
        expected = dense.channel_rows(rotor, PROBLEM.channels) @ motion
        # rounding of 1e-16 grows by the ratio of stiffnesses of elements and modes, 1e4, and by that of sharp peaks
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("loads", [[], LOADS])
def test_responses_to_loads_are_linearised_exactly(loads):
    """By one solution, as central differences of the responses have it."""
    problem = PROBLEM.with_phase_origin()
    x = np.append(TRUTH, 0.4)
    found = problem.linearised_per_load(x, loads)
    width = problem.parameters.width

    def columns(points):
        per_load = problem.load_response(points, loads) if loads else np.empty((len(points), 20, 4, 0))
        return np.concatenate([problem.response(points)[..., None], per_load], axis=-1)

    expected = differenced(columns, x, CUBE_STEP * width, problem.parameters.lower, problem.parameters.upper)
    # differences of 1e-5 of a box in which resonances are as narrow as 1e-2: about 1e-6 of a column's peak; and rounding, of 1e-16
    # times the ratio of stiffnesses, 1e4, of the response itself, which is all that is left where a column vanishes
    peak = np.abs(expected[0]).max(axis=(0, 1))  # (1 + n_load,)
    for one, other, rounding in zip(found, expected, (1e-12 * peak, 1e-12 / CUBE_STEP * peak[:, None] / width)):
        per_column = np.abs(other).max(axis=(0, 1))
        assert np.all(np.abs(one - other) < 1e-5 * per_column + rounding)
    assert np.abs(found[1] * width).max() > 1e-6


def test_receptances_are_reciprocal_where_nothing_turns():
    """Maxwell: as far as x at 0.1 m moves by a force in x at 0.77 m, x at 0.77 m moves by one at 0.1 m. The gyroscopic
    moments do not couple x with itself in a single plane at low speed, where they vanish with Ω²."""
    slow = PROBLEM.at(np.array([1.0]), [Channel(0.1, "x"), Channel(0.77, "x")])
    found = slow.load_response(TRUTH[None], [Load(0.1, "x"), Load(0.77, "x")])[0, 0]
    assert found[0, 1] == pytest.approx(found[1, 0], rel=1e-6)


@pytest.mark.parametrize("around", [[], ["runout"], ["flexible_pedestal", "probe_rotation"], ["mass", "residual_bow"]])
def test_an_unbalance_is_a_force_also_in_an_extended_problem(around):
    """The force Ω² u (1, −i) at a disk does what the effect `unbalance` there does by the dense route, whatever other
    effects there are."""
    problem, values = PROBLEM, []
    rng = np.random.default_rng(4)
    for name in around:
        effect = registry.create("effect", name, {}).locations(PROBLEM)[0]
        values.append(effect.draw(PROBLEM, rng))
        problem = effect.added_to(problem)
    x = np.concatenate([TRUTH, *values])
    unbalanced = registry.create("effect", "unbalance", {"position": 1.0}).added_to(problem)
    with_it, without = (unbalanced.dense_response(np.append(x, u)[None])[0] for u in ([3e-5, 4e-5], [0.0, 0.0]))
    force = (3e-5 + 4e-5j) * problem.speed[:, None] ** 2 * np.array([1, -1j])
    found = problem.load_response(x[None], [Load(1.0, "x"), Load(1.0, "y")])[0] @ force[..., None]
    # what is compared is a difference of responses that are up to 1e4 times as large, with errors of 1e-9 at their peaks
    assert np.abs(found[..., 0] - (with_it - without)).max() < 1e-7 * np.abs(with_it).max()


def test_loads_beyond_the_shaft_are_refused():
    with pytest.raises(SettingError, match="expected a"):
        PROBLEM.load_response(TRUTH[None], [Load(1.4, "x")])


def test_a_moment_within_an_element_is_that_of_a_node_there():
    """An element is exact at its ends where nothing moves: 0.33 m is no node of 13 elements, and one of 130."""
    load, ends = [Load(0.33, "x", "moment")], [Channel(place, "y") for place in (0.1, 0.77, 1.3)]
    coarse, fine = (ThreeDisk(mesh=mesh).build().at(np.array([0.01]), ends) for mesh in (13, 130))
    found, expected = (each.load_response(TRUTH[None], load)[0] for each in (coarse, fine))
    # 0.77 m lies within an element, between whose ends a cubic has no kink: compared at nodes alone
    assert found[0, [0, 2]] == pytest.approx(expected[0, [0, 2]], rel=1e-7)


@pytest.mark.parametrize("wrong", [("z", "force"), ("x", "torque")])
def test_a_load_has_a_direction_and_a_kind(wrong):
    with pytest.raises(SettingError, match="of a load: expected"):
        Load(0.1, *wrong)


def test_a_problem_that_is_no_rotor_says_so():
    class Flat(Problem):
        speed, channels = np.array([1.0]), (Channel(0.0, "x"),)
        parameters = Parameters((Parameter("p", "", 1.0, 0.0, 1.0),))

        def response(self, x):
            return x[:, :, None].astype(complex)

    assert not Flat().takes_loads
    assert PROBLEM.takes_loads
    with pytest.raises(SettingError, match="takes loads on its shaft, got Flat"):
        Flat().load_response(np.array([[0.5]]), LOADS)


def test_landmarks_are_bearings_and_disks_from_the_left():
    assert PROBLEM.landmarks == {"bearing 1": 0.0, "bearing 2": 1.3, "disk 1": 0.2, "disk 2": 0.5, "disk 3": 1.0}


def test_response_and_loads_by_one_solution_are_those_by_two():
    """Exactly but for rounding, of 1e-16 times the ratio of stiffnesses and of sharp peaks."""
    x = np.stack([TRUTH, PROBLEM.parameters.upper])
    response, per_load = PROBLEM.response_and_per_load(x, LOADS)
    np.testing.assert_array_equal(per_load, PROBLEM.load_response(x, LOADS))
    assert np.abs(response - PROBLEM.response(x)).max() < 1e-10 * np.abs(response).max()


def test_a_problem_before_another_makes_both_of_its_own(monkeypatch):
    """An extended rotor does not hand on what the rotor without its effects would answer."""
    bowed = registry.create("effect", "residual_bow", {}).added_to(PROBLEM)
    x = np.append(TRUTH, [2e-5, 1e-5])[None]
    response, per_load = bowed.response_and_per_load(x, LOADS)
    np.testing.assert_array_equal(response, bowed.response(x))
    np.testing.assert_array_equal(per_load, bowed.load_response(x, LOADS))
    assert np.abs(response - PROBLEM.response(x[:, :5])).max() > 1e-3 * np.abs(response).max()


def test_effects_that_leave_the_rotor_as_it_is_share_its_reductions():
    slow, gain = (registry.create("effect", name, {}).locations(PROBLEM)[0] for name in ("runout", "channel_gain"))
    heavy = registry.create("effect", "mass", {}).locations(PROBLEM)[0]
    one, other, third = (effect.added_to(PROBLEM) for effect in (slow, gain, heavy))
    assert one.physics.reduction((), ()) is other.physics.reduction((), ())
    assert third.physics.reduction((0.1,), ()) is not one.physics.reduction((), ())

"""A force that follows a law at a place: closed forms of each law, its eigenvalues, its company, and what is refused."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.nonlinear.laws import LAWS, MOMENT_LAWS, LinearLaw, NonlinearLaw
from ksmea.plugins import registry
from ksmea.problem.load import Load
from problems.rotor.extension.effect import rotor_mass, stiffness_scale
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=16)
PLAIN = SETTINGS.build()
TRUTH = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])
SPEED = np.linspace(50.0, 1500.0, 12)
LINEAR = [key for key, law in LAWS.items() if isinstance(law, LinearLaw)]
NONLINEAR = [key for key, law in LAWS.items() if isinstance(law, NonlinearLaw)]
WEAK = {"MN/m": 2e5, "MN/mm³": 1e14, "µm": 2e-6, "": 0.1}  # by unit, SI: of amplitudes of some µm


def local(law, position=0.2):
    return registry.create("effect", "local_force", {"law": law, "position": position})


def with_law(law, values, position=0.2, problem=PLAIN):
    """A problem with a local force, and its unknowns' values (1, d)."""
    return local(law, position).added_to(problem), np.concatenate([TRUTH, values])[None]


def with_bearing(**changes):
    """The plain problem with other coefficients of its first bearing, beside the unknowns' own."""
    rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, TRUTH)
    first, last = rotor.bearings
    changed = {name: getattr(first, name) + value for name, value in changes.items()}
    rotor = dataclasses.replace(rotor, bearings=(dataclasses.replace(first, **changed), last))
    unbalance = tuple(item for item in PLAIN.unknowns if item.parameter.name == "u")
    return dataclasses.replace(PLAIN, rotor=rotor, unknowns=unbalance), TRUTH[-1:]


AT_BEARING = [
    ("spring", [4e6, -3e6], {"kxx": 4e6, "kyy": -3e6}),
    ("damper", [2e3, 5e3], {"cxx": 2e3, "cyy": 5e3}),
    ("cross_coupling", [1.5e6], {"kxy": 1.5e6, "kyx": -1.5e6}),
    ("spring_and_damper", [4e6, 1e6, 2e3, 3e3], {"kxx": 4e6, "kyy": 1e6, "cxx": 2e3, "cyy": 3e3}),
]


@pytest.mark.parametrize("law, values, changes", AT_BEARING)
def test_at_a_bearing_it_is_another_bearing_in_response_and_in_growth(law, values, changes):
    problem, x = with_law(law, values, position=0.0)
    changed, own = with_bearing(**changes)
    expected = changed.response(own[None])
    assert np.abs(problem.response(x) - expected).max() < 1e-8 * np.abs(expected).max()
    growth, expected = problem.growth_rate(x[0], SPEED), changed.growth_rate(own, SPEED)
    # both are low modes of one rotor, with springs and deflections that differ: 1e-3 is what either leaves out
    assert growth == pytest.approx(expected, rel=1e-3, abs=1e-3)
    assert not np.allclose(growth, PLAIN.growth_rate(TRUTH, SPEED), rtol=0.02)


@pytest.mark.parametrize("mass", [20.0, 0.5])
def test_a_mass_is_a_disk_without_inertia(mass):
    problem, x = with_law("mass", [mass], position=0.2)
    heavier = dataclasses.replace(
        PLAIN, rotor=dataclasses.replace(PLAIN.rotor, disks=(*PLAIN.rotor.disks, Disk(0.2, mass, 0.0, 0.0)))
    )
    expected = heavier.response(TRUTH[None])
    assert np.abs(problem.response(x) - expected).max() < 1e-8 * np.abs(expected).max()
    assert problem.growth_rate(x[0], SPEED) == pytest.approx(heavier.growth_rate(TRUTH, SPEED), rel=1e-3)


def test_it_acts_on_the_motion_of_pedestals_too():
    """A mass at a node as a disk, where the eigenvalues of supports are those of a larger matrix."""
    pedestal = registry.create("effect", "flexible_pedestal", {"loss_factor": 0.02})
    heavier = dataclasses.replace(PLAIN.rotor, disks=(*PLAIN.rotor.disks, Disk(0.2, 15.0, 0.0, 0.0)))
    of_pedestal = [4e-9, 6e-9, 30.0]
    found = local("mass").added_to(pedestal.added_to(PLAIN))
    expected = pedestal.added_to(dataclasses.replace(PLAIN, rotor=heavier))
    x = np.concatenate([TRUTH, of_pedestal])
    assert found.growth_rate(np.append(x, 15.0), SPEED) == pytest.approx(expected.growth_rate(x, SPEED), rel=1e-3)


def test_cross_coupling_makes_the_rotor_unstable_and_unbalance_does_not():
    problem, x = with_law("cross_coupling", [2e6], position=0.0)
    assert problem.is_stable(np.append(TRUTH, 1e5)) and not problem.is_stable(x[0])
    problem, x = with_law("unbalance", [1e-4, -2e-4])
    assert problem.growth_rate(x[0], SPEED) == pytest.approx(PLAIN.growth_rate(TRUTH, SPEED), rel=1e-6)


def test_vectors_that_turn_are_unbalance_over_powers_of_speed():
    disk = registry.create("effect", "unbalance", {"position": 1.0}).added_to(PLAIN)
    one = PLAIN.speed[5]
    values = np.array([3e-5, -4e-5])
    expected = disk.response(np.append(TRUTH, values)[None])[0, 5]
    for law, power in (("unbalance", 0), ("proportional_to_speed", 1), ("constant", 2)):
        problem, x = with_law(law, values * one**power, position=1.0)
        assert problem.response(x)[0, 5] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("other", ["unbalance", "spring", "cross_coupling"])
def test_two_of_them_see_each_other(other):
    """A mass at one place and another law at a second one: by the dense route, in either order."""
    first, second = local("mass", 0.2), local(other, 0.77)
    problem, swapped = second.added_to(first.added_to(PLAIN)), first.added_to(second.added_to(PLAIN))
    of_second = 0.05 * np.array([item.upper for item in second.parameters(PLAIN)])
    response = problem.response(np.concatenate([TRUTH, [9.0], of_second])[None])
    expected = problem.dense_response(np.concatenate([TRUTH, [9.0], of_second])[None])
    assert np.abs(response - expected).max() < 1e-8 * np.abs(expected).max()
    turned = swapped.response(np.concatenate([TRUTH, of_second, [9.0]])[None])
    assert np.abs(response - turned).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("law", LINEAR)
def test_loads_act_on_the_rotor_with_it(law):
    """The force Ω² u (1, −i) as unit loads does what an unbalance there does beside the local force."""
    values = 0.03 * np.array([item.upper for item in local(law).parameters(PLAIN)])
    problem, x = with_law(law, values)
    unbalanced = registry.create("effect", "unbalance", {"position": 1.0}).added_to(problem)
    with_it, without = (unbalanced.dense_response(np.append(x, u)[None])[0] for u in ([3e-5, 4e-5], [0.0, 0.0]))
    force = (3e-5 + 4e-5j) * PLAIN.speed[:, None] ** 2 * np.array([1, -1j])
    found = problem.load_response(x, [Load(1.0, "x"), Load(1.0, "y")])[0] @ force[..., None]
    # differences of responses that are far larger at their peaks, as in tests/rotor/test_loads.py
    assert np.abs(found[..., 0] - (with_it - without)).max() < 1e-7 * np.abs(with_it).max()


@pytest.mark.parametrize("law", NONLINEAR)
def test_what_is_not_linear_in_the_motion_is_solved_for_by_either_route(law):
    """So weak that there is one steady motion at every speed, beside a linear law elsewhere that it must see."""
    effect = local(law)
    values = np.array([WEAK[item.unit] for item in effect.parameters(PLAIN)])
    problem = local("mass", 0.77).added_to(effect.added_to(PLAIN))
    x = np.concatenate([TRUTH, values, [3.0]])[None]
    found, plain = problem.response(x), local("mass", 0.77).added_to(PLAIN).response(np.append(TRUTH, 3.0)[None])
    assert np.abs(found - problem.dense_response(x)).max() < 1e-8 * np.abs(found).max()
    assert np.abs(found - plain).max() > 1e-3 * np.abs(found).max()
    growth = problem.growth_rate(x[0], SPEED)  # small motions do not feel it
    assert growth == pytest.approx(local("mass", 0.77).added_to(PLAIN).growth_rate(np.append(TRUTH, 3.0), SPEED))


@pytest.mark.parametrize("law", NONLINEAR)
def test_what_is_not_linear_has_no_response_to_loads_and_no_second_of_its_kind(law):
    problem = local(law).added_to(PLAIN)
    x = np.concatenate([TRUTH, np.zeros(len(problem.parameters) - len(TRUTH))])[None]
    with pytest.raises(SettingError, match="expected a law that is linear in the motion together with loads"):
        problem.load_response(x, [Load(1.0, "x")])


def test_limits_are_those_of_dimensions():
    [mass] = local("mass").parameters(PLAIN)
    spring, _ = local("spring").parameters(PLAIN)
    unbalance, _ = local("unbalance").parameters(PLAIN)
    assert (mass.upper, mass.unit) == (pytest.approx(rotor_mass(PLAIN)), "kg")
    assert spring.upper == pytest.approx(stiffness_scale(PLAIN)) and spring.lower == -spring.upper
    assert unbalance.upper == pytest.approx(5e-4)  # kg m, as that of the model


def test_limits_stay_where_other_speeds_are_seen():
    for law in (*LAWS, *MOMENT_LAWS):
        problem = local(law).added_to(PLAIN)
        assert problem.at(PLAIN.speed[:3], PLAIN.channels).parameters == problem.parameters


def test_a_mass_that_takes_away_more_than_is_there_is_unstable():
    problem, x = with_law("mass", [-0.9 * rotor_mass(PLAIN)])
    assert not problem.is_stable(x[0])


def test_a_skewed_disk_is_a_moment_that_turns():
    """The moment Ω² τ (1, −i) at a node as unit loads."""
    problem, x = with_law("skew", [2e-4, -1e-4], position=0.5)
    moment = (2e-4 - 1e-4j) * PLAIN.speed[:, None] ** 2 * np.array([1, -1j])
    columns = PLAIN.load_response(TRUTH[None], [Load(0.5, axis, "moment") for axis in "xy"])[0]
    added = problem.response(x)[0] - PLAIN.response(TRUTH[None])[0]
    assert added == pytest.approx((columns @ moment[..., None])[..., 0], rel=1e-6, abs=1e-15)
    between, x = with_law("skew", [2e-4, -1e-4], position=0.77)  # nodes
    columns = PLAIN.load_response(TRUTH[None], [Load(0.77, axis, "moment") for axis in "xy"])[0]
    added = between.response(x)[0] - PLAIN.response(TRUTH[None])[0]
    assert added == pytest.approx((columns @ moment[..., None])[..., 0], rel=1e-6, abs=1e-15)


def test_a_smooth_force_is_what_it_is_at_its_knots_and_refuses_speeds_beyond():
    knots = [float(PLAIN.speed[index]) for index in (0, 6, 15)]
    effect = registry.create("effect", "local_force", {"law": "smooth", "position": 1.0, "knots": knots})
    problem = effect.added_to(PLAIN)
    names = [item.name for item in effect.parameters(PLAIN)]
    assert names[:4] == [f"local_{part}_f_{axis}_at_200_rad_s" for axis in "xy" for part in ("Re", "Im")]
    values = np.arange(12.0) - 5
    x = np.concatenate([TRUTH, values])[None]
    force = values.reshape(3, 2, 2) @ [1, 1j]  # knot, axis
    columns = PLAIN.load_response(TRUTH[None], [Load(1.0, axis) for axis in "xy"])[0]
    added = (problem.response(x)[0] - PLAIN.response(TRUTH[None])[0])[[0, 6, 15]]
    assert added == pytest.approx((columns[[0, 6, 15]] @ force[..., None])[..., 0], rel=1e-6, abs=1e-15)
    beyond = problem.at(np.array([100.0, 300.0]), PLAIN.channels)
    with pytest.raises(SettingError, match="expected speeds from 200 to 1500 rad/s"):
        beyond.response(x)


@pytest.mark.parametrize(
    "settings, said",
    [
        ({"law": "smooth"}, "expected two rising speeds or more"),
        ({"law": "smooth", "knots": [300.0, 200.0]}, "expected two rising speeds or more"),
        ({"law": "mass", "knots": [200.0, 300.0]}, "expected none of law=mass"),
    ],
)
def test_knots_are_those_of_a_smooth_force(settings, said):
    with pytest.raises(SettingError, match=said):
        registry.create("effect", "local_force", {"position": 1.0, **settings})


def test_it_has_no_place_by_itself_and_a_diagnosis_does_not_try_it():
    bare = registry.create("effect", "local_force", {})
    assert bare.locations(PLAIN) == []
    with pytest.raises(SettingError, match="position: expected the place of the force, got none"):
        bare.added_to(PLAIN)
    assert local("mass").locations(PLAIN) == [local("mass")] and str(local("mass")) == "mass at 0.2 m"


def test_what_is_no_law_or_no_place_is_refused():
    with pytest.raises(SettingError, match="law"):
        local("sprung")
    with pytest.raises(SettingError, match="expected a position on the shaft"):
        local("mass", 5.0).added_to(PLAIN)

"""Effects that a plain rotor model lacks: nothing at zero, the same by two routes, and closed forms of each."""

import dataclasses
import inspect
import itertools

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.nonlinear.laws import LAWS, MOMENT_LAWS, NonlinearLaw
from ksmea.plugins import registry
from ksmea.problem.parameters import Parameter
from problems.rotor.extension.effect import RotorEffect
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor.response.unknowns import BearingTarget, Unknown
from problems.three_disk import ThreeDisk, three_disk_rotor
from tiers import mostly_slow

EXPECTED = {
    "annular_seal": 2,
    "bearing_mass": 2,
    "bilinear_stiffness": 2,
    "channel_gain": 1,
    "clearance_rub": 3,
    "coupling_misalignment": 2,
    "crack": 2,
    "cross_coupling_antisymmetric": 1,
    "cross_coupling_symmetric": 1,
    "cubic_stiffness": 1,
    "flexible_pedestal": 4,
    "foundation_resonance": 2,
    "internal_damping": 1,
    "local_force": 1,
    "mass": 1,
    "probe_rotation": 1,
    "residual_bow": 2,
    "run_up_acceleration": 1,
    "runout": 2,
    "shaft_asymmetry": 2,
    "short_journal_bearing": 1,
    "skewed_disk": 2,
    "speed_dependent_damping": 1,
    "speed_dependent_stiffness": 1,
    "spring_mass": 3,
    "thermal_bow": 2,
    "timing_delay": 1,
    "unbalance": 2,
    "unequal_bearings": 2,
    "youngs_modulus": 1,
}
SETTINGS = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=14)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])
NAMES = list(registry.registered("effect"))


def effect(name, **settings):
    return registry.create("effect", name, settings)


VECTORS = ("crack", "runout", *(name for name in NAMES if effect(name).has_loads))
NONLINEAR = ("bilinear_stiffness", "clearance_rub", "cubic_stiffness")
LINEAR = [key for key, law in LAWS.items() if not isinstance(law, NonlinearLaw)]


def places(name):  # a local force: at a bearing and between nodes, by each law that is linear; a moment at nodes
    given = [*itertools.product(MOMENT_LAWS, (0.5, 1.3)), *itertools.product(LINEAR, (0.0, 0.77))]
    return effect(name).locations(PLAIN) or [effect(name, position=position, law=law) for law, position in given]


def law(place):
    return getattr(place, "law", "")


PLACED = [(name, place) for name in NAMES for place in places(name)]
FIRST = list({(name, law(place)): (name, place) for name, place in reversed(PLACED)}.values())  # of each effect and law
every_place = pytest.mark.parametrize(
    "name, place", mostly_slow(PLACED, but=FIRST), ids=[f"{name} {place}" for name, place in PLACED]
)


def random_sets(problem, n, seed):
    return problem.parameters.to_si(np.random.default_rng(seed).random((n, len(problem.parameters))))


def drawn(place, seed=0):
    return place.draw(PLAIN, np.random.default_rng(seed))


def with_values(x, theta):
    return np.concatenate([x, np.atleast_1d(theta)])[None]


def difference(found, expected):
    """Largest difference relative to the largest expected value, set by set."""
    return (np.abs(found - expected).max(axis=(1, 2)) / np.abs(expected).max(axis=(1, 2))).max()


def test_all_effects_of_the_catalogue_are_registered_apart_from_the_parts_of_a_run():
    assert set(EXPECTED) <= set(NAMES)
    assert "effect" not in registry.GROUPS
    for name, count in EXPECTED.items():
        assert len(effect(name).parameters(PLAIN)) == count


@pytest.mark.parametrize("name", NAMES)
def test_every_effect_tells_its_physics_and_what_looks_like_it(name):
    one = effect(name)
    assert isinstance(one, RotorEffect) and type(one).__dataclass_params__.frozen
    assert len(inspect.getmodule(type(one)).__doc__) > 200 and type(one).__doc__
    for alias, what in one.aliases.items():
        assert alias in NAMES and alias != name and len(what) > 20
        assert name in effect(alias).aliases, f"{alias} does not name {name} back"


@pytest.mark.parametrize("name, nearest", [("runot", "runout"), ("cross_coupling", "cross_coupling_"), ("bow", "")])
def test_a_mistyped_name_gets_the_nearest_one(name, nearest):
    with pytest.raises(SettingError, match=f"unknown effect '{name}'; .*{nearest}.*known: {min(NAMES)}, ") as caught:
        effect(name)
    assert "\n" not in str(caught.value)


def test_a_mistyped_setting_gets_the_nearest_one():
    with pytest.raises(SettingError, match="unknown setting of effect=runout: 'positon'; did you mean 'position'"):
        effect("runout", positon=0.1)


@every_place
def test_bounds_hold_zero_and_what_is_drawn(name, place):
    problem = place.added_to(PLAIN)
    assert problem.parameters.names[: len(REFERENCE)] == PLAIN.parameters.names
    own = problem.parameters.items[len(REFERENCE) :]
    assert all(parameter.unit and parameter.lower <= 0 <= parameter.upper for parameter in own)
    draws = np.array([drawn(place, seed) for seed in range(50)])
    assert draws.shape == (50, len(own)) and np.array_equal(draws[3], drawn(place, 3))
    assert np.all([parameter.lower for parameter in own] <= draws)
    assert np.all(draws <= [parameter.upper for parameter in own])
    assert np.all(np.any(draws != 0, axis=1))


@every_place
def test_at_zero_the_model_is_as_without(name, place):
    problem = place.added_to(PLAIN)
    x = np.concatenate([REFERENCE[None], random_sets(PLAIN, 4, seed=1)])
    zero = np.zeros((len(x), len(problem.parameters) - x.shape[1]))
    # Further right-hand sides may change the order of sums in the solver; needles magnify rounding: 1.1e-11 seen.
    assert difference(problem.response(np.hstack([x, zero])), PLAIN.response(x)) < 1e-10


@every_place
def test_the_reduced_response_is_the_dense_one(name, place):
    problem = place.added_to(PLAIN)
    x = random_sets(problem, 6, seed=2)
    assert difference(problem.response(x), problem.dense_response(x)) < 1e-8


@every_place
def test_batches_do_not_change_the_numbers(name, place):
    problem = place.added_to(PLAIN)
    x = random_sets(problem, 3, seed=3)
    single = np.concatenate([problem.response(row[None]) for row in x])
    assert difference(problem.response(x), single) < 1e-12


@every_place
def test_it_matters_and_its_sensitivity_is_that_of_independent_differences(name, place):
    problem = place.added_to(PLAIN)
    x = with_values(REFERENCE, drawn(place))[0]
    found = problem.sensitivity(x)
    steps, weights = np.arange(-3, 4), np.array([-1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60])
    for index in range(len(REFERENCE), len(x)):
        size = 1e-4 * np.abs(x[index])
        points = np.tile(x, (7, 1))
        points[:, index] += steps * size
        expected = np.tensordot(weights, problem.dense_response(points), (0, 0)) / size
        assert np.abs(expected).max() * problem.parameters.width[index] > 1e-3 * np.abs(problem.response(x[None])).max()
        # where an orbit dips into a contact at one more of its angles the response has a corner
        # and a spring-mass drawn at 1 % of its highest frequency a resonance hardly wider than the step of differences
        has_edges = name == "clearance_rub" or str(place).startswith("spring-mass")
        tolerance = 2e-3 if has_edges else 2e-4
        assert np.abs(found[..., index] - expected).max() < tolerance * np.abs(expected).max()


@every_place
def test_it_is_a_problem_at_other_speeds_and_channels(name, place):
    problem = place.added_to(PLAIN)
    x = with_values(REFERENCE, drawn(place))
    few = problem.at(PLAIN.speed[[2, 7]], PLAIN.channels[1:5:2])
    assert difference(few.response(x), problem.response(x)[:, [2, 7]][..., 1:5:2]) < 1e-9
    assert few.parameters == problem.parameters


@every_place
def test_an_unknown_phase_origin_turns_everything(name, place):
    origin = 0.7
    known, free = place.added_to(PLAIN), place.added_to(PLAIN).with_phase_origin()
    theta = drawn(place)
    turned = theta
    if name in VECTORS or (name == "local_force" and not place.site_law().law.follows_motion):
        vector = (theta[0] + 1j * theta[1]) * np.exp(1j * origin)
        turned = np.array([vector.real, vector.imag])
    if name == "shaft_asymmetry":  # the same again after half a turn
        vector = (theta[0] + 1j * theta[1]) * np.exp(2j * origin)
        turned = np.array([vector.real, vector.imag])
    x = with_values(np.append(REFERENCE, origin), turned)
    assert difference(free.response(x), np.exp(1j * origin) * known.response(with_values(REFERENCE, theta))) < 1e-10


REFUSED = [{*pair} for pair in itertools.product(NONLINEAR, ("crack", "run_up_acceleration", "shaft_asymmetry"))]
REFUSED.append({"spring_mass", "run_up_acceleration"})
PAIRS = [pair for pair in itertools.combinations(NAMES, 2) if {*pair} not in REFUSED]


# every sixth pair, in which each effect occurs
@pytest.mark.parametrize(
    "names",
    [pair if n % 6 == 0 else pytest.param(pair, marks=pytest.mark.slow) for n, pair in enumerate(PAIRS)],
    ids=[" ".join(pair) for pair in PAIRS],
)
def test_pairs_are_problems_and_their_order_is_none(names):
    one, other = (places(name)[-1] for name in names)
    problem, swapped = other.added_to(one.added_to(PLAIN)), one.added_to(other.added_to(PLAIN))
    theta, phi = drawn(one, 1), drawn(other, 2)
    x = with_values(REFERENCE, np.concatenate([theta, phi]))
    response = problem.response(x)
    assert difference(response, problem.dense_response(x)) < 1e-8
    assert difference(swapped.response(with_values(REFERENCE, np.concatenate([phi, theta]))), response) < 1e-9
    assert len(one.locations(problem)) == len(one.locations(PLAIN)) and one.parameters(problem) == one.parameters(PLAIN)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_no_rotor_is_refused(name):
    with pytest.raises(SettingError, match="expected a rotor of this project, got object"):
        effect(name).added_to(object())


@pytest.mark.parametrize("name", ["runout", "channel_gain", "probe_rotation", "unbalance"])
def test_a_place_off_the_shaft_is_refused(name):
    with pytest.raises(SettingError, match="at 5 m: expected a position on the shaft"):
        effect(name, position=5.0).added_to(PLAIN)


def test_places():
    def found(name, problem=PLAIN):
        return [str(place) for place in effect(name).locations(problem)]

    planes = ["at 0.1 m", "at 0.2 m", "at 0.5 m"]
    assert found("runout") == planes == found("probe_position") == found("probe_rotation")
    drawn = dataclasses.replace(PLAIN, is_as_drawn=True)
    assert found("probe_rotation", drawn) == [*planes, *found("channel_gain")]
    assert found("channel_gain", drawn) == [*found("channel_gain"), *(f"x and y {plane}" for plane in planes)]
    assert found("unbalance") == ["at 0.2 m", "at 1 m"]
    assert found("channel_gain")[:3] == ["x at 0.1 m", "y at 0.1 m", "x at 0.2 m"] and len(found("channel_gain")) == 6
    assert found("mass") == ["whole rotor"]
    one = PLAIN.at(PLAIN.speed, [Channel(0.1, "x")])
    assert found("channel_gain", one) == [] == found("probe_rotation", one) == found("probe_position", one)


def test_one_bearing_cannot_be_unequal():
    rotor = dataclasses.replace(PLAIN.rotor, bearings=PLAIN.rotor.bearings[:1])
    unknown = Unknown(Parameter("kxx", "N/m", 1.0, 1e7, 9e7), (BearingTarget(0, "kxx"),))
    lonely = dataclasses.replace(PLAIN, rotor=rotor, unknowns=(unknown,))
    assert effect("unequal_bearings").locations(lonely) == []
    with pytest.raises(SettingError, match="at least two bearings"):
        effect("unequal_bearings").added_to(lonely)


# Closed forms, effect by effect.


def response(place, theta, x=REFERENCE, problem=PLAIN):
    return place.added_to(problem).response(with_values(x, theta))[0]


def test_runout_is_the_same_forward_vector_at_all_speeds_of_one_plane():
    added = response(effect("runout", position=0.2), [3e-6, -4e-6]) - PLAIN.response(REFERENCE[None])[0]
    expected = (3e-6 - 4e-6j) * np.array([0, 0, 1, -1j, 0, 0])
    assert added == pytest.approx(np.tile(expected, (14, 1)), abs=1e-15)


def test_a_bow_is_read_as_it_is_on_stiff_bearings_at_low_speed():
    slow = PLAIN.at(np.array([0.01]), PLAIN.channels)
    stiff = np.array([1e14, 1e14, 1.0, 1.0, 1e-20])
    found = response(effect("residual_bow"), [3e-5, 2e-5], stiff, slow)[0]
    shape = np.repeat(np.sin(np.pi * np.array([0.1, 0.2, 0.5]) / 1.3), 2)
    assert found == pytest.approx((3e-5 + 2e-5j) * shape * np.tile([1, -1j], 3), rel=1e-5)


def test_a_bow_is_amplified_at_a_critical_speed():
    problem = effect("residual_bow").added_to(PLAIN.at(np.linspace(100, 900, 400), PLAIN.channels))
    bowed = problem.response(with_values(np.append(REFERENCE[:4], 1e-20), [1e-5, 0]))[0]
    assert np.abs(bowed).max() > 10 * np.abs(bowed[0]).max()


def test_unbalance_on_the_plane_of_the_model_adds_to_its_own():
    found = response(effect("unbalance", position=0.5), [5e-5, 0])
    more = REFERENCE + np.array([0, 0, 0, 0, 5e-5])
    assert found == pytest.approx(PLAIN.response(more[None])[0], rel=1e-9)


def test_unbalance_is_a_trial_weight_at_its_place():
    found = response(effect("unbalance", position=1.0), [3e-5, 4e-5])
    trial = PLAIN.with_unbalance(1.0, 5e-5, np.arctan2(4, 3))
    assert found == pytest.approx(trial.response(REFERENCE[None])[0], rel=1e-9)


def with_bearing_unknowns(*names):
    """PLAIN with further coefficients of both bearings, or of each by itself ('kxx 0'), as unknowns of the rotor."""

    def unknown(name):
        coefficient, _, bearing = name.partition(" ")
        targets = tuple(BearingTarget(int(index), coefficient) for index in (bearing or "01"))
        return Unknown(Parameter(name, "SI", 1.0, -1e9, 1e9), targets)

    taken = {name.partition(" ")[0] for name in names}
    kept = tuple(item for item in PLAIN.unknowns if item.parameter.name not in taken)
    return dataclasses.replace(PLAIN, unknowns=(*kept, *map(unknown, names)))


@pytest.mark.parametrize("name, sign", [("cross_coupling_symmetric", 1), ("cross_coupling_antisymmetric", -1)])
def test_cross_coupling_is_that_of_the_bearings(name, sign):
    expected = with_bearing_unknowns("kxy", "kyx").response(np.array([[*REFERENCE, 2e6, sign * 2e6]]))[0]
    assert response(effect(name), [2e6]) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(
    "name, factors",
    [("speed_dependent_stiffness", [1.3, 1.3, 1, 1, 1]), ("speed_dependent_damping", [1, 1, 1.3, 1.3, 1])],
)
def test_a_law_over_speed_is_full_at_the_highest_speed_and_stays_where_it_is(name, factors):
    place = effect(name).locations(PLAIN)[0]
    expected = PLAIN.response((REFERENCE * factors)[None])[0]
    assert response(place, [0.3])[-1] == pytest.approx(expected[-1], rel=1e-8)
    part = place.added_to(PLAIN).at(PLAIN.speed[:6], PLAIN.channels)
    assert part.response(with_values(REFERENCE, [0.3]))[0] == pytest.approx(response(place, [0.3])[:6], rel=1e-8)
    assert effect(name).added_to(PLAIN).effects == (place,)


def test_mass_and_modulus_scale_a_rotor_to_itself():
    # All of M, G, K, the bearings and the unbalance larger by one factor: nothing changes.
    problem = effect("mass").added_to(effect("youngs_modulus").added_to(PLAIN))
    expected = PLAIN.response(REFERENCE[None])[0]
    assert problem.response(with_values(1.1 * REFERENCE, [0.1, 0.1]))[0] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("name, scaled", [("mass", ("mass", "gyroscopic")), ("youngs_modulus", ("stiffness",))])
def test_mass_and_modulus_scale_matrices(name, scaled):
    rotor = three_disk_rotor(13)
    plain, changed = assemble_free(rotor), assemble_free(effect(name).rotor(rotor, np.array([0.05])))
    for each in ("mass", "gyroscopic", "stiffness"):
        before, after = getattr(plain, each), getattr(changed, each)
        factor = 1.05 if each in scaled else 1.0
        assert np.abs(after - factor * before).max() < 1e-12 * np.abs(before).max()


def test_a_gain_acts_on_its_channel_alone():
    expected = PLAIN.response(REFERENCE[None])[0] * [1, 1, 1, 1.1, 1, 1]
    assert response(effect("channel_gain", position=0.2, direction="y"), [0.1]) == pytest.approx(expected, rel=1e-12)


def test_turned_probes_see_as_much_motion_at_one_plane_and_the_same_elsewhere():
    plain, found = PLAIN.response(REFERENCE[None])[0], response(effect("probe_rotation", position=0.2), [0.3])
    assert found[:, [0, 1, 4, 5]] == pytest.approx(plain[:, [0, 1, 4, 5]], rel=1e-12)
    assert np.sum(np.abs(found[:, 2:4]) ** 2, axis=1) == pytest.approx(np.sum(np.abs(plain[:, 2:4]) ** 2, axis=1))
    assert found[:, 2] == pytest.approx(np.cos(0.3) * plain[:, 2] + np.sin(0.3) * plain[:, 3], rel=1e-12)


def test_a_quarter_turn_swaps_the_probes():
    problem = effect("probe_rotation").added_to(PLAIN)
    found, plain = problem.response(with_values(REFERENCE, [np.pi / 2]))[0], PLAIN.response(REFERENCE[None])[0]
    assert found[:, ::2] == pytest.approx(plain[:, 1::2], rel=1e-9)
    assert found[:, 1::2] == pytest.approx(-plain[:, ::2], rel=1e-9)


def test_a_turned_probe_alone_still_sees_the_other_direction():
    problem = effect("probe_rotation", position=0.2).added_to(PLAIN)
    alone = problem.at(PLAIN.speed, [Channel(0.2, "x")])
    x = with_values(REFERENCE, [0.3])
    assert alone.response(x)[0] == pytest.approx(problem.response(x)[0][:, 2:3], rel=1e-9)
    assert difference(alone.response(x), alone.dense_response(x)) < 1e-8

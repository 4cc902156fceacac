"""RotorProblem: the receptance reduction against the dense route, sensitivities, and what the contract asks."""

import dataclasses
import itertools
import pickle

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.problem.alignment import aligned
from ksmea.problem.parameters import Parameter
from problems.rotor.finite_elements.bearing import COEFFICIENTS, MASSES, Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response import physics as physics_module
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, UnbalanceTarget, Unknown
from problems.three_disk import ThreeDisk

STEEL = Material(young_modulus=200e9, density=7800.0, poisson_ratio=0.3)

# Both routes lose digits at the needles of a lightly damped rotor: with damping ratios down to 1e-5 and element
# stiffnesses 1e4 times the modal ones, rounding of 1e-16 becomes 1e-9 there and 1e-13 elsewhere.
WORST, NEARLY_ALL = 1e-8, 1e-10


def relative_deviation(found, expected):
    return np.abs(found - expected) / np.abs(expected)


def random_sets(problem, n, seed):
    return problem.parameters.to_si(np.random.default_rng(seed).random((n, len(problem.parameters))))


def corners(problem):
    return problem.parameters.to_si(np.array(list(itertools.product((0.0, 1.0), repeat=len(problem.parameters)))))


@pytest.mark.parametrize("mesh", [13, 21])
def test_reduced_response_is_the_dense_one_in_the_whole_box(mesh):
    problem = ThreeDisk(mesh=mesh, sensors=[0.1, 0.77]).build()
    x = np.concatenate([corners(problem), random_sets(problem, 150, seed=1)])
    deviation = relative_deviation(problem.response(x), problem.dense_response(x))
    assert deviation.max() < WORST
    assert np.quantile(deviation, 0.99) < NEARLY_ALL


def full_problem():
    """Two different bearings with all twelve coefficients unknown, a third one given, two planes with phase."""
    given = Bearing(1.0, kxx=3e7, kyy=2e7, kxy=4e6, kyx=-2e6, cxx=2e4, cyy=3e4, cxy=1e3, cyx=2e3)
    rotor = Rotor(
        segments=(ShaftSegment(0.4, 0.04, STEEL, 3), ShaftSegment(0.6, 0.05, STEEL, 4, inner_radius=0.02)),
        disks=(Disk(0.4, 30.0, 0.6, 0.35),),
        bearings=(Bearing(0.0), given, Bearing(0.7)),
        unbalance=(UnbalancePlane(0.4), UnbalancePlane(0.85)),
    )

    def bounds(name):
        if name in ("kxx", "kyy"):
            return 1e7, 9e7
        if name in ("kxy", "kyx"):
            return -5e6, 6e6
        if name in MASSES:
            return (2.0, 30.0) if name in ("mxx", "myy") else (-3.0, 4.0)
        return (5e3, 5e4) if name in ("cxx", "cyy") else (-2e3, 3e3)

    coefficients = [
        Unknown(Parameter(f"{name}_{bearing}", "SI", 1.0, *bounds(name)), (BearingTarget(bearing, name),))
        for bearing in (0, 2)
        for name in COEFFICIENTS
    ]
    unbalance = [
        Unknown(Parameter(f"{part}_{plane}", "SI", 1.0, *limits), (UnbalanceTarget(plane, part),))
        for plane in (0, 1)
        for part, limits in (("magnitude", (1e-4, 5e-4)), ("phase", (-np.pi, np.pi)))
    ]
    return RotorProblem(
        rotor,
        tuple(coefficients + unbalance),
        speed=np.linspace(100.0, 1500.0, 15),
        channels=(Channel(0.0, "x"), Channel(0.33, "y"), Channel(1.0, "y")),
    )


def test_full_bearings_and_several_planes_agree_with_the_dense_route():
    problem = full_problem()
    x = random_sets(problem, 40, seed=2)
    # Well damped: rounding only, magnified by a condition number near 1e5.
    assert relative_deviation(problem.response(x), problem.dense_response(x)).max() < 1e-10


def test_every_unknown_matters():
    # Guards the comparisons above: an unknown that entered neither route would agree with itself.
    problem = full_problem()
    x = random_sets(problem, 1, seed=3)[0]
    effect = np.abs(problem.sensitivity(x) * problem.parameters.width).max(axis=(0, 1))
    assert effect.min() > 1e-4 * np.abs(problem.response(x[None])).max()


# Central difference of sixth order: f' ≈ Σ w_j f(x + jh)/h.
DIFFERENCE_STEPS = np.arange(-3, 4)
DIFFERENCE_WEIGHTS = np.array([-1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60])


def differences(problem, x, step):
    """∂response/∂x by differences of the dense route with steps (d,)."""
    columns = []
    for index in range(len(x)):
        points = x + np.outer(DIFFERENCE_STEPS, step[index] * np.eye(len(x))[index])
        columns.append(np.tensordot(DIFFERENCE_WEIGHTS, problem.dense_response(points), (0, 0)) / step[index])
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize(
    ("problem", "relative_step"),
    # The step is small against the half-width of a resonance (relative 4e-4 in k, half of that in Ω) and large
    # against rounding: truncation and rounding are then both below 4e-7 of the largest derivative.
    [(ThreeDisk().build(), 3e-4), (ThreeDisk(mesh=21, sensors=[0.4]).build(), 6e-4), (full_problem(), 1e-3)],
    ids=["three_disk", "three_disk_21", "full"],
)
def test_sensitivity_against_sixth_order_differences(problem, relative_step):
    for x in random_sets(problem, 3, seed=4):
        expected = differences(problem, x, relative_step * np.abs(x))
        error = np.abs(problem.sensitivity(x) - expected).max(axis=(0, 1)) / np.abs(expected).max(axis=(0, 1))
        assert error.max() < 1e-6


def test_tied_targets_are_one_unknown():
    problem = ThreeDisk().build()
    untied = dataclasses.replace(
        problem,
        unknowns=tuple(
            Unknown(dataclasses.replace(item.parameter, name=f"{item.parameter.name}_{index}"), (target,))
            for item in problem.unknowns
            for index, target in enumerate(item.targets)
        ),
    )
    x = random_sets(problem, 5, seed=5)
    doubled = np.repeat(x, [len(item.targets) for item in problem.unknowns], axis=1)
    # 1e-9: sums of 81 monomials and of 36, at a resonance
    assert untied.response(doubled) == pytest.approx(problem.response(x), rel=1e-9)
    # The chain rule: a tied unknown's sensitivity is the sum over what it sets.
    separate = untied.sensitivity(doubled[0])
    summed = np.stack([separate[..., 0:2].sum(-1), separate[..., 2:4].sum(-1)], axis=-1)
    assert np.allclose(problem.sensitivity(x[0])[..., :2], summed, rtol=1e-12)


def test_bearings_that_differ_change_the_response():
    problem = ThreeDisk().build()
    left_only = dataclasses.replace(
        problem, unknowns=(Unknown(problem.unknowns[0].parameter, (BearingTarget(0, "kxx"),)),)
    )
    middle = (problem.parameters.lower + problem.parameters.upper) / 2
    x = 0.5 * middle
    x[1:] = middle[1:]
    assert relative_deviation(left_only.response(x[None, :1]), problem.response(x[None])).max() > 0.01
    assert relative_deviation(left_only.response(x[None, :1]), left_only.dense_response(x[None, :1])).max() < WORST


def test_batches_do_not_change_the_numbers(monkeypatch):
    problem = ThreeDisk().build()
    x = random_sets(problem, 7, seed=6)
    whole = problem.response(x)
    monkeypatch.setattr(physics_module, "CHUNK_BYTES", 2 * problem.reduction.receptance.nbytes)
    assert problem.response(x) == pytest.approx(whole, rel=1e-14)
    assert problem.response(x[:1]) == pytest.approx(whole[:1], rel=1e-14)
    assert problem.response(x[:0]).shape == (0, 53, 2)


def test_shapes_and_types_of_the_contract():
    problem = ThreeDisk(n_speed=7, sensors=[0.1, 0.9, 1.2]).build()
    x = random_sets(problem, 3, seed=7)
    assert problem.response(x).shape == (3, 7, 6)
    assert problem.response(x).dtype == complex
    assert problem.sensitivity(x[0]).shape == (7, 6, 5)


def test_same_rotor_at_other_speeds_and_channels():
    problem = ThreeDisk().build()
    x = random_sets(problem, 2, seed=8)
    part = problem.at(problem.speed[[3, 40]], problem.channels[1:])
    # Where no needle is near, both are rounding; a change of speed must not touch the physics.
    assert relative_deviation(part.response(x)[:, :, 0], problem.response(x)[:, [3, 40], 1]).max() < 1e-10
    assert part.parameters == problem.parameters


def test_pickling_keeps_the_numbers():
    problem = ThreeDisk().build()
    x = random_sets(problem, 2, seed=9)
    fresh = pickle.loads(pickle.dumps(problem))
    expected = problem.response(x)
    used = pickle.loads(pickle.dumps(problem))
    for copy in (fresh, used):
        assert np.array_equal(copy.response(x), expected)


def test_frozen():
    problem = ThreeDisk().build()
    with pytest.raises(dataclasses.FrozenInstanceError):
        problem.speed = np.array([1.0])
    with pytest.raises(ValueError, match="read-only"):
        problem.speed[0] = 1.0


def test_problem_forgets_the_values_of_its_unknowns():
    settings = ThreeDisk()
    problem, reference = settings.build(), settings.reference()
    true_bearing = Bearing(0.0, **{name: reference[name] for name in ("kxx", "kyy", "cxx", "cyy")})
    given = dataclasses.replace(
        problem.rotor,
        bearings=(true_bearing, dataclasses.replace(true_bearing, position=1.3)),
        unbalance=(UnbalancePlane(0.5, reference["u"]),),
    )
    forgetful = RotorProblem(given, problem.unknowns, problem.speed, problem.channels)
    assert forgetful.rotor == problem.rotor
    assert forgetful.rotor.bearings[0].kxx == pytest.approx(55e6)  # the middle of 10 and 100 MN/m


def test_singular_response_is_an_error():
    problem = ThreeDisk().build()
    x = random_sets(problem, 2, seed=10)
    x[1, 0] = np.nan
    with pytest.raises(np.linalg.LinAlgError, match="not finite"):
        problem.response(x)


def small_rotor(**changes):
    segment = ShaftSegment(0.5, 0.02, STEEL, 2)
    parts = {
        "segments": (segment,),
        "bearings": (Bearing(0.0, kxx=1e6, kyy=1e6),),
        "unbalance": (UnbalancePlane(0.25),),
    }
    return Rotor(**(parts | changes))


def stiffness_unknown(name="k", bearing=0):
    return Unknown(Parameter(name, "N/m", 1.0, 1e5, 1e6), (BearingTarget(bearing, "kxx"),))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"unknowns": (stiffness_unknown(bearing=1),)}, "expected a bearing from 0 to 0, got 1"),
        ({"unknowns": (stiffness_unknown(), stiffness_unknown("again"))}, "already set by k"),
        ({"unknowns": (dataclasses.replace(stiffness_unknown(), targets=()),)}, "at least one target"),
        ({"speed": [0.0, 1.0]}, "above 0 rad/s"),
        ({"speed": []}, "above 0 rad/s"),
        ({"speed": [[1.0]]}, "above 0 rad/s"),
        ({"channels": (Channel(0.6, "x"),)}, "from 0 to 0.5 m"),
    ],
)
def test_bad_problem(changes, message):
    parts = {
        "rotor": small_rotor(),
        "unknowns": (stiffness_unknown(),),
        "speed": np.array([10.0]),
        "channels": (Channel(0.1, "x"),),
    }
    RotorProblem(**parts)
    with pytest.raises(SettingError, match=message) as caught:
        RotorProblem(**(parts | changes))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["bearings", "unbalance", "unknowns"])
def test_a_rotor_that_can_only_be_drawn_is_not_compared_with_data(name):
    """A measurement of it has nothing to be compared with; a drawing asks for none of it."""
    whole = {"bearings": (Bearing(0.0),), "unbalance": (UnbalancePlane(0.25),)}
    changed = small_rotor(**{key: () if key == name else part for key, part in whole.items()})
    unknowns = () if name in ("unknowns", "bearings") else (stiffness_unknown(),)
    problem = RotorProblem(changed, unknowns, np.array([10.0, 20.0]), (Channel(0.1, "x"),))
    measured = Measurement(problem.speed, problem.channels, np.zeros((2, 1)), None, "data")
    with pytest.raises(SettingError, match=f"problem: expected .*{name}.*, got none; add them to the rotor file"):
        aligned(problem, measured)


def test_bad_targets():
    with pytest.raises(SettingError, match="unknown bearing coefficient 'kxz'; did you mean"):
        BearingTarget(0, "kxz")
    with pytest.raises(SettingError, match="unknown part of an unbalance 'angle'"):
        UnbalanceTarget(0, "angle")


def test_wrong_shape_of_parameter_sets():
    problem = ThreeDisk().build()
    for shape in ((5,), (2, 4)):
        with pytest.raises(SettingError, match="kxx, kyy, cxx, cyy, u"):
            problem.response(np.ones(shape))

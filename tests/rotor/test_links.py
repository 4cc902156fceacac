"""Tables over speed, seals, pedestals and housing probes: the reduction against the dense route, in which housings have degrees of
freedom of their own, and free motions against all eigenvalues."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.numerics.differences import central_differences
from ksmea.plugins.registry import create
from ksmea.problem.load import Load
from ksmea.problem.parameters import Parameter
from ksmea.problem.response_structure import ResponseStructure
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.bearing import COEFFICIENTS, Bearing, Pedestal, SpeedTable
from problems.rotor.finite_elements.data import HousingProbe, Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.free_motion.critical_speeds import critical_speeds
from problems.rotor.free_motion.modes import eigenpairs, natural_modes
from problems.rotor.response.model import impedances_of
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, PedestalTarget, UnbalanceTarget, Unknown
from surrogates.rational import Rational

STEEL = Material(2e11, 7800.0, 0.3)
SPEED = np.linspace(60.0, 900.0, 23)


def table(seed, size=1.0):
    """Twelve columns over five speeds, with cross-coupling and mass terms (crossed ones would feed motions far above)."""
    rng = np.random.default_rng(seed)
    scale = np.array([2e7, 3e6, -3e6, 3e7, 2e4, 1e3, 1e3, 3e4, 5.0, 0.0, 0.0, 5.0]) * size
    rows = scale * rng.uniform(0.6, 1.4, (5, 12))
    return SpeedTable((50.0, 200.0, 450.0, 700.0, 1000.0), tuple(map(tuple, rows.tolist())))


def measured(seed):
    """Dynamic stiffness of a support over frequency, Re and Im of xx xy yx yy."""
    rng = np.random.default_rng(seed)
    scale = np.array([2e7, 2e6, 1e6, 1e5, 1e6, 1e5, 3e7, 3e6])
    rows = scale * rng.uniform(0.6, 1.4, (4, 8))
    return SpeedTable((30.0, 300.0, 600.0, 950.0), tuple(map(tuple, rows.tolist())))


def machine(**changes):
    """A rotor with every kind of link: a tabulated bearing on a pedestal, a constant one on a measured pedestal, a third on the ground,
    and three seals, one of them at a place of a bearing."""
    pedestal = Pedestal(kxx=6e7, kxy=2e6, kyx=1e6, kyy=4e7, cxx=3e3, cyy=2e3, mxx=12.0, myy=15.0, loss_factor=0.03)
    rotor = Rotor(
        segments=(ShaftSegment(0.4, 0.04, STEEL, 4), ShaftSegment(0.6, 0.05, STEEL, 5, inner_radius=0.02)),
        disks=(Disk(0.4, 30.0, 0.6, 0.35), Disk(0.76, 20.0, 0.3, 0.16)),
        bearings=(
            Bearing(0.0, table=table(1), pedestal=pedestal),
            Bearing(1.0, kxx=3e7, kyy=2e7, kxy=4e6, kyx=-2e6, cxx=2e4, cyy=3e4, pedestal=Pedestal(dynamic_stiffness=measured(2))),
            Bearing(0.64, kxx=1e7, kyy=1e7, cxx=5e3, cyy=5e3),
        ),
        seals=(
            Bearing(0.2, kxx=1e6, kxy=8e5, kyx=-8e5, kyy=1e6, cxx=2e3, cyy=2e3, mxx=3.0, myy=3.0),
            Bearing(0.88, table=table(3, 0.05)),
            Bearing(0.0, table=table(4, 0.02)),
        ),
        unbalance=(UnbalancePlane(0.4, 2e-4), UnbalancePlane(0.85, 1e-4, 0.7)),
        housing_probes=(HousingProbe(0.05, None, 0), HousingProbe(0.95, "y", 1)),
    )  # fmt: skip
    return dataclasses.replace(rotor, **changes)


CHANNELS = (
    Channel(0.05, "x"),
    Channel(0.05, "y"),
    Channel(0.95, "y"),
    Channel(0.95, "x"),
    Channel(0.5, "30"),
)


def unknown(name, lower, upper, *targets):
    return Unknown(Parameter(name, "SI", 1.0, lower, upper), targets)


UNKNOWNS = (
    unknown("stiffness_factor", 0.5, 2.0, BearingTarget(0, "stiffness_factor")),
    unknown("cyy_factor", 0.5, 2.0, BearingTarget(0, "cyy_factor")),
    unknown("kxx", 1e7, 6e7, BearingTarget(1, "kxx")),
    unknown("mxx", 1.0, 20.0, BearingTarget(1, "mxx")),
    unknown("seal_cross", 2e5, 2e6, BearingTarget(3, "kxy")),
    unknown("seal_factor", 0.5, 2.0, BearingTarget(4, "damping_factor")),
    unknown("support_kxx", 3e7, 9e7, PedestalTarget(0, "kxx")),
    unknown("support_mass", 5.0, 25.0, PedestalTarget(0, "mass")),
    unknown("other_support_kyy", 1e6, 2e7, PedestalTarget(1, "kyy")),
    unknown("u", 1e-4, 4e-4, UnbalanceTarget(0)),
)
# Known and unknown numbers of a bearing and its pedestal in all combinations
PARTS = {
    "all": UNKNOWNS,
    "films": UNKNOWNS[:6],
    "pedestals": UNKNOWNS[6:],
    "the third bearing": (unknown("kxx", 5e6, 4e7, BearingTarget(2, "kxx")),),
    "unbalance alone": UNKNOWNS[-1:],
}


def problem_with(unknowns, **changes):
    return RotorProblem(machine(**changes), unknowns, SPEED, CHANNELS)


def sets(problem, n, seed):
    return problem.parameters.to_si(np.random.default_rng(seed).random((n, len(problem.parameters))))


def deviation(found, expected):
    """Largest difference, relative to the largest motion of its channel."""
    size = np.abs(expected).max(axis=-2, keepdims=True)
    return np.max(np.abs(found - expected) / size)


@pytest.mark.parametrize("name", PARTS)
def test_reduced_response_is_the_dense_one(name):
    problem = problem_with(PARTS[name])
    x = sets(problem, 8, 1)
    # Rounding, magnified by condition numbers near 1e5.
    assert deviation(problem.response(x), problem.dense_response(x)) < 1e-10
    for row, own in zip(x, problem.response(x)):
        assert deviation(problem.linearised(row)[0], own) < 1e-10


@pytest.mark.parametrize("name", PARTS)
def test_sensitivity_is_that_of_differences(name):
    problem = problem_with(PARTS[name])
    x, limits = sets(problem, 1, 2)[0], problem.parameters
    differences = central_differences(x, 1e-4 * limits.width, limits.lower, limits.upper)
    expected = differences.derivative(problem.dense_response(differences.points))
    error = np.abs(problem.sensitivity(x) - expected).max(axis=(0, 1)) / np.abs(expected).max(axis=(0, 1))
    assert np.all(error < 1e-5)  # truncation: (1e-4)² of the range, some tens of half-widths of a resonance


def test_each_unknown_matters():
    problem = problem_with(UNKNOWNS)
    effect = np.abs(problem.sensitivity(sets(problem, 1, 3)[0]) * problem.parameters.width).max(axis=(0, 1))
    assert effect.min() > 1e-4 * effect.max()


def test_known_bearings_and_seals_cost_no_ports():
    impedances = impedances_of(machine(), PARTS["the third bearing"])
    assert {(item.bearing, item.link) for item in impedances} == {(2, 0)}
    assert problem_with(UNKNOWNS[-1:]).reduction.n_port == 0


@pytest.mark.parametrize(
    "effects",
    [
        ["runout"],
        ["speed_dependent_stiffness"],
        ["flexible_pedestal"],
        ["short_journal_bearing"],
        ["annular_seal"],
        ["mass"],
        ["foundation_resonance", "residual_bow"],
        ["cubic_stiffness"],
        ["crack"],
        ["axial_force", "unequal_bearings"],
    ],
    ids=" ".join,
)
def test_effects_act_on_such_a_rotor_as_by_the_dense_route(effects):
    problem = problem_with(UNKNOWNS)
    for name in effects:
        made = create("effect", name, {})
        problem = made.locations(problem)[0].added_to(problem)
    rng = np.random.default_rng(5)
    x = problem.parameters.to_si(rng.uniform(0.3, 0.7, (2, len(problem.parameters))))
    assert deviation(problem.response(x), problem.dense_response(x)) < 1e-7  # nonlinear laws end at 1e-8


@pytest.mark.parametrize("effect", ["speed_dependent_stiffness", "youngs_modulus", "annular_seal"])
def test_sensitivity_beside_an_effect_is_that_of_differences(effect):
    plain = problem_with(UNKNOWNS)
    problem = create("effect", effect, {}).locations(plain)[0].added_to(plain)
    x, limits = problem.parameters.to_si(np.full((1, len(problem.parameters)), 0.4))[0], problem.parameters
    differences = central_differences(x, 1e-4 * limits.width, limits.lower, limits.upper)
    expected = differences.derivative(problem.response(differences.points))
    error = np.abs(problem.sensitivity(x) - expected).max(axis=(0, 1)) / np.abs(expected).max(axis=(0, 1))
    assert np.all(error < 1e-5)


def test_response_to_a_unit_load_is_the_dense_one():
    """A load of 1 N on the shaft is what an unbalance of 1/Ω² there does."""
    problem = problem_with(UNKNOWNS)
    x = sets(problem, 2, 4)
    loads = [Load(0.85, "x"), Load(0.85, "y")]
    per_load = problem.load_response(x, loads)
    forward = per_load[..., 0] - 1j * per_load[..., 1]
    planes = (UnbalancePlane(0.4), UnbalancePlane(0.85, 1.0))
    alone = problem_with(tuple(UNKNOWNS[:-1]), unbalance=planes)
    expected = alone.dense_response(x[:, :-1]) / SPEED[:, None] ** 2
    assert deviation(forward, expected) < 1e-10


@pytest.mark.parametrize("massless", [False, True])
def test_free_motions_are_those_of_all_eigenvalues(massless):
    swirl = Bearing(0.4, kxy=4e7, kyx=-4e7)  # drives a low mode, so that it is the one that grows most
    rotor = dataclasses.replace(machine(), seals=(*machine().seals, swirl))
    if massless:
        soft = Pedestal(kxx=6e7, kyy=4e7)
        rotor = dataclasses.replace(rotor, bearings=(dataclasses.replace(rotor.bearings[0], pedestal=soft),))
        rotor = dataclasses.replace(rotor, housing_probes=())
    problem = RotorProblem(rotor, (unknown("u", 1e-4, 4e-4, UnbalanceTarget(0)),), SPEED, CHANNELS[4:])
    x = np.array([2e-4])
    for speed in (150.0, 700.0):
        eigenvalues, _ = eigenpairs(assemble(rotor, speed), speed)
        growth = np.max(eigenvalues.real[eigenvalues.imag >= 0])
        assert growth > 10
        assert problem.growth_rate(x, np.array([speed]))[0] == pytest.approx(growth, rel=1e-4)  # of its twelve modes
        frequencies = np.sort(eigenvalues.imag[eigenvalues.imag > 1.0])[:5]
        low = problem.free_rotor(x, 1000.0).frequencies(np.array([speed]))[0]
        np.testing.assert_allclose(low[low > 1.0][:5], frequencies, rtol=1e-5)  # as stated for its number of modes
        modes = [mode.frequency for mode in natural_modes(rotor, speed) if mode.frequency > 1.0]
        assert modes[:5] == pytest.approx(frequencies)


def test_critical_speeds_are_where_a_frequency_meets_the_speed():
    """Critical speeds of all eigenvalues, with the tables read at each speed."""
    rotor = machine()
    found = critical_speeds(rotor, 900.0)
    assert len(found) >= 2
    for speed in found:
        eigenvalues, _ = eigenpairs(assemble(rotor, float(speed)), float(speed))
        assert np.min(np.abs(eigenvalues.imag - speed)) < 1e-8 * speed


def test_a_stiff_pedestal_is_rigid_ground_and_a_stiff_bearing_rides_on_its_pedestal():
    springs = {"kxx": 2e7, "kyy": 3e7, "cxx": 1e4, "cyy": 2e4}
    planes = (UnbalancePlane(0.4, 2e-4),)
    base = machine(seals=(), housing_probes=(), unbalance=planes)

    def response(left):
        rotor = dataclasses.replace(base, bearings=(left, *base.bearings[1:]))
        target = (unknown("u", 1e-4, 4e-4, UnbalanceTarget(0)),)
        return RotorProblem(rotor, target, SPEED, CHANNELS).response(np.array([[2e-4]]))

    rigid = Pedestal(kxx=1e16, kyy=1e16)
    assert deviation(response(Bearing(0.0, **springs, pedestal=rigid)), response(Bearing(0.0, **springs))) < 1e-8
    welded = Bearing(0.0, kxx=1e16, kyy=1e16, pedestal=Pedestal(**springs))
    assert deviation(response(welded), response(Bearing(0.0, **springs))) < 1e-8


def test_a_table_goes_through_its_points_and_stops_at_its_ends():
    own = table(1)
    np.testing.assert_allclose(own.at(np.array(own.speed)), own.rows, rtol=1e-14)
    np.testing.assert_allclose(own.at(np.array([1.0, 5000.0])), [own.rows[0], own.rows[-1]], rtol=1e-14)
    assert own.beyond(np.array([60.0, 999.0])) is None
    assert own.beyond(np.array([10.0, 100.0])) == (10.0, 100.0)
    between = own.at(np.linspace(50.0, 1000.0, 400))
    assert np.all(between.max(axis=0) <= np.max(own.rows, axis=0) + 1e-9)  # PCHIP does not overshoot


def test_a_table_of_equal_rows_is_a_constant_bearing():
    numbers = dict(zip(COEFFICIENTS, [2e7, 3e6, -3e6, 3e7, 2e4, 1e3, 1e3, 3e4, 5.0, 0.0, 0.0, 5.0]))
    flat = SpeedTable((100.0, 500.0, 800.0), (tuple(numbers.values()),) * 3)
    rotor = machine(seals=(), housing_probes=())
    pair = [
        dataclasses.replace(rotor, bearings=(each, *rotor.bearings[1:]))
        for each in (Bearing(0.0, **numbers), Bearing(0.0, table=flat))
    ]
    target = (unknown("kxx", 1e7, 6e7, BearingTarget(1, "kxx")),)
    one, other = (RotorProblem(each, target, SPEED, CHANNELS) for each in pair)
    assert deviation(one.response(np.array([[3e7]])), other.response(np.array([[3e7]]))) < 1e-12
    one, other = (assemble(each, 300.0).stiffness for each in pair)
    np.testing.assert_allclose(other, one, rtol=1e-14)


@pytest.mark.parametrize(
    ("target", "words"),
    [
        (BearingTarget(1, "stiffness_factor"), "expected a bearing with a table"),
        (PedestalTarget(2, "kxx"), "expected a bearing with a support"),
        (BearingTarget(6, "kxx"), "expected a bearing from 0 to 5"),
    ],
)
def test_what_a_rotor_has_not_is_no_unknown(target, words):
    with pytest.raises(SettingError, match=words):
        problem_with((unknown("a", 0.5, 2.0, target),))


def test_a_housing_that_nothing_holds_is_named():
    loose = (Bearing(0.0, pedestal=Pedestal()), *machine().bearings[1:])
    with pytest.raises(SettingError, match="bearing at 0 m: expected a bearing or a support that holds its housing"):
        problem_with(UNKNOWNS[2:3], bearings=loose, housing_probes=()).response(np.array([[3e7]]))


def test_a_number_is_set_once():
    both = (BearingTarget(0, "stiffness_factor"), BearingTarget(0, "kyy_factor"))
    with pytest.raises(SettingError, match="already set by a"):
        problem_with((unknown("a", 0.5, 2.0, both[0]), unknown("b", 0.5, 2.0, both[1])))


def test_a_housing_probe_needs_a_support():
    with pytest.raises(SettingError, match="expected a bearing with a support to be relative to, got bearing 3"):
        problem_with(UNKNOWNS, housing_probes=(HousingProbe(0.6, None, 2),))


@pytest.mark.parametrize(
    "unknowns", [(UNKNOWNS[0], *UNKNOWNS[2:4]), UNKNOWNS[6:7], UNKNOWNS[7:8]], ids=["films", "support", "mass"]
)
def test_the_response_is_a_rational_function_of_factors_masses_and_supports(unknowns):
    """At one speed D is linear in each: fitted to samples of the response, the quotient of polynomials is exact but for rounding."""
    problem = problem_with((*unknowns, UNKNOWNS[-1]))
    structure = ResponseStructure(
        problem.parameters, problem.speed, len(CHANNELS), problem.unknown_impedances, problem.unbalance
    )
    surrogate = Rational(fallback="stop").with_structure(structure)
    rng, d = np.random.default_rng(0), len(problem.parameters)

    def samples(n):
        u = rng.random((n, d))
        response = problem.response(problem.parameters.to_si(u)).reshape(n, -1)
        return u, np.concatenate([response.real, response.imag], axis=1)

    predictor = surrogate.fit(*samples(surrogate.least_samples(d) + 6), rng)
    u, expected = samples(20)
    found = predictor.predict(u).reshape(expected.shape)
    assert np.max(np.abs(found - expected) / np.abs(expected).max(axis=0)) < 1e-8  # rounding of a null vector


def test_a_coupling_of_the_rotor_is_where_misalignment_acts():
    effect = create("effect", "coupling_misalignment", {})
    named = problem_with(UNKNOWNS, couplings=(0.64, 0.7))  # a node, and a place between two
    assert [str(each) for each in effect.locations(named)] == ["force at 0.64 m", "force at 0.7 m", "moment at 0.64 m"]
    assert str(effect.placed_on(named)) == "force at 0.64 m"
    assert len(effect.locations(problem_with(UNKNOWNS))) == 4  # both ends where none is named


def test_a_sweep_of_the_speed_is_refused_beside_probes_on_housings():
    """Poles of the response read the shaft against the ground."""
    effect = create("effect", "run_up_acceleration", {})
    with pytest.raises(SettingError, match="expected probes against the ground together with a sweep"):
        effect.locations(problem_with(UNKNOWNS))[0].added_to(problem_with(UNKNOWNS)).response(np.ones((1, 11)))
    on_ground = problem_with(UNKNOWNS, housing_probes=())
    swept = effect.locations(on_ground)[0].added_to(on_ground)
    x = swept.parameters.to_si(np.full((1, len(swept.parameters)), 0.5))
    x[0, -1] = 0.0
    assert deviation(swept.response(x), on_ground.response(x[:, :-1])) < 1e-12

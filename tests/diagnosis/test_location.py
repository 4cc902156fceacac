"""Where something acts that the model lacks: data come from the dense route and twice as many elements."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.location.location import candidates, locate
from ksmea.location.recovered_force import recovered_force, site_intervals
from ksmea.location.unknown_force import LATERAL, READING, Unmodelled
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.problem.load import Load
from ksmea.records.location import UNSEEN
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response import dense
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

SENSORS = [0.1, 0.5, 1.0]
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
NOISE = Noise(0.05, 1e-7)
PROBLEM = ThreeDisk(sensors=SENSORS, n_speed=40).build()
FINE = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=40).build()
FOLLOWS = 0.9  # coherence of force and motion
UNBALANCE = (5e-5, 4e-5)  # a third of the model's own, kg m


def response(name=None, size=(), **settings):
    """Response of the rotor with an effect hidden in it."""
    problem = FINE if name is None else registry.create("effect", name, settings).added_to(FINE)
    return problem.dense_response(np.append(TRUTH, size)[None])[0]


def measured(values, seed, noise=None):
    noisy = observe(values, "complex", NOISE, np.random.default_rng(seed))
    return Measurement(PROBLEM.speed, PROBLEM.channels, noisy, noise, "test")


@pytest.fixture(scope="module")
def unbalanced():
    """A second unbalance on the third disk, at 1 m, the noise unknown."""
    data = measured(response("unbalance", UNBALANCE, position=1.0), 1)
    return locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[0.0, 0.5, 1.0, 1.3])


def accepted(found):
    return {str(found.sites[index].unmodelled) for index in found.accepted}


def test_a_hidden_unbalance_is_a_force_at_its_disk_and_nothing_else(unbalanced):
    assert not unbalanced.is_plain_enough
    assert accepted(unbalanced) == {"force at 1 m"}


def test_the_unknowns_beside_it_are_the_true_ones_and_the_plain_ones_are_not(unbalanced):
    best = unbalanced.sites[unbalanced.accepted[0]]
    for value, interval in zip(TRUTH, site_intervals(best, 0.999)):  # five intervals, one draw: all should hold
        assert interval.low <= value <= interval.high
    plain = PROBLEM.parameters.to_si(unbalanced.plain.point.theta)
    assert abs(plain[4] / TRUTH[4] - 1) > 0.05  # the plain model spreads the second unbalance over its own unknowns


def test_the_noise_is_estimated_beside_it(unbalanced):
    """240 × 2/3 real data of each channel pair tell two parts: about 6 % each, and the least of several sites is taken."""
    assert unbalanced.noise.relative == pytest.approx(NOISE.relative, rel=0.15)
    assert unbalanced.noise.floor == pytest.approx(NOISE.floor, rel=0.4)


def test_the_recovered_force_is_the_hidden_one(unbalanced):
    recovered = recovered_force(unbalanced.sites[unbalanced.accepted[0]], np.random.default_rng(2))
    forward = complex(*UNBALANCE) * PROBLEM.speed**2
    truth = np.stack([forward, -1j * forward, forward, 0 * forward], axis=1)  # x, y, forward, backward
    for part in (np.real, np.imag):
        low, high = np.quantile(part(recovered.parts[1:]), [0.025, 0.975], axis=0)
        held = np.sum((low <= part(truth)) & (part(truth) <= high))
        # x and y at 40 speeds each are 80 independent ones, forward and backward the same again: fewer than 65 have a
        # chance below 1e-6
        assert held >= 2 * 65
    assert [name for name, _ in recovered.names] == ["x", "y", "forward", "backward"]
    assert np.all(recovered.coherence < FOLLOWS)  # an unbalance does not follow the motion


def test_what_follows_the_motion_is_a_dynamic_stiffness_that_takes_no_energy():
    """A mass added at the third disk acts as −(−Ω² m) q: the recovered −f/q is −Ω² m at all speeds."""
    mass = 8.0
    rotor = rotor_at(FINE.rotor, FINE.unknowns, TRUTH)
    heavier = dataclasses.replace(rotor, disks=(*rotor.disks, Disk(1.0, mass, 1e-6, 1e-6)))
    data = measured(dense.dense_response(heavier, FINE.speed, FINE.channels), 3)
    found = locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[1.0], quantities=["force"])
    assert accepted(found) == {"force at 1 m"}
    recovered = recovered_force(found.sites[0], np.random.default_rng(2))
    assert np.all(recovered.coherence[:2] > FOLLOWS)
    stiffness = recovered.dynamic_stiffness[:, :, :2]
    expected = -mass * PROBLEM.speed[:, None] ** 2
    low, high = np.quantile(stiffness[1:].real, [0.025, 0.975], axis=0)
    assert np.mean((low <= expected) & (expected <= high)) > 0.8  # 95 % of 80 but for common errors of the unknowns
    low, high = np.quantile(recovered.work[1:], [0.025, 0.975], axis=0)
    assert np.mean((low <= 0) & (0 <= high)) > 0.8


def test_a_damper_takes_energy():
    """W = π Im(q* f) of f = −iΩc q is −πΩc|q|²: what is added to the first bearing in the data acts on the model so."""
    rotor = rotor_at(FINE.rotor, FINE.unknowns, TRUTH)
    first, last = rotor.bearings
    damped = dataclasses.replace(first, cxx=first.cxx + 5000.0, cyy=first.cyy + 5000.0)
    values = dense.dense_response(dataclasses.replace(rotor, bearings=(damped, last)), FINE.speed, FINE.channels)
    found = locate(Case(PROBLEM, measured(values, 4)), np.random.default_rng(0), positions=[0.0], quantities=["force"])
    work = recovered_force(found.sites[0], np.random.default_rng(1)).work
    low, high = np.quantile(work[1:], [0.025, 0.975], axis=0)
    assert np.mean(high < 0) > 0.5
    assert np.mean(low > 0) < 0.1  # of 40, where 2.5 % would be wrong by chance


def test_a_skewed_disk_is_a_moment_at_its_disk():
    """A moment that turns with the shaft: at the third disk, as large as 0.1 m times the unbalance force."""
    rotor = rotor_at(FINE.rotor, FINE.unknowns, TRUTH)
    loads = unit_loads(rotor, [Load(1.0, "x", "moment"), Load(1.0, "y", "moment")], len(FINE.speed))
    moment = loads @ (0.1 * 2e-4 * FINE.speed[:, None] ** 2 * np.array([1, -1j]))[..., None]
    stiffness = dense.dynamic_stiffness(assemble(rotor), FINE.speed)
    added = (dense.channel_rows(rotor, FINE.channels) @ np.linalg.solve(stiffness, moment))[..., 0]
    data = measured(response() + added, 5)
    found = locate(
        Case(PROBLEM, data), np.random.default_rng(0), positions=[0.0, 0.5, 1.0], quantities=["force", "moment"]
    )
    assert accepted(found) == {"moment at 1 m"}


def test_a_gain_is_a_reading_at_its_plane_and_no_force():
    values = response()
    values[:, 4] *= 1.3  # x at 1 m
    data = measured(values, 6)
    found = locate(
        Case(PROBLEM, data), np.random.default_rng(0), positions=[0.0, 0.5, 1.0], quantities=["force", "reading"]
    )
    assert accepted(found) == {"reading at 1 m"}


@pytest.mark.parametrize("told", mostly_slow([NOISE, None], but=[None]))
def test_the_true_site_is_rejected_no_more_often_than_the_level_says(told):
    """p of the site is no smaller than a uniform one: of 8 draws, 4 or more below 0.1 would have a chance of 0.5 %."""
    column = FINE.load_response(TRUTH[None], [Load(1.0, "x")])[0, :, :, 0]
    small = 0
    for seed in range(8):
        data = measured(response() + 30.0 * np.exp(1j * seed) * column, [7, seed], told)
        found = locate(
            Case(PROBLEM, data), np.random.default_rng(seed), positions=[1.0], quantities=["force"], n_start=2
        )
        small += found.qualities[0].p < 0.1
    assert small < 4


def test_a_right_model_is_left_alone():
    found = locate(
        Case(PROBLEM, measured(response(), 8)), np.random.default_rng(0), positions=[1.0], quantities=["force"]
    )
    assert found.is_plain_enough
    assert accepted(found) == {"force at 1 m"}  # a force that is next to nothing


@pytest.mark.slow
def test_force_and_moment_are_tried_together_where_neither_is_enough():
    rng = np.random.default_rng(9)
    both = Unmodelled(LATERAL, 1.0)
    free = rng.standard_normal((40, 4)) * np.array([30.0, 30.0, 10.0, 10.0])
    columns = both.columns(FINE, TRUTH[None])[0]
    data = measured(response() + (columns @ free[..., None])[..., 0], 9)
    found = locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[0.5, 1.0])
    assert accepted(found) == {"force and moment at 1 m"}


def test_the_same_generator_gives_the_same_location():
    data = measured(response("unbalance", UNBALANCE, position=1.0), 1)
    first, second = (
        locate(Case(PROBLEM, data), np.random.default_rng(3), positions=[0.9, 1.0], quantities=["force"])
        for _ in range(2)
    )
    assert [quality.p for quality in first.qualities] == [quality.p for quality in second.qualities]
    assert [fit.point.deviance for fit in first.sites] == [fit.point.deviance for fit in second.sites]


def test_an_unbalance_at_the_very_site_is_set_to_where_the_force_is_least():
    """A force at the disk of the model's unbalance, a quarter turn before it, so that no unbalance can stand for any of it:
    the unbalance is the true one, and the rest the force."""
    column = FINE.load_response(TRUTH[None], [Load(0.5, "x")])[0, :, :, 0]
    data = measured(response() + 20j * column, 10)
    found = locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[0.5], quantities=["force"])
    [site] = found.sites
    u = PROBLEM.parameters.to_si(site.point.theta)[4]
    assert u == pytest.approx(TRUTH[4], rel=0.05)  # weighed by 40 speeds with forces of 8 to 450 N
    assert site_intervals(site, 0.95)[4].basis == UNSEEN
    assert np.median(np.abs(site.point.free[:, 0])) == pytest.approx(20.0, rel=0.3)


def test_what_leaves_no_channel_to_test_by_is_not_tried():
    two_planes = PROBLEM.at(PROBLEM.speed, PROBLEM.channels[:4])
    quantities = {each.quantity for each in candidates(two_planes, ["force", LATERAL, READING], np.array([0.0]))}
    assert quantities == {"force", READING}


@pytest.mark.parametrize(
    "n_channel, n_speed, kind, what",
    [
        (6, 40, "amplitude", "got amplitudes of 6; measure phases"),
        (2, 40, "complex", "got 2; add a probe"),
        (3, 4, "complex", "got 8 real data in addition to the force for 5 unknowns; measure more speeds"),
    ],
)
def test_too_few_data_are_refused_with_what_would_be_enough(n_channel, n_speed, kind, what):
    problem = PROBLEM.at(PROBLEM.speed[:n_speed], PROBLEM.channels[:n_channel])
    values = observe(problem.response(TRUTH[None])[0], kind, NOISE, np.random.default_rng(0))
    data = Measurement(problem.speed, problem.channels, values, None, "test")
    with pytest.raises(SettingError, match="expected complex data of at least 3 channels") as error:
        locate(Case(problem, data), np.random.default_rng(0))
    assert what in str(error.value)

"""Runout of each probe: constant readings, names of their unknowns, elimination at screened points."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.fits.elimination import eliminated
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.testing import check_effect
from problems.effects.runout import Runout
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=14)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])
DRAWN = dataclasses.replace(PLAIN, is_as_drawn=True)


def test_each_probe_reads_its_own_constant_and_others_read_none():
    effect = Runout(probes=["y@0.5", "x@0.1"])
    problem = effect.added_to(PLAIN)
    theta = np.array([3.0, -1.0, 0.5, 2.0]) * 1e-6
    added = problem.response(np.concatenate([REFERENCE, theta])[None])[0] - PLAIN.response(REFERENCE[None])[0]
    expected = {Channel(0.5, "y"): 3e-6 - 1e-6j, Channel(0.1, "x"): 0.5e-6 + 2e-6j}
    # beside responses of up to 1e-2 m
    assert added == pytest.approx(np.tile([expected.get(each, 0) for each in PLAIN.channels], (14, 1)), abs=1e-15)
    assert problem.parameters.names[-4:] == (
        "slow_roll_of_y_at_0_5_m_x",
        "slow_roll_of_y_at_0_5_m_y",
        "slow_roll_of_x_at_0_1_m_x",
        "slow_roll_of_x_at_0_1_m_y",
    )


def test_probes_at_plus_and_minus_45_degrees_have_names_of_their_own():
    names = [item.name for item in Runout(probes=["45@0.5", "-45@0.5"]).parameters(PLAIN)]
    assert len(set(names)) == 4 and all(name.isidentifier() for name in names)


def test_a_circle_of_a_plane_is_a_special_case():
    x, r = REFERENCE, np.array([2.0, -1.0]) * 1e-6
    circle = Runout(position=0.5).added_to(PLAIN).response(np.concatenate([x, r])[None])
    # y reads −i r
    each = Runout(probes=["x@0.5", "y@0.5"]).added_to(PLAIN).response(np.concatenate([x, r, [-1e-6, -2e-6]])[None])
    assert each == pytest.approx(circle, abs=1e-15)


def test_a_machine_as_drawn_has_vectors_for_the_probes_of_each_plane_and_of_all():
    assert [str(each) for each in Runout().locations(DRAWN)] == [
        "at 0.1 m",
        "at 0.5 m",
        "each probe at 0.1 m",
        "each probe at 0.5 m",
        "each probe at 0.1, 0.5 m",
    ]
    check_effect(dataclasses.replace(Runout()), on=SETTINGS)


@pytest.mark.parametrize("probes", [["z@0.1"], ["x"], ["x@0.1", "x@0.1"]])
def test_what_is_no_probe_is_refused(probes):
    with pytest.raises(SettingError, match="probes: expected"):
        Runout(probes=probes)


def test_the_unknowns_are_eliminated_at_a_point_whatever_its_unbalance():
    """Data without noise: at the true bearings the vectors and the unbalance are those of the truth, and nothing is left."""
    [*_, effect] = Runout().locations(DRAWN)
    problem = effect.added_to(PLAIN)
    truth = np.concatenate([REFERENCE, effect.draw(PLAIN, np.random.default_rng(0))])
    values = problem.response(truth[None])[0]
    measurement = Measurement(PLAIN.speed, PLAIN.channels, values, Noise(0.01, 1e-9), "made")
    u = problem.parameters.to_cube(truth)
    other = PLAIN.parameters.names.index("u")
    points = np.tile(u[: len(REFERENCE)], (2, 1))
    points[0, other] *= 0.3
    points[1, 0] *= 0.8
    found = eliminated(Case(problem, measurement), points, np.full(8, 0.5))
    assert found.points[0] == pytest.approx(u, abs=1e-9)
    assert found.misfits[0] < 1e-12 < found.misfits[1]

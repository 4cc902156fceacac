"""Repeats within runs and runs that are alike: the noise that they tell, and a test between runs that keeps its level."""

import dataclasses

import numpy as np
import pytest

import ksmea
from campaigns import TRIAL, layout_of, measured
from ksmea.fits.repeats import repeats
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.speeds import equal_speeds
from ksmea.show.text import repeat_lines
from ksmea.studies.hausman import repeats_of
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

PROBLEM = ThreeDisk(sensors=[0.1, 0.5]).build()
SPEED = np.linspace(200, 1500, 12)
NOISE = Noise(0.004, 1e-7)


def _mean(speed):
    """Any response will do: repeats know no model. From 1 to 100 µm."""
    channel = np.arange(1, 5)
    return 1e-6 * np.exp(4.6 * (speed[:, None] - 200) / 1300 + 1j * channel * speed[:, None] / 300)


def _measured(rng, times, n_run=3, kind="complex", noise=NOISE, factor=(1.0, 1.0, 1.0), own_noise=False):
    """Runs without weights and one with, each speed `times` measured in each; the response of each run has a factor."""
    runs = [*((f"run{number}", ()) for number in range(1, n_run + 1)), ("trial", (TRIAL,))]
    speed = np.repeat(SPEED, times)
    layout = layout_of(PROBLEM, [speed] * len(runs), runs, kind)
    gains = np.repeat([*factor[:n_run], 2.0], len(speed))[:, None]
    values = observe(gains * _mean(layout.speed), kind, noise, rng)
    campaign = dataclasses.replace(layout.campaign, own_noise=own_noise)
    return Measurement(layout.speed, layout.channels, values, None, "made", False, campaign)


def test_speeds_are_equal_within_a_tolerance():
    groups = equal_speeds(np.array([300.0, 100.0, 100.005, 100.02, 300.01]))
    assert [group.tolist() for group in groups] == [[1, 2], [3], [0, 4]]


@pytest.mark.parametrize("kind, dimensions", [("amplitude", 1), ("complex", 2)])
def test_repeats_tell_the_noise(kind, dimensions):
    found = repeats(_measured(np.random.default_rng(2), times=4, kind=kind))
    assert found.degrees == 4 * 12 * 4 * 3 * dimensions  # runs × speeds × channels × (times − 1)
    [(relative, floor)] = found.noise.levels
    # half of the cells tell each part: a few hundred degrees of freedom, 1/√(2 · 250) = 4.5 %; 4 standard errors
    assert relative == pytest.approx(0.004, rel=0.2) and floor == pytest.approx(1e-7, rel=0.2)


def test_runs_without_repeats_are_the_repeats():
    found = repeats(_measured(np.random.default_rng(3), times=1))
    assert found.are_runs and found.between is None
    assert found.degrees == 12 * 4 * 2 * 2  # three runs that are alike; the trial run is not
    assert found.noise.levels[0][0] == pytest.approx(0.004, rel=0.4)


@pytest.mark.parametrize("kind", mostly_slow(["amplitude", "complex"], but=["complex"]))
@pytest.mark.parametrize("own_noise", mostly_slow([False, True], but=[False]))
def test_runs_that_are_alike_are_rarely_said_to_differ(kind, own_noise):
    """At p < 0.05 in 5 % of draws: of 400, 20 ± 4.4; the noise is estimated, from two repeats of each."""
    rng = np.random.default_rng(7)
    p = np.array([repeats(_measured(rng, 2, kind=kind, own_noise=own_noise)).between.p for _ in range(400)])
    assert 4 <= np.sum(p < 0.05) <= 33  # 3 standard errors
    assert 0.4 < np.mean(p) < 0.65


def test_a_run_that_differs_is_named():
    """1.5 % of the response, 4 times the noise of large ones."""
    found = repeats(_measured(np.random.default_rng(4), times=3, factor=(1.0, 1.0, 1.015)))
    assert found.between.p < 1e-6 and found.between.ratio > 4
    assert [each.what for each in found.standing_out if each.what.startswith("run")] == ["run run3"]
    [said] = repeat_lines(repeats_of(_measured(np.random.default_rng(4), times=3, factor=(1.0, 1.0, 1.015))))
    assert said.startswith("repeats differ by 0.4") and "times as much (p " in said and "run run3 (" in said


def test_runs_with_unknowns_of_their_own_are_not_alike():
    data = _measured(np.random.default_rng(5), times=2, factor=(1.0, 1.0, 1.5))
    own = dataclasses.replace(data, campaign=dataclasses.replace(data.campaign, own=("u",)))
    assert repeats(own).between is None


def test_data_without_repeats_say_nothing():
    alone = _measured(np.random.default_rng(6), times=1, n_run=1)
    assert repeats(alone) is None and repeats_of(alone) is None and not list(repeat_lines(None))


def test_an_identification_says_it():
    one_plane = ThreeDisk(n_speed=9).build()
    speed = np.repeat(one_plane.speed, 2)
    data = measured(one_plane, layout_of(one_plane, [speed, speed], [("first", ()), ("second", ())]))
    text = str(ksmea.identify(one_plane, data, intervals="none"))
    assert "repeats differ by " in text and "(72 degrees of freedom); runs with the same weights differ no more" in text

"""How the speed of a run went, from its rows, and what a diagnosis makes of that."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import SpeedHistory
from ksmea.plugins import registry
from ksmea.problem.parameters import Prior
from ksmea.studies.diagnosis_remarks import sweep_remarks
from ksmea.studies.library import library
from measurements.sweeps import speed_history
from problems.rk4_two_disk import RK4TwoDisk

TURNS = np.sqrt(100.0**2 + 4 * np.pi * 20.0 * np.arange(150))  # rad/s at each turn, of a run-up at 20 rad/s²
SWEEP = "run_up_acceleration"


def test_times_say_the_rate_and_the_direction():
    time = np.linspace(0.0, 10.0, 60)
    for rate, direction in ((7.0, "run-up"), (-7.0, "coast-down")):
        found = speed_history(100.0 + rate * time, time)
        assert (found.direction, found.from_times, found.is_constant) == (direction, True, True)
        assert found.rate == pytest.approx(rate)
    assert not speed_history(100.0 + time**2, time).is_constant


def test_a_row_per_turn_says_the_rate():
    """Rising rows may have been sorted, so that they do not say which way; falling ones have not."""
    rng = np.random.default_rng(0)
    noisy = TURNS + rng.normal(0, 0.02, len(TURNS))
    assert speed_history(noisy, None).direction == "either"
    assert speed_history(noisy, None).rate == pytest.approx(20.0, rel=0.01)
    falling = speed_history(noisy[::-1], None)
    assert falling.direction == "coast-down" and falling.rate == pytest.approx(-20.0, rel=0.01)


def test_rows_that_are_even_in_time_say_no_rate():
    """Ω grows evenly with a little noise: Ω² over the rows is no straight line."""
    speed = np.linspace(100.0, 250.0, 150) + np.random.default_rng(1).normal(0, 0.05, 150)
    assert speed_history(speed, None) == SpeedHistory("either")


def test_rows_to_a_whole_rpm_are_no_grid():
    """Steps of a slow sweep that are rounded to 2, 3 and 4 rpm follow no grid."""
    rpm = np.round(np.linspace(1000.0, 1400.0, 150) + np.random.default_rng(1).normal(0, 0.3, 150))
    assert np.all(np.diff(rpm) > 0) and speed_history(rpm * np.pi / 30, None) == SpeedHistory("either")


@pytest.mark.parametrize(
    ("speed", "time"),
    [
        (np.linspace(100.0, 250.0, 150), None),  # a grid
        (np.r_[100:150:25j, 150.5:160:20j, 162:250:44j], None),  # a grid that is finer at a critical speed
        (np.cumsum(np.repeat([5, 1, 0.25, 1, 5, 0.5, 5], [12, 6, 8, 6, 9, 10, 9])) + 100.0, None),
        (TURNS[:40], None),  # few
        (np.where(np.arange(150) % 2, TURNS, TURNS[::-1]), None),  # in no order
        (np.where(np.arange(150) % 2, TURNS, TURNS[::-1]), np.arange(150.0)),
    ],
)
def test_steady_states_have_none(speed, time):
    assert speed_history(speed, time) is None


def seen(history=None, *directions, histories=(None, None)):
    """A measurement with that history, or of runs in these directions."""
    runs = tuple(
        Run(f"run{index}", 75, (), direction, history=own)
        for index, (direction, own) in enumerate(zip(directions, histories))
    )
    return Measurement(
        TURNS,
        (Channel(0.12, "x"),),
        np.ones((150, 1)),
        None,
        "",
        campaign=Campaign(runs) if runs else None,
        history=history,
    )


@pytest.mark.parametrize(
    ("measurement", "where"),
    [
        (seen(), None),
        (seen(SpeedHistory("run-up")), "run-up"),
        (seen(SpeedHistory("either")), "whole rotor"),  # run-up and coast-down apart
        (seen(None, "up", "up"), "runs up"),
        (seen(None, "down", "down"), "runs down"),
        (seen(None, "steady", "steady"), None),
        (seen(None, "up", "down"), "runs up and down"),
        (seen(None, "down", "steady"), "runs down"),
        (seen(None, "up", ""), None),
    ],
)
def test_a_sweep_is_tried_where_something_speaks_for_one(measurement, where):
    tried, _ = library((), (), measurement)
    asked, _ = library((SWEEP,), (), measurement)
    assert (SWEEP in tried) == (where is not None)
    assert str(asked[SWEEP]) == (where or "whole rotor")


PROBLEM = RK4TwoDisk(n_speed=20).build()
VALUES = np.array([RK4TwoDisk().reference()[name] for name in PROBLEM.parameters.names])


def test_a_rate_from_times_is_known_to_a_tolerance_and_an_exact_one_is_no_unknown():
    """Its standard deviation is half of the difference between the halves of the run, and the error of the closed form."""
    effect = registry.create("effect", SWEEP, {}).seen_in(seen(SpeedHistory("run-up", (19.0, 21.0), True)))
    [item] = effect.parameters(PROBLEM)
    assert (item.prior.value, item.prior.sd) == pytest.approx((20.0, np.hypot(1.0, 0.02 * 20.0)))
    assert item.lower == 0 and item.upper > 20.0 + 5 * item.prior.sd
    assert effect.path(PROBLEM)[-1] == pytest.approx(20.0)
    known = dataclasses.replace(effect, rate_sd=None)
    assert known.parameters(PROBLEM) == ()
    found = known.added_to(PROBLEM).response(VALUES[None])
    expected = effect.added_to(PROBLEM).response(np.append(VALUES, 20.0)[None])
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_rate_from_rows_is_the_limit_by_half():
    effect = registry.create("effect", SWEEP, {}).seen_in(seen(SpeedHistory("run-up", (20.0, 20.0))))
    [item] = effect.parameters(PROBLEM)
    assert item.prior is None and (item.lower, item.upper) == pytest.approx((0.0, 30.0))


def test_each_run_of_a_campaign_has_its_own_rate():
    """From times a prior, without times limits; a further run has that of the first run which goes its way, a steady one none."""
    timed = seen(None, "up", "down", histories=(None, SpeedHistory("coast-down", (-20.0, -20.0), True)))
    effect = registry.create("effect", SWEEP, {}).seen_in(timed).placed_on(PROBLEM)
    up, down = effect.parameters(PROBLEM)
    assert (up.name, down.name) == ("acceleration_run0", "acceleration_run1")
    assert up.prior is None and (up.lower, up.upper) == pytest.approx((0.0, 30.0), rel=0.01)  # a row per turn
    assert down.prior.value == pytest.approx(-20.0) and down.upper == 0.0
    names = [[item.name for item in effect.going(run).parameters(PROBLEM)] for run in timed.campaign.runs]
    assert names == [[up.name], [down.name]]
    further, still = (effect.going(Run("further", 20, direction=way)) for way in ("down", "steady"))
    assert [item.name for item in further.parameters(PROBLEM)] == [down.name] and still.parameters(PROBLEM) == ()
    one = further.added_to(PROBLEM).response(np.append(VALUES, -20.0)[None])
    other = still.added_to(PROBLEM).response(VALUES[None])
    assert other == pytest.approx(PROBLEM.response(VALUES[None]), rel=1e-12)
    assert np.abs(one - other).max() > 0.1 * np.abs(other).max()


def fitted(prior=None):
    """A diagnosis that ends at a rate of 18 [17, 19] rad/s²."""
    items = (SimpleNamespace(prior=None), SimpleNamespace(prior=prior))
    names = SimpleNamespace(names=("kxx", "acceleration"), items=items)
    estimate = SimpleNamespace(x=np.array([1.0, 18.0]), intervals=[None, SimpleNamespace(low=17.0, high=19.0)])
    best = SimpleNamespace(problem=SimpleNamespace(parameters=names))
    return SimpleNamespace(best=best, best_estimate=estimate, interval_level=0.95)


def test_the_rate_of_the_fit_stands_beside_that_of_the_rows():
    found = fitted()
    [apart] = sweep_remarks(found, seen(SpeedHistory("run-up", (20.0, 20.0))))
    [near] = sweep_remarks(found, seen(SpeedHistory("run-up", (18.5, 18.5), True)))
    assert apart.startswith("the rows, if each is a turn") and "they disagree" in apart
    assert near.startswith("the times give") and near.endswith("they agree")
    assert "approximation" in sweep_remarks(found, seen(SpeedHistory("run-up", (10.0, 26.0))))[0]
    assert sweep_remarks(found, seen()) == sweep_remarks(found, seen(SpeedHistory("run-up"))) == ()


def test_a_rate_of_times_is_judged_by_its_pull():
    """The interval is of times and data together, so that it would hold the rate of the times too often."""
    history = SpeedHistory("run-up", (22.0, 22.0), True)
    [near] = sweep_remarks(fitted(Prior(22.0, 2.0)), seen(history))
    [apart] = sweep_remarks(fitted(Prior(22.0, 1.0)), seen(history))
    assert near.endswith("they agree") and "22.0 ± 2" not in near and "± 19 rpm/s" in near
    assert "they disagree" in apart

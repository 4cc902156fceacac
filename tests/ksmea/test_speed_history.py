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
from ksmea.studies.diagnosis_remarks import sweep_remarks
from ksmea.studies.library import library
from ksmea.units import RPM
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


def seen(history=None, *directions):
    """A measurement with that history, or of runs in these directions."""
    runs = tuple(Run(f"run{index}", 75, (), direction) for index, direction in enumerate(directions))
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
    ("measurement", "direction"),
    [
        (seen(), None),
        (seen(SpeedHistory("run-up")), "run-up"),
        (seen(SpeedHistory("either")), "either"),
        (seen(None, "up", "up"), "run-up"),
        (seen(None, "down", "down"), "coast-down"),
        (seen(None, "steady", "steady"), None),
        (seen(None, "up", "down"), "run-up"),  # at one rate, which has the other sign in the run down
        (seen(None, "up", "steady"), "run-up"),
        (seen(None, "up", ""), None),
    ],
)
def test_a_sweep_is_tried_where_something_speaks_for_one(measurement, direction):
    tried, _ = library((), (), measurement)
    asked, _ = library((SWEEP,), (), measurement)
    assert (SWEEP in tried) == (direction is not None)
    assert asked[SWEEP].direction == (direction or "either")


def test_a_known_rate_is_the_limit_by_half_or_no_unknown():
    effect = registry.create("effect", SWEEP, {}).seen_in(seen(SpeedHistory("run-up", (20.0, 20.0), True)))
    problem = RK4TwoDisk(n_speed=20).build()
    [item] = effect.parameters(problem)
    assert (item.lower, item.upper) == pytest.approx((0.0, 30.0))
    assert effect.path(problem)[-1] == pytest.approx(30.0)
    known = dataclasses.replace(effect, rate=20.0 / RPM)
    x = np.array([RK4TwoDisk().reference()[name] for name in problem.parameters.names])
    found, expected = (
        known.added_to(problem).response(x[None]),
        effect.added_to(problem).response(np.append(x, 20.0)[None]),
    )
    assert found == pytest.approx(expected, rel=1e-9)


def test_the_rate_of_the_fit_stands_beside_that_of_the_rows():
    names = SimpleNamespace(names=("kxx", "acceleration"))
    estimate = SimpleNamespace(x=np.array([1.0, 18.0]), intervals=[None, SimpleNamespace(low=17.0, high=19.0)])
    best = SimpleNamespace(problem=SimpleNamespace(parameters=names))
    found = SimpleNamespace(best=best, best_estimate=estimate)
    [apart] = sweep_remarks(found, SpeedHistory("run-up", (20.0, 20.0)))
    [near] = sweep_remarks(found, SpeedHistory("run-up", (18.5, 18.5), True))
    assert apart.startswith("the rows, if each is a turn") and "they disagree" in apart
    assert near.startswith("the times give") and near.endswith("they agree")
    assert "approximation" in sweep_remarks(found, SpeedHistory("run-up", (10.0, 26.0)))[0]
    assert sweep_remarks(found, None) == sweep_remarks(found, SpeedHistory("run-up")) == ()

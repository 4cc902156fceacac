"""Effects that are not linear in the motion: 3X by two routes, the direction of a run, and what they are refused beside."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.channel import Channel
from ksmea.plugins import registry
from ksmea.problem.campaign_problem import CampaignProblem
from problems.rk4_two_disk import RK4TwoDisk

SETTINGS = RK4TwoDisk(sensors=[0.12, 0.44], directions=["x", "y"], n_speed=12)
PLAIN = SETTINGS.build()
TRUTH = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])
VALUES = {"bilinear_stiffness": [2e4, 8e-6], "clearance_rub": [2e4, 8e-6, 0.2], "cubic_stiffness": [2e13]}


def place(name):
    return registry.create("effect", name, {}).locations(PLAIN)[0]


@pytest.mark.parametrize("name", VALUES)
def test_at_3x_it_is_seen_by_either_route(name):
    channels = (*PLAIN.channels, *(dataclasses.replace(channel, harmonic=3.0) for channel in PLAIN.channels))
    problem = place(name).added_to(PLAIN).at(PLAIN.speed, channels)
    x = np.concatenate([TRUTH, VALUES[name]])[None]
    found = problem.response(x)
    assert np.abs(found - problem.dense_response(x)).max() < 1e-7 * np.abs(found).max()
    assert np.abs(found[..., 4:]).max() > 1e-4 * np.abs(found[..., :4]).max()
    none = np.concatenate([TRUTH, np.zeros(len(VALUES[name]))])[None]
    assert np.abs(problem.response(none)[..., 4:]).max() == 0


def ways(direction):
    """A run whose speed goes that way."""
    return Run(direction, 1, direction=direction)


def test_a_stiff_spring_is_met_on_the_large_motion_up_and_on_the_small_one_down():
    """With four times the unbalance the curve folds."""
    speed = np.linspace(150.0, 230.0, 41)
    problem = place("cubic_stiffness").added_to(PLAIN).at(speed, [Channel(0.44, "y")])
    x = np.concatenate([TRUTH * np.where([name.startswith("u") for name in PLAIN.parameters.names], 4.0, 1.0), [4e13]])
    up, down = (np.abs(problem.going(ways(direction)).response(x[None])[0, :, 0]) for direction in ("up", "down"))
    apart = up > 1.5 * down
    assert 1 <= apart.sum() <= 20 and np.all(up > 0.9 * down)
    assert np.array_equal(problem.going(ways("steady")).response(x[None]), problem.going(ways("up")).response(x[None]))


def test_of_several_steady_motions_that_next_to_a_given_one_is_met_whichever_way_a_run_goes():
    """In a run by itself, and in two runs of one machine, where each has its own. A stop that is touched with four times the unbalance."""
    speed, seen = np.linspace(190.0, 260.0, 36), [Channel(0.4, axis) for axis in "xy"]
    stop = registry.create("effect", "clearance_rub", {"position": 0.4}).added_to(PLAIN)
    x = np.concatenate([TRUTH * np.where(np.isin(PLAIN.parameters.names, ["u1", "u2"]), 4.0, 1.0), [1e5, 45e-6, 0.02]])
    run = stop.at(speed, seen)
    up, down = (run.going(ways(direction)).response(x[None])[0] for direction in ("up", "down"))
    assert np.abs(up - down).max() > 0.3 * np.abs(down).max()
    for going, other in (("up", down), ("down", up)):
        assert run.going(ways(going)).next_to(other).response(x[None])[0] == pytest.approx(other, rel=1e-6, abs=1e-12)
    runs = Campaign((Run("a", 36, (), "up"), Run("b", 36, (), "down")))
    both = CampaignProblem(stop.at(np.tile(speed, 2), seen), runs)
    swapped = np.concatenate([down, up])
    assert both.next_to(swapped).response(x[None])[0] == pytest.approx(swapped, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("name", VALUES)
@pytest.mark.parametrize("other", ["run_up_acceleration", "shaft_asymmetry"])
def test_what_moves_at_other_frequencies_is_refused_beside_it(name, other):
    with pytest.raises(SettingError, match="expected forces that are linear in the motion together with"):
        registry.create("effect", other, {}).added_to(place(name).added_to(PLAIN))

"""Synthetic data of several runs: the first run is as it would be alone, the others carry what they say."""

import dataclasses
import json

import numpy as np
import pytest

import ksmea
from bench.plan.plan import component_seeds, generator
from ksmea.errors import SettingError
from ksmea.measurement.campaign import Run, notation, weights_of
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned
from ksmea.units import DEGREE, GRAM_MILLIMETRE
from measurements.synthetic import Synthetic
from problems.effects.thermal_bow import ThermalBow
from problems.rk4_two_disk import RK4TwoDisk
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.5], n_speed=9)
RUNS = ["bare", "150@0.2", "150@0.2@30+80@1@-90"]
NOISY = {"kind": "complex", "relative": 0.05, "floor": 0.1}


def made(**settings):
    """A measurement, and what it was made from, always by the same seeds."""
    source = Synthetic(**NOISY | settings)
    truth = source.true_values(PROBLEM)
    streams = [generator(component_seeds(3, 0)[name]) for name in ("noise", "hidden")]
    return source.measure(PROBLEM, truth, *streams), source


def hidden_by(source):
    return source.hidden_effects(PROBLEM, generator(component_seeds(3, 0)["hidden"]))


@pytest.mark.parametrize(
    "settings", [{}, {"hidden": ["runout", "mass"]}, {"kind": "amplitude"}, {"phase_known": False}]
)
def test_the_first_run_is_the_same_whatever_follows(settings):
    alone, source = made(**settings)
    campaign, of_runs = made(**settings, runs=RUNS)
    assert alone.campaign is None and len(campaign.campaign.runs) == 3
    first = campaign.rows[0]
    np.testing.assert_array_equal(campaign.values[first], alone.values)
    np.testing.assert_array_equal(campaign.speed[first], alone.speed)
    assert hidden_by(source) == hidden_by(of_runs)


def test_each_run_carries_its_weights_and_has_noise_of_its_own():
    still = {"relative": 0.0, "floor": 0.0, "noise_known": False}
    campaign, _ = made(**still, runs=RUNS)
    problem = PROBLEM.build()
    x = np.array([PROBLEM.reference()[name] for name in problem.parameters.names])[None]
    one = problem.with_unbalance(0.2, 150 * GRAM_MILLIMETRE, 30 * DEGREE)
    both = one.with_unbalance(1.0, 80 * GRAM_MILLIMETRE, -90 * DEGREE)
    expected = [problem, problem.with_unbalance(0.2, 150 * GRAM_MILLIMETRE, 0.0), both]
    for rows, run in zip(campaign.rows, expected):
        np.testing.assert_allclose(campaign.values[rows], run.response(x)[0], rtol=1e-12)
    twice, _ = made(runs=["bare", "bare"])
    first, second = (twice.values[rows] for rows in twice.rows)
    assert np.all(first != second) and np.abs(first - second).max() < 0.5 * np.abs(first).max()


def test_what_is_hidden_acts_in_all_runs():
    """A runout is what a bare run and one with a weight have in common, whatever the weight."""
    runs = ["bare", "150@0.2", "300@0.2"]
    plain, _ = made(relative=0.0, floor=1e-9, runs=runs)
    hiding, _ = made(relative=0.0, floor=1e-9, runs=runs, hidden=["runout"], sizes={"runout_x": 3.0, "runout_y": 4.0})
    shift = (hiding.values - plain.values).reshape(3, 9, 4)
    np.testing.assert_allclose(shift, np.broadcast_to(shift[:1], shift.shape), atol=1e-12)
    assert np.abs(shift).max() == pytest.approx(5e-6, rel=0.5)


# Which way the speed goes.

BOTH_WAYS = {"runs": ["bare", "bare"], "directions": ["up", "down"]}
STILL = {"relative": 0.0, "floor": 0.0, "noise_known": False}


def stream(seed=3):
    return generator(component_seeds(seed, 0)["hidden"])


def test_a_hidden_thermal_bow_grows_through_runs_up_and_down():
    sizes = {"thermal_bow_x": 20.0, "thermal_bow_y": -10.0}
    campaign, source = made(**STILL, **BOTH_WAYS, hidden=["thermal_bow"], sizes=sizes)
    assert [run.direction for run in campaign.campaign.runs] == ["up", "down"]
    plain = PROBLEM.build()
    x = np.array([*(PROBLEM.reference()[name] for name in plain.parameters.names), 20e-6, -10e-6])[None]
    bow = ThermalBow(speeds=[float(plain.speed[0]), float(plain.speed[-1])], grown=[0.0, 1.0], of_run="up")
    ways = (Run("", 1, direction=direction) for direction in ("up", "down"))
    up, down = (bow.going(way).added_to(plain).response(x)[0] for way in ways)
    first, second = (campaign.values[rows] for rows in campaign.rows)
    np.testing.assert_allclose(first, up, rtol=1e-9)
    np.testing.assert_allclose(second, down, rtol=1e-9)
    assert np.abs(second - first).max() > 0.1 * np.abs(first).max()
    [told] = hidden_by(source)
    assert told.location == "half sine between the bearings in runs up and down"
    assert [part.value for part in told.parameters] == pytest.approx([20, -10])


@pytest.mark.parametrize("name", ["thermal_bow", "cubic_stiffness", "run_up_acceleration", "mass"])
def test_the_model_with_what_is_hidden_responds_as_the_data_of_each_run_do(name):
    source = Synthetic(kind="complex", hidden=[name], phase_known=False, **BOTH_WAYS)
    truth = source.true_values(PROBLEM)
    machine = aligned(PROBLEM.build(), source.layout(PROBLEM))
    problem, theta = source.with_hidden(PROBLEM, machine, stream())
    x = np.array([*(truth[each] for each in machine.parameters.names), *theta])[None]
    found = source.response(PROBLEM, truth, stream())
    np.testing.assert_allclose(problem.response(x)[0], found, rtol=1e-9)
    [told] = source.hidden_effects(PROBLEM, stream())
    own = problem.parameters.items[-len(theta) :]
    assert [part.value * item.si_per_unit for part, item in zip(told.parameters, own)] == pytest.approx(theta)
    dense = dataclasses.replace(source, route="dense").response(PROBLEM, truth, stream())
    assert np.abs(dense - found).max() < 1e-8 * np.abs(found).max()


def test_a_hidden_spring_is_met_on_the_large_motion_up_and_on_the_small_one_down():
    """Soft supports with four times the unbalance and bearings that stiffen fold the resonance curve."""
    rig = RK4TwoDisk(sensors=[0.44], directions=["y"], speed_from=1432.0, speed_to=2196.0, n_speed=41)
    source = Synthetic(
        kind="complex",
        truth={"u1": 12.0, "u2": 6.0},
        hidden=["cubic_stiffness"],
        sizes={"cubic_stiffness": 0.04},
        **BOTH_WAYS,
    )
    [told] = source.hidden_effects(rig, stream(1))
    assert told.location == "all bearings"
    up, down = np.split(np.abs(source.response(rig, source.true_values(rig), stream(1))[:, 0]), 2)
    apart = up > 1.5 * down
    assert 1 <= apart.sum() <= 20 and np.all(up > 0.9 * down)
    assert up[~apart] == pytest.approx(down[~apart], rel=0.05)


def test_runs_that_all_go_up_are_those_of_which_nothing_is_said():
    """A bow grows from the lowest speed to the highest in either, and every draw is the same."""
    said, source = made(hidden=["thermal_bow"], runs=["bare", "bare"], directions=["up", "up"])
    unsaid, of_unsaid = made(hidden=["thermal_bow"], runs=["bare", "bare"])
    np.testing.assert_array_equal(said.values, unsaid.values)
    assert hidden_by(source) == hidden_by(of_unsaid)


def test_what_does_not_depend_on_it_is_the_same_whichever_way_the_speed_goes():
    hidden = ["runout", "mass"]
    said, source = made(hidden=hidden, **BOTH_WAYS)
    unsaid, of_unsaid = made(hidden=hidden, runs=BOTH_WAYS["runs"])
    np.testing.assert_array_equal(said.values, unsaid.values)
    assert hidden_by(source) == hidden_by(of_unsaid)


@pytest.mark.parametrize("settings", [{}, BOTH_WAYS, {"harmonics": [2.0]}, {"kind": "amplitude"}])
@pytest.mark.parametrize("name", registry.registered("effect"))
def test_no_effect_looks_at_values_to_say_how_it_acts(name, settings):
    """Hidden effects are asked before there are any."""
    measurement, _ = made(**settings)
    nothing = dataclasses.replace(measurement, values=np.zeros_like(measurement.values))
    effect = registry.create("effect", name, {})
    assert effect.seen_in(nothing) == effect.seen_in(measurement)


@pytest.mark.parametrize(
    "settings, message",
    [
        (
            {"directions": ["up", "dwn"]},
            r"unknown direction in directions: 'dwn'; did you mean 'down'\? known: down, steady, up",
        ),
        ({"directions": ["up"]}, "directions: expected one for each of runs, which are 2, got 1; give as many"),
        ({"directions": ["up"], "runs": []}, "directions: expected one for each of runs, which are 0, got 1"),
        ({"directions": ["up", "down", "up"]}, "directions: expected one for each of runs, which are 2, got 3"),
    ],
)
def test_directions_that_do_not_fit_the_runs_are_refused_in_one_line(settings, message):
    with pytest.raises(SettingError, match=message) as caught:
        Synthetic(**{"runs": ["bare", "bare"]} | settings)
    assert "\n" not in str(caught.value)


def test_a_run_reads_back_from_its_word():
    for run in ("bare", "150@0.2", "150@0.2@30", "0.5@0.123456789@-12.5+80@1"):
        assert notation(weights_of(run)) == run


@pytest.mark.parametrize(
    "run", ["", "bar", "150", "150@", "150@0.2@30@1", "-1@0.2", "0@0.2", "nan@0.2", "1@inf", "1@1++1@1"]
)
def test_a_word_that_is_no_run_is_refused_in_one_line(run):
    with pytest.raises(SettingError, match=r"runs: expected bare, or weights such as 150@0\.2@30") as caught:
        Synthetic(runs=[run])
    assert "\n" not in str(caught.value)


def test_a_weight_off_the_shaft_is_refused(enter):
    ended = enter("+experiment=plan", "measurement.runs=[bare,150@7]")
    assert ended.code == 2 and "run run2, weight 150 g mm at 7 m, 0°" in ended.err and ended.err.count("\n") == 1


def test_from_python_a_weight_makes_the_unbalance_known():
    """Far below the first critical speed one run shows the unbalance over a stiffness alone."""
    rotor = ksmea.load_problem("three_disk", speed_from=20.0, speed_to=100.0, n_speed=20)
    widths = []
    for runs in ([], ["bare", "200@0.5"]):
        data = ksmea.synthetic_measurement(rotor, relative=0.02, kind="complex", runs=runs, rng=1)
        found = ksmea.identify(rotor, data, intervals="information")["u"]
        widths.append((found.high or 500.0) - (found.low or 50.0))
    assert widths[1] < 0.1 * widths[0]


@pytest.mark.parametrize(
    "words",
    [
        [
            "+experiment=identify",
            "measurement=synthetic",
            "optimizer.screening=99",
            "optimizer.starts=1",
            "study.intervals=none",
        ],
        ["+experiment=identifiability", "study.variations=[]"],
        ["+experiment=plan", "study.sensors=0", "study.add=2"],
        ["+experiment=diagnose", "study.effects=[mass]", "study.locate=false", "study.screening=256", "study.starts=2"],
    ],
)
def test_every_study_takes_them_from_the_command_line(enter, words):
    name = words[0].partition("=")[2]
    data = ["measurement.kind=complex", "measurement.relative=0.05", "problem.n_speed=20", "repetitions=1"]
    ended = enter(*words, *data, "measurement.runs=[bare,150@0.2,150@0.2@30+80@1@-90]", output=f"results/{name}")
    assert ended.code == 0, ended.err
    [cell] = ended.cells()
    assert cell["settings"]["measurement"]["runs"] == RUNS
    assert json.loads((ended.output / "plan.jsonl").read_text().splitlines()[0])["command"][-1].endswith("80@1@-90]")

"""Statements of effects: a sentence with size, angle and place in the reader's own notation."""

import re
from importlib.metadata import entry_points

import numpy as np
import pytest

from ksmea.measurement.notation import Notation
from ksmea.plugins import registry
from ksmea.records.estimate import EstimateRecord
from ksmea.records.statement import SizeRecord, StatementRecord, of_unknowns
from ksmea.show.statements import intervals, sentence
from problems.effects.probe_rotation import ProbeRotation
from problems.effects.run_up_acceleration import RunUpAcceleration
from problems.effects.runout import Runout
from problems.effects.unequal_bearings import UnequalBearings
from problems.three_disk import ThreeDisk

NAMES = sorted(point.name for point in entry_points(group="ksmea.effects"))
OWN = Notation("mil", "pp", "lag", names={"x at 0.1 m": "3X", "y at 0.1 m": "3Y"})


def estimated(name, value, half, unit):
    return EstimateRecord(name, unit, value, value - half, value + half, "gauss-newton", False)


def sizes(*estimates, correlation=0.0):
    count = len(estimates)
    matrix = np.full((count, count), correlation) + (1 - correlation) * np.eye(count)
    return of_unknowns({each.name: each for each in estimates}, matrix)


def test_a_runout_is_said_in_units_and_names_of_the_file():
    """0.242 mil pp is 3.0734 µm 0-peak; a lag of 295° is a lead of 65°."""
    length, lead = 0.242 * 25.4 / 2, np.radians(65)
    found = Runout(position=0.1).statement(
        sizes(
            estimated("runout_x", length * np.cos(lead), 0.03, "µm"),
            estimated("runout_y", length * np.sin(lead), 0.03, "µm"),
        )
    )
    assert sentence(found, OWN) == "Runout of 0.242 mil pp at 295° lag, seen by 3X and 3Y"
    assert sentence(found) == "Runout of 3.07 µm 0-peak at 65° lead, seen by the probes at 0.1 m"
    assert intervals(found, OWN) == "± 0.0024 mil pp, ± 0.6°"


def test_correlated_components_know_the_length_better_than_each():
    """Along the diagonal errors of correlation −1 cancel to first order."""
    parts = estimated("bow_x", 3.0, 0.5, "µm"), estimated("bow_y", 3.0, 0.5, "µm")
    independent, opposed = sizes(*parts)["bow"], sizes(*parts, correlation=-1.0)["bow"]
    assert independent.high - independent.low == pytest.approx(1.0)  # 2 · 0.5: the same in each direction
    assert opposed.high == pytest.approx(opposed.low)


def test_equal_differences_are_said_once_and_others_apart():
    alike = sizes(
        estimated("stiffness_difference_x", 8.1, 0.2, "%"), estimated("stiffness_difference_y", 8.0, 0.4, "%")
    )
    apart = sizes(
        estimated("stiffness_difference_x", -5.0, 0.3, "%"), estimated("stiffness_difference_y", 20.0, 0.4, "%")
    )
    bearings = UnequalBearings()
    assert sentence(bearings.statement(alike)) == "Bearing 1 is 8.10 % stiffer in x and y than the other bearings"
    two = ThreeDisk(mesh=13).build()
    assert sentence(bearings.statement_on(two, alike)) == "Bearing 1 is 8.10 % stiffer in x and y than bearing 2"
    damped = UnequalBearings(bearing=2, changes="stiffness and damping").statement(
        alike | sizes(estimated("damping_difference_x", -30.0, 3, "%"), estimated("damping_difference_y", 50.0, 4, "%"))
    )
    said = "Bearing 2 is 8.10 % stiffer in x and y and damps 30 % less in x and 50 % more in y than the other bearings"
    assert sentence(damped) == said
    said = "Bearing 1 is 5.0 % softer in x and 20.0 % stiffer in y than the other bearings"
    assert sentence(bearings.statement(apart)) == said


@pytest.mark.parametrize(
    ("value", "low", "high", "said"),
    [
        (3.0, None, 6.0, "The shaft is at most 6 % stiffer"),
        (3.0, 1.0, None, "The shaft is at least 1.0 % stiffer"),
        (-3.0, None, -1.0, "The shaft is at least 1.0 % softer"),
        (-3.0, -6.0, None, "The shaft is at most 6 % softer"),
        (3.0, -1.0, None, "The shaft is 3 % stiffer"),  # no bound of how much stiffer
        (3.0, None, None, "The shaft is 3 % stiffer"),
    ],
)
def test_a_size_whose_interval_is_open_is_said_as_a_bound(value, low, high, said):
    size = {"change": SizeRecord(value, low, high, "%")}
    assert sentence(StatementRecord("shaft stiffness", "The shaft is {change:stiffer|softer}", size)) == said


def test_probes_are_turned_in_the_direction_of_their_sign(three_disk):
    turned = {
        direction: sentence(
            ProbeRotation(position=0.1, direction=direction).statement(
                sizes(estimated("probe_rotation", -7.67, 0.1, "deg"))
            )
        )
        for direction in (None, "x")
    }
    assert turned[None] == "The probes at 0.1 m are turned by 7.67° from y towards x"
    assert turned["x"] == "The probe in x at 0.1 m is turned by 7.67° from y towards x"


@pytest.mark.parametrize("name", NAMES)
def test_each_effect_has_a_sentence_with_all_its_places_filled(name, three_disk):
    """At each of its locations; also an effect without a sentence of its own."""
    for effect in registry.plugin_class("effect", name)().locations(three_disk):
        unknowns = [(each.name, each.unit) for each in effect.parameters(three_disk)]
        said = sentence(effect.statement(sizes(*(estimated(*each[:1], 2.0, 0.1, each[1]) for each in unknowns))))
        assert said[0].isupper() and not said.endswith(".")
        assert not set("{}_?") & set(said), said


def test_a_sweep_has_the_rate_of_each_run_or_none_that_is_known():
    effect = RunUpAcceleration(runs=["up", "down{2}"], rates=[60.0, -200.0], rate_sds=[1.0, 2.0])
    unknowns = [("acceleration_up", 63.5), ("acceleration_down_2", -195.0)]
    found = effect.statement(sizes(*(estimated(name, value, 0.3, "rpm/s") for name, value in unknowns)))
    said = "The speed sweeps at 63.5 rpm/s in run up and −195 rpm/s in run down{2}, too fast for steady states"
    assert sentence(found) == said
    assert sentence(RunUpAcceleration(rate=60.0).statement({})) == "The speed sweeps too fast for steady states"


@pytest.mark.parametrize("name", NAMES)
def test_each_effect_says_in_a_sentence_what_to_do_and_what_confirms_it(name):
    said = registry.plugin_class("effect", name).check_next
    if name == "local_force":  # what it is says nothing of its cause
        return
    assert len(said.split()) <= 20 and said.endswith(".") and said.count(". ") == 0
    assert re.search(r"\bconfirms?\b", said)


def test_errors_of_the_measurement_are_those_of_probes_their_signals_and_the_run():
    found = {name for name in NAMES if registry.plugin_class("effect", name).is_of_measurement}
    of_probes = {"channel_gain", "probe_position", "probe_rotation", "runout", "timing_delay"}
    assert found == of_probes | {"run_up_acceleration"}


@pytest.fixture(scope="module")
def three_disk():
    return ThreeDisk().build()


@pytest.mark.parametrize(
    ("name", "settings", "said"),
    [
        ("residual_bow", {"shapes": ["sine", "force at 0.5"]},
         "The shaft is bent by 2.83 µm 0-peak at 45° lead in its middle and by 2.83 µm 0-peak at 45° lead at most, as under a force at 0.5 m"),
        ("thermal_bow", {"shapes": ["whole"]},
         "The shaft bends as it warms up, by 2.83 µm 0-peak at 45° lead in its middle"),
        ("hub_stiffening", {"position": 0.5, "width": 0.05, "is_width_free": True},
         "The hub at 0.5 m is 2.00 % wider than 50 mm and makes the shaft 2.00 % stiffer in bending"),
        ("added_mass", {"position": 0.5, "inertia": "assumed", "radius": 0.08},
         "The rotor carries 2.00 kg more at 0.5 m with a radius of gyration of 80 mm than in the model"),
    ],
)  # fmt: skip
def test_forms_of_an_effect_say_what_they_are(three_disk, name, settings, said):
    effect = registry.create("effect", name, settings)
    unknowns = [(each.name, each.unit) for each in effect.parameters(three_disk)]
    assert sentence(effect.statement(sizes(*(estimated(*each[:1], 2.0, 0.1, each[1]) for each in unknowns)))) == said

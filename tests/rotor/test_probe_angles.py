"""Probes at any angle: what they read follows from x and y, in the model, its sensitivities and its effects."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import ksmea
from ksmea.diagnosis.further_measurement import _through_other_planes
from ksmea.errors import SettingError
from ksmea.fits.fitting import fit_from_values
from ksmea.fits.lack_of_fit import whirl_parts
from ksmea.measurement.channel import Channel, direction_at
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned, through
from ksmea.problem.case import Case
from ksmea.show.charts.planning_chart import planning_chart
from ksmea.show.planning_text import text
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.misreadings import readings
from ksmea.studies.planning import PlanningOptions, planning_study
from problems.three_disk import ThreeDisk

AT = 0.1
XY = (Channel(AT, "x"), Channel(AT, "y"))
ANGLES = (45.0, -45.0, 180.0, 30.0)
SKEW = tuple(Channel(AT, direction_at(angle)) for angle in ANGLES)
TURN = np.array([[np.cos(np.radians(angle)), np.sin(np.radians(angle))] for angle in ANGLES])  # of x and y
REFERENCE = np.array(list(ThreeDisk().reference().values()))


@pytest.fixture(scope="module")
def problem():
    return ThreeDisk(n_speed=15).build()


def seen(problem, channels):
    return through(problem, channels)


@pytest.mark.parametrize("route", ["response", "dense_response"])
def test_a_probe_reads_its_part_of_x_and_y(problem, route):
    xy = getattr(seen(problem, XY), route)(REFERENCE[None])[0]
    skew = getattr(seen(problem, SKEW), route)(REFERENCE[None])[0]
    # dense and reduced alike are linear in the row that reads: rounding alone
    assert skew == pytest.approx(xy @ TURN.T, rel=1e-9)


def test_sensitivities_turn_as_the_response_does(problem):
    xy, skew = (seen(problem, channels).sensitivity(REFERENCE) for channels in (XY, SKEW))
    assert skew == pytest.approx(np.einsum("ct,std->scd", TURN, xy), rel=1e-8, abs=1e-12 * np.abs(xy).max())


@pytest.mark.parametrize(
    ("name", "theta"), [("runout", [3e-6, -2e-6]), ("probe_rotation", [0.1]), ("residual_bow", [2e-6, 1e-6])]
)
def test_effects_read_skew_probes_as_the_motion_in_x_and_y_says(problem, name, theta):
    """A probe that is turned by φ reads what one at θ + φ reads: the second route to the rotation of probes."""
    effect = registry.create("effect", name, {})
    x = np.concatenate([REFERENCE, theta])[None]
    skew = effect.added_to(seen(problem, SKEW)).response(x)[0]
    if name == "probe_rotation":
        turned = [Channel(AT, direction_at(angle + np.degrees(theta[0]))) for angle in ANGLES]
        expected = seen(problem, turned).response(REFERENCE[None])[0]
    else:
        expected = effect.added_to(seen(problem, XY)).response(x)[0] @ TURN.T
    assert skew == pytest.approx(expected, rel=1e-9)


def test_probe_rotation_needs_two_directions_at_a_plane(problem):
    effect = registry.create("effect", "probe_rotation", {})
    pair, parallel = (Channel(AT, "45"), Channel(AT, "-45")), (Channel(AT, "45"), Channel(AT, "-135"))
    assert [str(each) for each in effect.locations(seen(problem, pair))] == ["at 0.1 m"]
    assert not effect.locations(seen(problem, parallel))
    drawn = dataclasses.replace(problem, is_as_drawn=True)  # of which one may be turned alone
    assert [str(each) for each in effect.locations(seen(drawn, pair))] == ["at 0.1 m", "45° at 0.1 m", "-45° at 0.1 m"]
    assert [str(each) for each in effect.locations(seen(drawn, parallel))] == ["45° at 0.1 m", "-135° at 0.1 m"]


@pytest.mark.parametrize("name", ["channel_gain", "timing_delay"])
def test_effects_of_one_channel_name_a_skew_one(problem, name):
    found = registry.create("effect", name, {}).locations(seen(problem, (Channel(AT, "45"), Channel(AT, "y"))))
    assert [str(each) for each in found][-2:] == ["45° at 0.1 m", "y at 0.1 m"]
    with pytest.raises(SettingError, match="direction: expected x, y or degrees from x towards y, got 'up'"):
        registry.create("effect", name, {"direction": "up"})


def test_whirl_of_a_skew_pair_is_that_of_x_and_y():
    rng = np.random.default_rng(1)
    forward, backward = rng.standard_normal((2, 7)) + 1j * rng.standard_normal((2, 7))
    xy = np.stack([forward + backward, -1j * forward + 1j * backward], axis=1)
    pair = TURN[:2]
    for channels, data in ((XY, xy), (SKEW[:2], xy @ pair.T), (SKEW[1::-1], (xy @ pair.T)[:, ::-1])):
        assert whirl_parts(data, channels)[AT] == pytest.approx(np.stack([forward, backward]), rel=1e-12)
    assert not whirl_parts(data[:, :1], SKEW[:1])


def test_swapped_axes_reflect_a_probe_and_twice_is_nothing(problem):
    data = Measurement(problem.speed, SKEW, seen(problem, SKEW).response(REFERENCE[None])[0], None, "made")
    swapped = next(each for each in readings(data) if "swapped" in each.given[0]).measurement
    assert [channel.direction for channel in swapped.channels] == ["45", "135", "-90", "60"]
    again = next(each for each in readings(swapped) if "swapped" in each.given[0]).measurement
    assert again.channels == data.channels


def test_one_skew_probe_identifies_what_it_sees():
    """As many data as a probe along x has, with both bearing directions in them."""
    rotor = ksmea.load_problem("three_disk")
    skew = aligned(rotor.problem, ksmea.synthetic_measurement(rotor, kind="complex").measurement)
    skew = through(skew, (Channel(AT, "30"),))
    values = skew.response(REFERENCE[None])[0]
    rng = np.random.default_rng(2)
    noise = 0.02 * np.abs(values) * (rng.standard_normal((2, *values.shape)).T @ [1, 1j]).T / np.sqrt(2)
    data = Measurement(skew.speed, skew.channels, values + noise, None, "made", phase_known=True)
    found = ksmea.identify(rotor, data, rng=1)
    for name, true in (("kxx", 50.0), ("kyy", 70.0), ("u", 200.0)):
        assert found[name].low < true < found[name].high


@pytest.mark.parametrize(
    ("direction", "message"),
    [
        ("90", "expected y, got '90'"),
        ("045", "expected 45"),
        ("360", "expected x"),
        ("z", "degrees"),
        ("nan", "degrees"),
    ],
)
def test_each_direction_has_one_name(direction, message):
    with pytest.raises(SettingError, match=message):
        Channel(0.1, direction)


def test_a_rotor_file_names_a_probe_by_its_angle(tmp_path):
    example = (Path(__file__).resolve().parents[2] / "docs/examples/rotor.yaml").read_text(encoding="utf-8")
    assert "direction: x}" in example
    (tmp_path / "rotor.yaml").write_text(example.replace("direction: x}", "direction: -45}", 1), encoding="utf-8")
    made = ksmea.load_problem(tmp_path / "rotor.yaml")
    assert made.problem.channels[0].direction == "-45"


def test_further_probes_are_proposed_as_those_that_there_are(problem):
    """Where two at right angles look, others add no direction, whatever they are called."""
    seen_skew = seen(problem, (Channel(AT, "45"), Channel(AT, "-45")))
    point = DesignPoint(seen_skew, REFERENCE, Noise(0.05, 0.0), "complex", noise_known=True)
    record = planning_study(point, PlanningOptions(add=0, sensors=1, trial_phases=[]))
    [probes] = record.families
    assert set(probes.candidates.direction) == {"45", "-45"} and AT not in np.round(probes.candidates.position, 9)
    assert "45° at" in text(record, "")
    (panel,) = planning_chart({"": record}).panels
    assert {each.name for each in panel.elements} >= {"probe in 45°", "probe in -45°"}
    layout = Layout(problem.speed, seen_skew.channels, "complex", "made", phase_known=True)
    values = seen_skew.response(REFERENCE[None])[0]
    measurement = Measurement(layout.speed, layout.channels, values, Noise(0.05, 0.0), "made", phase_known=True)
    further = list(_through_other_planes(fit_from_values(Case(seen_skew, measurement), REFERENCE)))
    assert {each.layout.channels[-1].direction for each in further} == {"-45"}
    assert AT not in {each.layout.channels[-1].position for each in further}
    assert further[0].words.startswith("The same with further probes in 45° and -45° at")

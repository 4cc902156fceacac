"""Bode and polar plots: phase lag without jumps, resonances and their close pairs, counted residuals, round loops."""

import numpy as np
import pytest

from bench.reports.response_blocks import orbits
from ksmea import identify, load_problem, synthetic_measurement
from ksmea.measurement.notation import Notation
from ksmea.rotordynamics.half_power import full_peaks
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Level, Line, Points, Words
from ksmea.show.charts.parts.bode import (
    close_pairs,
    lag_along,
    lags_along,
    nearest_lag,
    outside,
    phase_ticks,
    resonances,
)
from ksmea.show.charts.parts.polar import AWAY, BEYOND, HEIGHT, LABELLED, labelled, rings, speeds_at
from ksmea.show.charts.response_charts import bode_chart, nyquist_chart
from ksmea.show.charts.responses import ModelCurve, of_fit

CRITICAL = (3620, 3798, 10018, 11279)  # rpm, of the three-disk rotor


@pytest.fixture(scope="module")
def fit():
    rotor = load_problem("three_disk")
    measured = synthetic_measurement(rotor, relative=0.05, kind="complex", rng=1).measurement
    found = identify(rotor, measured, method="direct", optimizer="lm", rng=1)
    return found.record.fit


@pytest.fixture(scope="module")
def response(fit):
    return of_fit(fit)


def one_degree(damping=0.01, n=2001):
    """Receptance of a single degree of freedom whose natural speed is 1000 rpm, as two channels of opposite sign."""
    speed = np.linspace(500, 1500, n)
    ratio = speed / 1000
    value = 1 / (1 - ratio**2 + 2j * damping * ratio)
    return ModelCurve(speed, np.stack([value, -value], axis=1))


def test_a_lag_rises_by_half_a_turn_without_a_jump():
    curve = one_degree()
    for column, first in ((0, 0.0), (1, 180.0)):
        lag = lag_along(curve, column)
        assert lag[0] == pytest.approx(first, abs=2) and lag[-1] == pytest.approx(first + 180, abs=2)
        assert np.all(np.diff(lag) > 0)


def test_a_measured_lag_stands_in_the_turn_of_the_model():
    curve = one_degree()
    rows = np.arange(0, 2001, 100)
    measured = curve.values[rows, 1] * np.exp(0.1j)
    lag = nearest_lag(measured, curve.speed[rows], (), curve, 1)
    assert lag == pytest.approx(lag_along(curve, 1)[rows] - np.degrees(0.1), abs=1e-6)


@pytest.mark.parametrize("degrees", [1.0, -1.0])
def test_two_models_that_begin_on_both_sides_of_zero_stand_in_one_turn(degrees):
    """Alone, the one that begins at −1° begins at 359°; a second run and other speeds change nothing."""
    once = one_degree(damping=1e-6)
    values, start = np.tile(once.values, (2, 1)), len(once.speed)
    late = ModelCurve(np.tile(once.speed, 2), values * np.exp(-1j * np.radians(degrees)), (start,))
    early = ModelCurve(np.tile(once.speed[::2], 2), np.tile(once.values[::2], (2, 1)), (len(once.speed[::2]),))
    other = ModelCurve(early.speed, early.values * np.exp(1j * np.radians(degrees)), early.breaks)
    of_other, of_last = lags_along([other, late], 0)
    assert of_last == pytest.approx(lag_along(late, 0))
    assert np.abs(of_other - np.concatenate([of_last[:start:2], of_last[start::2]])).max() < 3


def test_runs_are_unwrapped_apart():
    once = one_degree()
    twice = ModelCurve(np.tile(once.speed, 2), np.tile(once.values, (2, 1)), (len(once.speed),))
    assert lag_along(twice, 0) == pytest.approx(np.tile(lag_along(once, 0), 2))
    assert resonances(twice) == resonances(once)


def test_a_resonance_has_its_half_power_width():
    curve = one_degree()
    [peak] = full_peaks(curve.speed, np.abs(curve.values[:, 0]))
    at, width = peak.speed, peak.width
    assert at == pytest.approx(1000, rel=1e-3) and width == pytest.approx(2 * 0.01 * 1000, rel=0.1)
    assert close_pairs([3620.0, 3798.0, 10018.0]) == [(3620.0, 3798.0)] and close_pairs([100.0, 106.0]) == []


def test_ticks_of_a_phase_are_few_and_round():
    assert phase_ticks(-20, 200) == {0: "0", 45: "45", 90: "90", 135: "135", 180: "180"}
    assert list(phase_ticks(-95, 360)) == [0, 180, 360] and list(phase_ticks(-300, 900)) == [0, 360, 720]


def test_residuals_are_counted_against_noise_alone():
    many = np.random.default_rng(1).normal(size=(1000, 2))
    expected = np.count_nonzero(np.abs(many) > 2)
    assert outside({"one": many[:, 0], "other": many[:, 1]}) == f"{expected} of 2000 outside ± 2 σ; noise alone: 91"


def test_a_bode_plot_names_its_resonances_and_shows_the_close_pair_apart(response):
    assert np.round(resonances(response.curves["fitted"])) == pytest.approx(CRITICAL, abs=2)
    chart = bode_chart(response, "title")
    titles = [stack[0].title for stack in chart.stacks]
    assert titles == [f"{name} at 0.1 m{pair}" for name in "xy" for pair in ("", ", 3620 and 3798 rpm")]
    whole, pair = chart.stacks[:2]
    assert [panel.y.label for panel in whole] == ["phase lag (°)", "amplitude (µm 0-peak)", "residual / σ"]
    named = [[each.label for each in stack[0].elements if isinstance(each, Level)] for stack in (whole, pair)]
    third, fourth = (f"{each:.0f}" for each in resonances(response.curves["fitted"])[2:])
    assert named == [["3620, 3798", "", third, fourth], ["3620", "3798"]]
    assert pair[0].x.low < 3620 and pair[0].x.high > 3798 and pair[0].x.high - pair[0].x.low < 400
    [said] = [each.text for each in whole[2].elements if isinstance(each, Words)]
    assert said.endswith("of 106 outside ± 2 σ; noise alone: 5")
    [line] = [each for each in whole[0].elements if isinstance(each, Line)]
    [dots] = [each for each in whole[0].elements if isinstance(each, Points)]
    of_model = np.interp(dots.x, line.x, line.y)
    assert np.max(np.abs(dots.y - of_model)) < 90 and np.median(np.abs(dots.y - of_model)) < 4
    assert np.max(np.abs(np.diff(line.y))) < 15  # no jump, and no corner


def test_page_and_picture_of_a_bode_plot_agree(response):
    chart = bode_chart(response, "title")
    axes, spec = picture.figure(chart).axes, interactive.plot(chart)
    layout = spec["layout"]
    sides = [layout[f"{side}axis{end}"] for side in "xy" for end in ("", *range(2, len(chart.panels) + 1))]
    assert len(axes) == len(chart.panels) == len(sides) / 2
    pair = [each for each in axes if "3798 rpm" in each.get_title()]
    for each in pair:
        assert list(each.get_xlim()) == pytest.approx(layout["xaxis4"]["range"])
    shown = {note["text"] for note in layout["annotations"]}
    drawn = {text.get_text() for each in axes for text in each.texts}
    assert drawn <= shown and {"3620, 3798", "3620", "3798"} <= drawn


def test_loops_are_round_and_speeds_are_named(response):
    chart = nyquist_chart(response)
    for column, panel in enumerate(chart.panels):
        assert panel.is_to_scale and panel.x.low == -panel.x.high
        reach = np.max(np.abs(response.measured[:, column]))
        [curve] = [each for each in panel.elements if isinstance(each, Line) and each.name == "fitted"]
        values = np.asarray(curve.x) + 1j * np.asarray(curve.y)
        assert np.nanmax(np.abs(values)) <= BEYOND * reach
        steps = np.diff(values)
        is_long = np.abs(steps) > 0.02 * reach  # longer than 3 px
        turns = np.degrees(np.abs(np.angle(steps[1:] * np.conj(steps[:-1]))))[is_long[1:] & is_long[:-1]]
        assert np.nanmax(turns) < 10
        speeds = [each.text for each in panel.elements if isinstance(each, Words) and each.has_ground]
        assert 3 <= len(speeds) <= LABELLED and all(each.isdigit() for each in speeds)


def test_numbers_of_a_polar_plot_do_not_hide_each_other():
    """The first speed, the largest amplitude and the last speed have one each; a cluster at the origin has one in all.

    Of the rings the outer one has its amplitude.
    """
    curve = one_degree(damping=0.05, n=101)
    response = curve.values[:, 0]
    chosen = labelled(response)
    assert {0, 50, 100} <= set(chosen)
    places = response[chosen] * (1 + AWAY * np.abs(response).max() / np.abs(response[chosen]))
    apart = np.abs(np.subtract.outer(places, places)[np.triu_indices(len(chosen), 1)]) / np.abs(response).max()
    assert np.all(apart > HEIGHT)
    assert labelled(np.append(1e-3 * np.exp(1j * np.arange(20)), 1.0)) == [0, 20]
    words = list(speeds_at(response, [str(each) for each in range(101)]))
    alone, beside = (
        [each for each in rings(abs(response[50]), Notation(), shown) if isinstance(each, Words)]
        for shown in ([], words)
    )
    for found in (alone, beside):
        assert [each.text for each in found if each.text.endswith("µm 0-peak")] == ["10 µm 0-peak"]


@pytest.mark.parametrize(
    ("phase", "above", "said"), [("lead", "90°", "lead anticlockwise"), ("lag", "270°", "lag clockwise")]
)
def test_a_polar_plot_counts_phases_as_the_data_do(fit, phase, above, said):
    """Axes lead anticlockwise in any notation; only their labels change."""
    chart = nyquist_chart(of_fit(fit, notation=Notation(phase=phase)))
    words = [each for each in chart.panels[0].elements if isinstance(each, Words) and each.text.endswith("°")]
    assert max(words, key=lambda each: each.y).text.strip() == above and said in chart.caption


def test_the_orbit_of_the_largest_difference_is_seen_first(response):
    seen = orbits(response)
    misfit = np.abs(response.measured - response.at_speeds["fitted"]).max(axis=1)
    said = f"the fitted model differs most from the data at {response.speed[seen.first]:.0f} rpm"
    assert seen.first == np.argmax(misfit) and said in seen.title and seen.title.endswith("µm 0-peak")


def test_a_response_in_another_notation_is_the_same_motion(fit, response):
    """25.4 µm 0-peak are 2 mil pp; σ, resonances and whether probes make a plane depend on no unit."""
    own = of_fit(fit, notation=Notation("mil", "pp", "lag", "Hz", {"x at 0.1 m": "3X"}))
    assert own.measured == pytest.approx(response.measured * 2 / 25.4)
    assert own.sd == pytest.approx(response.sd * 2 / 25.4)
    assert all(
        np.array_equal(own.residuals["fitted"][part], each) for part, each in response.residuals["fitted"].items()
    )
    found, expected = (np.array(resonances(each.curves["fitted"])) for each in (own, response))
    assert found == pytest.approx(expected / 60)
    assert own.shown_channels == ("3X", "y at 0.1 m") and own.planes().keys() == response.planes().keys()
    chart = bode_chart(own, "title")
    assert [stack[0].title for stack in chart.stacks] == [
        f"{name}{pair}" for name in own.shown_channels for pair in ("", ", 60.3 and 63.3 Hz")
    ]
    named = [each.label for each in chart.stacks[1][0].elements if isinstance(each, Level)]
    assert named == ["60.3", "63.3"] and "vertical: peaks of the model, Hz" in chart.caption
    assert [panel.y.label for panel in chart.stacks[0]] == ["phase lag (°)", "amplitude (mil pp)", "residual / σ"]


def test_an_orbit_is_as_wide_as_the_vibration_peak_to_peak(fit, response):
    """Its displacements are in mil, whichever detection amplitudes have."""
    x = np.abs(response.measured[:, 0]) / 25.4
    for detection in ("0-peak", "pp", "rms"):
        seen = orbits(of_fit(fit, notation=Notation("mil", detection, names={"x at 0.1 m": "3X"})))
        phasors = np.array(seen.planes["0.1 m (3X)"]["measured"])
        assert np.hypot(phasors[:, 0], phasors[:, 1]) == pytest.approx(x) and seen.unit == "mil"

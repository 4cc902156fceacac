"""`+experiment=diagnosis_power`: chances from closed forms, counts of draws made by hand, and its files."""

import numpy as np
import pandas as pd
import pytest
import scipy

from bench.reports.diagnosis.power import DATA, DROP, EFFECT, chance, confusion, detectable_drop, false_alarms, rates
from bench.reports.diagnosis.power_page import _rate_of, confusion_chart, detection_chart, verdicts_chart
from ksmea.show.charts.chart import Bars, Line, Points
from ksmea.show.charts.picture import figure

FEW = "study.effects=[runout,channel_gain,mass]"


def test_the_chance_of_detection_is_that_of_a_shifted_normal_for_one_unknown():
    """A noncentral χ² with one degree of freedom is the square of a normal variable with unit variance."""
    level, candidates, drop = 0.01, 5, 12.0
    edge = scipy.stats.norm.isf(level / candidates / 2)
    expected = scipy.stats.norm.sf(edge - np.sqrt(drop)) + scipy.stats.norm.cdf(-edge - np.sqrt(drop))
    assert chance(drop, 1, candidates, level) == pytest.approx(expected, rel=1e-9)


def test_nine_of_ten_see_the_smallest_detectable_size_and_more_candidates_need_more():
    assert chance(detectable_drop(2, 40, 0.005), 2, 40, 0.005) == pytest.approx(0.9)
    assert detectable_drop(2, 80, 0.005) > detectable_drop(2, 40, 0.005) > detectable_drop(1, 40, 0.005)


@pytest.fixture
def told():
    """Draws of two effects: one always found, one taken for the other in half of its draws and unseen in one of four."""
    common = {DATA: "complex", "predicted": 1.0, "surplus": 0, "sizes_compared": 1, "sizes_held": 1, "seconds": 2.0}
    right = {EFFECT: "mass", DROP: 80.0, "group": "mass", "verdict": "named", "in_group": True, "is_first": True}
    taken = {EFFECT: "bow", DROP: 80.0, "group": "mass", "verdict": "named", "in_group": False, "is_first": False}
    unseen = {EFFECT: "bow", DROP: 80.0, "group": "", "verdict": "adequate", "in_group": False, "is_first": False}
    unnamed = unseen | {"verdict": "unknown"}
    weak = unseen | {DROP: 10.0}
    rows = [right, right, taken, taken, unseen, unnamed, weak]
    return pd.DataFrame([common | row | {"detected": row["verdict"] != "adequate"} for row in rows])


def test_rates_count_what_is_clearly_visible_alone(told):
    by_effect = rates(told, EFFECT).set_index(EFFECT)
    assert by_effect.loc["bow", ["draws", "detected", "in_set"]].tolist() == [4, 3, 0]
    assert by_effect.loc["all", ["draws", "detected", "in_set", "first"]].tolist() == [6, 5, 2, 2]


def test_false_alarms_are_counted_by_kind_and_in_all():
    right = pd.DataFrame({DATA: ["complex", "complex", "amplitudes"], "detected": [True, False, False]})
    assert false_alarms(right).to_numpy().tolist() == [["complex", 2, 1], ["amplitudes", 1, 0], ["all", 3, 1]]


def test_a_page_of_many_diagnoses_begins_with_its_rates():
    """Wilson's ends of 0 of 10 and 12 of 12."""
    of_both = pd.DataFrame(
        {"runs": [10, 12], "false_alarms": [0, np.nan], "in_group": [np.nan, 12], "clearly_visible": [np.nan, 12]}
    )
    said = "Hidden effect in the reported set in 12 of 12 clearly visible draws (76 to 100 %)"
    assert _rate_of(of_both) == f"{said}; No false alarm in 10 diagnoses (0 to 28 %)"
    assert _rate_of(pd.DataFrame({"runs": [2], "false_alarms": [1]})).startswith("1 false alarm in 2 diagnoses (")
    none = pd.DataFrame({"runs": [3], "in_group": [0], "clearly_visible": [3]})
    assert _rate_of(none).startswith("Hidden effect in the reported set in 0 of 3 clearly visible draws (0 to ")
    assert _rate_of(pd.DataFrame({"runs": [3]})) == ""


def test_confusion_tells_what_each_is_called_and_what_ends_without_a_name(told):
    shares = confusion(told)
    assert shares.loc["bow", ["mass", "bow", "no name", "not seen"]].tolist() == [0.5, 0.0, 0.25, 0.25]
    assert shares.loc["mass", ["mass", "bow", "no name", "not seen"]].tolist() == [1.0, 0.0, 0.0, 0.0]
    chart = confusion_chart(shares)
    (panel,) = chart.panels
    points = {each.name: dict(zip(each.y, each.x)) for each in panel.elements if isinstance(each, Points)}
    assert points == {"its own name": {0: 100, 1: 0}, "no name, or not seen": {1: 50}, "another name": {1: 50}}
    assert [text.get_text() for text in figure(chart).axes[0].texts] == ["mass"]
    assert (
        "50 % of the clearly visible draws report the right name" in chart.title
        and "mass for bow, in 50 %" in chart.title
    )


def test_detection_is_drawn_beside_what_is_expected(told):
    one = {"unknowns": 1, "candidates": 5, "level": 0.01}
    needed = detectable_drop(*one.values())
    panels = detection_chart(told.assign(**one, size=np.sqrt(told[DROP] / needed))).panels
    assert [panel.title for panel in panels] == ["mass", "bow"]
    of_bow = {type(element): element for element in panels[1].elements}
    assert list(of_bow[Points].y) == [0, 75] and list(of_bow[Points].x) == pytest.approx(
        np.sqrt([10 / needed, 80 / needed])
    )
    assert np.interp(1.0, of_bow[Line].x, of_bow[Line].y) == pytest.approx(90, abs=0.5)


def test_bars_of_verdicts_stand_on_each_other():
    counts = pd.DataFrame(
        {name: [0, 0] for name in ("adequate", "named", "ambiguous", "located", "unknown", "not observable")}
    )
    bars = verdicts_chart(["one", "two"], counts.assign(named=[2, 3], unknown=[1, 0])).panels[0].elements
    assert {bar.name: (list(bar.base), list(bar.size)) for bar in bars if isinstance(bar, Bars)} == {
        "named": ([0, 0], [2, 3]),
        "unknown": ([2, 3], [1, 0]),
    }


@pytest.fixture(scope="module")
def ended(apart, tmp_path_factory):
    hiding = "{label: '<b>data', measurement.hidden: [[runout], [channel_gain]], measurement.expected_drop: [20, 1000]}"
    words = [
        "+experiment=diagnosis_power",
        FEW,
        "repetitions=1",
        f"grid=[{hiding}, {{label: '<b>data', measurement.hidden: [[]]}}]",
    ]
    one = [
        "measurement.kind=complex",
        "measurement.relative=0.07",
        "measurement.noise_known=false",
        "measurement.stated=1",
    ]
    seen = ["problem.sensors=[0.1,0.5]", "problem.n_speed=27", "problem.speed_to=1500"]  # one kind of data
    few = [
        "study.screening=128",
        "study.starts=3",
        "study.scan_values=2",
        "study.scan=16",
        "study.effect_starts=2",
        "workers=1",
        *one,
        *seen,
    ]
    return apart(*words, *few, draws=True, cwd=tmp_path_factory.mktemp("power"), output="results/diagnosis_power")


@pytest.mark.slow
def test_its_files_hold_every_draw_and_the_page_shows_names_as_text(ended):
    assert ended.code == 0, ended.err
    assert {path.name for path in ended.output.iterdir()} >= {
        "diagnosis_power.csv", "confusion.csv", "detection.png", "confusion.png", "false_alarms.csv", "index.html", "runs.csv",
    }  # fmt: skip
    counts = ended.table("diagnosis_power")
    assert len(counts) == 4 and counts["draws"].sum() == len(ended.runs()) - 1  # the other hides nothing
    alarms = pd.read_csv(ended.output / "false_alarms.csv")
    assert alarms.to_numpy().tolist() == [["<b>data", 1, 0], ["all", 1, 0]]
    assert "Right models" in (ended.output / "index.html").read_text() and "called wrong" in ended.out
    assert counts.loc[counts[DROP] == 1000, "detected"].sum() == counts.loc[counts[DROP] == 1000, "draws"].sum()
    page = (ended.output / "index.html").read_text()
    assert "&lt;b&gt;data" in page and "<b>" not in page and "http" not in page.replace("http-equiv", "")


@pytest.mark.slow
def test_each_cell_draws_noise_of_its_own(ended):
    seeds = [cell["seed"] for cell in ended.cells()]
    assert len(set(seeds)) == len(seeds) == 5

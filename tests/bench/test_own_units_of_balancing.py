"""A campaign in mil pp, lag and own probe names: text, tables and charts of its balancing show what its files show."""

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ksmea
from balancing_cases import PLANES, campaign
from bench.plan.page import Folded, Table
from bench.plan.plan import read_plan
from bench.plan.report import report_named
from ksmea.measurement.notation import Notation
from ksmea.records.balancing import BalanceRecord, EntryMisfitRecord, PolarRecord
from ksmea.records.weights import VectorRecord, WeightsRecord
from ksmea.show import weights_text
from ksmea.show.balance_text import frame, text
from ksmea.show.charts.balance_chart import balance_chart, coefficients_chart

EXAMPLES = Path(__file__).parents[2] / "docs/examples"
HEAD = "# shown as: mil_pp,lag,rpm; 3X = x at 0.12 m; 4Y = y at 0.44 m\n"
OWN = Notation("mil", "pp", "lag", "rpm", {"x at 0.1 m": "3X", "x at 0.2 m": "4X"})
BALANCE = ["+experiment=balance", "measurement=campaign", "measurement.path=balancing.yaml", "workers=1"]
ANGLES = "Angles of weights count in the direction of rotation; phases of vibrations are lags."
MIL_PP = 12.7  # µm 0-peak


@pytest.fixture
def copied(tmp_path):
    """The example of docs/balancing.md, with these lines at the head of its readings."""

    def made(head):
        shutil.copy(EXAMPLES / "balancing.yaml", tmp_path)
        (tmp_path / "balancing.csv").write_text(head + (EXAMPLES / "balancing.csv").read_text("utf-8"), "utf-8")

    return made


def balanced(enter, *words, output="results/balance"):
    ended = enter(*BALANCE, f"output={output}", *words, output=output)
    assert ended.code == 0, ended.err + ended.out
    return ended


def page_of(ended):
    return report_named("balance").make(read_plan(ended.output), ended.output).page()


def coefficients_on(page):
    [folded] = [
        block
        for section in page.sections
        for block in section.blocks
        if isinstance(block, Folded) and section.title == "Influence coefficients"
    ]
    [table] = [block for block in folded.blocks if isinstance(block, Table)]
    return table.frame


@pytest.fixture
def record():
    """By hand: 25.4 µm at 30° of lead without weights; 10 g mm at 90° add 12.7 µm at 120°, so that a weight at 0° adds at 30°."""
    bare, with_weight = (25.4 * np.exp(1j * np.radians(30)), 12.7 * np.exp(1j * np.radians(120)))
    runs = [
        ("bare", {}, [[bare, bare / 2]]),
        ("trial", {PLANES[0]: 10j}, [[bare + with_weight, bare / 2 + with_weight]]),
    ]
    found = ksmea.balance(campaign(runs, [1000.0])).record
    return found, replace(found, notation=OWN)


def test_vibrations_are_in_the_unit_of_the_file_and_weights_stay(record):
    """25.4 µm 0-peak at 30° of lead read as 2 mil pp at 330° of lag; 1.27 µm/(g mm) are 0.1 mil pp/(g mm)."""
    plain, own = record
    shown = frame(own, own.notation)
    assert list(shown["channel"]) == ["3X", "4X", "3X", "4X"]
    assert shown["size"].to_numpy() == pytest.approx([2.0, 1.0, 0.1, 0.1])
    assert shown["lag_deg"].to_numpy() == pytest.approx([330.0] * 4)
    assert list(shown["unit"]) == ["mil pp", "mil pp", "mil pp/(g mm)", "mil pp/(g mm)"]
    said = text(own)
    assert ANGLES in said and "µm" not in said and "lag °" in said and "x at" not in said
    table, of_plain = (each.split("\n\n")[1].splitlines()[:3] for each in (said, text(plain)))
    assert table == of_plain  # the correction weight and its angle


def test_lags_have_their_intervals(record):
    _, own = record
    bare = (PolarRecord(25.4, 30.0, 12.7, 38.1, 20.0, 50.0), PolarRecord(12.7, -10.0))
    shown = frame(replace(own, bare=bare), OWN).iloc[:2]
    assert shown.loc[0, ["low", "size", "high"]].to_list() == pytest.approx([1.0, 2.0, 3.0])
    assert shown.loc[0, ["lag_low", "lag_deg", "lag_high"]].to_list() == pytest.approx([310.0, 330.0, 340.0])
    assert shown.loc[1, "lag_deg"] == pytest.approx(10.0) and np.isnan(shown.loc[1, "lag_low"])


def test_misfits_and_scatter_are_in_the_unit_of_the_file(record):
    _, own = record
    misfit = EntryMisfitRecord(
        "trial", own.entries[1], "other speeds", 1e-5, 4, PolarRecord(25.4, -90.0), PolarRecord(12.7, 45.0)
    )
    said = text(replace(own, entry_misfits=(misfit,)))
    assert "1000 rpm, 4X: 2@90° mil pp (lag) does not fit other speeds, by which it is 1@315° mil pp (lag)" in said


def test_charts_are_in_the_unit_of_the_file(record):
    plain, own = record
    [panel] = balance_chart(own).panels
    assert panel.y.label == "amplitude (mil pp)"
    assert panel.elements[0].said[0] == "1000 rpm, 3X, bare: 2 mil pp" and panel.x.ticks[0.0] == "1000\n3X"
    chart, of_plain = coefficients_chart(own), coefficients_chart(plain)
    dots, of_leads = (each.panels[0].elements[-1] for each in (chart, of_plain))
    assert dots.said[0] == "0.2 m, 1000 rpm, 3X: 0.1 mil pp/(g mm) at 330.0° lag"
    for part, lead in ((dots.x, of_leads.x), (dots.y, of_leads.y)):
        assert np.array(part) == pytest.approx(np.array(lead) / MIL_PP)  # a lag turns clockwise
    assert "lag clockwise" in chart.caption and "clockwise" not in of_plain.caption
    hertz = balance_chart(replace(own, notation=replace(OWN, speed="Hz"))).panels[0]
    assert hertz.elements[0].said[0].startswith("16.7 Hz, 3X") and hertz.x.label == "speed (Hz)"


def test_page_and_text_show_the_file_and_files_stay_as_they_are(copied, enter):
    copied("")
    plain = balanced(enter, output="results/plain")
    copied(HEAD)
    ended = balanced(enter)
    assert ANGLES in ended.out and "mil pp/(g mm)" in ended.out and "3X" in ended.out and "µm" not in ended.out
    assert ANGLES not in plain.out
    shown, of_file = coefficients_on(page_of(ended)), ended.table("coefficients")
    assert shown["size"].to_numpy() == pytest.approx(of_file["size"].to_numpy() / MIL_PP)
    turns = (shown["lag_deg"].to_numpy() + of_file["angle_deg"].to_numpy()) / 360
    assert turns == pytest.approx(np.round(turns), abs=1e-9)
    assert list(shown["channel"][:2]) == ["3X", "4Y"]
    heads, rows = zip(*(_numbers(each.output / "coefficients.csv") for each in (plain, ended)))
    assert heads[0] == heads[1] and rows[0] == pytest.approx(rows[1], rel=1e-6)
    assert page_of(ended).headline == page_of(plain).headline  # correction weights
    [line] = ended.events()
    found = BalanceRecord.from_data(line)
    assert found.notation == Notation("mil", "pp", "lag", "rpm", {"x at 0.12 m": "3X", "y at 0.44 m": "4Y"})
    assert BalanceRecord.from_data(found.to_data()) == found and found.entries[0].channel == "x at 0.12 m"


def _numbers(path):
    with path.open(encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return head, [float(each) for row in rows for each in row[3:-1]]


def test_units_of_the_command_line_take_the_place_of_those_of_the_file(copied, enter):
    copied(HEAD)
    own = balanced(enter, "units=um_0pk,lead")
    assert ANGLES not in own.out and "µm/(g mm)" in own.out and "3X" in own.out
    copied("")
    ended = balanced(enter, "units=mil_pp,lag,Hz")
    assert ANGLES in ended.out and "mil pp/(g mm)" in ended.out and "x at 0.12 m" in ended.out
    shown = coefficients_on(page_of(ended))
    assert shown["speed_Hz"][0] == pytest.approx(1005 / 60)


def test_a_balancing_without_a_notation_is_shown_and_written_as_ever(copied, enter):
    copied("")
    ended = balanced(enter)
    [line] = ended.events()
    assert "notation" not in line and BalanceRecord.from_data(line).notation == Notation()
    assert "With them the root sum of squares goes from 10.6 to" in ended.out
    assert "plane m     rpm      channel  µm/(g mm)                95 %  angle °" in ended.out
    assert "\nInfluence coefficients:\n" in ended.out and "lag" not in ended.out
    shown, of_file = coefficients_on(page_of(ended)), ended.table("coefficients")
    assert list(shown.columns) == list(of_file.columns)
    [panel] = balance_chart(BalanceRecord.from_data(line)).panels
    assert panel.y.label == "amplitude (µm 0-peak)" and panel.x.label == ""


def test_angles_of_identified_weights_are_explained_beside_lags():
    vector = VectorRecord(0.2, "", "after", 1e-5, 0.0, 1e-5, 0.9e-5, 1.1e-5, 0.0, -0.1, 0.1)
    weights = WeightsRecord(0.95, (vector,), (), (), (), (), (), ())
    said = list(weights_text.lines(weights, OWN))
    assert said[1:] == [ANGLES[0].lower() + ANGLES[1:-1]] and len(list(weights_text.lines(weights))) == 1

"""The study of identifiability: CRLBs against those of ksmea, how they scale with the data, and what is printed of them."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from bench.plan.setup import Setup
from bench.reports.design import identifiability_report as reporting
from bench.reports.design.page import identifiability_page
from ksmea.inference.cramer_rao import identifiability
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.problem.problem import Problem
from ksmea.records.identifiability import IdentifiabilityRecord, Unknown
from ksmea.results import IdentifiabilityResult
from ksmea.show.charts.chart import Points
from ksmea.show.charts.identifiability_chart import half_widths, identifiability_chart, label
from ksmea.show.charts.picture import figure
from ksmea.show.identifiability_text import COLUMNS, frame, sentences, text
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.identifiability import (
    IdentifiabilityOptions,
    identifiability_of,
    identifiability_study,
    varied_data,
)
from problems.three_disk import ThreeDisk

FIVE = ["kxx", "kyy", "cxx", "cyy", "u"]
EXAMPLE = "docs/examples/rotor.yaml"
DATA = Path(__file__).parents[1] / "data"
TRUTH = np.array(list(ThreeDisk().reference().values()))


def record_of(problem=None, study=None, **measurement):
    """The record of one run, without planning it."""
    settings = {
        "problem": {"name": "three_disk", **(problem or {})},
        "measurement": {"name": "synthetic", "relative": 0.1, **measurement},
        "study": {"name": "identifiability", **(study or {})},
    }
    setup = Setup.of(settings)
    setup.plugins["study"].validate(setup)
    return json.loads(json.dumps(setup.plugins["study"].run(setup, None), allow_nan=False))  # as a file has it


def crlbs(record, variation=None):
    """(d,) of the present data, or by value (d,) of a variation."""
    if variation is None:
        return np.array([parameter["crlb"] for parameter in record["parameters"]], dtype=float)
    entries = [entry for entry in record["variations"] if entry["variation"] == variation]
    return {str(entry["value"]): np.array(entry["crlb"], dtype=float) for entry in entries}


@pytest.fixture(scope="module")
def three_disk():
    return record_of()


# -- the record --


def test_the_crlbs_are_those_of_ksmea_at_the_reference_values(three_disk):
    x = np.array(list(ThreeDisk().reference().values()))
    expected = identifiability(ThreeDisk().build(), x, Noise(0.1, 0.0), "amplitude")
    assert crlbs(three_disk) == pytest.approx(expected.crlb, rel=1e-9)
    assert np.array(three_disk["correlation"]) == pytest.approx(expected.correlation, abs=1e-9)
    assert crlbs(three_disk, "kind")["complex"] == pytest.approx(
        identifiability(ThreeDisk().build(), x, Noise(0.1, 0.0), "complex").crlb, rel=1e-9
    )


def test_the_true_values_of_the_measurement_are_where_the_crlbs_are_taken():
    record = record_of(truth={"cxx": 0.9}, study={"variations": []})
    x = np.array(list((ThreeDisk().reference() | {"cxx": 900.0}).values()))
    expected = identifiability(ThreeDisk().build(), x, Noise(0.1, 0.0), "amplitude").crlb
    assert crlbs(record) == pytest.approx(expected, rel=1e-9)


def test_every_variation_passes_through_the_data_as_they_are(three_disk):
    present = crlbs(three_disk)
    places = {"speeds": "53", "band": "[200.0, 1500.0]", "position": "0.1", "noise": "1.0", "kind": "amplitude"}
    for variation, value in places.items():
        assert crlbs(three_disk, variation)[value] == pytest.approx(present, rel=1e-6)


def test_a_crlb_is_proportional_to_the_noise():
    """Exactly where the noise is a floor alone: its size then tells nothing."""
    by_noise = crlbs(record_of(relative=0.0, floor=0.2, study={"variations": ["noise"]}), "noise")
    assert by_noise["0.5"] == pytest.approx(by_noise["1.0"] / 2)
    assert by_noise["3.0"] == pytest.approx(by_noise["1.0"] * 3)


def test_four_times_as_many_speeds_halve_the_crlbs_where_the_response_is_smooth():
    record = record_of({"reading": "rpm"}, {"variations": ["speeds"]}, kind="complex")
    by_speed = crlbs(record, "speeds")
    assert list(by_speed) == ["14", "27", "53", "105", "209"]
    assert by_speed["53"] / by_speed["209"] == pytest.approx(np.full(5, 2.0), rel=0.05)


def test_unevenly_spaced_speeds_keep_their_spacing(three_disk):
    problem = ThreeDisk().build()
    speed = np.array([200.0, 300.0, 700.0])
    data = DesignPoint(problem.at(speed, problem.channels), TRUTH, Noise(0.1, 0), "amplitude", True)
    options = IdentifiabilityOptions(speed_factors=[1.0, 2.0])
    found = {value: varied.problem.speed for value, varied in varied_data("speeds", data, options)}
    assert found[3] == pytest.approx(speed)
    assert found[5] == pytest.approx([200, 250, 300, 500, 700])


def test_a_measuring_plane_replaces_the_present_probes():
    record = record_of({"sensors": [0.1, 0.9]}, {"variations": ["position"]})
    x = np.array(list(ThreeDisk().reference().values()))
    problem = ThreeDisk().build()
    there = problem.at(problem.speed, [Channel(0.5, "x"), Channel(0.5, "y")])
    expected = identifiability(there, x, Noise(0.1, 0.0), "amplitude").crlb
    by_position = crlbs(record, "position")
    assert len(by_position) == 14  # the nodes of 13 elements
    [found] = [crlb for value, crlb in by_position.items() if float(value) == pytest.approx(0.5)]
    assert found == pytest.approx(expected, rel=1e-6)
    few = crlbs(record_of(study={"variations": ["position"], "n_position": 3}), "position")
    assert [float(value) for value in few] == pytest.approx([0, 0.6, 1.3])


def test_unknown_noise_costs_information():
    known, unknown = (crlbs(record_of(noise_known=flag, study={"variations": []})) for flag in (True, False))
    assert np.all(unknown >= known * (1 - 1e-9)) and np.any(unknown > known * 1.0001)


class Bare(Problem):
    """A problem that offers only what the contract asks of every one."""

    def __init__(self, problem):
        self.parameters, self.speed, self.channels = problem.parameters, problem.speed, problem.channels
        self._problem = problem

    def response(self, x):
        return self._problem.response(x)

    def at(self, speed, channels):
        return Bare(self._problem.at(speed, channels))


def test_a_problem_without_sensitivity_and_sites_is_differentiated():
    problem = ThreeDisk(reading="rpm").build()
    data = DesignPoint(problem, TRUTH, Noise(0.1, 0.0), "complex", True)
    bare = dataclasses.replace(data, problem=Bare(problem))
    assert identifiability_of(bare).crlb == pytest.approx(identifiability_of(data).crlb, rel=1e-3)
    assert list(varied_data("position", bare, IdentifiabilityOptions())) == []


def test_fewer_data_than_unknowns_tell_of_none_alone():
    data = DesignPoint(ThreeDisk(n_speed=1, directions=["x"]).build(), TRUTH, Noise(0.0, 1e-7), "amplitude")
    assert np.isinf(identifiability_of(data).crlb).all()


def test_a_value_of_0_is_measured_by_its_limits():
    """An angle or a cross-coupling can be 0; the CRLB in SI does not depend on what it is measured by."""
    problem = ThreeDisk().build()
    x = np.array([50e6, 70e6, 500.0, 0.0, 2e-4])
    told = identifiability_of(DesignPoint(problem, x, Noise(0.1, 0.0), "amplitude"))
    scale = problem.parameters.width  # for the inverse alone
    covariance = np.linalg.inv(told.information * np.outer(scale, scale)) * np.outer(scale, scale)
    assert told.crlb == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-6)


def test_an_angle_is_drawn_by_its_limits_and_says_so(three_disk):
    """10° ± 3.6° is 1 % of the 360° of its search; a part of 10° says nothing."""
    found = IdentifiabilityRecord.from_data(three_disk)
    angle = Unknown("origin", "deg", np.pi / 180, np.radians(10), -np.pi, np.pi, np.radians(3.6) / found.sigmas)
    found = dataclasses.replace(found, parameters=(*found.parameters[:4], angle))
    crlb = np.array([each.crlb_si for each in found.parameters])
    assert half_widths([crlb], found)[0, 4] == pytest.approx(1.0)  # 3.6° of 360°
    assert [label(each) for each in found.parameters[3:]] == ["cyy", "origin (% of its range)"]
    drawn = identifiability_page({"": found}, [], frame(found), "identifiability.csv").sections[0].blocks[1]
    names = [each.name for panel in drawn.described().panels for each in panel.elements if each.name]
    assert list(dict.fromkeys(names)) == [label(each) for each in found.parameters]


# -- the command --


def test_the_command_prints_and_tables_what_the_record_holds(enter, three_disk):
    ended = enter("+experiment=identifiability", "workers=1", output="results/identifiability")
    assert ended.code == 0
    assert "kxx to ± 0.1 MN/m (± 0.21 %)" in ended.out
    assert "only roughly: cyy to ± 0.29 kN s/m (± 42 %)" in ended.out
    table = ended.table("identifiability")
    assert list(table)[-9:] == list(COLUMNS)
    present = table[table["variation"] == "present"]
    assert present["parameter"].tolist() == FIVE
    assert present["crlb"].to_numpy() == pytest.approx(crlbs(three_disk) / [1e6, 1e6, 1e3, 1e3, 1e-6])
    crlb, true, pct = (present[name].to_numpy() for name in ("crlb", "true", "crlb_pct"))
    assert pct == pytest.approx(100 * crlb / true)
    assert present["half_width_pct"].to_numpy() == pytest.approx(1.959964 * pct)
    assert len(table) == 5 * (1 + len(three_disk["variations"]))
    assert (ended.output / "identifiability.png").exists() and ended.runs()["status"].tolist() == ["done"]


def test_a_rotor_from_a_file_is_told_as_much_of(enter, three_disk, pytestconfig):
    file = pytestconfig.rootpath / EXAMPLE
    words = ["+experiment=identifiability", "problem=rotor", f"problem.file={file}", "workers=1"]
    table = enter(*words, output="results/identifiability").table("identifiability")
    present = table[table["variation"] == "present"]
    assert present["crlb"].to_numpy() == pytest.approx(crlbs(three_disk) / [1e6, 1e6, 1e3, 1e3, 1e-6], rel=1e-6)


def test_a_sweep_has_a_section_per_cell_and_figures_of_the_first_ones(enter):
    words = ["+experiment=identifiability", "measurement.relative=0.05,0.1", "study.variations=[noise]", "workers=1"]
    ended = enter(*words, "problem.mesh=13,21,26", output="results/identifiability")
    assert ended.code == 0
    assert ended.out.count("With 53 speeds") == 6 and ended.out.count("* the data as they are") == reporting.MAX_CELLS
    table = ended.table("identifiability")
    halves = table[(table["measurement.relative"] == 0.1) & (table["value"] == "× 0.5")]
    of_half = table[(table["measurement.relative"] == 0.05) & (table["variation"] == "present")]
    assert halves["crlb"].to_numpy() == pytest.approx(of_half["crlb"].to_numpy())
    assert len(list(ended.output.glob("*.png"))) == reporting.MAX_CELLS


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["measurement.relative=0"], "measurement.relative=0.1 or measurement.floor"),
        (["study.variations=[speed]"], "did you mean 'speeds'"),
        (["study.level=1.2"], "at most 0.9999"),
        (["table=audit"], "run +experiment=audit"),
    ],
)
def test_bad_input_is_one_line(words, said, enter):
    ended = enter("+experiment=identifiability", "study.variations=[]", "workers=1", *words)
    assert ended.code == 2
    assert said in ended.err and ended.err.count("\n") == 1


def test_the_table_of_another_study_is_refused(enter, cheapest):
    ended = enter(*cheapest, "table=identifiability", "measurement.relative=0.1", "repetitions=1", "workers=1")
    assert ended.code == 2 and "for study=identify, got identifiability" in ended.err


# -- what is said, of a record made by hand --


def hand_made(**changes):
    parameter = {"unit": "MN/m", "si_per_unit": 1e6, "true": 1e7, "lower": 0.0, "upper": 1e8}
    record = {
        "level": 0.95,
        "sigmas": 2.0,
        "data": {
            "n_speed": 1, "speed_from": np.pi / 30 * 600, "speed_to": np.pi / 30 * 600, "channels": ["x at 0 m"],
            "positions": [0.0], "kind": "complex", "relative": 0.0, "floor": 5e-7, "noise_known": False,
        },
        "parameters": [{"name": name, "crlb": crlb, **parameter} for name, crlb in
                       (("a", 1e5), ("b", 2e6), ("c", 6e6), ("d", None))],
        "correlation": np.array([[1, 0.96, 0, 0], [0.96, 1, -0.99, 0], [0, -0.99, 1, 0], [0, 0, 0, 1]]).tolist(),
        "worst_direction": {"change": [0.05, -0.6, 0.0, -0.8], "crlb": 0.25},
        "variations": [],
    }  # fmt: skip
    return IdentifiabilityRecord.from_data(record | changes)


def test_sentences_of_a_record():
    said = list(sentences(hand_made()))
    assert said == [
        "With 1 speed of 600 rpm, 1 channel (x at 0 m), complex values and 0.5 µm noise of unknown level",
        "you will know (95 %): a to ± 0.2 MN/m (± 2 %)",
        "you will know only roughly: b to ± 4 MN/m (± 40 %)",
        "not identifiable: c to ± 12 MN/m (± 120 %), d (± more than 1000 %)",
        "strongly correlated parameters (|r| > 0.95): a and b (+0.960), b and c (-0.990)",
        "least constrained: a joint relative change of +0.80 d +0.60 b, known to ± 50 %",
    ]


def test_a_text_has_its_title_first_and_the_table_where_it_is_asked_for():
    entries = [{"variation": "noise", "value": 2.0, "crlb": [2e5, 4e6, None, None]}]
    with_table = text(hand_made(variations=entries), "rotor").splitlines()
    assert with_table[0] == "rotor" and with_table[-1].split() == ["noise", "×", "2", "4", "80", "∞", "∞"]
    assert text(hand_made(variations=entries), with_variations=False).splitlines() == list(sentences(hand_made()))


def test_the_table_of_a_record_is_in_the_units_of_the_unknowns():
    table = frame(hand_made())
    assert list(table) == list(COLUMNS) and table["variation"].unique().tolist() == ["present"]
    assert table["crlb"].tolist() == pytest.approx([0.1, 2.0, 6.0, np.inf])
    assert table["half_width_pct"].tolist() == pytest.approx([2.0, 40.0, 120.0, np.inf])


def test_the_figure_shows_half_widths_and_marks_what_lies_beyond():
    entries = [
        {"variation": "noise", "value": factor, "crlb": [1e5 * factor, 2e6 * factor, None, None]} for factor in (1, 2)
    ]
    chart = identifiability_chart(hand_made(variations=entries), "hand made")
    [panel] = figure(chart).axes
    lines = {line.get_label(): line for line in panel.get_lines()}
    assert lines["a"].get_xdata().tolist() == [1, 2] and lines["a"].get_ydata() == pytest.approx([2, 4])
    assert lines["b"].get_ydata() == pytest.approx([40, 80])
    arrows = [each for each in chart.panels[0].elements if isinstance(each, Points) and each.symbol == "arrow up"]
    assert len(arrows) == 2  # c and d, of which nothing is known


def test_given_axes_show_the_first_variation_or_the_data_as_they_are():
    entries = [{"variation": "noise", "value": factor, "crlb": [1e5 * factor, 2e6, None, None]} for factor in (1, 2)]
    panel = Figure().subplots()
    assert IdentifiabilityResult(hand_made(variations=entries)).plot(panel) is panel.figure
    assert panel.get_title() == "noise, times the present"
    [panel] = IdentifiabilityResult(hand_made()).plot().axes
    assert [line.get_ydata()[0] for line in panel.get_lines()] == pytest.approx([2, 40, 120, 1e4])


def test_the_study_is_a_function_of_a_problem_and_its_noise(three_disk):
    x = np.array(list(ThreeDisk().reference().values()))
    record = identifiability_study(DesignPoint(ThreeDisk().build(), x, Noise(0.1, 0.0), "amplitude"))
    assert IdentifiabilityRecord.from_data(three_disk) == record and three_disk["status"] == "done"


def test_a_record_that_says_bound_is_read():
    """It was written before CRLBs had their name."""
    record = IdentifiabilityRecord.from_data(json.loads((DATA / "identifiability_bound.json").read_text()))
    assert record.names == ("kxx", "kyy", "cxx", "cyy", "u") and record.parameters[3].crlb == pytest.approx(75.0, abs=1)
    assert record.variations[0].value == 14 and record.variations[1].value == pytest.approx((200.0, 1500.0))
    assert record.worst_direction.crlb == pytest.approx(0.107, abs=1e-3)
    assert "you will know only roughly: cyy to ± 0.15 kN s/m (± 21 %)" in text(record)
    assert IdentifiabilityRecord.from_data(record.to_data()) == record


def test_a_run_without_result_is_counted_and_not_tabled(plan, tmp_path):
    cells = tuple(
        dataclasses.replace(cell, settings={"problem": {"name": "p"}, "study": {"name": "identifiability"}})
        for cell in plan.cells
    )
    made = reporting.IdentifiabilityReport().make(dataclasses.replace(plan, cells=cells), tmp_path)
    assert made.text == "" and made.figures() == {}
    assert made.runs["status"].unique().tolist() == ["not run"]
    assert made.files["table3.csv"].decode().startswith("cell,samples,variation,value")

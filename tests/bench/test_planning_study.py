"""The study `plan` as its users meet it: files, sentences, and what it refuses."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from bench.plan.setup import Setup
from ksmea.errors import SettingError
from ksmea.inference.cramer_rao import identifiability
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.records.planning import PlanningRecord
from ksmea.results import PlanResult
from ksmea.show.charts.picture import figure
from ksmea.show.charts.planning_chart import planning_chart
from ksmea.show.planning_text import frame, text
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.planning import PlanningOptions, planning_study
from problems.three_disk import ThreeDisk

DATA = Path(__file__).parents[1] / "data"
ROTOR = Path(__file__).parents[2] / "docs" / "examples" / "rotor.yaml"
PLAN = ["+experiment=plan", "study.n_candidate=60", "workers=1"]
OUTPUT = "results/plan"
SETTINGS = {"problem": {"name": "three_disk"}, "measurement": {"name": "synthetic", "relative": 0.1}}


@pytest.fixture
def plan(enter, monkeypatch):
    """`+experiment=plan` with a coarser choice of speeds; its chart is drawn and not written."""
    drawn = []

    def draw(*found):
        drawn.append(figure(chart := planning_chart(*found)))
        return chart

    monkeypatch.setattr("bench.reports.design.page.planning_chart", draw)

    def call(*words):
        ended = enter(*PLAN, *words, output=OUTPUT)
        assert ended.code == 0, ended.err
        assert len(drawn) == 1  # one chart for the picture and the page
        return ended

    return call


def record(ended):
    (event,) = ended.events()
    return event


def family(found, name):
    return next(family for family in found["families"] if family["family"] == name)


def test_the_table_says_what_to_add_and_what_it_gives(plan):
    ended = plan("study.target=cyy", "measurement.kind=complex")
    table = ended.table("plan")
    assert set(table["family"]) == {"speeds", "probes", "trial run"}
    assert list(table.groupby("family")["order"].max()[["speeds", "probes", "trial run"]]) == [10, 2, 1]
    assert len(table) == 13 * 5  # a row per addition and unknown
    assert np.all(table["after"] <= table["before"] * (1 + 1e-9))  # rounding
    assert np.all(np.diff(table[(table.family == "speeds") & (table.parameter == "cyy")]["after"]) < 0)
    of_target = table[table.parameter == "cyy"].groupby("family").last()
    # the choice is made for cyy: at least as good as as many data without a plan
    assert np.all(of_target["reduction_pct"] > of_target["unplanned_reduction_pct"])
    fall = 1 - of_target["after"] / of_target["before"]
    assert of_target["reduction_pct"].to_numpy() == pytest.approx(100 * fall.to_numpy())
    # the same run twice: 1 − 1/√2
    assert of_target.loc["trial run", "unplanned_reduction_pct"] == pytest.approx(100 * (1 - np.sqrt(0.5)), abs=1e-6)
    assert "To know cyy better, its CRLB being 6.3 % now:" in ended.out
    assert "add these 10 speeds:" in ended.out and "add a second run with 140 g mm at" in ended.out
    assert sorted(path.name for path in ended.output.glob("*.*g")) == ["plan.log", "plan.png"]
    begins = {"speeds": "Add these", "probes": "Add 2", "trial run": "Add a"}  # the sentences above
    page = (ended.output / "index.html").read_text(encoding="utf-8")
    assert f"<h1>{begins[of_target['reduction_pct'].idxmax()]}" in page  # the most useful one heads the page


def test_the_crlbs_are_those_of_the_enlarged_measurement(plan):
    """The speeds of the plan given to the problem: `identifiability` of present and added speeds in one."""
    found = record(plan("study.target=cxx", "study.sensors=0", "study.trial_phases=[]", "study.add=3"))
    setup = Setup.of(SETTINGS)
    steps = family(found, "speeds")["steps"]
    speeds = np.concatenate([setup.problem.speed, [step["speed"] for step in steps]])
    enlarged = setup.problem.at(speeds, setup.problem.channels)
    noise = setup.plugins["measurement"].noise
    # another reduction of the same rotor, and a scale of its own
    assert steps[-1]["crlb"] == pytest.approx(
        identifiability(enlarged, setup.true_x, noise, "amplitude").crlb, rel=1e-5
    )
    assert [name["family"] for name in found["families"]] == ["speeds"]
    assert any("study.sensors is 0" in remark for remark in found["remarks"])
    assert any("study.trial_phases is empty" in remark for remark in found["remarks"])


def test_records_are_json_without_infinities_and_nothing_is_drawn(plan):
    ended = plan("study.target=null", "repetitions=2", "problem=rk4_two_disk", "problem.n_speed=9", "problem.mesh=14")
    first, second = ended.events()
    for event in (first, second):
        json.dumps(event, allow_nan=False)
    for part in ("families", "crlb", "remarks", "parameters"):
        assert first[part] == second[part]
    assert len(ended.table("plan")) == 13 * 9  # of two equal repetitions one: eight unknowns, and all together


def test_speeds_stay_in_the_band_and_probes_where_none_is(plan):
    found = record(plan("study.target=u", "study.band=[1, 1]", "study.sensors=27"))
    lowest, highest = found["speed_from"], found["speed_to"]
    speeds = [step["speed"] for step in family(found, "speeds")["steps"]]
    assert len(set(speeds)) == 10 and lowest <= min(speeds) and max(speeds) <= highest
    probes = [(step["position"], step["direction"]) for step in family(found, "probes")["steps"]]
    assert len(set(probes)) == len(probes) == 26  # 14 nodes in x and y, but for the two there are
    assert not {(0.1, "x"), (0.1, "y")} & set(probes)


def test_one_speed_may_be_measured_again_and_again(plan):
    found = record(plan("study.target=cyy", "study.repeats=10", "study.sensors=0", "study.trial_phases=[]"))
    speeds = [step["speed"] for step in family(found, "speeds")["steps"]]
    assert len(speeds) == 10 and len(set(speeds)) < 10


def test_a_sweep_of_targets_has_a_plan_for_each(plan):
    ended = plan("study.target=kxx,cyy", "study.sensors=0", "study.trial_phases=[]")
    table = ended.table("plan")
    assert list(dict.fromkeys(table["study.target"])) == ["kxx", "cyy"]
    assert "study.target kxx:" in ended.out and "study.target cyy:" in ended.out
    last = table[table.order == 10].set_index(["study.target", "parameter"])["after"]
    assert last["kxx", "kxx"] < last["cyy", "kxx"] and last["cyy", "cyy"] < last["kxx", "cyy"]


def test_all_unknowns_together_have_a_row_of_their_own(plan):
    table = plan().table("plan")
    together = table[table.parameter == "all"]
    assert len(together) == 13 and np.all(together["reduction_pct"] > 0) and together["after"].isna().all()


def test_a_rotor_from_a_file_with_unknown_noise(plan):
    ended = plan("problem=rotor", f"problem.file={ROTOR}", "measurement.noise_known=false", "study.target=cxx")
    table = ended.table("plan")
    assert set(table["parameter"]) == {"kxx", "kyy", "cxx", "cyy", "u"}
    assert np.isfinite(table["after"]).all()


def test_what_the_data_do_not_tell_at_all(plan):
    """The RK-4 rig with two disks: amplitudes tell no absolute phase, whatever is added but a known unbalance."""
    ended = plan("problem=rk4_two_disk", "problem.n_speed=25", "study.target=phase1", "study.trial_sites=[0.16, 0.4]")
    assert "To know phase1, which the present data do not determine:" in ended.out
    assert "the best 10 speeds leave it unknown" in ended.out
    assert "it becomes known to" in ended.out
    rows = ended.table("plan").query("parameter == 'phase1'").set_index("family")
    assert np.isinf(rows["before"]).all() and np.isinf(rows.loc[["speeds", "probes"], "after"]).all()
    assert np.isfinite(rows.loc["trial run", "after"]) and pd.isna(rows.loc["trial run", "reduction_pct"])
    assert record(ended)["crlb"][5] is None


def test_crlbs_beyond_the_search_are_not_called_knowledge(plan):
    """rk4 in its band is quasi-static: CRLBs of c of 1e8 % and more are no news, however much they fall."""
    ended = plan("problem=rk4", "study.target=cyy")
    assert "the best 10 speeds leave it unknown: its CRLB stays wider than the search limits" in ended.out
    assert "e+0" not in ended.out


class Bare(Problem):
    """A problem that offers no sensitivity, no sites and no trial unbalance."""

    def __init__(self, whole):
        self.parameters, self.speed, self.channels = whole.parameters, whole.speed, whole.channels
        self._whole = whole

    def response(self, x):
        return self._whole.response(x)

    def at(self, speed, channels):
        return Bare(self._whole.at(speed, channels))


def point_of(setup, noise):
    return DesignPoint(setup.problem, setup.true_x, noise, "amplitude")


def test_a_problem_that_can_do_less_is_planned_for_as_far_as_it_goes():
    setup = Setup.of({**SETTINGS, "study": {"name": "plan", "target": "cyy", "n_candidate": 30}})
    study = setup.plugins["study"]
    bare = dataclasses.replace(setup, aligned_problem=Bare(setup.problem))
    study.validate(bare)
    found, whole = (study.run(each, None) for each in (bare, setup))
    assert [family["family"] for family in found["families"]] == ["speeds"]
    assert sum("considered" in remark for remark in found["remarks"]) == 2
    # derivatives by differences: steps of 1e-5 of the range leave some 1e-6 near a resonance
    assert found["crlb"] == pytest.approx(whole["crlb"], rel=1e-4)
    chosen = [[step["candidate"] for step in family(each, "speeds")["steps"]] for each in (found, whole)]
    assert chosen[0] == chosen[1]


@pytest.mark.parametrize(
    "words, said",
    [
        (
            ["study.target=czz"],
            "unknown parameter in study.target: 'czz'; known: cxx, cyy, kxx, kyy, u",
        ),
        (["measurement.relative=0"], "study=plan: expected a measurement with noise"),
        (["study.trial_sites=[9]"], "study.trial_sites: "),
        (["study.band=[1]"], "band: expected two numbers"),
        (["study.band=[3, 0.1]"], "band: expected room for speeds"),
        (["study.add=0", "study.sensors=0", "study.trial_phases=[]"], "expected something to add"),
        (["study.add=61"], "add: expected at most n_candidate × repeats = 60 speeds, got 61"),
    ],
)
def test_bad_input_is_one_line(enter, words, said):
    ended = enter(*PLAN, *words, output=OUTPUT)
    assert ended.code == 2
    assert said in ended.err and len(ended.err.strip().splitlines()) == 1


# -- the record in Python --


@pytest.fixture(scope="module")
def small():
    setup = Setup.of(SETTINGS)
    options = PlanningOptions(target="cyy", n_candidate=20, add=2, sensors=1, trial_phases=[0.0])
    return planning_study(point_of(setup, setup.plugins["measurement"].noise), options)


def test_the_study_is_a_function_of_a_problem_and_its_noise(small):
    assert PlanningRecord.from_data(json.loads(json.dumps(small.to_data(), allow_nan=False))) == small
    assert small.target_unknown.name == "cyy" and small.target_index == 3
    assert [len(family.steps) for family in small.families] == [2, 1, 1]
    assert small.families[0].candidates.position is None and len(small.families[0].candidates.speed) == 20
    assert frame(small)["order"].max() == 2 and len(frame(small)) == 4 * 5
    assert text(small, "rotor:").startswith("rotor:\nTo know cyy better, its CRLB being")


def test_an_angle_has_no_per_cent(small):
    """Its zero is chosen, so that a part of its value says nothing; the reduction of its CRLB does."""
    angle = dataclasses.replace(small.parameters[4], name="origin", unit="deg", si_per_unit=np.pi / 180, true=0.7)
    table = frame(dataclasses.replace(small, parameters=(*small.parameters[:4], angle))).set_index("parameter")
    parts = ["before_pct", "after_pct", "unplanned_pct"]
    assert table.loc["origin", parts].isna().all(axis=None) and table.loc["kxx", parts].notna().all(axis=None)
    assert table.loc["origin", ["after", "reduction_pct"]].notna().all(axis=None)


def test_options_that_do_not_fit_are_refused_in_python():
    setup = Setup.of(SETTINGS)
    with pytest.raises(SettingError, match=r"unknown parameter in study\.target: 'czz'"):
        planning_study(point_of(setup, Noise(0.1, 0.0)), PlanningOptions(target="czz"))


def test_the_figure_has_a_panel_per_family_and_given_axes_the_first(small):
    plot = PlanResult(small).plot
    speeds, probes, trial = plot().axes
    assert speeds.get_ylabel() == "reduction of the CRLB of cyy (%)"
    assert (
        speeds.get_xlabel().startswith("added speed (rpm)")
        and "probe" in probes.get_xlabel()
        and "trial" in trial.get_xlabel()
    )
    panel = Figure().subplots()
    assert plot(panel) is panel.figure
    assert panel.get_xlabel() == speeds.get_xlabel() and panel.get_ylabel() == speeds.get_ylabel()


def test_several_plans_are_stacks_of_one_chart(small):
    chart = planning_chart({"first": small, "second": small}, "plan")
    assert [stack[0].title for stack in chart.stacks] == ["first", "second"] and chart.across == 2
    for panel, found in zip(chart.stacks[1], small.families):
        rings = panel.elements[-1] if found.family == "speeds" else panel.elements[-2]
        assert rings.name == "chosen" and list(rings.y) == [found.candidates.reduction_pct[at] for at in found.chosen]


def test_a_target_that_stays_unknown_has_no_reduction_to_draw(small):
    families = [
        dataclasses.replace(
            each, candidates=dataclasses.replace(each.candidates, crlb=(None,) * len(each.candidates.reduction_pct))
        )
        for each in small.families
    ]
    unknown = dataclasses.replace(small, crlb=(None,) * 5, families=tuple(families))
    for panel in planning_chart({"": unknown}).panels:
        assert [each.text for each in panel.elements] == ["still unknown"] and not panel.y.label


def test_a_record_that_says_bound_and_gain_is_read():
    """It was written before CRLBs and their reductions had their names."""
    found = PlanningRecord.from_data(json.loads((DATA / "plan_bound.json").read_text()))
    assert found.target == "cyy" and found.crlb[3] == pytest.approx(75, abs=1) and found.n_speed == 53
    assert [family.family for family in found.families] == ["speeds", "probes", "trial run"]
    speeds = found.families[0]
    assert speeds.chosen == (1,) and speeds.candidates.speed[1] == speeds.steps[0].speed
    assert speeds.steps[0].reduction_pct == pytest.approx(speeds.candidates.reduction_pct[1])
    assert "To know cyy better, its CRLB being 11 % now:" in text(found)
    assert PlanningRecord.from_data(found.to_data()) == found


def test_a_plan_from_fewer_measured_data_than_unknowns_is_refused():
    problem = ThreeDisk(n_speed=3, sensors=[0.1], directions=["x"]).build()
    measurement = Measurement(problem.speed, problem.channels, np.ones((3, 1)), None, "few.csv")
    with pytest.raises(
        SettingError, match=r"few.csv: expected at least 7 data for 5 unknowns and 2 of the noise, got 3"
    ):
        DesignPoint.of_measurement(Case(problem, measurement), np.random.default_rng(0))

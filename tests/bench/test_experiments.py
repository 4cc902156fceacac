"""The experiments in conf/: the cells that they plan, the noise that methods share, and the paper's values beside ours."""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hydra import initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.types import RunMode

from bench.jobs.execute import execute
from bench.jobs.records import RecordWriter
from bench.plan.experiment import Experiment
from bench.plan.plan import write_plan
from bench.reports.collect import collect
from bench.reports.runs import runs_frame
from bench.reports.settings_report import settings_frame
from bench.reports.tables import PAPER, csv_text, slips, summary_frame
from bench.storage.own_files import CONF
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from problems.rk4 import RK4
from problems.three_disk import ThreeDisk

TABLES = ["table2", "table3", "table4", "table5", "table6", "table8"]
ONCE = ["audit", "plan", "identify", "identifiability", "diagnose", "locate", "balance"]
REPETITIONS = dict.fromkeys([*ONCE, "diagnosis_effects_drawn", "diagnosis_nulls_drawn"], 1)  # of others than tables
REPETITIONS |= {"contest": 2, "coverage": 2000, "efficiency": 100, "rational": 100, "tolerances": 300}
REPETITIONS |= {"diagnosis_nulls": 300, "diagnosis_effects": 20, "diagnosis_further": 20, "diagnosis_numbers": 50}
REPETITIONS |= {"diagnosis_power": 2, "diagnosis_pairs": 2, "diagnosis_without": 6}
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
NEEDED = {  # to plan them at all
    "identify": [f"measurement.path={EXAMPLES / 'run_up.csv'}"],
    "contest": ["problem.family=one_disk", "problem.instance=0"],  # others are alike
    # other effects and kinds of data are alike, too, and drawn more slowly: 1000 cells
    "diagnosis_power": ["measurement.hidden=[runout]", "label=complex"],
    "diagnosis_effects": ["measurement.hidden=[runout]"],
    "diagnosis_nulls_drawn": ["problem.family=overhung", "problem.instance=0"],
    "diagnosis_effects_drawn": ["problem.family=overhung", "problem.instance=0", "measurement.hidden=[runout]"],
    "balance": ["measurement=campaign", f"measurement.path={EXAMPLES / 'balancing.yaml'}"],
    "diagnose": ["measurement.relative=0.1"],
    "locate": ["measurement.relative=0.1", "measurement.kind=complex", "problem.sensors=[0.1,0.5]"],
}
WITH_VALUES = [name for name in TABLES if name != "table5"]
FIVE = ["kxx", "kyy", "cxx", "cyy", "u"]
SAMPLES = [40, 70, 100, 200]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """The working directory, in which planning leaves nothing."""
    folder = tmp_path_factory.mktemp("place")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(folder)
        yield folder
    assert list(folder.iterdir()) == []


@pytest.fixture(scope="module")
def compose_all(place):
    """All experiments that a command line means."""
    with initialize_config_dir(str(CONF), version_base="1.3"):
        loader = GlobalHydra.instance().config_loader()
        master = loader.load_configuration("config", overrides=[], run_mode=RunMode.MULTIRUN)
        yield cache(lambda *words: Experiment.compose_all(loader, master, list(words)))


@pytest.fixture(scope="module")
def plan_of(compose_all):
    """The plan of one experiment."""

    def call(name, *words):
        [experiment] = compose_all(f"+experiment={name}", *words)
        return experiment.plan

    return call


def chosen(plan, *names):
    """The named settings of each cell; 'optimizer' is the plugin, 'problem.mesh' a setting of one."""
    return [tuple(_chosen(cell.settings, name) for name in names) for cell in plan.cells]


def _chosen(settings, name):
    part, _, setting = name.partition(".")
    if isinstance(settings[part], dict):
        return settings[part][setting or "name"]
    return settings[part]


@pytest.mark.slow
def test_every_experiment_of_the_folder_is_planned(compose_all, place):
    names = sorted(path.stem for path in (CONF / "experiment").glob("*.yaml"))
    assert names == sorted([*TABLES, "paper", "sweep", *REPETITIONS])
    (place / "docs").mkdir()
    (place / "docs" / "examples").symlink_to(EXAMPLES)  # some are run in the project's folder
    for name in names:
        for experiment in compose_all(f"+experiment={name}", *NEEDED.get(name, [])):
            plan = experiment.plan
            assert len(plan.runs) == len(plan.cells) * REPETITIONS.get(plan.name, 0 if plan.name == "table5" else 20)
            of_file = {"identify": "_run_up", "balance": "_balancing"}.get(name, "")
            assert experiment.output.is_relative_to(place / "results" / f"{name}{of_file}")
    (place / "docs" / "examples").unlink()
    (place / "docs").rmdir()


def test_table2_is_without_noise_and_shows_raw_amplitudes_too(plan_of):
    plan = plan_of("table2")
    names = ("measurement.kind", "surrogate.transform", "samples", "measurement.relative", "problem.mesh")
    assert chosen(plan, *names) == [
        *(("complex", "auto", samples, 0.0, 13) for samples in SAMPLES),
        *(("amplitude", "none", samples, 0.0, 13) for samples in SAMPLES),
    ]
    assert [cell.place["label"] for cell in plan.cells] == ["KSMEA"] * 4 + ["raw amplitudes"] * 4
    assert plan.report.exact == 0.1
    assert {_chosen(cell.settings, "method.max_updates") for cell in plan.cells} == {15}


@pytest.mark.slow
def test_every_effect_is_hidden_in_drawn_machines_of_its_own(plan_of):
    """Chosen as one kind, which has places for all: more machines than one for effects that other kinds can hardly have."""
    words = "diagnosis_effects_drawn", "problem.family=long", "label=drop 1000"
    machines = chosen(plan_of(*words), "measurement.hidden", "problem.instance")
    hidden = {str(effect) for effect, _ in machines}
    assert len(hidden) == 30 and "None" not in hidden
    assert len(machines) == len({instance for _, instance in machines}) == 55


@pytest.mark.parametrize("name, mesh", [("table3", 13), ("table4", 21)])
def test_tables_3_and_4_differ_in_the_mesh_alone(name, mesh, plan_of):
    plan = plan_of(name)
    assert chosen(plan, "samples", "problem.mesh", "measurement.relative") == [(n, mesh, 0.1) for n in SAMPLES]
    one, other = plan_of("table3", f"problem.mesh={mesh}"), plan_of(name)
    assert [run.key for run in one.runs] == [run.key for run in other.runs]


def test_table6_compares_six_methods(plan_of):
    plan = plan_of("table6")
    methods = ["KSMEA", "DE", "PSO", "GA", "RSM + DE", "LM"]
    assert [cell.place["label"] for cell in plan.cells] == methods
    assert chosen(plan, "method", "surrogate", "optimizer", "samples") == [
        ("ksmea", "kriging", "de", 100),
        ("direct", None, "de", None),
        ("direct", None, "pso", None),
        ("direct", None, "ga", None),
        ("ksmea", "rsm", "de", 100),
        ("direct", None, "lm", None),
    ]
    for cell in plan.cells[1:]:
        for part in ("problem", "measurement"):
            assert cell.settings[part] == plan.cells[0].settings[part]


def test_the_contest_is_every_method_on_every_instance_with_one_budget(plan_of):
    plan = plan_of("contest", "problem.instance=0")
    labels = list(dict.fromkeys(cell.place["label"] for cell in plan.cells))
    assert len(labels) == 14 and {"random search", "CMA-ES", "Kriging + DE"} <= set(labels)
    families = list(dict.fromkeys(chosen(plan, "problem.family")))
    assert [(cell.place["label"], cell.place["problem.family"]) for cell in plan.cells] == [
        (label, family) for label in labels for (family,) in families
    ]
    assert set(chosen(plan, "study.budget", "problem.held_back")) == {(2000, False)}
    for cell in plan.cells:
        if cell.settings["method"]["name"] == "ksmea":
            assert cell.settings["method"]["polish"] is False
    assert len({cell.seed for cell in plan.cells}) == len(
        families
    )  # other noise on another instance, and the same for all


def test_table8_is_the_rk4_rig_in_rpm(plan_of):
    plan = plan_of("table8")
    assert chosen(plan, "problem", "samples", "measurement.relative") == [("rk4", n, 0.02) for n in SAMPLES]
    speed = RK4().build().speed * 30 / np.pi
    assert (speed[0], speed[-1]) == (pytest.approx(1500), pytest.approx(2500))


@pytest.mark.parametrize("name", ["table2", "table3", "table4", "table6"])
def test_the_band_is_read_in_rad_per_s_and_in_rpm_on_request(name, plan_of):
    assert set(chosen(plan_of(name), "problem.reading")) == {("rad_s",)}
    assert set(chosen(plan_of(name, "problem.reading=rpm"), "problem.reading")) == {("rpm",)}
    assert ThreeDisk().build().speed[-1] == pytest.approx(1500)
    assert ThreeDisk(reading="rpm").build().speed[-1] == pytest.approx(1500 * np.pi / 30)


def test_the_sweep_is_noise_by_samples_by_mesh(plan_of):
    plan = plan_of("sweep")
    expected = {(noise, n, mesh) for noise in (0, 0.05, 0.1) for n in SAMPLES for mesh in (13, 21)}
    names = ("measurement.relative", "samples", "problem.mesh")
    assert len(plan.cells) == 3 * 4 * 2 and set(chosen(plan, *names)) == expected
    assert set(plan.axes) == set(names)
    other = plan_of("sweep", "measurement.relative=0.02,0.2", "samples=50", "optimizer=de,pso")
    assert set(chosen(other, *names, "optimizer")) == {
        (noise, 50, mesh, optimizer) for noise in (0.02, 0.2) for mesh in (13, 21) for optimizer in ("de", "pso")
    }


def test_the_paper_is_all_tables_which_share_their_runs(compose_all, plan_of, place):
    experiments = compose_all("+experiment=paper")
    assert [experiment.plan.name for experiment in experiments] == TABLES
    assert [experiment.output for experiment in experiments] == [place / "results" / "paper" / n for n in TABLES]
    for experiment in experiments:  # each is what it is alone
        assert experiment.plan.runs == plan_of(experiment.plan.name).runs
        assert experiment.plan.cells == plan_of(experiment.plan.name).cells
    plans = {experiment.plan.name: experiment.plan for experiment in experiments}
    hundred = [run.key for run in plans["table3"].runs if plans["table3"].cells[run.cell].settings["samples"] == 100]
    ksmea = [run.key for run in plans["table6"].runs if plans["table6"].cells[run.cell].place["label"] == "KSMEA"]
    assert hundred == ksmea and len(set(ksmea)) == 20
    shared = dict(zip(TABLES, (each.share for each in experiments)))
    assert place / "results" / "paper" / "table3" in shared["table6"]
    assert place / "results" / "table6" in shared["table6"]  # what it did alone
    assert place / "results" / "paper" / "table6" not in shared["table3"]  # it comes later


@pytest.mark.slow
def test_overrides_of_the_paper_reach_all_its_tables(compose_all):
    experiments = compose_all("+experiment=paper", "repetitions=2", "seed=3")
    for experiment in experiments[:3] + experiments[4:]:
        assert len(experiment.plan.runs) == 2 * len(experiment.plan.cells)
        assert {cell.seed for cell in experiment.plan.cells} == {3}


@pytest.fixture
def measured(monkeypatch):
    """The measurement that a run hands to its method, which goes no further."""
    handed = []

    def identify(self, problem, measurement, *others):
        handed.append(measurement)
        raise InterruptedError

    for method in (Direct, KSMEA):
        monkeypatch.setattr(method, "identify", identify)

    def call(plan, run):
        record = execute(plan.cells[run.cell].settings, plan.seeds(run))
        assert record["error"].startswith("InterruptedError")
        return handed.pop()

    return call


def test_all_methods_of_a_repetition_see_the_same_noise(plan_of, measured):
    """All methods of Table 6 and all numbers of samples of Table 3, to the last bit."""
    by_repetition = {}
    for plan in (plan_of("table6", "repetitions=3"), plan_of("table3", "repetitions=3")):
        for run in plan.runs:
            by_repetition.setdefault(run.repetition, []).append(measured(plan, run))
    assert [len(measurements) for measurements in by_repetition.values()] == [6 + 4] * 3
    for first, *others in by_repetition.values():
        assert first.noise.relative == 0.1
        for other in others:
            assert np.array_equal(other.values, first.values) and np.array_equal(other.speed, first.speed)
    one, two, three = (measurements[0].values for measurements in by_repetition.values())
    for a, b in ((one, two), (one, three), (two, three)):
        assert not np.any(a == b)


def test_the_noise_differs_between_seeds_and_is_that_of_the_experiments_size(plan_of, measured):
    plans = [plan_of("table3", "repetitions=20", f"seed={seed}", "samples=40") for seed in (0, 1)]
    values = np.array([[measured(plan, run).values for run in plan.runs] for plan in plans])
    assert not np.any(values[0] == values[1])
    clean = measured(*with_run(plan_of("table3", "measurement.relative=0", "samples=40"))).values
    spread = np.std(values / clean - 1)  # of 2 · 20 · 53 · 2 draws
    assert spread == pytest.approx(0.1, rel=0.05)


def with_run(plan):
    return plan, plan.runs[0]


def test_table5_agrees_with_the_defaults_in_every_printed_value(plan_of):
    frame = settings_frame(plan_of("table5"))
    printed = pd.read_csv(PAPER / "table5.csv")
    assert len(frame) == len(printed) == 11
    assert frame["paper"].tolist() == printed["value"].tolist()
    assert frame["agrees"].all() and frame["here"].notna().all()


def test_table5_shows_a_setting_that_is_not_the_printed_one(plan_of, tmp_path, capsys):
    plan = plan_of("table5", "optimizer.population=50")
    frame = settings_frame(plan)
    differing = frame[~frame["agrees"]]
    assert differing["optimizer"].tolist() == ["DE", "PSO", "GA"]
    assert (differing["setting"] == "population").all() and (differing["here"] == 50).all()
    write_plan(plan, tmp_path)
    assert collect(tmp_path) == 0
    assert pd.read_csv(tmp_path / "table5.csv")["agrees"].tolist() == frame["agrees"].tolist()
    assert capsys.readouterr().out.count("False") == 3


def identified(cell):
    """A record of a run of a cell that is 10 % off in every unknown."""
    return {
        "status": "done",
        "stop": "smc",
        "parameters": [
            {
                "name": facts.name,
                "unit": facts.unit,
                "si_per_unit": facts.si_per_unit,
                "true": facts.truth,
                "identified": 1.1 * facts.truth,
                "at_limit": False,
            }
            for facts in cell.parameters
        ],
        "misfit": 1.5,
        "updates": 3,
        "model_evaluations": 43,
        "model_jacobians": 0,
        "surrogate_evaluations": 1000,
        "seconds": {"model": 0.5, "surrogate": 0.25, "search": 0.25, "total": 2.0},
        "history": [],
    }


@pytest.mark.parametrize("name", WITH_VALUES)
def test_every_printed_value_stands_beside_ours(name, plan_of, tmp_path):
    plan = plan_of(name, "repetitions=1")
    with RecordWriter(tmp_path, 0, plan) as writer:
        for run in plan.runs:
            writer.result(run, identified(plan.cells[run.cell]))
    summary = summary_frame(plan, runs_frame(plan, tmp_path))
    (tmp_path / "table.csv").write_text(csv_text(summary))
    table = pd.read_csv(tmp_path / "table.csv")
    printed = pd.read_csv(PAPER / f"{name}.csv")
    column = "label" if "method" in printed else "samples"
    found = 0
    for row in printed.itertuples():
        place = row.method if column == "label" else row.samples
        rows = table[(table["parameter"] == row.parameter) & (table[column] == place)]
        assert len(rows) == (2 if name == "table2" else 1), (row.parameter, place)  # both ways of Table 2
        assert rows["paper"].eq(row.identified).all() and rows["median"].notna().all()
        assert rows["paper_error_pct"].tolist() == pytest.approx([row.error_pct_printed] * len(rows), nan_ok=True)
        if np.isfinite(row.reference):  # the values that ours are compared with are those the paper prints
            assert rows["reference"].tolist() == pytest.approx([row.reference] * len(rows))
            assert (rows["unit"] == row.unit).all()
        found += len(rows)
    assert table["paper"].notna().sum() == found  # and nothing else passes for the paper's


@pytest.mark.parametrize("name", WITH_VALUES)
def test_the_papers_values_stand_there_before_anything_is_run(name, plan_of, tmp_path):
    plan = plan_of(name, "repetitions=1")
    summary = summary_frame(plan, runs_frame(plan, tmp_path))
    printed = pd.read_csv(PAPER / f"{name}.csv")
    assert set(summary["paper"].dropna()) == set(printed["identified"])
    assert (summary["runs"] == 0).all() and summary["median"].isna().all()


def printed_text(name):
    return pd.read_csv(PAPER / f"{name}.csv", dtype=str)


def misprinted(name):
    """Places whose printed error is not |x/reference - 1| of the printed values to the digits that it has."""
    found = []
    for row in printed_text(name).dropna(subset=["error_pct_printed", "reference"]).itertuples():
        error = 100 * abs(float(row.identified) / float(row.reference) - 1)
        digits = len(row.error_pct_printed.partition(".")[2])
        if abs(error - float(row.error_pct_printed)) > (0.5 + 1e-9) * 10.0**-digits:
            found.append((row.parameter, str(getattr(row, "samples", None) or row.method)))
    return found


@pytest.mark.parametrize("name, expected", [("table3", 1), ("table4", 0), ("table6", 0), ("table8", 2)])
def test_every_printed_error_follows_from_the_printed_values_or_is_a_known_slip(name, expected):
    known = slips(name)
    places = {(row.parameter, row.at.removesuffix(" samples")) for row in known.itertuples()}
    found = misprinted(name)
    assert set(found) <= places, f"not in slips.csv: {set(found) - places}"
    assert len(found) == expected
    assert known["reason"].str.len().gt(0).all()


def test_the_other_slips_are_there_too():
    table3, table6 = (pd.read_csv(PAPER / f"{name}.csv") for name in ("table3", "table6"))
    columns = table3[table3["parameter"].isin(FIVE)].pivot(index="parameter", columns="samples", values="identified")
    assert columns[70].equals(columns[100]) and not columns[40].equals(columns[70])
    ksmea = table6[table6["method"] == "KSMEA"].set_index("parameter")["identified"]
    hundred = table3[table3["samples"] == 100].set_index("parameter")["identified"]
    assert ksmea.to_dict() == {name: hundred[name] for name in [*FIVE, "time"]}
    table8 = pd.read_csv(PAPER / "table8.csv").set_index(["parameter", "samples"])
    assert table8.loc[("kyy", 40), "identified"] == RK4().limits["kyy"][1]


def test_every_slip_is_of_a_table_and_is_printed_below_it(plan_of, tmp_path, no_figures, capsys):
    known = pd.read_csv(PAPER / "slips.csv")
    assert set(known["table"]) <= set(WITH_VALUES) and known.notna().all(axis=None)
    plan = plan_of("table8", "repetitions=1")
    write_plan(plan, tmp_path)
    collect(tmp_path)
    printed = capsys.readouterr().out
    for slip in known[known["table"] == "table8"].itertuples():
        assert f"slip in print: {slip.parameter}, {slip.at}: {slip.printed}; {slip.reason}" in printed
    assert printed.count("slip in print") == (known["table"] == "table8").sum()
    assert Path(tmp_path, "table8.csv").is_file()

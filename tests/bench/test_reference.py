"""Reference results name all that they were made from, and `verify` finds every value that is no longer so."""

import dataclasses
import shutil

import numpy as np
import pandas as pd
import pytest

from bench.commands.reference import read_reference, reference_tables, write_reference
from bench.commands.verify import frame_differences
from bench.plan.plan import read_plan, write_plan
from bench.plan.provenance import NUMERICAL
from bench.reports.runs import runs_frame
from bench.reports.tables import PAPER
from bench.storage.own_files import REFERENCE
from ksmea.errors import SettingError
from ksmea.plugins import registry

REPETITIONS = {
    "coverage": 2000,
    "efficiency": 100,
    "diagnosis_nulls": 300,
    "tolerances": 300,
    "audit": 1,
}  # 20 in the paper's tables
COMMITTED = reference_tables()
RUNS = 8  # of the small table3


@pytest.fixture(scope="module")
def released(table3, tmp_path_factory):
    """The small experiment as if committed code had computed it."""
    output = shutil.copytree(table3.output, tmp_path_factory.mktemp("released") / "table3")
    write_plan(dataclasses.replace(read_plan(output), commit="c0ffee"), output)
    return output


@pytest.fixture
def folder(released, tmp_path, monkeypatch):
    """Its reference, which `verify` reads instead of the committed ones and a test may change."""
    place = tmp_path / "reference"
    write_reference(released, place)
    monkeypatch.setattr("bench.commands.verify.read_reference", lambda table: read_reference(table, place))
    return place


def change(folder, row, column, factor, name="table3.runs.csv"):
    """Multiply one value of the runs, or a whole column where `row` is slice(None); the keys of the rows changed."""
    path = folder / name
    lines = path.read_text().splitlines(keepends=True)
    head = [line for line in lines if line.startswith("#")]
    frame = pd.read_csv(path, comment="#", dtype={"key": str})
    frame.loc[row, column] *= factor
    path.write_text("".join(head) + frame.to_csv(index=False))
    return frame.loc[row, "key"]


def test_what_is_written_is_read_back(released, tmp_path):
    written = write_reference(released, tmp_path)
    assert [path.name for path in written] == ["table3.csv", "table3.runs.csv"]
    plan, runs = read_reference("table3", tmp_path)
    original = read_plan(released)
    assert plan == dataclasses.replace(original, runs=())
    assert runs["key"].tolist() == [run.key for run in original.runs]
    table, whole = (pd.read_csv(path, comment="#") for path in (tmp_path / "table3.csv", released / "table3.csv"))
    pd.testing.assert_frame_equal(table, whole)
    made = pd.read_csv(released / "runs.csv", dtype={"key": str})
    pd.testing.assert_frame_equal(runs, made)


def test_an_undisturbed_reference_is_verified_run_by_run(folder, enter):
    ended = enter("verify", "table3", "workers=2")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out == f"table3: every value of {RUNS} runs; all {5 * RUNS} agree\n"


@pytest.mark.parametrize("factor", [1.00001, 0.5, np.nan])
def test_a_value_that_is_another_is_named(factor, folder, enter):
    key = change(folder, 1, "cyy", factor)
    ended = enter("verify", "table3", "repetitions=1")
    assert ended.code == 1
    verdict, *named = ended.out.splitlines()
    assert verdict == "table3: every value of 2 runs; 1 of 10 differ"
    [line] = named
    assert line.startswith(f"  cyy of run {key}: ") and "reference " in line and "allowed ± " in line


def test_a_tolerance_may_be_given(folder, enter):
    change(folder, 0, "kxx", 1.001)
    assert enter("verify", "table3", "repetitions=1").code == 1
    assert enter("verify", "table3", "repetitions=1", "tolerance=0.01").code == 0


def test_a_value_within_the_tolerance_agrees(folder, enter):
    change(folder, 0, "kxx", 1 + 1e-7)
    assert enter("verify", "table3", "repetitions=1").code == 0


@pytest.mark.parametrize(("now", "n_failure"), [((500.0, 3e-12), 0), ((500.0, 3e-6), 1), ((500.1, 7e-12), 1)])
def test_rounding_of_a_difference_that_is_zero_agrees(now, n_failure):
    """A drop of a deviance of some hundreds is known to 1e-13 of them."""
    was = pd.DataFrame({"deviance_drop": [500.0, 7e-12], "verdict": ["named", "adequate"]})
    found = frame_differences(was, was.assign(deviance_drop=now), 1e-6)
    assert sum(difference.is_failure for difference in found) == n_failure


def test_a_subset_of_the_repetitions_sees_nothing_of_the_others(folder, enter):
    key = change(folder, RUNS - 1, "kxx", 1.01)  # of the last repetition
    subset = enter("verify", "table3", "repetitions=1")
    assert (subset.code, subset.out) == (0, "table3: every value of 2 runs; all 10 agree\n")
    whole = enter("verify", "table3")
    assert whole.code == 1 and f"kxx of run {key}" in whole.out


def test_a_run_that_fails_now_is_a_difference_in_all_its_values(folder, enter, monkeypatch):
    key = read_reference("table3", folder)[1]["key"][0]

    def run_tasks(function, tasks, *others):
        return (
            (given.task, {"status": "error"} if given.task == key else function(*given.arguments)) for given in tasks
        )

    monkeypatch.setattr("bench.commands.verify.run_tasks", run_tasks)
    ended = enter("verify", "table3", "repetitions=1")
    assert ended.code == 1 and "5 of 10 differ" in ended.out
    assert ended.out.count(f"of run {key}: nan") == 5


@pytest.fixture
def elsewhere(monkeypatch):
    monkeypatch.setattr("bench.commands.verify.platform_name", lambda: "abacus")


def test_on_another_platform_medians_are_compared(folder, enter, elsewhere):
    change(folder, 1, "cyy", 1 + 1e-5)  # a difference that this platform would not forgive
    ended = enter("verify", "table3")
    assert ended.code == 0
    platform = read_reference("table3", folder)[0].platform
    assert f"other libraries or processor than the reference ({platform})" in ended.out
    assert ended.out.endswith(f"medians of {RUNS} runs; all 10 agree\n")


@pytest.mark.parametrize("part, code", [(0.95, 0), (1.05, 1), (-0.95, 0), (-1.05, 1)])
def test_on_another_platform_a_median_may_move_by_the_quartiles_distance(part, code, folder, enter, elsewhere):
    values = read_reference("table3", folder)[1]
    cell = values["cell"] == 0
    q1, q3 = np.percentile(values.loc[cell, "kxx"], [25, 75])
    change(folder, cell, "kxx", 1 + part * (q3 - q1) / values.loc[cell, "kxx"])
    ended = enter("verify", "table3")
    assert ended.code == code
    for line in ended.out.splitlines()[1:]:
        assert line.startswith("  median kxx of cell 0 (samples=25): ")


def test_on_another_platform_runs_that_all_agree_may_differ_by_the_tolerance(released, enter, elsewhere, monkeypatch):
    """As of a single repetition, or of data without noise: no quartiles apart, and yet rounding differs."""
    plan, runs = reference_of(released, repetitions=1)
    monkeypatch.setattr("bench.commands.verify.read_reference", lambda table: (plan, runs))
    assert enter("verify", "table3").code == 0
    runs["kxx"] *= 1 + 5e-7
    assert enter("verify", "table3").code == 0
    runs["kxx"] *= 1 + 5e-6
    ended = enter("verify", "table3")
    assert ended.code == 1 and ended.out.count("median kxx") == ended.out.count("median") - 1 == 2


def reference_of(released, repetitions):
    plan = read_plan(released)
    runs = runs_frame(plan, released)
    return plan, runs[runs["repetition"] < repetitions].copy()


def test_other_libraries_are_another_platform(folder, enter, monkeypatch):
    monkeypatch.setattr("bench.commands.verify.library_versions", lambda: {"numpy": "0.1"})
    assert "medians of 2 runs" in enter("verify", "table3", "repetitions=1").out


@pytest.mark.parametrize(
    "words, expected",
    [
        (["verify", "tabel3"], "unknown reference table 'tabel3'; did you mean 'table3'? known: table3"),
        (["verify"], "verify: expected the name of a table, for example table3, got nothing"),
        (["verify", "table3", "repetitons=1"], "unknown option of verify: 'repetitons'; did you mean 'repetitions'?"),
        (["verify", "table3", "repetitions=few"], "verify: expected a number for repetitions, got 'few'"),
        (["verify", "table3", "repetitions=0"], "verify: expected repetitions above 0, got 0"),
        (["verify", "table3", "tolerance=-1"], "verify: expected tolerance above 0, got -1"),
        (["reference", "tabel3"], "unknown results 'tabel3'"),
    ],
)
def test_what_cannot_be_verified_is_one_line(words, expected, folder, enter):
    ended = enter(*words)
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    assert line.startswith(f"error: {expected}")


def test_the_command_makes_a_reference_where_verify_finds_it(released, enter, tmp_path, monkeypatch):
    made = tmp_path / "made"
    monkeypatch.setattr("bench.commands.reference.write_reference", lambda output: write_reference(output, made))
    ended = enter("reference", str(released))
    assert (ended.code, ended.out.splitlines()) == (
        0,
        [f"written: {made / name}" for name in ("table3.csv", "table3.runs.csv")],
    )


def test_results_of_changed_code_are_no_reference(released, tmp_path):
    output = shutil.copytree(released, tmp_path / "table3")
    write_plan(dataclasses.replace(read_plan(output), commit="c0ffee+"), output)
    with pytest.raises(SettingError, match=r"expected results of committed code, got c0ffee\+") as caught:
        write_reference(output, tmp_path / "reference")
    assert "\n" not in str(caught.value) and not (tmp_path / "reference").exists()


def test_an_experiment_without_all_its_results_is_no_reference(released, tmp_path):
    output = shutil.copytree(released, tmp_path / "table3")
    record = output / "records" / "batch-0000.jsonl"
    record.write_text("".join(record.read_text().splitlines(keepends=True)[:-1]))
    with pytest.raises(SettingError, match="expected a result of every planned run") as caught:
        write_reference(output, tmp_path / "reference")
    assert "\n" not in str(caught.value) and not (tmp_path / "reference").exists()


@pytest.fixture
def table5(enter, tmp_path, monkeypatch):
    """The reference of a table of settings, of which there are no runs."""
    monkeypatch.setattr("bench.plan.experiment.commit", lambda: "c0ffee")
    assert enter("+experiment=table5").code == 0
    place = tmp_path / "reference"
    assert write_reference(tmp_path / "results" / "table5", place) == [place / "table5.csv"]
    monkeypatch.setattr("bench.commands.verify.read_reference", lambda table: read_reference(table, place))
    return place / "table5.csv"


def test_a_table_of_settings_is_verified_by_the_defaults(table5, enter):
    ended = enter("verify", "table5")
    assert (ended.code, ended.out) == (0, "table5: settings by default; all 11 agree\n")
    table5.write_text(table5.read_text().replace('"mutation_factor": 0.8', '"mutation_factor": 0.7'))
    ended = enter("verify", "table5")
    assert ended.code == 1
    assert ended.out.splitlines()[1:] == ["  mutation_factor of de: 0.8, reference 0.7, allowed ± 0"]


@pytest.fixture(scope="module")
def diagnosed(apart, tmp_path_factory):
    """Two diagnoses of each of two right models with few effects, as if committed code had made them."""
    few = ["label=complex,amplitudes", "study.effects=[runout,mass]", "problem.sensors=[0.1]", "repetitions=2"]
    ended = apart("+experiment=diagnosis_nulls", *few, cwd=tmp_path_factory.mktemp("nulls"))
    output = ended.output.parent / "diagnosis_nulls"
    write_plan(dataclasses.replace(read_plan(output), commit="c0ffee"), output)
    return output


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "value", "what"),
    [(None, None, None), ("verdict", "named", "verdict"), ("deviance_drop", 2.0, "deviance_drop")],
)
def test_tables_of_other_studies_are_computed_again(diagnosed, tmp_path, monkeypatch, enter, column, value, what):
    """Numbers and words of the runs, and of the table where all runs are computed; times may be others."""
    assert [path.name for path in write_reference(diagnosed, tmp_path)] == [
        "diagnosis_nulls.csv",
        "diagnosis_nulls.runs.csv",
    ]
    path = tmp_path / "diagnosis_nulls.runs.csv"
    head = [line for line in path.read_text().splitlines(keepends=True) if line.startswith("#")]
    frame = pd.read_csv(path, comment="#", dtype={"key": str})
    frame["seconds"] *= 3
    if column is not None:
        frame.loc[0, column] = value if isinstance(value, str) else frame.loc[0, column] * value
    path.write_text("".join(head) + frame.to_csv(index=False))
    monkeypatch.setattr("bench.commands.verify.read_reference", lambda table: read_reference(table, tmp_path))
    monkeypatch.setattr("bench.commands.verify.REFERENCE", tmp_path)
    ended = enter("verify", "diagnosis_nulls", *(["repetitions=1"] if column else []))
    assert ended.code == (1 if column else 0), ended.err
    assert ("all" in ended.out and "agree" in ended.out) if column is None else f"{what} in row 1" in ended.out


@pytest.mark.skipif(not COMMITTED, reason="no reference results are there yet")
@pytest.mark.parametrize("table", COMMITTED or ["none"])
def test_every_committed_reference_names_all_that_it_was_made_from(table):
    plan, frame = read_reference(table)
    assert plan.name == table and plan.command[0] == f"+experiment={table}"
    assert plan.commit and not plan.commit.endswith("+")
    assert {"python", *NUMERICAL} <= set(plan.versions) and plan.platform
    assert len(plan.cells) > 0 and plan.modules
    for cell in plan.cells:
        assert set(registry.GROUPS) <= set(cell.settings) and cell.seed >= 0
    for name in (f"{table}.csv", f"{table}.runs.csv"):
        path = REFERENCE / name
        if path.is_file():
            head = path.read_text(encoding="utf-8").splitlines()[: 1 + len(plan.cells)]
            assert all(line.startswith('# {"') for line in head)
    if plan.report.table == "settings":
        assert frame["agrees"].all()
        return
    assert frame["status"].isin(["done", "budget"]).all()
    for index, cell in enumerate(plan.cells):
        rows = frame[frame["cell"] == index]
        assert rows["repetition"].tolist() == list(range(REPETITIONS.get(table, 20)))
        assert "seed" not in rows or (rows["seed"] == cell.seed).all()
        if plan.report.table in ("summary", "calibration"):
            assert rows[[parameter.name for parameter in cell.parameters]].notna().all(axis=None)


@pytest.mark.skipif(not COMMITTED, reason="no reference results are there yet")
def test_a_committed_table_is_the_medians_of_its_runs():
    for table in COMMITTED:
        path = REFERENCE / f"{table}.csv"
        summary, (plan, runs) = pd.read_csv(path, comment="#"), read_reference(table)
        if plan.report.table != "summary":
            continue
        kxx = summary[summary["parameter"] == "kxx"]
        medians = [runs.loc[runs["cell"] == cell, "kxx"].median() for cell in range(len(plan.cells))]
        assert kxx["median"].to_numpy() == pytest.approx(medians, rel=1e-8)
        assert set(summary["paper"].dropna()) == set(pd.read_csv(PAPER / f"{table}.csv")["identified"])

"""Output of `python -m bench +experiment=table3` with overrides of one's own."""

import json

import numpy as np
import pandas as pd
import pytest

from tiers import mostly_slow

PARAMETERS = ["kxx", "kyy", "cxx", "cyy", "u"]
HEADER = (
    "parameter,unit,reference,samples,paper,paper_error_pct,median,q1,q3,error_pct_median,crlb_pct,most_likely,"
    "low,high,covered_pct,ended_short_pct,excess_deviance,beyond_pct,runs,failed"
)


CLOCK = ("time", "interval_seconds")
WITHOUT = "study.intervals=none"  # most of the time of a run of few evaluations


def without_times(ended):
    """table3.csv and runs.csv but for what a clock says."""
    table, runs = ended.table(), ended.runs()
    return table[table["parameter"] != "time"], runs.loc[:, ~runs.columns.str.startswith(CLOCK)]


def assert_same(ended, other):
    for one, two in zip(without_times(ended), without_times(other)):
        pd.testing.assert_frame_equal(one, two, check_exact=True)


def traces(ended):
    """The trace of each run but for what a clock says."""
    return {line["key"]: {**line["trace"], "seconds": None} for line in ended.events()}


def test_a_small_table3_ends_well_and_leaves_its_files(table3):
    assert table3.code == 0, table3.err
    assert {path.name for path in table3.output.iterdir()} >= {
        "plan.jsonl", "records", "runs.csv", "table3.csv", "table3.png"
    }  # fmt: skip
    assert (table3.output / "table3.png").read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in table3.output.parent.parent.iterdir()] == ["results"]


def test_it_prints_the_table_beside_the_papers(table3):
    head, *lines = table3.out.splitlines()
    for word in ("parameter", "unit", "reference", "samples", "median", "[q1, q3]", "paper", "runs", "failed"):
        assert word in head
    first = [line.split()[0] for line in lines if line.strip()]
    assert first[:16] == [name for name in [*PARAMETERS, "updates", "model", "time"] for _ in range(2)]
    assert "all 8 runs of table3 have a result" in table3.out
    assert "runs.csv, table3.csv, table3.png" in table3.out
    assert table3.err == ""


def test_table3_csv_is_tidy(table3):
    assert (table3.output / "table3.csv").read_text().splitlines()[0] == HEADER
    table = table3.table()
    assert table["parameter"].tolist() == [
        name for name in [*PARAMETERS, "updates", "model_evaluations", "time"] for _ in range(2)
    ]
    assert table["samples"].tolist() == [25, 30] * 8
    assert table["runs"].tolist() == [4] * 16 and table["failed"].tolist() == [0] * 16
    assert table["median"].notna().all() and (table["q1"] <= table["q3"]).all()
    references = table.drop_duplicates("parameter").set_index("parameter")["reference"]
    assert references[PARAMETERS].tolist() == [50, 70, 0.5, 0.7, 200]  # Table 1 of the paper, in the units printed
    assert references[["updates", "model_evaluations", "time"]].isna().all()


def test_runs_csv_has_a_row_per_run_that_agrees_with_the_table(table3):
    runs, table = table3.runs(), table3.table().set_index(["parameter", "samples"])
    assert sorted(zip(runs["samples"], runs["repetition"])) == [(n, r) for n in (25, 30) for r in range(4)]
    assert set(runs["status"]) <= {"done", "budget"}
    assert runs["model_evaluations"].between(26, 32).all() and (runs["updates"] <= 2).all()
    for (name, samples), row in table.iterrows():
        assert row["median"] == pytest.approx(runs.loc[runs["samples"] == samples, name].median(), rel=1e-9)


def test_every_run_has_one_record_with_a_start_before_it(table3):
    keys = set(table3.runs()["key"])
    events = [json.loads(line) for line in table3.records().splitlines()]
    assert {event["key"] for event in events if event["event"] == "result"} == keys
    assert len(table3.events("result")) == len(table3.events("started")) == len(keys) == 8
    for key in keys:
        assert [event["event"] for event in events if event.get("key") == key] == ["started", "result"]


def test_another_call_computes_nothing_and_says_the_same(table3, quick, apart):
    before = {path: path.read_bytes() for path in table3.output.glob("records/*.jsonl")}
    again = apart(*quick, "repetitions=4", "workers=2", draws=True, cwd=table3.output.parent.parent)
    assert (again.code, again.out) == (0, table3.out)
    assert {path: path.read_bytes() for path in table3.output.glob("records/*.jsonl")} == before


@pytest.mark.slow
def test_more_repetitions_compute_the_new_ones_only(enter, cheapest):
    first = enter(*cheapest, "repetitions=2")
    kept = first.records()
    more = enter(*cheapest, "repetitions=3")
    assert more.code == 0 and more.records().startswith(kept)
    assert len(more.events()) == 3
    fewer = enter(*cheapest, "repetitions=1")
    assert fewer.runs()["repetition"].tolist() == [0]


def test_one_worker_computes_what_two_do(table3, quick, enter):
    alone = enter(*quick, "repetitions=4", "workers=1", output="results/table3")
    assert alone.code == 0
    assert_same(alone, table3)
    assert traces(alone) == traces(table3)
    for ended, workers in ((alone, 1), (table3, 2)):
        assert f"8 runs to do with {workers} workers" in (ended.output / "table3.log").read_text()


@pytest.mark.slow
def test_another_seed_gives_other_numbers(enter, cheapest):
    seeds = [enter(*cheapest, "repetitions=1", f"seed={seed}", f"output=s{seed}", output=f"s{seed}") for seed in (0, 5)]
    zero, five = (ended.runs() for ended in seeds)
    assert five["seed"].tolist() == [5]
    assert (zero[PARAMETERS].to_numpy() != five[PARAMETERS].to_numpy()).all()


def test_single_values_reach_the_runs(enter):
    words = ["repetitions=3", "seed=5", "workers=1", "output=mine", "samples=30", "optimizer=pso", "surrogate=rsm"]
    words += [
        "problem.mesh=21",
        "measurement.relative=0.05",
        "optimizer.generations=1",
        "method.max_updates=1",
        WITHOUT,
    ]
    ended = enter("+experiment=table3", *words, output="mine")
    assert ended.code == 0
    [cell] = ended.cells()
    settings = cell["settings"]
    assert (settings["optimizer"]["name"], settings["surrogate"]["name"]) == ("pso", "rsm")
    assert (settings["problem"]["mesh"], settings["measurement"]["relative"]) == (21, 0.05)
    assert (settings["samples"], settings["optimizer"]["generations"]) == (30, 1)
    runs = ended.runs()
    assert runs["seed"].tolist() == [5] * 3 and runs["repetition"].tolist() == [0, 1, 2]
    assert ended.table().columns.tolist() == HEADER.split(",")  # a single value is no axis


SWEEPS = {
    "optimizer": ["de", "pso"],
    "surrogate": ["none", "rsm"],
    "problem.mesh": [13, 21],
    "measurement.relative": [0.05, 0.1],
    "seed": [1, 2],
    "method": ["ksmea", "direct"],
}


@pytest.mark.parametrize("key", mostly_slow(SWEEPS, but=["optimizer"]))
def test_a_list_is_a_sweep_with_a_column_of_its_own(key, enter):
    words = ["method.max_updates=1", "surrogate=none", "optimizer.population=5", "optimizer.generations=1", WITHOUT]
    if key == "method":
        words.pop(0)  # which direct does not have
    words = [word for word in words if not word.startswith(f"{key}=")]
    values = SWEEPS[key]
    sweep = f"{key}={','.join(map(str, values))}"
    ended = enter("+experiment=table3", *words, "samples=25,30", "repetitions=1", sweep, output="results/table3")
    assert ended.code == 0, ended.err
    table, runs = ended.table(), ended.runs()
    assert table.columns.tolist() == HEADER.replace("samples", f"samples,{key}").split(",")
    for frame in (runs, table[table["parameter"] == "kxx"]):
        assert sorted(zip(frame["samples"], frame[key])) == sorted((n, value) for n in (25, 30) for value in values)
    expected = 3 if key == "method" else 4  # the direct method takes no samples: both its cells are the same run
    assert len(ended.events()) == runs["key"].nunique() == expected


@pytest.mark.slow
def test_sweeps_multiply(enter, cheapest):
    words = [word for word in cheapest if not word.startswith("samples")]
    ended = enter(*words, "repetitions=2", "samples=25,26", "problem.mesh=13,21", "measurement.relative=0,0.1")
    assert ended.code == 0
    runs = ended.runs()
    assert len(runs) == 2 * 2 * 2 * 2 and runs["key"].is_unique
    assert len(ended.table("run")) == 8 * 8


def test_the_noise_of_a_repetition_is_the_same_for_every_method(enter):
    """Two searches that both reach the minimum find the same one only where the data are the same."""
    words = ["method=direct", "optimizer=lm", "optimizer.screening=500", "optimizer.starts=2", "repetitions=2"]
    ended = enter(*words, "measurement.relative=0.05", "optimizer.max_iterations=60,80")
    misfits = ended.runs().pivot(index="repetition", columns="optimizer.max_iterations", values="misfit")
    assert misfits[60].to_numpy() == pytest.approx(misfits[80].to_numpy(), rel=1e-6)
    assert abs(misfits[60][0] / misfits[60][1] - 1) > 1e-3  # and another one in another repetition


def test_batches_share_the_runs_and_none_is_done_twice(enter, cheapest):
    ended = enter(*cheapest, "repetitions=3", "batches=2", "workers=1")
    assert ended.code == 0
    files = sorted(ended.output.glob("records/*.jsonl"))
    keys = [
        line["key"]
        for path in files
        for line in map(json.loads, path.read_text().splitlines())
        if line["event"] == "result"
    ]
    assert sorted(keys) == sorted(ended.runs()["key"]) and len(set(keys)) == 3
    assert not (ended.output / "claims").exists()  # nothing is left of what only jobs at work need


def test_results_of_other_settings_are_not_taken_for_these(enter, cheapest):
    first = enter(*cheapest, "repetitions=1").runs()
    ended = enter(*cheapest, "repetitions=1", "measurement.relative=0.2")
    second = ended.runs()
    assert ended.code == 0 and len(ended.events()) == 2
    assert first["key"][0] != second["key"][0]
    assert not np.isclose(first["misfit"][0], second["misfit"][0], rtol=1e-6)


@pytest.mark.slow
def test_it_works_where_a_conf_of_someone_else_lies(shell, cheapest, tmp_path):
    (tmp_path / "conf" / "experiment").mkdir(parents=True)
    (tmp_path / "conf" / "config.yaml").write_text("name: wrong\nsamples: [\n")
    (tmp_path / "conf" / "experiment" / "table3.yaml").write_text("name: wrong\n")
    (tmp_path / "conf.py").write_text("raise SystemExit('the wrong conf')\n")
    folder = """it's a "folder" a=b, of 1"""
    quoted = folder.replace("'", "\\'")
    ended = shell("+experiment=table3", *cheapest, "repetitions=1", f"output='{quoted}'", cwd=tmp_path, output=folder)
    assert (ended.code, ended.err) == (0, "")
    assert ended.output.is_dir() and ended.table()["runs"].eq(1).all()
    assert {path.name for path in tmp_path.iterdir()} == {"conf", "conf.py", folder}


@pytest.mark.parametrize("folder", ["back\\slash", "a b {1,2}\\", "quote'\\'s $é"])
def test_an_output_with_signs_of_hydras_grammar(folder, enter, cheapest):
    quoted = quoted_for_hydra(folder)
    ended = enter(*cheapest, "repetitions=1", f"output={quoted}", output=folder)
    assert ended.code == 0, ended.err
    assert (ended.output / "run.csv").is_file()
    assert [path.name for path in ended.output.parent.iterdir()] == [folder]


def quoted_for_hydra(text):
    """Hydra's rule: quotes are escaped, and backslashes only where a quote follows."""
    parts = (text + "'").split("'")
    escaped = [part + "\\" * (len(part) - len(part.rstrip("\\"))) for part in parts[:-1]]
    return "'" + "\\'".join(escaped) + "'"


def test_without_an_experiment_it_is_a_single_cell_called_run(enter, cheapest):
    ended = enter(*cheapest, "repetitions=1")
    table = ended.table("run")
    assert table.columns.tolist() == HEADER.split(",")
    assert table["paper"].isna().all() and len(table) == 8
    assert "paper" not in ended.out


def test_experiment_needs_no_plus_sign(enter, cheapest):
    ended = enter("experiment=table3", *cheapest, "repetitions=1", output="results/table3")
    assert ended.code == 0 and (ended.output / "table3.csv").is_file()


@pytest.mark.parametrize("name", ["problems.py", "optimizers/__init__.py"])
def test_a_module_in_the_working_directory_that_hides_the_project_is_named(shell, tmp_path, name):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("raise SystemExit('the wrong one')")
    ended = shell("help", cwd=tmp_path)
    package = name.partition("/")[0].removesuffix(".py")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.startswith(f"error: {package}: expected this project's package, found {tmp_path}")
    assert ended.err.count("\n") == 1 and "`ksmea-bench`" in ended.err


@pytest.mark.parametrize("words", [["hydra.searchpath=[mine]"], ["--config-dir", "mine"]])
def test_experiments_of_ones_own_are_found_in_folders_of_ones_own(enter, cheapest, tmp_path, words):
    (tmp_path / "mine" / "experiment").mkdir(parents=True)
    (tmp_path / "mine" / "experiment" / "own.yaml").write_text("# @package _global_\nname: own\nrepetitions: 1\n")
    ended = enter("+experiment=own", *words, *cheapest, output="results/own")
    assert ended.code == 0 and "the run of own has a result" in ended.out, ended.err


HEAD = "# @package _global_\nname: own\n"


@pytest.mark.parametrize(
    "text, line",
    [
        (HEAD + "grid: [{method: direct\n", "own.yaml line 4: expected YAML, got a syntax error"),
        ("name: own\n", "own.yaml: expected '# @package _global_' as its first line"),
        (HEAD + "sampels: 3\n", "own.yaml: unknown setting 'sampels'; did you mean 'samples'?"),
        (HEAD + "method: {bugdet: 3}\n", "own.yaml: unknown setting 'method.bugdet'; did you mean 'method.budget'?"),
        (HEAD + "grid: [{samples: many}]\n", "own.yaml: samples: expected a whole number, got 'many'"),
        (
            HEAD + "optimizer: {population: 2}\n",
            "own.yaml: optimizer=de: population: expected a number at least 5, got 2",
        ),
        (HEAD + "figures: [tracks]\n", "own.yaml: unknown value for figures: 'tracks'; did you mean 'trace'?"),
    ],
)
def test_an_error_in_an_experiment_of_ones_own_names_its_file(enter, tmp_path, monkeypatch, text, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine" / "experiment").mkdir(parents=True)
    (tmp_path / "mine" / "experiment" / "own.yaml").write_text(text)
    ended = enter("--config-dir", "mine", "+experiment=own")
    assert (ended.code, ended.err.count("\n")) == (2, 1)
    assert line in ended.err and "mine/experiment" in ended.err


def test_help_lists_experiments_of_ones_own_and_a_folder_that_is_not_there_is_named(enter, tmp_path):
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "own_one.yaml").write_text(HEAD)
    for words in (["--config-dir", str(tmp_path)], [f"hydra.searchpath=[{tmp_path}]"]):
        assert ", own_one, " in enter("help", *words).out
    for words in (["--config-dir=nowhere"], ["hydra.searchpath=[nowhere]"]):
        ended = enter("+experiment=own_one", *words)
        assert ended.code == 2 and ended.err.startswith("error: nowhere: expected a folder with configuration files"), (
            ended.err
        )


def test_the_launcher_of_joblib_gives_the_same_table(shell, apart, cheapest, tmp_path):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher", reason="hydra-joblib-launcher is not installed")
    words = ["+experiment=table3", *cheapest, "samples=25,30", "repetitions=2"]
    basic = apart(*words, cwd=tmp_path)
    joblib = shell(*words, "hydra/launcher=joblib", "batches=2", "output=results/joblib", cwd=tmp_path)
    assert joblib.code == 0, joblib.err
    pd.testing.assert_frame_equal(*(table[table["parameter"] != "time"] for table in (basic.table(), joblib.table())))

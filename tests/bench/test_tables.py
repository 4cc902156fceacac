"""Tables from records made by hand, whose medians and quartiles can be computed by hand."""

import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import bench
from bench.jobs.records import RecordWriter
from bench.plan.plan import write_plan
from bench.reports.collect import collect
from bench.reports.pages.document import facts_of

PAPER = Path(bench.__file__).parent / "paper" / "table3.csv"
HEADER = (
    "parameter,unit,reference,samples,paper,paper_error_pct,median,q1,q3,error_pct_median,crlb_pct,most_likely,"
    "low,high,covered_pct,ended_short_pct,excess_deviance,beyond_pct,runs,failed"
)
NAN = float("nan")


def identified(kxx, u, status="done", updates=3, evaluations=43, seconds=2.0):
    """A record with kxx in N/m and u in kg m."""
    values = (("kxx", "MN/m", 1e6, 50e6, kxx), ("u", "g mm", 1e-6, 2e-4, u))
    return {
        "status": status,
        "stop": "smc",
        "parameters": [
            {"name": name, "unit": unit, "si_per_unit": size, "true": true, "identified": value, "at_limit": False}
            for name, unit, size, true, value in values
        ],
        "misfit": 1.5,
        "updates": updates,
        "model_evaluations": evaluations,
        "model_jacobians": 0,
        "surrogate_evaluations": 1000,
        "seconds": {"model": 0.5, "surrogate": 0.25, "search": 0.25, "total": seconds},
        "history": [],
        "notes": {},
        "elapsed": seconds,
    }


ERROR = {"status": "error", "error": "ValueError: singular", "traceback": "Traceback …"}


@pytest.fixture
def collected(no_figures, collected_and_drawn):
    return collected_and_drawn


@pytest.fixture
def collected_and_drawn(tmp_path, plan, capsys):
    """Write the records of the plan's runs, in its order (None: not run), and collect: code, table, runs, print."""

    def call(*records):
        write_plan(plan, tmp_path)
        with RecordWriter(tmp_path, 0, plan) as writer:
            for run, record in zip(plan.runs, records):
                if record is not None:
                    writer.started(run)
                    if record != {}:
                        writer.result(run, record)
        code = collect(tmp_path)
        table = pd.read_csv(tmp_path / "table3.csv").set_index(["parameter", "samples"])
        return code, table, pd.read_csv(tmp_path / "runs.csv"), capsys.readouterr().out

    return call


# In the plan's order: repetitions one after the other, 40 and 70 samples in each.
RECORDS = [
    identified(50.5e6, 2.02e-4, updates=1, evaluations=41, seconds=4.0),
    identified(45e6, 1.8e-4),
    identified(49e6, 1.96e-4, updates=2, evaluations=42, seconds=1.0),
    identified(55e6, 2.2e-4, status="budget"),
    identified(52e6, 2.2e-4, updates=9, evaluations=49, seconds=2.0),
    ERROR,
    ERROR,
    {},  # started and no more
]


def test_medians_quartiles_errors_and_counts(collected):
    _, table, _, _ = collected(*RECORDS)
    kxx = table.loc[("kxx", 40)]
    # of 49, 50.5, 52 MN/m; their errors are 2, 1 and 4 %, whose median is not that of the signed ones
    assert [kxx["median"], kxx["q1"], kxx["q3"]] == pytest.approx([50.5, 49.75, 51.25])
    assert kxx["error_pct_median"] == pytest.approx(2.0)
    assert (kxx["runs"], kxx["failed"], kxx["reference"], kxx["unit"]) == (3, 1, 50, "MN/m")
    u = table.loc[("u", 40)]  # of 196, 202, 220 g mm; errors 2, 1, 10 %
    assert [u["median"], u["q1"], u["q3"], u["error_pct_median"]] == pytest.approx([202, 199, 211, 2.0])
    assert (u["reference"], u["unit"]) == (pytest.approx(200), "g mm")
    both = table.loc[("kxx", 70)]  # of 45 and 55 MN/m: right in the median, and yet each is 10 % off
    assert [both["median"], both["q1"], both["q3"], both["error_pct_median"]] == pytest.approx([50, 47.5, 52.5, 10])
    assert (both["runs"], both["failed"]) == (2, 1)  # and one was interrupted


def test_rows_of_effort(collected):
    _, table, _, _ = collected(*RECORDS)
    assert table.loc[("updates", 40), ["median", "q1", "q3"]].tolist() == [2, 1.5, 5.5]
    assert table.loc[("model_evaluations", 40), ["median", "q1", "q3"]].tolist() == [42, 41.5, 45.5]
    assert table.loc[("time", 40), ["median", "q1", "q3"]].tolist() == [2, 1.5, 3]
    assert table.loc[("time", 40), "unit"] == "s"
    for name in ("updates", "model_evaluations", "time"):
        assert table.loc[(name, 40), ["reference", "error_pct_median"]].isna().all()
        assert table.loc[(name, 40), ["runs", "failed"]].tolist() == [3, 1]


def test_header_and_rows(collected, tmp_path):
    collected(*RECORDS)
    with (tmp_path / "table3.csv").open() as file:
        assert file.readline() == HEADER + "\n"
        rows = [(row[0], row[3]) for row in csv.reader(file)]
    assert rows == [(name, n) for name in ("kxx", "u", "updates", "model_evaluations", "time") for n in ("40", "70")]


def test_the_papers_values_are_those_it_prints(collected):
    _, table, _, out = collected(*RECORDS)
    with PAPER.open() as file:
        printed = {(row["parameter"], int(row["samples"])): row for row in csv.DictReader(file)}
    for place in table.index:
        row = printed.get(place, {"identified": "", "error_pct_printed": ""})
        for column, name in (("paper", "identified"), ("paper_error_pct", "error_pct_printed")):
            expected = float(row[name]) if row[name] else NAN
            assert table.loc[place, column] == pytest.approx(expected, nan_ok=True)
    assert table.loc[("kxx", 40), ["paper", "paper_error_pct"]].tolist() == [50.3, 0.6]
    assert table.loc[("time", 70), "paper"] == 231.32
    assert np.isnan(table.loc[("model_evaluations", 40), "paper"])
    assert "50.3" in out.splitlines()[1]


def test_failed_runs_are_counted_and_keep_a_row(collected):
    code, _, runs, out = collected(*RECORDS)
    assert code == 1
    assert runs["status"].tolist() == ["done", "done", "done", "budget", "done", "error", "error", "interrupted"]
    assert runs["repetition"].tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    failed = runs[runs["status"].isin(["error", "interrupted"])]
    assert failed[["kxx", "u", "misfit", "updates", "time"]].isna().all(axis=None)
    assert failed["error"].tolist()[:2] == ["ValueError: singular"] * 2
    assert runs["error"].isna().tolist() == [True] * 5 + [False] * 3
    assert "2 of 8 failed (2 × error: ValueError: singular); 1 of 8 interrupted; the same command does the rest" in out


def test_a_run_that_is_being_computed_is_told_as_that(collected, plan, tmp_path, capsys):
    """A repeated command would be refused meanwhile, so that it is not advised."""
    collected(*RECORDS)
    with RecordWriter(tmp_path, 0, plan) as writer:
        writer.started(plan.runs[-1])
        collect(tmp_path)
    out = capsys.readouterr().out
    assert "1 of 8 running\n" in out and "interrupted" not in out and "same command" not in out


def test_a_row_of_runs_csv_says_what_the_record_says(collected, plan):
    _, _, runs, _ = collected(*RECORDS)
    row = runs.iloc[3]
    assert (row["key"], row["samples"], row["repetition"], row["seed"]) == (plan.runs[3].key, 70, 1, 0)
    assert (row["kxx"], row["u"], row["stop"]) == (pytest.approx(55), pytest.approx(220), "smc")
    assert (row["kxx_error_pct"], runs.iloc[1]["kxx_error_pct"]) == (pytest.approx(10), pytest.approx(-10))
    assert (row["model_evaluations"], row["updates"], row["time"], row["time_model"]) == (43, 3, 2.0, 0.5)


def test_what_was_not_run_is_said_and_counted(collected, tmp_path):
    code, table, runs, out = collected(RECORDS[0])
    facts = facts_of((tmp_path / "index.html").read_text(encoding="utf-8")[:8192])
    assert (facts["runs"], facts["failed"], facts["unfinished"]) == (8, 0, 7)
    assert code == 1 and "7 of 8 not run; the same command does the rest" in out and "of 8 failed" not in out
    assert runs["status"].tolist() == ["done"] + ["not run"] * 7
    assert table.loc[("kxx", 40), ["median", "q1", "q3", "runs", "failed"]].tolist() == [50.5, 50.5, 50.5, 1, 0]
    assert table.loc[("kxx", 70), ["runs", "failed"]].tolist() == [0, 0]
    assert table.loc[("kxx", 70), ["median", "q1", "q3", "error_pct_median"]].isna().all()


@pytest.mark.parametrize("record", [ERROR, None], ids=["all failed", "none run"])
def test_a_table_without_any_result_has_all_its_rows(record, collected):
    code, table, _, out = collected(*[record] * 8)
    said, n_failed = ("8 of 8 failed", 4) if record else ("8 of 8 not run", 0)
    assert code == 1 and said in out and "[–, –]" not in out
    assert len(table) == 10 and table["median"].isna().all() and (table["failed"] == n_failed).all()
    assert table.loc[("kxx", 40), "paper"] == 50.3


def test_all_results_are_a_success(collected):
    code, table, _, out = collected(*[identified(51e6, 2e-4)] * 8)
    assert code == 0 and "all 8 runs of table3 have a result" in out
    assert (table["runs"] == 4).all() and (table["failed"] == 0).all()


def test_a_message_of_several_lines_is_counted_in_one(collected):
    _, _, runs, out = collected({**ERROR, "error": "ValueError: first\nsecond"}, *[identified(51e6, 2e-4)] * 7)
    assert "1 of 8 failed (1 × error: ValueError: first second)" in out
    assert runs["status"].tolist() == ["error"] + ["done"] * 7


def test_collecting_twice_writes_the_same(collected, tmp_path, plan):
    collected(*RECORDS)
    before = [(tmp_path / name).read_bytes() for name in ("table3.csv", "runs.csv")]
    assert collect(tmp_path) == 1
    assert [(tmp_path / name).read_bytes() for name in ("table3.csv", "runs.csv")] == before


@pytest.mark.parametrize("records", [RECORDS, [ERROR] * 8], ids=["some failed", "all failed"])
def test_a_figure_is_drawn_whatever_failed(records, collected_and_drawn, tmp_path):
    collected_and_drawn(*records)
    assert (tmp_path / "table3.png").read_bytes().startswith(b"\x89PNG")

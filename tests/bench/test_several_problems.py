"""Sweeps over problems with other unknowns, figures that cannot be drawn, and reports of other packages."""

import os
import re

import pytest

from bench.plan.plan import read_plan
from bench.reports.collect import collect
from bench.reports.identification.course_charts import updates_chart
from bench.reports.identification.error_chart import error_chart
from bench.reports.identification.spread_chart import cells_with
from outside_package import on_path

FIGURES = "figures=[updates,response,cost]"
TWO = ["problem=three_disk,rk4_two_disk", "measurement.relative=0.05", "repetitions=1", "workers=1", FIGURES]
METADATA = "Metadata-Version: 2.1\nName: others\nVersion: 1.0\n"
ENTRY_POINTS = """\
[ksmea.reports]
worst = others_reports:Worst
homeless = others_reports:Homeless
breaks = others_reports:Breaks
"""
REPORTS = '''
from dataclasses import dataclass
from typing import ClassVar

from bench.plan.report import Made, Report
from bench.reports.runs import runs_frame


def fails():
    raise RuntimeError("no\\nink")


@dataclass(frozen=True)
class Worst(Report):
    """The run with the largest misfit."""

    study: ClassVar[str] = "identify"

    def make(self, plan, output):
        runs = runs_frame(plan, output)
        text = f"worst of {len(runs)}: {runs['misfit'].max():.3g}"
        figures = lambda: {"drawn.png": b"ink", "failed.png": fails}
        return Made(text, {"worst.txt": text.encode(), "runs.csv": runs.to_csv().encode()}, runs, figures)


@dataclass(frozen=True)
class Breaks(Report):
    """Made of nothing."""

    study: ClassVar[str] = "identify"

    def make(self, plan, output):
        raise KeyError("no such\\ncolumn")


@dataclass(frozen=True)
class Homeless(Report):
    def make(self, plan, output):
        raise AssertionError("made of records of no study")
'''


@pytest.fixture(scope="module")
def two(apart, cheapest, tmp_path_factory):
    """Two problems that share some unknowns, drawn with all figures."""
    return apart(*cheapest, *TWO, draws=True, cwd=tmp_path_factory.mktemp("two"), output="results/run")


@pytest.mark.slow
def test_problems_with_other_unknowns_share_an_experiment(two):
    assert (two.code, two.err) == (0, "")
    runs, table = two.runs(), two.table("run")
    assert runs["problem"].tolist() == ["three_disk", "rk4_two_disk"]
    assert {"u", "u1", "phase1", "u2", "phase2"} <= set(runs)
    assert table.loc[table["parameter"] == "kxx", "problem"].tolist() == ["three_disk", "rk4_two_disk"]
    assert table.loc[table["parameter"] == "u1", "problem"].tolist() == ["rk4_two_disk"]
    for name in ("run", "run_updates", "run_response", "run_cost"):
        assert (two.output / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_a_panel_shows_the_cells_that_have_its_parameter(two):
    plan = read_plan(two.output)
    found = {name: cells_with(plan, name, unit) for name, unit in (("kxx", "MN/m"), ("u", "g mm"), ("u1", "g mm"))}
    assert found == {"kxx": [0, 1], "u": [0], "u1": [1]}
    assert cells_with(plan, "kxx", "N/m") == [] and cells_with(plan, "time", "s") == [0, 1]


def test_updates_of_problems_with_fewer_unknowns_have_fewer_panels(plan):
    first, second = plan.cells
    second = type(second)(second.place, second.settings, second.seed, second.parameters[:1], second.code)
    chart = updates_chart(type(plan)(**{**vars(plan), "cells": (first, second)}), {})
    assert [len(stack) for stack in chart.stacks] == [3, 2]


def test_a_figure_that_cannot_be_drawn_is_one_line_and_costs_nothing_else(enter, cheapest, monkeypatch, capsys):
    ended = enter(*cheapest, "measurement.relative=0.05", "repetitions=1", "workers=1", FIGURES)
    for name in ("runs.csv", "run.csv"):
        (ended.output / name).unlink()

    def fails(*arguments):
        raise ValueError("too\nmany colours")

    monkeypatch.setattr("bench.reports.identification.summary.error_chart", fails)
    assert collect(ended.output) == 0
    printed = capsys.readouterr()
    assert printed.err == "run.png: cannot be drawn (ValueError: too many colours); the tables are written\n"
    assert "the run of run has a result" in printed.out
    names = {path.name for path in ended.output.iterdir()}
    assert {"runs.csv", "run.csv", "run_response.png", "run_cost.png", "run_cost.csv"} <= names
    assert "run.png" not in names  # the old one shows other tables
    monkeypatch.setattr("bench.reports.identification.summary.error_chart", error_chart)
    assert collect(ended.output, redraw=False) == 0 and (ended.output / "run.png").is_file()  # tried again


@pytest.fixture(scope="module")
def others(tmp_path_factory):
    """A folder for PYTHONPATH, as an installer would leave it."""
    folder = tmp_path_factory.mktemp("others")
    (folder / "others_reports.py").write_text(REPORTS)
    information = folder / "others-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(METADATA)
    (information / "entry_points.txt").write_text(ENTRY_POINTS)
    return os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])


@pytest.fixture
def others_here(enter, others, monkeypatch):
    """The bench with that package inside this process, whose registry forgets it afterwards."""
    with on_path(others.partition(os.pathsep)[0], monkeypatch):
        yield enter


def test_a_report_of_another_package_is_made(apart, cheapest, others, tmp_path):
    words = [*cheapest, "table=worst", "repetitions=2", "workers=1", "problem=three_disk,rk4_two_disk"]
    ended = apart(*words, draws=True, cwd=tmp_path, output="results/run", PYTHONPATH=others)
    assert ended.code == 0 and re.match(r"worst of 4: \S+\n", ended.out)
    assert ended.err == "failed.png: cannot be drawn (RuntimeError: no ink); the tables are written\n"
    assert (ended.output / "worst.txt").read_text() == ended.out.splitlines()[0]
    assert (ended.output / "drawn.png").read_bytes() == b"ink" and len(ended.runs()) == 4


def test_a_report_of_no_study_is_refused(others_here, cheapest):
    refused = others_here(*cheapest, "table=homeless")
    assert refused.code == 2 and refused.err.startswith(
        "error: table=homeless: expected Homeless to name the study whose records it is made of, got none"
    )


def test_a_broken_report_of_another_package_is_not_offered(others_here, cheapest):
    refused = others_here(*cheapest, "table=audit")
    assert refused.code == 2 and refused.err.startswith("error: table: expected one of breaks, ")
    assert "worst" in refused.err and "homeless" not in refused.err


def test_a_report_that_raises_is_one_line_and_leaves_records_and_earlier_tables(others_here, cheapest):
    words = [*cheapest, "repetitions=1", "workers=1"]
    others_here(*words, "table=worst")
    broken = others_here(*words, "table=breaks")
    assert broken.code == 1 and broken.err.count("\n") == 1
    assert broken.err.startswith("Breaks of ") and broken.err.endswith(
        r"cannot be made (KeyError: 'no such\ncolumn'); records and earlier tables stay" + "\n"
    )
    assert len(broken.events()) == 1 and (broken.output / "worst.txt").is_file() and len(broken.runs()) == 1

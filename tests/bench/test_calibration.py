"""Calibration of estimates and intervals, from records made by hand whose statistics are known."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from scipy.stats import norm

from bench.jobs.records import RecordWriter
from bench.plan.plan import ParameterFacts, all_runs
from bench.reports.accuracy.calibration import CalibrationReport, basin_shares, calibration_frame
from bench.reports.accuracy.calibration_page import FAR, LEAST_COVERED, calibration_chart
from bench.reports.runs import runs_frame
from bench.storage.own_files import CONF
from ksmea.show.charts import interactive
from ksmea.show.charts.chart import Boxes, Points, Words

CRLB = 0.5e6  # N/m


@pytest.fixture
def plan(plan):
    """One cell of many repetitions; a CRLB of 1 % of 50 MN/m."""
    facts = (ParameterFacts("kxx", "MN/m", 1e6, 50e6, CRLB),)
    cells = tuple(replace(cell, parameters=facts) for cell in plan.cells[:1])
    report = replace(plan.report, table="calibration", paper=None)
    return replace(plan, name="coverage", cells=cells, runs=all_runs(cells, 400, plan.versions), report=report)


def record(value, low, high, basis="gauss-newton", excess=0.0, status="done"):
    parameter = {
        "name": "kxx", "unit": "MN/m", "si_per_unit": 1e6, "true": 50e6, "identified": value, "at_limit": False,
        "low": low, "high": high, "kind": basis, "most_likely": value,
    }  # fmt: skip
    effort = {
        "level": 0.95, "noise": {"relative": 0.1, "floor": 0.0, "estimated": False}, "model_evaluations": 3,
        "model_jacobians": 7, "seconds": 0.01,
    }  # fmt: skip
    return {
        "status": status, "stop": "optimizer", "parameters": [parameter], "misfit": 1.0, "updates": 0,
        "model_evaluations": 1, "model_jacobians": 1, "surrogate_evaluations": 0,
        "seconds": {"model": 0.0, "surrogate": 0.0, "search": 0.0, "total": 0.0}, "history": [],
        "intervals": effort, "basin_excess": excess,
    }  # fmt: skip


def frame_of(plan, folder, records):
    with RecordWriter(folder, 0, plan) as writer:
        for run, content in zip(plan.runs, records):
            writer.result(run, content)
    runs = runs_frame(plan, folder)
    return calibration_frame(plan, runs), runs


def normal_records(n, factor=1.0):
    """Quantiles of a normal distribution in place of draws, with intervals of ± 1.96 CRLB."""
    errors = norm.ppf((np.arange(n) + 0.5) / n) * CRLB * factor
    half = norm.ppf(0.975) * CRLB
    return [record(50e6 + error, 50e6 + error - half, 50e6 + error + half) for error in errors]


@pytest.mark.parametrize(("factor", "covered"), [(1.0, 95.0), (2.0, 67.3)])
def test_normal_errors_have_their_spread_and_coverage(plan, tmp_path, factor, covered):
    frame, _ = frame_of(plan, tmp_path, normal_records(400, factor))
    row = frame.iloc[0]
    # quantiles of 400 stand in for the distribution: its tails are cut by half a per cent
    assert [row["bias"], row["sd"], row["spread"]] == pytest.approx([0, factor, factor], abs=0.01 * factor)
    assert row["covered_pct"] == pytest.approx(covered, abs=0.3)  # 2 Φ(1.96 / factor) − 1
    assert row["covered_se"] == pytest.approx(100 * np.sqrt(covered / 100 * (1 - covered / 100) / 400), rel=0.02)
    assert row["width"] == pytest.approx(1.0) and row["crlb_pct"] == pytest.approx(1.0)
    assert row["right_basin_pct"] == 100 and (row["runs"], row["failed"]) == (400, 0)


def test_runs_in_another_basin_count_for_coverage_and_not_for_the_right_basin(plan, tmp_path):
    good = normal_records(380)
    elsewhere = [record(90e6, 89e6, 91e6, excess=12.0)] * 15 + [record(20e6, 19e6, 21e6, excess=-3.0)] * 5
    frame, _ = frame_of(plan, tmp_path, good + elsewhere)
    row = frame.iloc[0]
    assert [row["right_basin_pct"], row["wrong_basin_pct"], row["higher_elsewhere_pct"]] == [95, 3.75, 1.25]
    assert row["covered_pct"] == pytest.approx(0.95 * 95, abs=0.3)
    assert row["sd"] > 10 and row["sd_right_basin"] == pytest.approx(1, abs=0.01)
    assert row["spread"] == pytest.approx(1, abs=0.1)  # quartiles do not see them


def test_open_sides_hold_everything_and_are_counted(plan, tmp_path):
    records = [
        record(50e6, 49e6, None, "lower limit"),
        record(50e6, 51e6, None, "lower limit"),  # misses
        record(50e6, None, 51e6, "upper limit"),
        record(50e6, None, None, "not identifiable"),
    ] * 100
    row = frame_of(plan, tmp_path, records)[0].iloc[0]
    assert [row["covered_pct"], row["one_sided_pct"], row["not_identifiable_pct"]] == [75, 75, 25]
    assert np.isnan(row["width"])


def test_failed_runs_are_counted(plan, tmp_path):
    row = frame_of(plan, tmp_path, [*normal_records(398), {"status": "error", "error": "x"}])[0].iloc[0]
    assert (row["runs"], row["failed"]) == (398, 1)  # another one was not run


def test_without_basins_nothing_is_said_of_them():
    assert np.isnan(list(basin_shares(pd.DataFrame({"kxx": [1.0]})).values())).all()


def test_the_report_is_printed_tabled_and_drawn(plan, tmp_path):
    frame, _ = frame_of(plan, tmp_path, normal_records(400))
    made = CalibrationReport().make(plan, tmp_path)
    assert set(made.files) == {"coverage.csv", "runs.csv"}
    assert "100.0 %" in made.text and "covers %" in made.text
    charts = made.page().charts()
    assert set(charts) == {"coverage.png"}
    errors, coverage = charts["coverage.png"]().panels
    (points,) = [each for each in coverage.elements if isinstance(each, Points)]
    assert list(points.x) == pytest.approx(frame["covered_pct"].tolist())
    assert coverage.x.low == LEAST_COVERED < points.left[0]
    (boxes,) = [each for each in errors.elements if isinstance(each, Boxes)]
    assert [np.median(values) for values in boxes.values] == pytest.approx([0.0], abs=1e-9)


def test_errors_beyond_the_axis_are_counted_at_its_ends():
    frame = pd.DataFrame({"parameter": ["kxx", "kxx"], "cell_name": ["one", "other"]})
    errors = {"kxx": [np.array([-9.0, -7.0, 0.0, 1.0, 100.0]), np.array([-1.0, 1.0])]}
    chart = calibration_chart("two", frame, ["one", "other"], errors, [0.95])
    [panel] = chart.panels
    assert (panel.x.low, panel.x.high) == (-FAR, FAR) == (-6, 6)
    told = [(each.x, each.y, each.text) for each in panel.elements if isinstance(each, Words)]
    assert told == [(-6, 0, "◂ 2"), (6, 0, "1 ▸")]
    assert chart.title == "two; nearest to the bound: other, rms error 1 CRLB; farthest: one, 45 CRLB"
    notes = {note["text"] for note in interactive.plot(chart)["layout"]["annotations"]}
    assert {"◂ 2", "1 ▸"} <= notes


def test_few_draws_are_dots_and_a_full_share_has_an_interval():
    """Four of four are at least 51 % of all by Wilson (1927)."""
    frame = pd.DataFrame({"parameter": ["kxx"], "cell_name": ["one"], "covered_pct": [100.0], "runs": [4]})
    errors, coverage = calibration_chart(
        "few", frame, ["one"], {"kxx": [np.array([-1.0, 0.0, 1.0, 2.0])]}, [0.95]
    ).panels
    [dots] = [each for each in errors.elements if isinstance(each, Points)]
    assert list(dots.x) == [-1.0, 0.0, 1.0, 2.0] and not any(isinstance(each, Boxes) for each in errors.elements)
    [share] = [each for each in coverage.elements if isinstance(each, Points)]
    assert (share.left[0], share.right[0]) == pytest.approx((51.0, 100.0), abs=0.1)


def test_coverage_is_asked_of_thousands_of_draws_from_honest_starts():
    """The experiment itself: no start knows the truth, 2000 draws, noise known and estimated."""
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        config = compose("config", overrides=["+experiment=coverage"])
    assert config.repetitions >= 2000 and config.measurement.relative == 0.1
    assert config.method.name == "direct" and config.optimizer.name == "lm"
    assert [list(block["measurement.noise_known"]) for block in config.grid] == [[True, False]] * 2

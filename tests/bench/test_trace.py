"""The trace in records, tables and figures of the bench."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from bench.plan.plan import read_plan
from bench.reports.identification.course_charts import LEAST_EXCESS, anytime_chart
from bench.reports.identification.trace_table import (
    Traced,
    _grid,
    jacobian_price,
    read_traces,
    stages_frame,
    trace_frame,
)
from ksmea.records.identification import IdentificationRecord
from ksmea.records.trace import StageRecord, TraceRecord
from ksmea.show.charts.chart import Line, Points


def trace_of(evaluations, misfit, jacobians=None, error=(), stages=()):
    n = len(evaluations)
    seconds = tuple(0.1 * number for number in evaluations)
    return TraceRecord(
        tuple(evaluations), tuple(jacobians or (0,) * n), (0,) * n, tuple(misfit), seconds, (), error, 10.0, stages
    )


@pytest.fixture
def traces(plan):
    """Of the first cell's four runs three have ended, the second after two Jacobians, and the last has found nothing until
    its fourth evaluation; of the second cell none."""
    ends = (StageRecord("search", 6, 0, (1.0, 1.0), 3.0), StageRecord("final step", 6, 2, (1.0, 1.0), 1.0))
    runs = [run for run in plan.runs if run.cell == 0]
    made = (
        (trace_of([1, 2, 5], [110.0, 30.0, 12.0], error=(9.0, 5.0, 4.0)), 10, 0),
        (trace_of([1, 6, 6], [60.0, 20.0, 10.5], [0, 0, 1], (8.0, 3.0, 1.0), ends), 6, 2),
        (trace_of([4], [14.0], error=(2.0,)), 10, 0),
    )
    return {run.key: Traced(trace, *took) for run, (trace, *took) in zip(runs, made)}


def test_quartiles_are_of_all_planned_runs_and_what_has_nothing_is_infinitely_far(plan, traces):
    frame = trace_frame(plan, traces)
    assert set(frame["cell"]) == {0}  # a cell without a trace has no row
    rows = frame.set_index("cost")
    assert (rows["runs"] == 4).all() and rows.index.max() == 10
    # excess at cost 1: 100, 50, nothing yet, failed; at 5: 2, 50, 4, failed; at 8, a Jacobian as 2: 2, 0.5, 4, failed
    assert (rows.loc[1, "excess_q1"], rows.loc[1, "without"]) == (100.0, 2)
    assert rows.loc[1, "excess_median"] == np.inf
    assert rows.loc[5, ["excess_q1", "excess_median", "without"]].tolist() == [4.0, 50.0, 1]
    assert rows.loc[8, ["excess_q1", "excess_median", "error_median"]].tolist() == [2.0, 4.0, 4.0]
    assert rows.loc[7, "excess_q1"] == 4.0  # a Jacobian has a price: the second run is not there yet
    assert rows.loc[10, "seconds"] == pytest.approx(0.5)  # of the improvements


def test_stages_are_told_as_they_ended(plan, traces):
    stages = stages_frame(plan, traces).set_index("stage")
    assert stages.index.tolist() == ["search", "final step"]
    assert stages["excess"].tolist() == [10.0, 0.5] and stages["error"].tolist() == [3.0, 1.0]
    assert stages["jacobians"].tolist() == [0, 2] and (stages["runs"] == 1).all()
    without = {key: dataclasses.replace(each, trace=trace_of([1], [12.0])) for key, each in traces.items()}
    assert stages_frame(plan, without).empty and "cell" in stages_frame(plan, without)


def test_a_methods_own_price_of_a_jacobian_is_taken(plan):
    cell = plan.cells[0]
    assert jacobian_price(cell) == 2
    dear = dataclasses.replace(cell, settings={**cell.settings, "method": {"name": "direct", "jacobian_cost": 5}})
    assert jacobian_price(dear) == 5


def test_what_nobody_knows_the_maximum_of_has_no_excess(plan, traces):
    without = {key: dataclasses.replace(each.trace, least=None) for key, each in traces.items()}
    unknown = {key: dataclasses.replace(each, trace=without[key]) for key, each in traces.items()}
    frame = trace_frame(plan, unknown)
    assert frame[["excess_q1", "excess_median", "excess_q3"]].isna().all(axis=None)
    assert np.isfinite(frame["error_q1"].iloc[-1])


@pytest.mark.parametrize("most", [1, 2, 37, 10_100])
def test_the_costs_of_the_table_go_up_to_the_last(most):
    grid = _grid(most)
    assert grid[0] == 1 and grid[-1] == most and grid == sorted(set(grid))


def test_the_figure_has_a_line_for_each_cell_that_starts_where_most_runs_have_something(plan, traces):
    excess, error = anytime_chart(plan, trace_frame(plan, traces), stages_frame(plan, traces)).panels
    [line] = [each for each in excess.elements if isinstance(each, Line)]
    assert line.is_stepped and np.isnan(line.y[0]) and line.y[line.x == 5] == [50.0]
    assert line.y[-1] >= LEAST_EXCESS
    [dot] = [each for each in excess.elements if isinstance(each, Points) and each.symbol == "circle"]
    assert dot.x.tolist() == [6]  # where the search ended and the final step began
    assert "Jacobian as 2" in error.x.label


def test_a_sweep_leaves_traces_judged_by_the_truth_and_their_table(enter, cheapest):
    words = [
        "figures=[trace]",
        "repetitions=2",
        "workers=1",
        "measurement.relative=0.1",
        "method.final_step=true,false",
    ]
    ended = enter(*cheapest, *words)
    assert ended.code == 0, ended.err
    plan = read_plan(ended.output)
    found = read_traces(plan, ended.output)
    assert found.keys() == {run.key for run in plan.runs}
    for run in plan.runs:
        trace = found[run.key].trace
        facts = plan.cells[run.cell].parameters
        truth, crlb = (np.array([getattr(each, name) for each in facts]) for name in ("truth", "crlb"))
        for stage in trace.stages:  # five digits are kept
            deviations = (np.array(stage.x) - truth) / crlb
            assert stage.error == pytest.approx(np.sqrt(np.mean(deviations**2)), rel=1e-4)
        assert len(trace.error) == len(trace.misfit) and trace.x == () and trace.excess[0] > 0
    stages = ended.table("run_stages").groupby("method.final_step")["stage"].agg(list).to_dict()
    assert stages == {
        True: ["samples", "search", "polish", "updating steps", "final step"],
        False: ["samples", "search", "polish", "updating steps"],
    }
    assert set(ended.table("run_trace")["cell"]) == {0, 1}
    assert ended.runs().groupby("method.final_step")["stage"].unique().map(list).to_dict() == {
        True: ["final step"], False: ["updating steps"]
    }  # fmt: skip


def test_a_record_without_a_trace_has_no_part_in_the_table(plan):
    older = Path(__file__).resolve().parents[1] / "data" / "identifications_schema_2.jsonl"
    record = IdentificationRecord.from_data(json.loads(older.read_text(encoding="utf-8").splitlines()[0]))
    assert record.trace is None and record.stage == ""
    assert trace_frame(plan, {}).empty

"""Figures hold the data of the records: what their charts describe is compared with what was recorded."""

import dataclasses
import shutil

import numpy as np
import pandas as pd
import pytest

from bench.jobs.records import read_records
from bench.plan.naming import cell_name, place_text, telling_axes
from bench.plan.plan import read_plan
from bench.reports.collect import collect
from bench.reports.identification.agreement_charts import agreement, agreement_chart, mesh_chart
from bench.reports.identification.cost import COSTS, JACOBIAN_AS_EVALUATIONS, cost_chart, cost_frame, paper_cost
from bench.reports.identification.course_charts import figure_number, updates_chart
from bench.reports.identification.spread_chart import spread_chart
from bench.reports.runs import runs_frame
from bench.reports.tables import summary_frame
from drawn_curves import curves_of, drawn
from ksmea.records.identification import IdentificationRecord, UpdateRecord
from ksmea.show.charts.chart import Boxes, Chart, Level, Line, Points, Words
from ksmea.show.charts.picture import png
from problems.three_disk import ThreeDisk

RPM = np.pi / 30  # rad/s
PNG = b"\x89PNG"


def parted(line):
    """The parts of a line with gaps, as (x, y)."""
    parts, begin = [], 0
    for end in np.flatnonzero(np.isnan(line.x)):
        parts.append((line.x[begin:end].tolist(), line.y[begin:end].tolist()))
        begin = end + 1
    return parts


# -- from the records of runs --


@pytest.fixture
def figures(table3, tmp_path, monkeypatch):
    """The figures that `collect` makes of the small experiment, before they are files; its plan and its records."""
    output = shutil.copytree(table3.output, tmp_path / "table3")
    made = []

    def png(chart):
        assert isinstance(chart, Chart)
        made.append(chart)
        return PNG

    monkeypatch.setattr("bench.reports.collect._png", png)
    monkeypatch.setattr("bench.reports.collect.available_cores", lambda: 1)  # all are drawn here
    assert collect(output) == 0
    names = ("", "_spread", "_updates", "_response", "_surrogate")
    assert all((output / f"table3{name}.png").read_bytes() == PNG for name in names)
    return (
        dict(zip(("errors", "summary", "updates", "response", "surrogate"), made, strict=True)),
        read_plan(output),
        _records(output),
    )


def _records(output):
    return read_records(output, lambda line: line.record(IdentificationRecord) if line.has_result else None)


def test_a_real_experiment_draws_them_all(table3):
    for name in ("table3.png", "table3_updates.png", "table3_response.png", "table3_surrogate.png"):
        assert (table3.output / name).read_bytes().startswith(PNG)
        assert name in table3.out


def test_the_updates_are_those_of_every_repetition(figures):
    made, plan, records = figures
    for cell, stack in enumerate(made["updates"].stacks):  # a stack per cell; kxx, kyy and the misfit
        histories = [records[run.key].history for run in plan.runs if run.cell == cell]
        assert len(histories) == 4 and all(histories)
        for index, panel in enumerate(stack[:2]):
            line, band, median, reference = panel.elements
            last = [update.x[index] / 1e6 for update in (history[-1] for history in histories)]
            assert median.y[-1] == pytest.approx(np.median(last))  # a run that has ended keeps its last value
            assert [band.low[-1], band.high[-1]] == pytest.approx(np.percentile(last, [25, 75]))
            for (steps, values), history in zip(parted(line), histories, strict=True):
                assert steps == list(range(1, 1 + len(history)))
                assert values == pytest.approx([update.x[index] / 1e6 for update in history])
            assert isinstance(reference, Level) and reference.at == (50.0, 70.0)[index]  # MN/m, Table 1
            assert panel.y.label == ("kxx (MN/m)", "kyy (MN/m)")[index]
        misfits, *_ = stack[2].elements
        for (_, values), history in zip(parted(misfits), histories, strict=True):
            assert values == [update.misfit for update in history]
        assert stack[0].title == f"samples {(25, 30)[cell]}"


def test_the_curves_of_a_record_are_the_responses_that_they_are_called(figures):
    """The identified curve is the model at the recorded values, the true one that at the reference values."""
    _, plan, records = figures
    record = records[plan.runs[0].key]
    problem = ThreeDisk().build()
    for name, key in (("identified", "identified"), ("true", "true")):
        x = np.array([getattr(parameter, key) for parameter in record.parameters])
        expected = np.abs(problem.response(x[None])[0])
        assert np.array(getattr(record.curves, name)) == pytest.approx(expected, rel=1e-6)
    last = np.array(record.history[-1].x)
    assert np.array(record.curves.modelled) == pytest.approx(np.abs(problem.response(last[None])[0]), rel=1e-6)
    noise = np.array(record.curves.measured) / np.array(record.curves.true) - 1
    assert np.std(noise) == pytest.approx(0.1, rel=0.25)


def test_the_summary_holds_quartiles_and_the_papers_values(plan, tmp_path, monkeypatch):
    runs = runs_frame(plan, tmp_path)
    runs["status"] = "done"
    runs["kxx"] = [49, 60, 50, 60, 51, 60, 52, 60]  # repetitions one after the other, two cells in each
    summary = summary_frame(plan, runs)
    few = spread_chart(plan, runs, summary)
    assert few.caption.startswith("Dots: all values of 4 repetitions")
    assert few.title == "samples 40: within 2 % of each parameter (median); samples 70: within 20 %"
    dots = drawn(few.panels[0])["this bench"]  # of four values there are no quartiles
    assert sorted(zip(dots.y, dots.x)) == [(0, 49), (0, 50), (0, 51), (0, 52), (1, 60), (1, 60), (1, 60), (1, 60)]
    monkeypatch.setattr("bench.reports.identification.spread_chart.FEWEST_OF_BOX", 4)
    kxx, *_ = spread_chart(plan, runs, summary).panels
    assert kxx.title == "kxx (MN/m)"
    assert drawn(kxx)["paper"].x.tolist() == [50.3, 50.1]
    [boxes] = [each for each in kxx.elements if isinstance(each, Boxes)]
    assert [np.median(values) for values in boxes.values] == [50.5, 60.0]
    assert list(kxx.y.ticks.values()) == ["40", "70"]


# -- from data made by hand --


def test_figures_of_the_paper_have_its_numbers_and_say_what_was_found(plan):
    """Figs. 3, 4, 6, 7, 10 and 11; a table without such a figure has no number."""
    numbers = {
        (table, kind): figure_number(
            dataclasses.replace(plan, report=dataclasses.replace(plan.report, paper=table)), kind
        )
        for table in ("table2", "table3", "table4", "table8", None)
        for kind in ("updates", "identified", "surrogate")
    }
    assert {key: said for key, said in numbers.items() if said} == {
        ("table2", "updates"): "Fig. 3. ", ("table2", "surrogate"): "Fig. 4. ", ("table3", "identified"): "Fig. 6. ",
        ("table3", "surrogate"): "Fig. 7. ", ("table8", "identified"): "Fig. 10. ", ("table8", "surrogate"): "Fig. 11. ",
    }  # fmt: skip
    histories = {run.key: [UpdateRecord((51e6, 2e-4), misfit=3.0)] * (run.cell + 2) for run in plan.runs}
    assert updates_chart(plan, histories).title == "Updating steps until the end of a run (median): 2 to 3"


def test_updates_of_runs_that_failed_are_left_out(plan):
    history = [UpdateRecord((51e6, 2e-4), misfit=3.0), UpdateRecord((50e6, 2e-4))]  # None: it was not finite
    chart = updates_chart(plan, {plan.runs[0].key: history, plan.runs[2].key: []})
    (first, _, misfit), second = chart.stacks
    assert first.elements[0].y[:2] == pytest.approx([51, 50])
    assert misfit.elements[0].y[:2] == pytest.approx([3.0, np.nan], nan_ok=True)
    assert not any(np.isfinite(each.y).any() for panel in second for each in panel.elements if isinstance(each, Line))
    assert png(chart).startswith(PNG)


def test_an_experiment_of_failures_draws_what_it_can(table3, tmp_path, capsys):
    output = shutil.copytree(table3.output, tmp_path / "table3")
    for path in output.glob("*.png"):
        path.unlink()
    shutil.rmtree(output / "records")
    assert collect(output) == 1
    assert {path.name for path in output.glob("*.png")} == {"table3.png", "table3_spread.png"}
    assert "table3.png" in capsys.readouterr().out


# -- cost --

# Cells of a table 6: evaluations and Jacobians, seconds in the model and in all.
METHODS = {
    "KSMEA": (100, 0, 0.1, 10.1),
    "DE": (2100, 0, 2.0, 4.0),
    "LM": (80, 40, 0.2, 0.5),
    "PSO": None,  # nothing has ended
}


@pytest.fixture
def labelled(plan):
    """The plan made by hand with a cell per method, of two repetitions."""
    cells = tuple(dataclasses.replace(plan.cells[0], place={"samples": None, "label": name}) for name in METHODS)
    return dataclasses.replace(plan, cells=cells, axes=("samples", "label"))


@pytest.fixture
def runs():
    """Three runs of every method, whose medians are the figures above."""
    rows = []
    for cell, figures in enumerate(METHODS.values()):
        for factor in (1, 0.5, 1.5):
            evaluations, jacobians, model, total = figures or (np.nan,) * 4
            values = (factor * evaluations, factor * jacobians, factor * model, factor * total)
            names = ("model_evaluations", "model_jacobians", "time_model", "time")
            rows.append({"cell": cell, "status": "done" if figures else "error", **dict(zip(names, values))})
    return pd.DataFrame(rows)


def test_the_cost_of_a_method_is_its_evaluations_and_its_overhead(labelled, runs):
    frame = cost_frame(labelled, runs).set_index("method")
    assert frame.index.tolist() == ["KSMEA", "DE", "LM"]  # what has no result has no row
    assert JACOBIAN_AS_EVALUATIONS == 2
    assert frame["evaluations"].tolist() == [100, 2100, 80 + 2 * 40]
    assert frame["overhead_s"].tolist() == pytest.approx([10.0, 2.0, 0.3])
    assert (frame["runs"] == 3).all()
    # 100 t + 10 = 2100 t + 2 and 100 t + 10 = 160 t + 0.3
    assert frame["break_even_s"].tolist() == pytest.approx([np.nan, 8 / 2000, 9.7 / 60], nan_ok=True)


def test_a_method_that_is_dearer_in_both_is_never_worth_it(labelled, runs):
    """Fewer evaluations and less overhead: it is ahead at any cost, from 0 on."""
    runs.loc[runs["cell"] == 1, "time"] += 20
    frame = cost_frame(labelled, runs).set_index("method")
    assert frame.loc["DE", "break_even_s"] == 0
    runs.loc[runs["cell"] == 1, "model_evaluations"] = 50  # fewer than the first: nothing to break even with
    assert np.isnan(cost_frame(labelled, runs).set_index("method").loc["DE", "break_even_s"])


def test_the_lines_of_the_cost_figure_rise_by_the_evaluations_and_cross_at_the_break_even(labelled, runs):
    frame = cost_frame(labelled, runs)
    (panel,) = cost_chart(frame).panels
    lines = [each for each in panel.elements if isinstance(each, Line)]
    assert COSTS[0] == pytest.approx(1e-6) and COSTS[-1] == pytest.approx(3600)
    for line, row in zip(lines, frame.itertuples(), strict=True):
        assert np.polyfit(line.x, line.y, 1) == pytest.approx([row.evaluations, row.overhead_s])
        assert line.name.startswith(f"{row.method}: {row.evaluations:.0f} evaluations")
    dots = [each for each in panel.elements if isinstance(each, Points) and each.symbol == "circle"]
    assert [dot.x[0] for dot in dots] == pytest.approx([8 / 2000, 9.7 / 60])
    for dot in dots:  # it lies on the line of the first method too
        assert dot.y[0] == pytest.approx(100 * dot.x[0] + 10)


def test_the_papers_times_stand_at_the_cost_that_its_table_3_implies(labelled, runs):
    """Times of Table 3 over samples + updates: a straight line by least squares, written out."""
    evaluations = np.array([40 + 7, 70 + 6, 100 + 6, 200 + 5])
    seconds = np.array([196.21, 231.32, 271.27, 321.99])
    deviation = evaluations - evaluations.mean()
    slope = np.sum(deviation * (seconds - seconds.mean())) / np.sum(deviation**2)
    cost, times = paper_cost()
    assert cost == pytest.approx(slope) and cost == pytest.approx(0.7635, abs=5e-5)
    assert times.set_index("method")["identified"].to_dict() == {
        "KSMEA": 271.27, "DE": 3086.2, "PSO": 3460.5, "GA": 2959.8
    }  # fmt: skip
    (panel,) = cost_chart(cost_frame(labelled, runs)).panels
    diamonds = drawn(panel)["paper, Table 6"]
    assert {each.text for each in panel.elements if isinstance(each, Words)} == {"DE, PSO, GA", "KSMEA"}
    assert diamonds.x == pytest.approx([slope] * 4)
    assert diamonds.y == pytest.approx([271.27, 3086.2, 3460.5, 2959.8])


@pytest.mark.parametrize("left", [["KSMEA"], ["DE", "LM"], list(METHODS)])
def test_a_cost_figure_is_drawn_whatever_has_results(left, labelled, runs):
    for cell, name in enumerate(METHODS):
        if name not in left:
            runs.loc[runs["cell"] == cell, "status"] = "error"
    frame = cost_frame(labelled, runs)
    assert frame["method"].tolist() == [name for name in left if METHODS[name]]
    assert png(cost_chart(frame)).startswith(PNG)


def test_a_cost_figure_says_from_when_on_a_surrogate_pays_and_names_points_beside_them(labelled, runs):
    """(10 − 2) s for 2000 evaluations less; at 1 s 2102 s against 110 s."""
    chart = cost_chart(cost_frame(labelled, runs))
    assert chart.title == "KSMEA is faster than DE if an evaluation costs more than 4 ms; 19 times at 1 s"
    words = {each.text: each for each in chart.panels[0].elements if isinstance(each, Words)}
    assert words["DE, PSO, GA"].side == "left" and words["DE, PSO, GA"].offset[0] > 0  # between both groups of lines
    assert words["KSMEA"].side == "right" and words["KSMEA"].offset[0] < 0


def test_a_cost_figure_has_a_line_for_every_cell(labelled, runs):
    """As where a list on the command line multiplies the methods."""
    more = [runs.assign(cell=runs["cell"] + 4 * turn) for turn in range(3)]
    cells = tuple(
        dataclasses.replace(cell, place={**cell.place, "problem.mesh": mesh})
        for mesh in (13, 21, 42)
        for cell in labelled.cells
    )
    plan = dataclasses.replace(labelled, cells=cells, axes=("samples", "label", "problem.mesh"))
    frame = cost_frame(plan, pd.concat(more))
    assert len(frame) == 9 and frame["method"].is_unique
    lines = [each for each in cost_chart(frame).panels[0].elements if isinstance(each, Line)]
    assert len(lines) == 9


# -- names --


def renamed(plan, places, axes):
    cells = tuple(dataclasses.replace(plan.cells[0], place=place) for place in places)
    return dataclasses.replace(plan, cells=cells, axes=axes)


def names(plan):
    return [cell_name(plan, cell) for cell in plan.cells]


def test_an_axis_tells_cells_apart_only_where_they_differ_on_it(plan):
    assert telling_axes(plan) == ("samples",) and names(plan) == ["samples 40", "samples 70"]
    places = [{"samples": 40, "problem.mesh": 13, "seed": 0}, {"samples": 40, "problem.mesh": 21, "seed": 0}]
    of_meshes = renamed(plan, places, ("samples", "problem.mesh", "seed"))
    assert telling_axes(of_meshes) == ("problem.mesh",)
    assert names(of_meshes) == ["problem.mesh 13", "problem.mesh 21"]


def test_a_single_cell_is_called_by_its_samples(plan):
    alone = renamed(plan, [{"samples": 40, "seed": 0}], ("samples", "seed"))
    assert telling_axes(alone) == ("samples",) and names(alone) == ["samples 40"]


def test_a_label_stands_for_the_axes_that_go_with_it(plan):
    """As in Table 6, where method, surrogate and optimiser follow from the label, and in Table 2, where samples do not."""
    table6 = [
        {"label": "DE", "optimizer": "de", "samples": None},
        {"label": "KSMEA", "optimizer": "de", "samples": 100},
    ]
    labelled = renamed(plan, table6, ("samples", "label", "optimizer"))
    assert telling_axes(labelled) == ("label",) and names(labelled) == ["DE", "KSMEA"]
    table2 = [{"label": label, "samples": n} for label in ("KSMEA", "raw") for n in (40, 70)]
    both = renamed(plan, table2, ("samples", "label"))
    assert telling_axes(both) == ("label", "samples")
    assert names(both) == ["KSMEA, samples 40", "KSMEA, samples 70", "raw, samples 40", "raw, samples 70"]


@pytest.mark.parametrize(
    "value, text", [(None, "–"), (0.05, "0.05"), (0.1 + 0.2, "0.3"), (100, "100"), ("de", "de"), ([1, 2], "[1, 2]")]
)
def test_a_value_is_shown_as_people_read_it(value, text):
    assert place_text(value) == text


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("text", ["cost", "updates", "response", "mesh"])
def test_no_figure_warns(text, plan, labelled, runs):
    figure = {
        "cost": lambda: cost_chart(cost_frame(labelled, runs)),
        "updates": lambda: updates_chart(plan, {plan.runs[0].key: [UpdateRecord((51e6, 2e-4), misfit=3.0)]}),
        "response": lambda: agreement_chart(
            plan, 0, "identified", [agreement(curves_of(identified=[[1e-6, 2e-6]] * 4), "identified")] * 2
        ),
        "mesh": lambda: mesh_chart(curves_of(), curves_of(true=[[5e-6, 5e-6]] * 4)),
    }[text]()
    assert png(figure).startswith(PNG)

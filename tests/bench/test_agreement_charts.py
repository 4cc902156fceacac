"""Responses of the paper's figures: both curves, and their difference in per cent, as recorded."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from bench.jobs.records import RecordWriter, read_records
from bench.plan.drawn_cell import drawn_cell
from bench.plan.plan import read_plan, write_plan
from bench.reports.collect_all import collect_all
from bench.reports.identification.agreement_charts import LEAST, agreement, agreement_chart, mesh_chart
from bench.reports.identification.summary import read_courses, summary_page
from bench.reports.runs import runs_frame
from bench.reports.tables import summary_frame
from drawn_curves import curves_of, drawn
from ksmea.records.identification import IdentificationRecord, ParameterRecord, Seconds
from ksmea.rotordynamics.half_power import full_peaks
from ksmea.show.charts.chart import Chart, Line, Points
from ksmea.show.charts.picture import png
from problems.three_disk import ThreeDisk

RPM = np.pi / 30  # rad/s
PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def figures(table3):
    """The charts of the page of the small experiment, its plan and its records."""
    plan, output = read_plan(table3.output), table3.output
    runs = runs_frame(plan, output)
    page = summary_page(plan, runs, summary_frame(plan, runs), "", read_courses(plan, runs, output))
    made = {name.removeprefix("table3_").removesuffix(".png"): draw() for name, draw in page.charts().items()}
    return made, plan, read_records(output, lambda line: line.record(IdentificationRecord) if line.has_result else None)


def test_the_responses_are_those_of_the_best_and_the_worst_repetition(figures):
    """The paper's Figs. 6 and 7: both responses in a panel, their difference in per cent below, on common axes."""
    made, plan, records = figures
    cell = drawn_cell(plan)
    curves = [records[run.key].curves for run in plan.runs if run.cell == cell]
    assert len(curves) == 4 and None not in curves
    for kind, number in (("identified", 6), ("surrogate", 7)):
        chart = made["response" if kind == "identified" else kind]
        assert chart.title.startswith(f"Fig. {number}. ")
        ranked = sorted((agreement(each, kind) for each in curves), key=lambda each: each.size)
        missed, speed = ranked[-1].worst()[2], ranked[-1].worst()[0]
        assert f"misses {speed:.0f} rpm by {missed:.2g} %" in chart.title or missed < LEAST or missed > 100
        for stack, of in zip(chart.stacks, (ranked[0], ranked[-1]), strict=True):
            for column, (response, difference) in enumerate(zip(stack[::2], stack[1::2], strict=True)):
                shown = [each for each in difference.elements if isinstance(each, Line | Points)]
                [errors] = shown
                assert errors.x == pytest.approx(of.speed)
                assert errors.y == pytest.approx(np.maximum(of.difference[:, column], LEAST), rel=1e-3)
                assert drawn(response)[of.names[0]].y.max() > 0
        for row in zip(*chart.stacks, strict=True):
            assert len({(panel.x.group, panel.y.group, panel.y.low, panel.y.high) for panel in row}) == 1


def test_fine_responses_are_those_of_the_models_at_40_speeds_in_a_half_power_width(figures):
    _, plan, records = figures
    record = records[plan.runs[0].key]
    fine = record.curves.fine
    problem = ThreeDisk().build()
    speed = np.array(fine.speed)
    seen = problem.at(speed, problem.channels)
    for name, x in (
        ("identified", record.x),
        ("true", np.array([each.true for each in record.parameters])),
        ("modelled", np.array(record.history[-1].x)),
    ):
        found = np.array(getattr(fine, name))
        assert found == pytest.approx(np.abs(seen.response(x[None])[0]), rel=2e-3)  # speeds are rounded
        widths = [(peak.low, peak.high) for column in found.T for peak in full_peaks(speed, column)]
        assert len(widths) >= 6
        assert all(np.count_nonzero((speed >= low) & (speed <= high)) >= 38 for low, high in widths)


def test_the_mesh_figure_shows_both_meshes_and_their_difference():
    coarse = curves_of()
    fine = curves_of(true=(np.array(coarse.true) * [1.02, 0.99]).tolist())
    chart = mesh_chart(coarse, fine)
    assert chart.title.startswith("Fig. 5. ") and "by 2 % at" in chart.title
    for channel, (above, below), first, factor in zip(coarse.channels, chart.stacks, (1, 3), (1.02, 0.99)):
        assert above.title == channel and set(drawn(above)) == {"13 elements", "21 elements"}
        assert drawn(above)["13 elements"].y == pytest.approx(first * np.linspace(1, 2, 4), rel=1e-3)
        assert drawn(above)["21 elements"].y == pytest.approx(factor * first * np.linspace(1, 2, 4), rel=1e-3)
        [errors] = [each for each in below.elements if isinstance(each, Line)]
        assert errors.y == pytest.approx([100 * abs(factor - 1)] * 4)
        assert errors.x == pytest.approx(np.linspace(200, 1500, 4) / RPM)


def test_meshes_on_speeds_of_their_own_are_compared_at_common_ones():
    def with_fine(n, factor):
        speed = np.linspace(200, 1500, n)
        true = (factor * (1e-6 + 1e-9 * speed))[:, None] * [1, 2]
        return curves_of(fine={"speed": speed.tolist(), "true": true.tolist()})

    chart = mesh_chart(with_fine(300, 1.0), with_fine(401, 1.003))
    for _, below in chart.stacks:
        [errors] = [each for each in below.elements if isinstance(each, Line)]
        assert len(errors.x) == 300 and errors.y == pytest.approx(np.full(300, 0.3), rel=1e-3)


def test_a_response_without_surrogate_or_original_is_compared_with_what_was_measured(plan):
    """A method that works on the true model predicts nothing."""
    curves = curves_of(measured=[[1e-6, 2e-6]] * 4, identified=[[3e-6, 4e-6]] * 4, true=None)
    assert agreement(curves, "surrogate") is None
    chart = agreement_chart(plan, 1, "identified", [agreement(curves, "identified")])
    [(first, errors, second, _)] = chart.stacks
    assert drawn(second)["identified"].y == pytest.approx([4.0] * 4)
    assert set(drawn(second)) == {"measured", "identified"}
    assert errors.elements[0].y == pytest.approx([200.0] * 4)
    assert first.title == "x at 0.1 m" and "within 200 % of the measured" in chart.title and "samples 70" in chart.title
    assert png(chart).startswith(PNG)


def test_the_mesh_figure_is_made_where_both_tables_have_their_curves(plan, tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(
        "bench.reports.collect_all.mesh_chart", lambda *curves: made.append(curves) or Chart("", "", ())
    )
    monkeypatch.setattr("bench.reports.collect._png", lambda chart: PNG)
    coarse, fine = curves_of(), curves_of(true=[[5e-6, 5e-6]] * 4)
    output = tmp_path / "all"
    parts = [output / "table3", output / "table4"]
    for part, curves in zip(parts, (coarse, None)):
        leave_results(part, plan, curves)
    collect_all(output, parts)  # no run of the second one has ended yet
    assert made == [] and not (output / "mesh.png").exists()
    assert pd.read_csv(output / "all.csv")["table"].tolist() == ["table3", "table4"]
    leave_results(parts[1], plan, fine)
    collect_all(output, parts)
    assert made == [(coarse, fine)] and (output / "mesh.png").read_bytes() == PNG


def leave_results(folder, plan, curves):
    """Plan, table and the record of a first run with these curves."""
    write_plan(dataclasses.replace(plan, name=folder.name), folder)
    (folder / f"{folder.name}.csv").write_text("parameter,median\nkxx,50\n")
    with RecordWriter(folder, 0, plan) as writer:
        if curves is not None:
            counts = {"updates": 0, "model_evaluations": 1, "model_jacobians": 0, "surrogate_evaluations": 0}
            identified = ParameterRecord("kxx", "MN/m", 1e6, identified=5e7, at_limit=False)
            record = IdentificationRecord("done", "smc", (identified,), 1.0, **counts, seconds=Seconds(), curves=curves)
            writer.result(plan.runs[0], record.to_data())

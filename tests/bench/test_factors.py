"""Factors of a sweep: strength all else equal, merged cells, cells that lack runs, and charts of them."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from bench.plan.plan import Cell, ParameterFacts, Plan, ReportSettings, Run
from bench.reports.identification.factor_charts import cells_chart, factors_chart
from bench.reports.identification.factors import cells_finding, headline, sweep_of, two_figures, without_twins
from bench.reports.tables import as_text, summary_frame
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Heat, Line, Span, Words

FACTS = ParameterFacts("kxx", "MN/m", 1e6, truth=50e6, crlb=0.5e6)
LEVELS = [(optimizer, noise, samples) for optimizer in ("pso", "de") for noise in (0.1, 0.05) for samples in (40, 100)]
N = 5


def plan_of():
    """Eight cells, of which those that differ in samples have the same runs."""
    cells = tuple(
        Cell(
            {"optimizer": optimizer, "measurement.relative": noise, "samples": samples}, {"study": {}}, 0, (FACTS,), ""
        )
        for optimizer, noise, samples in LEVELS
    )
    runs = tuple(
        Run(f"{optimizer}{noise}{repetition}", "", index, repetition)
        for repetition in range(N)
        for index, (optimizer, noise, _) in enumerate(LEVELS)
    )
    report = ReportSettings("identify", None, (), None)
    return Plan("sweep", report, ("optimizer", "measurement.relative", "samples"), (), "", {}, "", {}, cells, runs)


def runs_of(plan, errors, failed=0):
    """Values off by `errors` σ by optimiser and noise; the first runs of pso at 0.1 fail."""
    rows = []
    for run in plan.runs:
        optimizer, noise, samples = LEVELS[run.cell]
        is_failed = run.repetition < failed and (optimizer, noise) == ("pso", 0.1)
        value = np.nan if is_failed else 50 + 0.5 * errors[optimizer, noise]
        place = {"optimizer": optimizer, "measurement.relative": noise, "samples": samples}
        rows.append(
            {
                "key": run.key,
                "cell": run.cell,
                **place,
                "repetition": run.repetition,
                "status": "timeout" if is_failed else "done",
                "kxx": value,
            }
        )
    return pd.DataFrame(rows)


ERRORS = {("pso", 0.05): 8.0, ("pso", 0.1): 6.0, ("de", 0.05): 1.0, ("de", 0.1): 1.5}


def test_strength_is_worst_over_best_all_else_equal():
    """Optimiser: 8 and 4, median 6. Noise: 8/6 and 1.5, median 1.417."""
    plan = plan_of()
    sweep = sweep_of(plan, runs_of(plan, ERRORS))
    assert list(sweep.factors) == ["optimizer", "measurement.relative"]  # strongest first
    assert sweep.strength["optimizer"] == pytest.approx(6.0)
    assert sweep.strength["measurement.relative"] == pytest.approx((8 / 6 + 1.5) / 2)
    assert sweep.factors["optimizer"] == ("de", "pso")  # names by result
    assert sweep.factors["measurement.relative"] == (0.05, 0.1)  # numbers in order
    said = "Optimizer matters most: typical error 1.2 σ with de, 7.0 σ with pso (worst over best level 6.0 times"
    assert headline(sweep) == f"{said}; relative noise 1.4)"
    assert cells_finding(sweep) == "2 of 4 cells are above 2 σ; best: 1.0 σ with optimizer de, relative noise 0.05"


def test_typical_levels_and_what_the_data_allow_stand_in_each_panel():
    plan = plan_of()
    sweep = sweep_of(plan, runs_of(plan, ERRORS))
    chart = factors_chart(sweep)
    scales = [panel.x if "pso" in sweep.factors[name] else panel.y for name, panel in zip(sweep.factors, chart.panels)]
    assert len({(scale.low, scale.high) for scale in scales}) == 1
    for name, panel, scale in zip(sweep.factors, chart.panels, scales, strict=True):
        typical = sweep.typical(name)
        words = [each for each in panel.elements if isinstance(each, Words)]
        assert [each.text for each in words] == [two_figures(value) for value in typical.values()]
        assert [each.x if scale is panel.x else each.y for each in words] == list(typical.values())
        [allowed] = [each for each in panel.elements if isinstance(each, Span)]
        assert allowed.high == 2 and scale.low <= allowed.low
    assert "as good as the data allow" in chart.caption


def test_a_heat_map_has_no_grid_on_its_page():
    plan = plan_of()
    layout = interactive.plot(cells_chart(sweep_of(plan, runs_of(plan, ERRORS))))["layout"]
    assert not layout["xaxis"]["showgrid"] and not layout["yaxis"]["showgrid"]


def test_cells_with_the_same_runs_are_merged_and_said():
    plan = plan_of()
    runs = runs_of(plan, ERRORS)
    sweep = sweep_of(plan, runs)
    assert len(sweep.cells) == 4 and sweep.merged == (f"samples (40, 100): no influence; {4 * N} runs serve 8 cells",)
    summary = summary_frame(plan, runs)
    assert len(without_twins(plan, summary)) == len(summary) / 2
    assert as_text(plan, without_twins(plan, summary)).count(" pso ") * 2 == as_text(plan, summary).count(" pso ")


@pytest.mark.parametrize(("failed", "words"), [(0, "6.0"), (2, "6.0 (2 of 5 timeout)"), (N, "timeout")])
def test_runs_that_lack_a_result_stand_in_their_cell(failed, words):
    plan = plan_of()
    sweep = sweep_of(plan, runs_of(plan, ERRORS, failed))
    said = [
        word
        for panel in cells_chart(sweep).panels
        for each in panel.elements
        if isinstance(each, Heat)
        for row in each.words
        for word in row
    ]
    assert words in said and len(said) == 4
    if failed == N:  # the line of pso over noise breaks there
        noise = factors_chart(sweep).panels[1]
        assert sum(isinstance(each, Line) and each.width < 1 for each in noise.elements) == 1
        assert "30 of 40 runs have a result" in factors_chart(sweep).caption


def test_axes_have_names_and_both_renderers_the_same():
    plan = plan_of()
    sweep = sweep_of(plan, runs_of(plan, ERRORS))
    for chart in (factors_chart(sweep), cells_chart(sweep)):
        shown, drawn = interactive.plot(chart)["layout"], picture.figure(chart)
        for number, (panel, axes) in enumerate(zip(chart.panels, drawn.axes), start=1):
            along = "y" if panel.x.ticks is None else "x"  # names are rows
            words = list(getattr(panel, along).ticks.values())
            assert shown[f"{along}axis{number if number > 1 else ''}"]["ticktext"] == words
            assert [each.get_text() for each in getattr(axes, f"get_{along}ticklabels")()] == words
            assert not any(word.isdigit() for word in words if "pso" in words)


def test_a_sweep_of_one_factor_or_without_true_values_has_no_such_chart():
    plan = plan_of()
    unknown = dataclasses.replace(plan, cells=tuple(dataclasses.replace(each, parameters=()) for each in plan.cells))
    assert sweep_of(unknown, runs_of(plan, ERRORS)) is None

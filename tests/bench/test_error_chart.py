"""Errors of a table in σ of the Cramér–Rao bound, and its table of median errors."""

import numpy as np
import pandas as pd
import pytest

from bench.plan.page import Drawn, Page, Section
from bench.plan.plan import Cell, ParameterFacts, Plan, ReportSettings, Run
from bench.reports.identification.error_chart import error_chart, error_finding, has_bounds
from bench.reports.identification.error_table import error_table
from bench.reports.pages.document import document
from bench.reports.tables import summary_frame
from ksmea.show.charts.chart import Line, Points, Words

# of kxx 1 σ is 0.5 MN/m, of u 2 g mm; the paper's Table 3 has kxx 50.3 and 51.2, u 201 and 200 at 40 and 70 samples
FACTS = (
    ParameterFacts("kxx", "MN/m", 1e6, 50e6, 0.5e6, 10e6, 100e6),
    ParameterFacts("u", "g mm", 1e-6, 2e-4, 2e-6, 5e-5, 5e-4),
)
KXX = {40: (49.0, 50.0, 50.5, 100.0), 70: (50.0, 50.25, 46.0, 10.0)}


def plan_of(facts=FACTS, paper=None):
    cells = tuple(Cell({"samples": n}, {"samples": n, "study": {}}, 0, facts, "") for n in KXX)
    runs = tuple(Run(f"{cell}-{number}", "", cell, number) for cell in (0, 1) for number in range(4))
    return Plan("table3", ReportSettings("identify", paper, (), None), ("samples",), (), "", {}, "", {}, cells, runs)


@pytest.fixture
def runs():
    rows = [
        {"key": f"{cell}-{number}", "cell": cell, "samples": n, "repetition": number, "status": "done", "kxx": value,
         "u": 200.0 + number, "updates": 7 + number, "model_evaluations": 50, "time": 1.0}
        for cell, (n, values) in enumerate(KXX.items())
        for number, value in enumerate(values)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def elements(chart, panel, kind):
    return [each for each in chart.panels[panel].elements if isinstance(each, kind)]


def test_values_are_errors_in_sigma_and_those_beyond_are_counted(runs):
    plan = plan_of()
    chart = error_chart(plan, runs, summary_frame(plan, runs))
    dots = np.concatenate([each.x for each in elements(chart, 0, Points)])
    assert sorted(dots) == pytest.approx([-2.0, 0.0, 0.0, 0.5, 1.0])  # (value − 50) / 0.5
    assert [each.text for each in elements(chart, 0, Words)] == ["1 ▸", "◂ 2"]  # 100 σ; −8 and −80 σ
    assert [each.x[0] for each in elements(chart, 0, Line)] == pytest.approx([0.5, -4.0])  # medians of the rows
    # 5 of 8 of kxx; all of u, 0 to 1.5 σ
    assert chart.title == error_finding(plan, runs, summary_frame(plan, runs))
    assert chart.title == "81 % of the 16 values found lie within 2 σ of the true ones"


def test_values_at_a_search_limit_are_open(runs):
    runs.loc[0, "kxx"] = 50.0 + 0.5 * 3
    near = (ParameterFacts("kxx", "MN/m", 1e6, 50e6, 0.5e6, 10e6, 51.5e6), FACTS[1])
    plan = plan_of(near)
    chart = error_chart(plan, runs, summary_frame(plan, runs))
    is_open = {float(x): each.is_open for each in elements(chart, 0, Points) for x in each.x}
    assert is_open[3.0] and not is_open[1.0] and "open: at a search limit" in chart.caption
    older = tuple(ParameterFacts(each.name, each.unit, each.si_per_unit, each.truth, each.crlb) for each in near)
    assert "open" not in error_chart(plan_of(older), runs, summary_frame(plan_of(older), runs)).caption


def test_the_papers_values_stand_below_ours(runs):
    plan = plan_of(paper="table3")
    summary = summary_frame(plan, runs)
    chart = error_chart(plan, runs, summary)
    [diamonds] = [each.x for each in elements(chart, 0, Points) if each.symbol == "diamond"][:1]
    assert diamonds == pytest.approx([(50.3 - 50) / 0.5])
    assert "of the paper's, " in chart.title and "(paper\u00a07)" in chart.panels[0].y.ticks[0.0]
    table = error_table(plan, summary)
    assert list(table[""]) == ["here", "paper"] * 2
    ours = table[table[""] == "here"]
    assert list(ours["kxx (%)"]) == ["1.5*", "4.2"]  # medians of 2, 0, 1, 100 and of 0, 0.5, 8, 80 %
    assert float(table["kxx (%)"][1].rstrip("*")) == pytest.approx(0.6)  # 100 · (50.3/50 − 1)


def test_without_bounds_there_is_no_such_chart():
    assert has_bounds(plan_of())
    assert not has_bounds(plan_of((FACTS[0], ParameterFacts("u", "g mm", 1e-6, 2e-4))))
    assert not has_bounds(plan_of((ParameterFacts("kxx", "MN/m", 1e6, None),)))


def test_what_the_data_do_not_determine_counts_nothing(runs):
    """Within a bound of 150 % of the value every run would lie."""
    wide = ParameterFacts("kxx", "MN/m", 1e6, 50e6, 75e6)
    plan = plan_of((wide, FACTS[1]))
    chart = error_chart(plan, runs, summary_frame(plan, runs))
    assert len(chart.panels) == 1 and "without kxx, which the data do not determine" in chart.caption
    assert "of the 8 values" in chart.title
    assert not has_bounds(plan_of((wide,)))


def test_a_figure_does_not_repeat_the_headline_of_its_page(runs):
    plan = plan_of()
    figure = Drawn(lambda: error_chart(plan, runs, summary_frame(plan, runs)), "table3.png")
    finding = error_finding(plan, runs, summary_frame(plan, runs))
    sections = [Section("Runs", (figure,))]
    heading = f"<h3>{finding}</h3>"
    assert heading not in document("table3", Page(finding), sections, {}, {}).decode()
    assert heading in document("table3", Page("Another"), sections, {}, {}).decode()

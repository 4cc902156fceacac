"""Figure and page of one result are drawn from one chart: reports describe, and the two renderers alone draw."""

import ast
import shutil
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bench.plan.page import Drawn, Folded, Grid, Page, Section
from bench.reports.collect import collect
from ksmea.show.charts import interactive
from ksmea.show.charts.chart import Axis, Line, one_panel

ROOT = Path(__file__).resolve().parents[2]
DRAWS = {"ksmea.show.charts.picture", "ksmea.show.charts.locators", "matplotlib", "plotly"}
MAY_DRAW = {"bench/reports/collect.py"}  # writes the charts of a page as pictures
REPORTS = sorted(entry.name for entry in entry_points(group="ksmea.reports") if entry.value.startswith("bench."))


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_no_report_draws_itself():
    for path in (ROOT / "bench" / "reports").rglob("*.py"):
        name = path.relative_to(ROOT).as_posix()
        drawing = [each for each in imported(path) if any(each == one or each.startswith(f"{one}.") for one in DRAWS)]
        assert not drawing or name in MAY_DRAW, (
            f"{name} imports {drawing}; describe a chart, and put it on the page as Drawn"
        )


def test_no_description_draws_itself():
    renderers = {"picture.py", "locators.py"}
    for path in (ROOT / "ksmea" / "show" / "charts").glob("*.py"):
        drawing = [each for each in imported(path) if each.split(".")[0] in ("matplotlib", "plotly", "mpl_toolkits")]
        assert not drawing or path.name in renderers, f"{path.name} imports {drawing}"


@pytest.mark.parametrize("name", REPORTS)
def test_every_report_gives_its_figures_as_charts_of_its_page(name):
    """No report names a picture that no page shows: `figures` of `Made` are tables alone."""
    (entry,) = [each for each in entry_points(group="ksmea.reports") if each.name == name]
    source = (ROOT / f"{entry.module.replace('.', '/')}.py").read_text(encoding="utf-8")
    made = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Made"
    ]
    given = [
        ast.unparse(each)
        for call in made
        for each in [*call.args[3:4], *(k.value for k in call.keywords if k.arg == "figures")]
    ]
    assert not any(".png" in each or "png(" in each for each in given), given


@pytest.fixture
def spied(monkeypatch):
    """The charts that each renderer is asked to draw."""
    pictures, plots = [], []
    own = interactive.plot
    monkeypatch.setattr("bench.reports.collect._png", lambda chart: pictures.append(chart) or b"\x89PNG")
    monkeypatch.setattr("bench.reports.collect.available_cores", lambda: 1)  # all are drawn here
    monkeypatch.setattr("bench.reports.pages.blocks.interactive.plot", lambda chart: plots.append(chart) or own(chart))
    return pictures, plots


def test_the_picture_and_the_plot_of_a_page_are_one_chart(table3, tmp_path, spied):
    pictures, plots = spied
    assert collect(shutil.copytree(table3.output, tmp_path / "table3")) == 0
    assert len(pictures) == 5 and all(one is other for one, other in zip(pictures, plots, strict=True))


def test_charts_are_written_wherever_they_stand_on_a_page():
    chart = one_panel([Line([1.0, 2.0], [1.0, 2.0])], Axis(), Axis(), "title", "caption")
    asked = []
    blocks = (
        Grid((Drawn(chart, "a.png"), Drawn(chart))),
        Folded("more", (Drawn(lambda: asked.append(1) or chart, "b.png"),)),
    )
    charts = Page("", (Section("", blocks),)).charts()
    assert list(charts) == ["a.png", "b.png"] and not asked
    assert charts["b.png"]() is charts["b.png"]() is chart and asked == [1]  # described once

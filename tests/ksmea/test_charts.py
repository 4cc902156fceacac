"""Charts as data: both renderers draw every kind of element, at the same values and on the same axes."""

import io
import json
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from bench.reports.pages.blocks import plain
from ksmea.show.charts import chart as charts
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Axis, Chart, Choice, Element, Level, Line, Panel, Points, broken, ends_of, one_panel
from ksmea.show.charts.colours import DARK, DASHES, LIGHT, SYMBOLS, styles
from ksmea.show.charts.traces import SYMBOLS as ON_PAGE

UP, DOWN = [1.0, 2.0, 4.0], [3.0, 2.0, 1.0]
EXAMPLES = (
    charts.Line(UP, DOWN, name="line", dash="dash", symbol="square"),
    charts.Points(UP, DOWN, name="points", low=[2, 1, 0.5], high=[4, 3, 2], left=[0.5, 1, 3], right=[2, 3, 5]),
    charts.Band(UP, DOWN, [4.0, 4.0, 4.0], name="band"),
    charts.Boxes([1.0, 2.0], [UP, DOWN], name="boxes", with_points=True),
    charts.Bars([1.0, 2.0, 3.0], UP, name="bars", low=[0.5, 1, 3], high=[2, 3, 5]),
    charts.Level(at=2.0, label="level"),
    charts.Span(low=1.0, high=2.0),
    charts.Words(x=1.0, y=2.0, text="words", has_leader=True),
    charts.Area(UP, DOWN, name="area"),
    charts.Heat(np.array([[0.0, 0.4], [1.0, 0.0]])),
    charts.Space(UP, DOWN, UP, name="space"),
)


def kinds(of=Element):
    return {of} if not of.__subclasses__() else set().union(*map(kinds, of.__subclasses__()))


def chart_of(element):
    axis = Axis("z", low=0, high=5) if isinstance(element, charts.Space) else None
    return Chart("title", "caption", ((Panel((element,), Axis("x"), Axis("y"), z=axis),),))


def test_there_is_an_example_of_every_kind():
    assert {type(each) for each in EXAMPLES} == kinds()


@pytest.mark.parametrize("element", EXAMPLES, ids=lambda each: type(each).__name__)
def test_both_renderers_draw_every_kind(element):
    with_it, without = chart_of(element), chart_of(Element())
    made = picture.figure(with_it)
    empty = picture.Figure().add_subplot()
    assert isinstance(made, Figure) and len(made.axes[0].get_children()) > len(empty.get_children())
    assert picture.png(with_it).startswith(b"\x89PNG")
    spec = interactive.plot(with_it)
    drawn = spec["data"] or spec["layout"]["shapes"] or spec["layout"]["annotations"]
    assert drawn and json.dumps(plain(spec))
    with pytest.raises(TypeError, match="expected an element of a chart"):
        picture.figure(without)
    with pytest.raises(TypeError, match="expected an element of a chart"):
        interactive.plot(without)


@pytest.mark.parametrize("scale", ["linear", "log", "symlog"])
def test_both_renderers_have_the_same_values_axes_and_legend(scale):
    y = Axis("misfit (µm)", scale, 0.5, 200.0, linear=2.0, better="low")
    lines = [
        Line(UP, [1.0, 10.0, 100.0], name="one"),
        Line(UP, DOWN, name="one"),
        Points(UP, UP, name="two"),
        Level(at=10.0),
    ]
    chart = one_panel(lines, Axis("speed (rpm)"), y, "title", "caption")
    axes, spec = picture.figure(chart).axes[0], interactive.plot(chart)
    layout, data = spec["layout"], spec["data"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        layout["xaxis"]["title"]["text"],
        layout["yaxis"]["title"]["text"],
    )
    assert axes.get_yscale() == scale and axes.get_ylim() == (0.5, 200.0)
    place = {"linear": float, "log": np.log10, "symlog": lambda value: axes.transScale.transform((0, value))[1]}[scale]
    assert layout["yaxis"]["range"] == pytest.approx([place(0.5), place(200.0)])
    drawn = [line for line in axes.get_lines() if len(line.get_xdata()) == 3]
    for line, trace in zip(drawn, data):
        assert list(line.get_xdata()) == list(trace["x"])
        shown = line.get_ydata() if scale != "symlog" else axes.transScale.transform(line.get_xydata())[:, 1]
        assert list(shown) == pytest.approx(list(trace["y"]))
        assert line.get_color() == LIGHT["model"]
    (legend,) = picture.figure(chart).legends
    assert [text.get_text() for text in legend.get_texts()] == ["one", "two"]
    assert [trace["name"] for trace in data if trace["showlegend"]] == ["one", "two"]


@pytest.mark.parametrize(("high", "ticks"), [(20.0, {"dtick": "D2"}), (1e4, {"dtick": 1}), (1e9, {"nticks": 5})])
def test_ticks_of_a_logarithmic_axis_are_few(high, ticks):
    """1, 2 and 5 over one decade, each power over four: as in a picture."""
    chart = one_panel([Line(UP, DOWN)], Axis(), Axis("", "log", 1.0, high), "title", "caption")
    axis = interactive.plot(chart)["layout"]["yaxis"]
    assert {name: axis[name] for name in ticks} == ticks and ("nticks" in axis) == ("nticks" in ticks)


def test_every_point_of_a_line_is_drawn_on_a_page():
    """Simplified lines make polygons of narrow peaks."""
    spec = interactive.plot(one_panel([Line(UP, DOWN)], Axis(), Axis(), "title", "caption"))
    assert spec["data"][0]["line"]["simplify"] is False


def test_a_picture_on_given_axes_is_that_of_the_main_panel():
    panels = (Panel((Line(UP, UP, name="phase"),), title="above"), Panel((Line(UP, DOWN, name="amplitude"),)))
    axes = Figure().subplots()
    picture.on_axes(Chart("title", "caption", (panels,), main=1), axes)
    assert [line.get_label() for line in axes.get_lines()] == ["amplitude"] and axes.get_title() == "above"


def test_a_picture_has_few_colours_and_says_what_is_seen():
    chart = one_panel([Line(UP, DOWN)], Axis("x"), Axis("y"), "title µ", "caption")
    with Image.open(io.BytesIO(picture.png(chart))) as image:
        assert image.mode == "P" and len(image.getcolors()) <= 256
        assert (image.text["Title"], image.text["Description"]) == ("title µ", "caption")


@pytest.mark.parametrize("width", [2.8 * 4 + 0.6, 7.0, 6.5])  # 130 pixels times the first are 1533.9999999999998
def test_a_picture_is_upright(width):
    """A row that is a pixel short shifts all that follow: no edge of a frame is then upright."""
    chart = Chart("title", "caption", ((Panel((EXAMPLES[0],)),),), width=width)
    with Image.open(io.BytesIO(picture.png(chart))) as image:
        is_dark = np.asarray(image.convert("L")) < 100
    assert np.max(is_dark.mean(axis=0)) > 0.7


def test_a_long_line_has_few_symbols():
    long = np.arange(100.0)
    for most, shown in ((0, 100), (5, 5)):
        chart = one_panel([Line(long, long, symbol="square", most_symbols=most)], Axis(), Axis(), "title", "caption")
        (line,) = picture.figure(chart).axes[0].get_lines()
        assert len(long[:: line.get_markevery() or 1]) == shown
        assert interactive.plot(chart)["data"][0]["marker"]["maxdisplayed"] == most


def test_many_stacks_are_chosen_on_a_page_and_counted_in_a_picture():
    stacks = tuple((Panel((Line(UP, UP), Level(at=number)), title=f"cell {number}"),) for number in range(12))
    chart = Chart("title", "caption", stacks, 3, of_stacks="cell", most=9)
    made, spec = picture.figure(chart), interactive.plot(chart)
    assert len(made.axes) == 9 and "3 more are not shown" in made.get_suptitle()
    (choice,) = interactive.choices(chart)
    assert choice.options == tuple(f"cell {number}" for number in range(12)) and not choice.with_all
    assert [trace["meta"] for trace in spec["data"]] == [{"cell": name} for name in choice.options]
    assert [shape["meta"] for shape in spec["layout"]["shapes"]] == [{"cell": name} for name in choice.options]
    assert "xaxis2" not in spec["layout"]


def test_stacks_side_by_side_are_one_over_another_on_a_narrow_page():
    own = tuple((Panel((Line(UP, UP),), Axis("x", group="x"), Axis("y", group="y"), name),) for name in "abc")
    layout = interactive.plot(Chart("title", "caption", own, 3))["layout"]
    wide, narrow = (
        [at[f"{side}axis{end}"]["domain"] for end in ("", 2, 3)]
        for at, side in ((layout, "x"), (layout["narrow"], "y"))
    )
    for domains in (wide, narrow[::-1]):
        assert all(one[1] < other[0] for one, other in pairwise(domains))
    assert layout["narrow"]["height"] > 2 * layout["height"]
    assert layout["xaxis2"]["matches"] == "x" and layout["yaxis3"]["matches"] == "y"
    panels = picture.figure(Chart("title", "caption", own, 3)).axes
    assert panels[0].get_shared_x_axes().joined(panels[0], panels[2])
    assert [panel.get_ylabel() for panel in panels] == ["y", "", ""]


def test_long_names_of_rows_are_broken_on_a_narrow_page():
    names = ["complex, noise_known False, floor 0.1", "short"]
    y = Axis(ticks=dict(enumerate(names)))
    layout = interactive.plot(one_panel([Points([1, 2], [0, 1])], Axis(), y, "title", "caption"))["layout"]
    assert layout["yaxis"]["ticktext"] == names
    assert layout["narrow"]["yaxis"]["ticktext"] == ["complex, noise_known<br>False, floor 0.1", "short"]


def test_a_page_chooses_by_tags():
    lines = [Line(UP, UP, tags={"whirl": "forward"}), Line(UP, DOWN)]
    chart = one_panel(lines, Axis(), Axis(), "", "", choices=(Choice("whirl", "whirl", ("forward",)),))
    assert [trace["meta"] for trace in interactive.plot(chart)["data"]] == [{"whirl": "forward"}, {}]
    assert interactive.choices(chart) == chart.choices


def test_ends_are_those_of_all_elements():
    panel = Panel((Points([1, 2], [3, np.nan], low=[0, 1], high=[5, 9]), Level(at=-1.0), charts.Boxes([7], [[20.0]])))
    assert ends_of([panel], "y") == (-1.0, 20.0) and ends_of([panel], "x") == (1.0, 7.0)
    other = Panel((Line([0.0, 9.0], [0.0, 30.0]),), Axis("", "log"))
    assert ends_of([panel, other], "y") == (-1.0, 30.0) and ends_of([other], "x") == (9.0, 9.0)
    assert ends_of([Panel(())], "x") == (1.0, 1.0)


def test_words_of_the_descriptions_are_known_to_both():
    assert set(LIGHT) == set(DARK) and set(DASHES) == set(picture.LINES)
    assert set(SYMBOLS) <= set(ON_PAGE) == set(picture.MARKERS) - {""}
    twenty = styles([str(number) for number in range(20)])
    assert len(set(twenty.values())) == 20
    assert np.isnan(broken([1.0, 2.0, 3.0], [1])[1])

"""`draw`: a rotor to scale and how it whirls, from the words of a command to its files; what its figures show."""

import dataclasses
import re
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ksmea import load_problem
from ksmea.errors import SettingError
from ksmea.rotordynamics.layout import EffectMark, ShaftSection
from ksmea.rotordynamics.whirl import CriticalSpeedMap
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Area, Points, Words
from ksmea.show.charts.mode_shape_charts import deflections_chart, in_plane, nodes, orbits_chart
from ksmea.show.charts.rotor_chart import rotor_chart
from ksmea.show.charts.whirl_charts import WHIRL, campbell_chart, stiffnesses_of_model
from ksmea.studies.rotordynamics import _crossings

ROOT = Path(__file__).resolve().parents[2]
QUICK = ("speeds=31", "modes=4", "harmonics=[1]")
PUBLISHED = [3620, 3798, 10018, 11279]  # rpm, Lalanne & Ferraris


@pytest.fixture(scope="module")
def drawing():
    return load_problem("three_disk").draw(speeds=31, modes=4, harmonics=[1.0])


def test_files_with_umlauts_and_spaces_are_drawn_and_exported_as_they_are_named(enter, tmp_path):
    rotor = "mein läufer.yaml"
    (tmp_path / rotor).write_bytes((ROOT / "docs" / "examples" / "rotor.yaml").read_bytes())
    given = ("problem=rotor", f"problem.file={rotor}")
    drawn = enter("draw", *given, *QUICK, "output=Bild µ, 1", output="Bild µ, 1")
    assert drawn.code == 0 and not drawn.err and (drawn.output / "index.html").is_file()
    exported = enter("export", "measurement", "--out", "run.csv", *given, "measurement.relative=0.05")
    assert exported.code == 0 and not exported.err and (tmp_path / "run.csv").is_file()


def test_a_drawing_has_figures_numbers_and_one_page(enter):
    ended = enter("draw", "problem=three_disk", "highest_rpm=12000", *QUICK, output="results/draw_three_disk")
    assert ended.code == 0 and not ended.err
    names = {path.name for path in ended.output.iterdir()}
    pictures = {"rotor", "campbell", "stability", "speed_map", "orbits", "deflections"}
    tables = {"rotor", "campbell", "critical_speeds", "speed_map", "mode_shapes", "sag"}
    assert names == {*(f"{each}.png" for each in pictures), *(f"{each}.csv" for each in tables), "index.html"}
    found = ended.table("critical_speeds")["critical_speed_rpm"]
    assert list(found) == pytest.approx(PUBLISHED, rel=5e-4)  # as tests/rotor/test_modes.py
    assert "3620.4" in ended.out and "index.html" in ended.out
    page = (ended.output / "index.html").read_text()
    assert (
        # without JavaScript the first ones are shown, the others linked
        page.count("<img alt=") + sum(f'href="{each}.png"' in page for each in pictures) == 6
        and "http:" not in page
        and "https:" not in page
        and "highest_rpm=12000" in page
        and "3620.4" in page
    )
    index = (ended.output.parent / "index.html").read_text()
    assert "4 critical speeds up to 12000 rpm" in index and re.search(
        r"<td class=\"when\">20\d\d-\d\d-\d\d \d\d:\d\d</td><td>draw</td>", index
    )


def test_values_settings_and_plugins_are_those_of_the_command_line(enter):
    words = ("problem.mesh=21", "problem=three_disk", "values.kxx=30", "values={kyy: 30}", "output=here")
    ended = enter("draw", *words, *QUICK, output="here")
    assert ended.code == 0
    bearings = ended.table("rotor").query("thing == 'bearing 1'")
    assert bearings[["kxx_MN_m", "kyy_MN_m", "cxx_kN_s_m"]].to_numpy().tolist() == [[30, 30, 0.5]]
    assert (ended.output / "index.html").exists()


def test_an_unknown_without_a_value_has_the_middle_of_its_limits_and_it_is_said(tmp_path):
    drawing = load_problem("rk4").with_settings().draw(speeds=16, modes=2)
    assert not any("No value" in remark for remark in drawing.record.remarks)
    rotor = (ROOT / "docs/examples/rotor.yaml").read_text(encoding="utf-8")
    file = tmp_path / "rotor.yaml"
    file.write_text(re.sub(", reference: [0-9.]*", "", rotor).replace("upper: 500", "upper: 400"), encoding="utf-8")
    drawing = load_problem("rotor", file=str(file)).draw({"kyy": 70.0}, speeds=16, modes=2, harmonics=[1.0])
    values = {name: value for name, _, value in drawing.record.values}
    # limits of 10 and 100, 0.01 and 1, 50 and 400; exact but for rounding
    assert values == pytest.approx({"kxx": np.sqrt(1000), "kyy": 70, "cxx": 0.1, "cyy": 0.1, "u": 225})
    lines = str(drawing).splitlines()
    assert "No value is known of kxx, cxx, cyy, u." in lines and max(map(len, lines)) < 125


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("problem=nope", "unknown problem 'nope'"),
        ("values.kxx=soft", "values.kxx: expected a number"),
        ("values.kzz=1", "kzz"),
        ("values=3", "values: expected values by name"),
        ("modes=99", "modes: expected a number"),
        ("modez=3", "did you mean 'modes'"),
        ("values.kxx=1,2", "expected one value of values.kxx, got 2"),
        ("--fast", "expected setting=value, got --fast"),
        ("problem.mesh=3", "mesh: expected at least 4"),
        ("harmonics=[]", "harmonics: expected at least one"),
        ("stiffness_from=1e9", "stiffness_from, stiffness_to"),
        ("output=results/run", "choose another output"),
    ],
)
def test_bad_input_is_one_line(enter, tmp_path, word, said):
    (tmp_path / "results" / "run").mkdir(parents=True)
    (tmp_path / "results" / "run" / "plan.jsonl").write_text("")
    ended = enter("draw", word)
    assert ended.code == 2 and said in ended.err and ended.err.count("\n") == 1 and not ended.out


def test_the_rotor_is_drawn_to_scale(drawing):
    chart = rotor_chart(drawing.record.layout)
    (panel,) = chart.panels
    assert panel.is_to_scale and picture.figure(chart).axes[0].get_aspect() == 1.0
    areas = [each for each in panel.elements if isinstance(each, Area)]
    sections = [each for each in areas if np.ptp(each.y) == pytest.approx(100.0)]  # mm: the shaft's diameter
    assert [np.ptp(each.x) for each in sections] == pytest.approx([200.0, 300.0, 500.0, 300.0])
    assert {120, 200} <= {round(max(each.y)) for each in areas}  # outer radii of the disks
    words = " ".join(each.text for each in panel.elements if isinstance(each, Words))
    for each in ("bearing 1", "bearing 2", "disk 3", "unbalance 200 g mm", "probe x, y", "500"):
        assert each in words


def crowded_layout(layout):
    """91 sections with sleeves and a cone, 7 disks, 2 bearings, one of them on a pedestal, and 12 seals."""
    length = layout.length
    ends = np.linspace(0.0, length, 92)
    sections = tuple(ShaftSection(a, b, 0.04, 0.0, 0.05 if number == 3 else None) for number, (a, b) in
                     enumerate(pairwise(ends)))  # fmt: skip
    layers = tuple(ShaftSection(a, b, 0.06, 0.04, kind="layer") for a, b in zip(ends[10:80:2], ends[11:80:2]))
    at = np.linspace(0.25, 0.75, 12) * length
    first, last = layout.bearings
    return dataclasses.replace(
        layout, sections=sections, layers=layers, sag=1e-4 * np.sin(np.pi * layout.node_positions / length),
        disks=tuple(dataclasses.replace(layout.disks[0], position=place, thickness=0.01) for place in at[:7]),
        bearings=(first, dataclasses.replace(last, has_pedestal=True)), couplings=(0.0,), masses=layout.disks[:1],
        seals=tuple(dataclasses.replace(first, position=place) for place in at),
        housings=(None, *(1 for _ in layout.probes[1:])),
    )  # fmt: skip


def test_a_rotor_of_91_sections_is_legible_and_its_new_parts_have_a_legend(drawing):
    layout = crowded_layout(drawing.record.layout)
    chart, largest = rotor_chart(layout), 1e6 * np.max(layout.sag)
    (panel,) = chart.panels
    names = {each.name for each in panel.elements if each.name}
    assert names == {"layer", "seal", "lumped mass", "pedestal", "coupling", f"static sag, largest {largest:.3g} µm"}
    cone = next(each for each in panel.elements if isinstance(each, Area) and np.ptp(each.y) == pytest.approx(100.0))
    assert list(np.abs(cone.y)) == pytest.approx([40.0, 50.0, 50.0, 40.0])
    (sag,) = (each for each in panel.elements if each.name.startswith("static sag"))
    assert min(sag.y) == pytest.approx(-0.04 * 1300, rel=0.01)  # hangs below the axis
    figure = picture.figure(chart)
    figure.draw_without_rendering()
    texts = figure.axes[0].texts
    said = [text.get_text() for text in texts]
    assert {"disk 1", "bearing 1", "seal 1"} <= set(said) and any("on housing 2" in each for each in said)
    boxes = [text.get_window_extent() for text in texts]
    for index, box in enumerate(boxes):
        assert not any(box.shrunk(0.98, 0.8).overlaps(other.shrunk(0.98, 0.8)) for other in boxes[:index])


def test_words_at_one_place_do_not_hide_each_other(drawing):
    layout = drawing.record.layout
    marks = tuple(EffectMark(f"effect {n}", "", (0.1, 0.1 + 0.02 * n)) for n in range(4))
    crowded = type(layout)(**{**vars(layout), "effects": marks})
    figure = picture.figure(rotor_chart(crowded))
    figure.draw_without_rendering()
    above = [text for text in figure.axes[0].texts if text.get_verticalalignment() == "bottom"]
    boxes = [text.get_window_extent() for text in above]
    assert len(boxes) > 8
    for index, box in enumerate(boxes):
        assert not any(box.shrunk(0.98, 0.8).overlaps(other.shrunk(0.98, 0.8)) for other in boxes[:index])


def words_on_a_phone(layout):
    """Ends of each line of words in px, as a page 360 px wide draws it: across and down."""
    (panel,) = rotor_chart(layout).panels
    scale = 256 / (panel.x.high - panel.x.low)
    for words in panel.elements:
        if isinstance(words, Words):
            lines = words.text.split("\n")
            width, height = 6.0 * max(map(len, lines)), 14.0 * len(lines)
            left = scale * words.x - {"left": 0.0, "center": 0.5, "right": 1.0}[words.side] * width
            top = -scale * words.y - (height if words.edge == "bottom" else 0.0)
            yield words.text, left, left + width, top, top + height


@pytest.mark.parametrize("of", ["three_disk", "pump.yaml", "rig.yaml", "rotor.yaml", "crowded"])
def test_no_words_of_a_rotor_lie_on_each_other_on_a_phone(drawing, of):
    layout = drawing.record.layout
    if of.endswith("yaml"):
        layout = load_problem("rotor", file=str(ROOT / "docs" / "examples" / of)).draw(speeds=31).record.layout
    found = [*words_on_a_phone(crowded_layout(layout) if of == "crowded" else layout)]
    assert len(found) > 6
    for (_, left, right, top, bottom), (_, first, last, high, low) in combinations(found, 2):
        assert not (left < last and first < right and top < low and high < bottom)


def test_the_campbell_diagram_marks_each_critical_speed_where_it_is(drawing):
    (panel,) = campbell_chart(drawing.record).panels
    (circles,) = [each for each in panel.elements if isinstance(each, Points)]
    assert circles.x == pytest.approx(PUBLISHED, rel=5e-4)
    assert circles.y == pytest.approx(np.array(circles.x) / 60)  # 1X: Hz and rpm
    assert {WHIRL["forward"], WHIRL["backward"]} <= {each.colour for each in panel.elements}


def test_tables_say_what_the_figures_show(drawing):
    found = drawing.record
    campbell = drawing.to_frame("campbell")
    assert len(campbell) == np.isfinite(found.branches.frequency).sum()
    shapes = drawing.to_frame("mode_shapes")
    assert shapes.groupby("mode")[["x_re", "y_re"]].max().to_numpy().max() <= 1 + 1e-12
    assert (shapes.groupby("mode").size() == len(found.shapes.places)).all()
    speeds = drawing.to_frame("speed_map")
    at_end = speeds[speeds["stiffness_MN_m"] == speeds["stiffness_MN_m"].max()]
    assert (
        at_end.groupby(["whirl", "number"])["critical_speed_rpm"].max().groupby("whirl").is_monotonic_increasing
    ).all()
    assert isinstance(drawing.to_frame(), pd.DataFrame) and "1X" in str(drawing) and "<table" in drawing._repr_html_()
    with pytest.raises(SettingError, match="unknown table of a drawing"):
        drawing.to_frame("nothing")


def test_a_shape_in_its_plane_has_the_nodes_of_the_beam():
    places = np.linspace(0.0, 1.0, 101)
    shape = np.sin(3 * np.pi * places + 1e-9) * np.exp(0.7j)  # the third mode of a beam on two pins, at any moment
    inner = [node for node in nodes(places, in_plane(shape)) if 0.01 < node < 0.99]
    assert inner == pytest.approx([1 / 3, 2 / 3], abs=1e-3)  # straight lines between a hundred places
    assert np.max(np.abs(in_plane(shape))) == pytest.approx(1.0)


def test_a_page_shows_one_orbit_at_a_time_and_all_deflections_side_by_side(drawing):
    """Panels in space are turned by hand; the same panels stand side by side in the picture."""
    orbits, deflections = orbits_chart(drawing.record), deflections_chart(drawing.record)
    assert len(orbits.stacks) == len(deflections.stacks) == len(drawing.record.shapes.motions.eigenvalue) == 4
    (choice,) = interactive.choices(orbits)
    assert choice.options[0].startswith("1: ") and not interactive.choices(deflections)
    layout = interactive.plot(orbits)["layout"]
    narrow, wide = (each["scene"]["camera"]["eye"] for each in (layout["narrow"], layout))
    assert narrow["y"] < wide["y"] < 0  # farther
    colours = {each.colour for panel in orbits.panels for each in panel.elements if each.name in WHIRL}
    assert colours == {WHIRL["forward"], WHIRL["backward"]}
    second = {each.name: each for each in deflections.panels[2].elements}
    assert max(np.max(np.abs(second[name].y)) for name in "xy") == pytest.approx(1.0)


def test_the_legend_of_a_page_names_nodes_although_the_first_mode_has_none(drawing):
    traces = interactive.plot(deflections_chart(drawing.record))["data"]
    named = [trace for trace in traces if trace["showlegend"]]
    assert {"node of x", "node of y"} <= {trace["name"] for trace in named} and all(len(trace["x"]) for trace in named)


def test_a_page_of_others_is_not_overwritten(enter, tmp_path):
    theirs = tmp_path / "site" / "index.html"
    theirs.parent.mkdir()
    theirs.write_text("<p>mine</p>")
    ended = enter("draw", f"output={theirs.parent}", *QUICK, output="site")
    assert ended.code == 2 and "found another page" in ended.err and theirs.read_text() == "<p>mine</p>"
    assert [path.name for path in theirs.parent.iterdir()] == ["index.html"]


def test_a_critical_speed_that_is_a_scanned_one_is_found_once():
    def constant(speed):
        return np.full((len(speed), 1), 100.0)

    for n_speed in (5, 6):
        speed = np.linspace(0.0, 200.0, n_speed)
        assert _crossings(constant, constant(speed), speed, 1.0) == [(100.0, 0)]


def test_stiffnesses_that_are_close_share_one_text():
    drawn = CriticalSpeedMap(
        np.array([1e6, 1e9]), np.ones((2, 1)), np.ones((2, 1)), (("kyy", 52e6), ("kxx", 50e6), ("k", 4e8), ("far", 2e9))
    )
    assert stiffnesses_of_model(drawn) == [([50.0, 52.0], "kxx 50, kyy 52"), ([400.0], "k 400")]

"""Words of a page on itself: its file, its marks, and 100 % of an angle."""

import dataclasses
import json
import re
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from bench.plan.page import Table
from bench.reports.diagnosis.page import diagnosis_page
from bench.reports.identification.spread_chart import _percent as error_in_words
from bench.reports.pages.blocks import Blocks
from bench.reports.pages.experiment import heading
from bench.reports.pages.made_by import command_line
from ksmea.records.curves import FineCurve
from ksmea.records.diagnosis import CurvesRecord, DiagnosisRecord, NoiseRecord, ResidualsRecord, ResponsesRecord
from ksmea.records.estimate import NoiseLevelRecord, Shown
from ksmea.show.charts.chart import Points
from ksmea.show.charts.intervals_chart import intervals_chart
from ksmea.show.charts.response_charts import bode_chart
from ksmea.show.charts.responses import AS_GIVEN, WITH_CAUSE, ModelCurve, Response, of_diagnosis, residuals
from ksmea.show.diagnosis_text import text

RECORD = DiagnosisRecord.from_data(
    json.loads((Path(__file__).parents[1] / "data/diagnosis_of_schema_2.json").read_text())
)


def points_of(chart):
    return [each for each in chart.panels[0].elements if isinstance(each, Points)]


def plan_of(*paths):
    return SimpleNamespace(
        name="diagnose",
        cells=[SimpleNamespace(settings={"measurement": {"name": "file", "path": path}}) for path in paths],
    )


@pytest.mark.parametrize(
    ("paths", "title"),
    [(["rig/run 1.csv"] * 2, "diagnose: run 1.csv"), (["a.csv", "b.csv"], "diagnose"), ([None], "diagnose")],
)
def test_a_page_is_named_after_the_file_of_its_data(paths, title):
    assert heading(plan_of(*paths)) == title


def test_an_angle_near_zero_does_not_squash_the_other_intervals():
    """0.1° ± 2° is ± 2000 % of the value, but 3.5 % of 1 rad."""
    unknowns = {
        "kxx": {"identified": Shown(50, 49, 51, "MN/m")},
        "phase_origin": {"identified": Shown(0.1, -1.9, 2.1, "deg")},
    }
    drawn = intervals_chart(unknowns, {}, "Intervals.")
    assert drawn.caption == "Intervals. Angles: 100 % is 1 rad."
    assert points_of(drawn)[0].right == pytest.approx([2.0, 100 * np.radians(2.0)])
    assert intervals_chart({"kxx": unknowns["kxx"]}, {}, "Intervals.").caption == "Intervals."


def test_a_value_beyond_the_edge_is_an_arrow_there():
    """10 ± 1 is believed: beyond 1.15 × 10 times that nothing fits; 30 lies 200 % away, and 11 does not."""
    of = {"before": Shown(30, 29, 31, "N"), "after": Shown(10, 9, 11, "N")}
    near = {"before": Shown(11, 10, 12, "N"), "after": Shown(10, 9, 11, "N")}
    drawn = intervals_chart({"far": of, "near": near}, {}, "Intervals.")
    edge = drawn.panels[0].x.high
    before, _, arrow = points_of(drawn)
    assert edge == pytest.approx(115) and before.x == pytest.approx([10])
    assert arrow.symbol == "triangle right" and 0.9 * edge < arrow.x[0] < edge
    assert arrow.said == ["far: 30.0 [29.0, 31.0] N"] and arrow.y[0] < 0.5  # in the row of its unknown
    assert drawn.caption == "Intervals. Arrows: beyond that edge or open, as the table says."
    assert "Arrows" not in intervals_chart({"near": near}, {}, "Intervals.").caption


def test_an_end_beyond_the_edge_or_open_is_an_arrow_there():
    """One unknown that is hardly known sets no scale for four that are: ± 1 % against ± 900 %; an open end is beyond any."""
    known = {name: {"after": Shown(10, 9.9, 10.1, "N")} for name in ("kxx", "kyy", "u", "cxx")}
    loose = {"cyy": {"after": Shown(1, -8, 10, "N")}, "czz": {"after": Shown(1, 0.99, np.nan, "N")}}
    drawn = intervals_chart(known | loose, {}, "Intervals.")
    assert drawn.panels[0].x.high == pytest.approx(1.15 * 10 * 1)
    arrows = [(each.y[0], each.symbol) for each in points_of(drawn)[1:]]
    assert arrows == [(4, "triangle left"), (4, "triangle right"), (5, "triangle right")]


def test_a_caption_tells_the_marks_of_residuals_apart():
    speed, values = np.array([100.0, 200.0]), np.array([[1 + 1j], [2 + 0j]])
    parts = {"in phase": values.real, "in quadrature": values.imag}
    models = (AS_GIVEN, WITH_CAUSE)
    curves = {name: ModelCurve(speed, values) for name in models}
    shown = Response(
        speed, ("x",), values, True, None, curves, dict.fromkeys(models, values), dict.fromkeys(models, parts)
    )
    chart = bode_chart(shown, "title")
    assert "(● in phase; × in quadrature)" in chart.caption
    *_, before, after = chart.panels  # of each model
    for panel, model in ((before, AS_GIVEN), (after, WITH_CAUSE)):
        assert panel.y.label.endswith(model)
        assert [(each.symbol, each.name) for each in panel.elements if isinstance(each, Points)] == [
            ("circle", "residual in phase"),
            ("x", "residual in quadrature"),
        ]


@pytest.mark.parametrize("word", ["a='ä b'", 'a="b"', "a='$HOME'", "a='`id`'", "a='b!c'", "a='\\'", "a=b c", "a=''"])
def test_a_command_of_a_page_gives_a_shell_the_words_that_were_given(word):
    done = subprocess.run(
        ["sh", "-c", command_line([word]).replace("python -m bench", "printf %s", 1)], capture_output=True, check=True
    )
    assert done.stdout.decode() == word


def test_an_error_is_told_without_powers_of_ten():
    assert [error_in_words(each) for each in (3.02, 100.0, 2.8e-7)] == ["3", "100", "0.001"]


def test_models_of_a_diagnosis_are_drawn_at_the_fine_speeds_of_its_record():
    speed, fine = (200.0, 300.0), (200.0, 250.0, 300.0)
    values = ((1e-6,), (2e-6,))
    curves = CurvesRecord(
        speed=speed,
        channels=("x at 0.1 m",),
        responses=ResponsesRecord(measured=values, before=values, after=values),
        residuals=ResidualsRecord(before=values, after=values),
        fine_after=FineCurve(fine, ((1e-6,), (9e-6,), (2e-6,))),
    )
    drawn = of_diagnosis(dataclasses.replace(RECORD, curves=curves)).curves
    assert drawn[WITH_CAUSE].values[:, 0] == pytest.approx([1, 9, 2])  # µm
    assert drawn[WITH_CAUSE].speed == pytest.approx(np.array(fine) * 60 / (2 * np.pi))
    assert len(drawn[AS_GIVEN].speed) == len(speed)


@pytest.mark.parametrize("by_run", [(), (("up", 0.0, 2e-6), ("down", 0.5, 0.0))])
@pytest.mark.parametrize("is_complex", [False, True])
def test_residuals_before_and_after_are_in_units_of_the_same_noise(by_run, is_complex):
    """Amplitudes of 4 and 6 µm, of which the model before leaves 2 and 3 µm and that after 1 µm each; the noise that was
    estimated before is 2 µm, that after is by the extended model."""
    of_before, of_after = ([2.0, 0.5 * 3.0], [2.0, 0.5 * 5.0]) if by_run else ([1.0, 1.0], [1.0, 1.0])  # µm

    def told(*values):
        return tuple(((complex(each).real, 0.0) if is_complex else each,) for each in values)

    curves = CurvesRecord(
        speed=(200.0, 300.0),
        channels=("x at 0.1 m",),
        responses=ResponsesRecord(told(4e-6, 6e-6), told(2e-6, 3e-6), told(3e-6, 5e-6)),
        residuals=ResidualsRecord(told(1.0, 1.5), told(*(1 / np.array(of_after)).tolist())),
        breaks=(1,) if by_run else (),
    )
    noise = NoiseRecord(False, False, NoiseLevelRecord(0.0, 2e-6), NoiseLevelRecord(0.0, 1e-6, by_run))
    record = dataclasses.replace(RECORD, curves=curves, noise=noise)
    parts = {name: next(iter(each.values()))[:, 0] for name, each in of_diagnosis(record).residuals.items()}
    turned = np.sqrt(2) if is_complex else 1  # a component of a complex residual has half its variance
    assert parts[AS_GIVEN] == pytest.approx(turned * np.array([2.0, 3.0]) / of_before)
    assert parts[WITH_CAUSE] == pytest.approx(turned / np.array(of_after))
    known = dataclasses.replace(record, noise=dataclasses.replace(noise, known=True))
    told_before = of_diagnosis(known).residuals[AS_GIVEN]
    assert next(iter(told_before.values()))[:, 0] == pytest.approx(turned * np.array([1.0, 1.5]))  # the same of both
    alone = dataclasses.replace(curves, residuals=dataclasses.replace(curves.residuals, after=None))
    assert residuals(dataclasses.replace(record, curves=alone))["before"][:, 0] == pytest.approx([1.0, 1.5])


def test_tables_of_a_page_have_the_digits_of_the_text():
    """Every value and interval of the folded tables stands in the text, character by character."""
    folded = {
        each.title: each.blocks for section in diagnosis_page(RECORD, ()).sections[-1:] for each in section.blocks
    }
    [unknowns, _], said = folded["All unknowns, as given and with the cause"], text(RECORD)
    cells = unknowns.frame[[AS_GIVEN, WITH_CAUSE]].to_numpy().ravel()
    assert {cell for cell in cells if "[" in cell} and all(cell in said for cell in cells)
    assert unknowns.frame["unknown"].tolist() == [row.name for row in RECORD.coefficients]
    assert unknowns.frame.set_index("unknown").loc["runout_x", AS_GIVEN] == "–"
    [trials] = folded[f"All {len(RECORD.ranking)} fits, the highest ΔBIC first"]
    first = trials.frame.iloc[0]
    assert f"{first['unknown']} {first['size']} {first['interval']} {first['unit']}" in said


def test_a_table_tells_what_is_missing_and_keeps_names():
    frame = pd.DataFrame({"k_xx (MN/m)": [np.nan, 1.5, 50.026], "error": [None, "", "none"]})
    html = Blocks({}).html(Table(frame))
    assert re.findall("<th [^>]*>([^<]*)", html) == ["k_xx (MN/m)", "error"]
    assert re.findall("<td[^>]*>([^<]*)", html) == ["–", "–", "1.5", "", "50.026", "none"]

"""Columns and figures that are believed: a flag is of the value beside it, an unfinished figure says so, no name of another quantity is
proposed."""

import numpy as np
import pandas as pd
import pytest

from bench.plan.page import Drawn, Folded, Grid, Page, Plot, Prose, Section
from bench.reports import runs
from bench.reports.collect import _titled, _unfinished
from ksmea.errors import CONVERSIONS, SettingError, unknown
from ksmea.measurement.channel import Channel
from ksmea.records.identification import ParameterRecord
from ksmea.show.charts.chart import Chart
from measurements.common_speeds import at_compared_speeds
from measurements.run_up import RunUp


def parameter(**more):
    return ParameterRecord("kxx", "MN/m", 1e6, identified=5e7, at_limit=True, **more)


def frames(plan, monkeypatch, *parameters):
    """runs.csv of records with these values of kxx, plain and in the words of identifications."""
    rows = {}
    for run, each in zip(plan.runs, parameters):
        row = {"kxx": each.in_unit(each.identified), "kxx_error_pct": 1.0}
        if each.most_likely is None:
            row["kxx_at_limit"] = each.at_limit
        else:
            row |= runs._interval_columns(each, "profile")
        rows[run.key] = row | {"status": "done", "error": ""}
    monkeypatch.setattr(runs, "read_records", lambda *given: rows)
    return runs.runs_frame(plan, None), runs.of_identifications(plan, None)


def test_a_flag_stands_beside_the_value_that_it_is_of(plan, monkeypatch):
    """The most likely value is at its limit; where the search ended, 50 MN/m, is not."""
    plain, identified = frames(plan, monkeypatch, parameter(most_likely=1e8, kind="profile", low=9e7), parameter())
    assert plain.loc[0, "kxx_most_likely_at_limit"] and pd.isna(plain.loc[0, "kxx_at_limit"])
    columns = list(identified.columns)
    assert columns[columns.index("kxx_value") + 1] == "kxx_at_limit"
    assert identified["kxx_value"].iloc[:2].tolist() == [100.0, 50.0] and identified["kxx_at_limit"].iloc[:2].all()
    assert not [name for name in columns if name.endswith("most_likely_at_limit")]


def test_a_figure_of_an_unfinished_experiment_says_how_many_runs_it_shows():
    status = pd.DataFrame({"status": ["done"] * 9 + ["budget"] * 2 + ["not run"] * 9})
    said = _unfinished(status)
    assert said == "11 of 20 runs" and _unfinished(status.iloc[:11]) == ""
    drawings = _titled({"a.png": lambda: Chart("Spread", "", ()), "b.png": b"png"}, said)
    assert drawings["a.png"]().title == "Spread (11 of 20 runs)" and drawings["b.png"]() == b"png"


@pytest.mark.parametrize(
    ("name", "known", "conversion"),
    [
        ("phase_lag_deg", "phase_lead_deg", "lead = -lag"),
        ("amplitude_mil_0pk", "amplitude_um_0pk", "1 mil = 25.4 um"),
        ("amplitude_um_pp", "amplitude_um_0pk", "0pk = pp / 2"),
        ("pressure_psi", "pressure_pa", "1 psi = 6894.757 Pa"),
        ("length_in", "length_mm", "1 in = 25.4 mm"),
    ],
)
def test_a_name_of_another_quantity_is_not_proposed(name, known, conversion):
    error = unknown("column", name, [known, "run"])
    assert "did you mean" not in str(error) and f"{known} is another quantity: convert by {conversion}" in str(error)
    assert error.meant.near is None
    assert "did you mean" in str(unknown("column", name.replace("_", "-"), [name]))


def test_conversions_agree_with_each_other():
    """There and back gives 1, of those that are factors."""
    for (first, second), text in CONVERSIONS.items():
        back = CONVERSIONS[second, first]
        if not (text.startswith("1 ") and "/" not in text + back):
            continue
        assert float(text.split()[3]) * float(back.split()[3]) == pytest.approx(1, rel=1e-4), (first, second)


def test_what_is_left_out_is_named_with_its_cause():
    speeds = np.array([100.0, 110.0, 120.0, 130.0])

    def run(kept):
        speed = speeds[kept]
        values, order = np.ones((len(speed), 1)) * 1j, np.arange(len(speed))[:, None]
        return RunUp(speed, (Channel(0.1, "x"),), (2,), values, None, None, None, (), order)

    bare, trial = at_compared_speeds([run([0, 1, 2, 3]), run([0, 2, 3])], ["bare", "trial"], "bare", "campaign.yaml")
    assert list(bare.speed) == list(trial.speed) == [100.0, 120.0, 130.0]
    assert bare.remarks == ("1 of 4 speeds left out: no other run has them",) and trial.remarks == ()
    with pytest.raises(SettingError, match=r"of run bare that another run has for differences.*got none"):
        at_compared_speeds([run([0, 1]), run([2, 3])], ["bare", "trial"], "bare", "campaign.yaml")
    names = ["bare", "one", "two"]
    with pytest.raises(SettingError, match="of run two that another run has"):
        at_compared_speeds([run([0, 1]), run([0, 1]), run([2, 3])], names, "bare", "campaign.yaml")
    bare, one, two = at_compared_speeds([run([0, 1]), run([0, 1, 2]), run([1, 2, 3])], names, "bare", "campaign.yaml")
    assert [list(each.speed) for each in (bare, one, two)] == [[100.0, 110.0], [100.0, 110.0, 120.0], [110.0, 120.0]]
    assert bare.remarks == (
        "lacks 1 of the 3 speeds that other runs have, and has no part in the differences there",
    ) and not (one.remarks)
    assert two.remarks[0] == "1 of 3 speeds left out: no other run has them" and "lacks 1 of the 3" in two.remarks[1]


def test_charts_of_a_page_say_how_many_runs_they_show_in_every_place():
    chart = Chart("Spread", "", ())
    blocks = (
        Drawn(chart, "a.png"),
        Grid((Plot("Bode", "", {}),)),
        Folded("more", (Drawn(lambda: chart),)),
        Prose("text"),
    )
    page = Page("found", (Section("Results", blocks),)).titled("11 of 20 runs")
    [section] = page.sections
    drawn, grid, folded, prose = section.blocks
    assert page.charts()["a.png"]().title == drawn.described().title == "Spread (11 of 20 runs)"
    assert grid.plots[0].title == "Bode (11 of 20 runs)" and folded.blocks[0].described().title.endswith(
        "(11 of 20 runs)"
    )
    assert prose is blocks[-1] and page.headline == "found"

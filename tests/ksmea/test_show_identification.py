"""An identification in sentences, as a table and as a figure, from records that earlier versions have written."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from ksmea.errors import SettingError
from ksmea.records.identification import IdentificationRecord, ParameterRecord
from ksmea.show.identification_text import COLUMNS, frame, plot, text
from ksmea.units import MICROMETRE, RPM

OLDER = Path(__file__).resolve().parents[1] / "data" / "identifications_schema_2.jsonl"

PRINTED = """\
three_disk, run_up.csv: 90 speeds from 2062 to 13868 rpm, 2 channels (x at 0.1 m, y at 0.1 m), amplitudes (0-peak) and phases
  kxx = 50.028 MN/m, 95 % interval [49.992, 50.063]
  kyy = 70.011 MN/m, 95 % interval [69.964, 70.059]
  cxx = 0.496 kN s/m, 95 % interval [0.462, 0.530]
  cyy = 0.710 kN s/m, 95 % interval [0.664, 0.756]
  u = 199.9 g mm, 95 % interval [198.7, 201.2]
  phase_origin = 39.88 deg, 95 % interval [39.51, 40.24]
noise, estimated: 5.2 % + 0.018 µm
strongly correlated parameters (|r| > 0.95): none
fit: the residuals are consistent with noise (channels together, p = 0.31)"""


@pytest.fixture(scope="module")
def synthetic():
    return IdentificationRecord.from_data(json.loads(OLDER.read_text(encoding="utf-8").splitlines()[0]))


@pytest.fixture(scope="module")
def detailed():
    return IdentificationRecord.from_data(json.loads(OLDER.read_text(encoding="utf-8").splitlines()[1]))


def test_the_sentences_are_those_that_were_printed(detailed):
    assert text(detailed, "three_disk, run_up.csv") == PRINTED
    assert text(detailed).splitlines()[0] == PRINTED.splitlines()[0].partition(": ")[2]


def test_a_record_without_details_has_a_title_and_values(synthetic):
    assert text(synthetic, "here").splitlines() == [
        "here",
        "  kxx = 50.00 MN/m, 95 % interval [49.90, 50.11]",
        "  kyy = 70.03 MN/m, 95 % interval [69.88, 70.15]",
        "  cxx = 0.523 kN s/m, 95 % interval [0.439, 0.607]",
        "  cyy: at most 0.92 kN s/m (95 %; best fit 0.65 kN s/m)",
        "  u = 198.2 g mm, 95 % interval [194.4, 202.0]",
        (
            "search ended short: the method stopped at kxx = 50.13 MN/m, kyy = 69.94 MN/m, cxx = 0.577 kN s/m,"
            " cyy = 0.954 kN s/m, u = 194.8 g mm; the values above are at the maximum of the likelihood"
        ),
        "noise as stated: 10 %",
        "strongly correlated parameters (|r| > 0.95): not computed, without noise",
    ]
    assert text(synthetic).splitlines()[0].startswith("  kxx = ")


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"kind": None}, "kxx = 50.00 MN/m"),
        (
            {"kind": "not identifiable"},
            "kxx: not identifiable from these data: any value of the search fits about as well",
        ),
        (
            {"kind": "hull", "high": 51e6},
            "kxx = 50.0 MN/m, 95 % interval [49.0, 51.0], of which some between do not fit",
        ),
        ({"kind": "lower limit", "high": None}, "kxx: at least 49.00 MN/m (95 %; best fit 50.00 MN/m)"),
        (
            {"kind": "profile", "high": 51e6, "at_limit": True},
            "kxx = 50.0 MN/m, 95 % interval [49.0, 51.0]; best fit at a limit of its search (problem.limits)",
        ),
    ],
)
def test_each_kind_of_interval_in_words(synthetic, changed, expected):
    part = ParameterRecord("kxx", "MN/m", 1e6, 50e6, False, low=49e6, most_likely=50e6)
    record = dataclasses.replace(synthetic, parameters=(dataclasses.replace(part, **changed),))
    assert text(record).splitlines()[0] == f"  {expected}"


def test_a_value_stands_inside_its_own_interval_and_where_the_method_stopped_is_said(synthetic):
    part = ParameterRecord(
        "kxx", "MN/m", 1e6, 47.4e6, False, low=48.4e6, high=49.2e6, kind="profile", most_likely=48.8e6
    )
    record = dataclasses.replace(synthetic, parameters=(part,), search_excess=31.234)
    value, ended = text(record).splitlines()[:2]
    assert value == "  kxx = 48.80 MN/m, 95 % interval [48.40, 49.20]"
    assert ended.startswith("search ended short: the method stopped at kxx = 47.40 MN/m, with a deviance 31.2 higher")
    assert frame(record).loc[0, ["value", "search_end"]].tolist() == pytest.approx([48.8, 47.4])
    near = dataclasses.replace(part, identified=48.85e6)  # 6 % of the interval's width
    assert "ended short" not in text(dataclasses.replace(record, parameters=(near,)))


def test_why_there_are_no_intervals_is_said(synthetic):
    record = dataclasses.replace(synthetic, intervals=None, interval_error="Singular matrix")
    assert "no intervals: Singular matrix" in text(record).splitlines()


def test_the_table_has_a_row_per_parameter_in_its_unit(detailed, synthetic):
    table = frame(detailed).set_index("parameter")
    assert ("parameter", *table.columns) == COLUMNS
    assert list(table.index) == ["kxx", "kyy", "cxx", "cyy", "u", "phase_origin"]
    first = detailed.parameters[0]
    assert table.loc["kxx", ["value", "low", "high", "crlb"]].tolist() == pytest.approx(
        [value / 1e6 for value in (first.most_likely, first.low, first.high, first.crlb)]
    )
    assert table.loc["phase_origin", "unit"] == "deg" and table.loc["phase_origin", "value"] == pytest.approx(
        39.88, 1e-3
    )
    assert table["kind"].isin(["gauss-newton", "profile"]).all() and not table["at_limit"].any()
    one_sided = frame(synthetic).set_index("parameter").loc["cyy"]
    assert np.isnan(one_sided["low"]) and one_sided["kind"] == "upper limit" and np.isnan(one_sided["crlb"])


def test_the_whole_figure_has_a_column_per_channel(detailed):
    figure = plot(detailed, title="here")
    assert figure.get_suptitle().replace("\n", " ").startswith("here: The residuals are consistent with noise")
    assert len(figure.axes) == 3 * 2  # phase, amplitude and residual of two channels
    assert [axes.get_title() for axes in figure.axes[:2]] == ["x at 0.1 m", "y at 0.1 m"]


def test_on_given_axes_the_amplitude_of_the_first_channel_is_drawn(detailed):
    axes = Figure().subplots()
    assert plot(detailed, axes) is axes.get_figure()
    fitted = next(line for line in axes.get_lines() if line.get_label() == "fitted")
    assert fitted.get_xdata() == pytest.approx(np.array(detailed.fit.fine.speed) / RPM)
    assert fitted.get_ydata() == pytest.approx(np.array(detailed.fit.fine.amplitude)[:, 0] / MICROMETRE)
    assert axes.get_title() == "x at 0.1 m"


def test_a_record_without_curves_cannot_be_drawn(synthetic):
    with pytest.raises(SettingError, match="details=True"):
        plot(synthetic)

"""A file in mil pp, lag and own probe names: texts, charts and records show what the file shows.

Those of an identification, of a fleet, and of the agreement of two responses.
"""

import dataclasses
import json
import shutil

import numpy as np
import pytest

from bench.plan.page import Drawn, Orbits
from bench.plan.plan import read_plan
from bench.plan.report import report_named
from bench.reports.fleet.rows import diagnosed
from bench.reports.identification.agreement_charts import agreement, agreement_chart
from drawn_curves import curves_of, drawn
from ksmea.measurement.notation import Notation
from ksmea.records.identification import IdentificationRecord
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Points, Words
from ksmea.show.identification_text import residual_frame
from ksmea.units import RPM
from measurements.run_up_csv import as_csv
from tests.bench.test_identify_file import run_up
from tests.diagnosis.test_show import RECORD, changed

MIL_PP = 12.7e-6  # m 0-peak
WORDS = ["+experiment=identify", "workers=1", "optimizer.screening=100", "optimizer.starts=1"]
PROBES = ("3X", "3Y")


@pytest.fixture
def raw(enter, tmp_path):
    """Columns of a table as an instrument writes it: rpm, and for each probe mil pp and degrees of lag; run.csv has them."""
    measurement, _ = run_up(n_speed=40)
    amplitude, lag = np.abs(measurement.values) / MIL_PP, -np.degrees(np.angle(measurement.values)) % 360
    columns = {"rpm": measurement.speed / RPM}
    for column, probe in enumerate(PROBES):
        columns |= {f"{probe} mil pp": amplitude[:, column], f"{probe} phase lag": lag[:, column]}
    rows = "\n".join(",".join(f"{each:.9g}" for each in row) for row in zip(*columns.values()))
    (tmp_path / "raw.csv").write_text(f"{','.join(columns)}\n{rows}\n", encoding="utf-8")
    own = ["--format", "csv", "--unit", "mil", "--amplitude", "pp", "--phase", "lag", "--speed-unit", "rpm"]
    own += ["--column", "speed=rpm", "--probe", "3X@0.1@x", "--probe", "3Y@0.1@y"]
    for probe in PROBES:
        own += ["--column", f"amplitude.{probe}={probe} mil pp", "--column", f"phase.{probe}={probe} phase lag"]
    assert enter("import", "raw.csv", *own, "--out", "run.csv").code == 0
    return columns


def identified(enter, *words):
    ended = enter(*WORDS, "measurement.path=run.csv", *words, output="results/identify_run")
    assert ended.code == 0, ended.err + ended.out
    return ended


def blocks_of(ended):
    """Bode, polar and orbit plots of the page."""
    page = report_named("identification").make(read_plan(ended.output), ended.output).page()
    [section] = [each for each in page.sections if each.title == "Response"]
    bode, polar, orbits = section.blocks
    assert isinstance(bode, Drawn) and isinstance(polar, Drawn) and isinstance(orbits, Orbits)
    return bode.described(), polar.described(), orbits


def measured(panel):
    [points] = [each for each in panel.elements if isinstance(each, Points) and each.colour == "measured"]
    return points


def test_a_page_shows_the_numbers_and_names_of_its_file(raw, enter):
    ended = identified(enter)
    speed = raw["rpm"]
    assert ended.out.startswith("three_disk, run.csv: 40 speeds from")
    assert "rpm, 2 channels (3X, 3Y), amplitudes (mil pp) and phases (lag)" in ended.out.splitlines()[0]
    [noise] = [line for line in ended.out.splitlines() if line.startswith("noise, estimated: ")]
    assert noise.endswith(("mil pp", "%"))
    bode, polar, orbits = blocks_of(ended)
    whole = [stack for stack in bode.stacks if stack[0].title in PROBES]
    assert [stack[0].title for stack in whole] == list(PROBES)
    for probe, (phase, amplitude, _), loop in zip(PROBES, whole, polar.panels, strict=True):
        assert amplitude.y.label == "amplitude (mil pp)" and amplitude.x.label == "speed (rpm)"
        assert phase.y.label == "phase lag (°)" and loop.title == probe
        assert measured(amplitude).x == pytest.approx(speed, rel=1e-4)
        assert measured(amplitude).y == pytest.approx(raw[f"{probe} mil pp"], rel=1e-5)
        turns = (measured(phase).y - raw[f"{probe} phase lag"]) / 360
        assert turns == pytest.approx(np.round(turns), abs=1e-5)
        phasor = np.array(measured(loop).x) + 1j * np.array(measured(loop).y)
        assert np.abs(phasor) == pytest.approx(raw[f"{probe} mil pp"], rel=1e-5)
        quarter = [each for each in loop.elements if isinstance(each, Words) and each.text == " 90°"]
        assert quarter[0].y < 0  # a lag turns clockwise
    assert "mil pp" in polar.caption and "µm" not in polar.caption
    assert orbits.unit == "mil" and list(orbits.planes) == ["0.1 m (3X, 3Y)"]
    x = np.array(orbits.planes["0.1 m (3X, 3Y)"]["measured"])[:, :2]
    assert 2 * np.hypot(*x.T) == pytest.approx(raw["3X mil pp"], rel=1e-5)  # the width of an orbit is its peak to peak


def test_units_of_the_command_line_take_the_place_of_those_of_the_file(raw, enter):
    ended = identified(enter, "units=Hz,um_rms")
    bode, polar, orbits = blocks_of(ended)
    [stack] = [stack for stack in bode.stacks if stack[0].title == "3X"]
    assert stack[1].x.label == "speed (Hz)" and stack[1].y.label == "amplitude (µm rms)"
    assert measured(stack[1]).x == pytest.approx(raw["rpm"] / 60, rel=1e-4)
    assert measured(stack[1]).y == pytest.approx(raw["3X mil pp"] * 12.7 / 2**0.5, rel=1e-5)
    assert measured(stack[0]).said == "{x:.1f} Hz: {y:.1f}°"
    assert all(said.endswith(" Hz") for said in measured(polar.panels[0]).said)
    assert (orbits.unit, orbits.speed_unit, orbits.decimals) == ("µm", "Hz", 1) and "Hz" in orbits.title
    assert orbits.speed == pytest.approx(raw["rpm"] / 60, rel=1e-4)
    assert f"from {min(raw['rpm']) / 60:.1f} to {max(raw['rpm']) / 60:.1f} Hz" in ended.out


def test_page_and_picture_are_in_one_unit(raw, enter):
    bode, _, _ = blocks_of(identified(enter, "units=Hz"))
    layout, axes = interactive.plot(bode)["layout"], picture.figure(bode).axes
    on_page = {axis["title"]["text"] for name, axis in layout.items() if "axis" in name and axis.get("title")}
    on_picture = {label for each in axes for label in (each.get_xlabel(), each.get_ylabel())} - {""}
    assert {"speed (Hz)", "amplitude (mil pp)"} <= on_page & on_picture
    assert {each.get_title() for each in axes} >= set(PROBES)


def test_a_record_carries_the_notation_and_its_numbers_stay_si(raw, enter):
    [line] = identified(enter).events()
    record = IdentificationRecord.from_data(line)
    assert record.notation == Notation("mil", "pp", "lag", "rpm", {"x at 0.1 m": "3X", "y at 0.1 m": "3Y"})
    assert IdentificationRecord.from_data(json.loads(json.dumps(record.to_data()))) == record
    assert np.array(record.fit.measured.amplitude)[:, 0] == pytest.approx(raw["3X mil pp"] * MIL_PP, rel=1e-5)
    table = residual_frame(record)
    assert set(table["channel"]) == {"x at 0.1 m", "y at 0.1 m"}
    assert table["measured_um_0pk"][::2].to_numpy() == pytest.approx(raw["3X mil pp"] * 12.7, rel=1e-5)


def test_a_file_without_a_notation_is_shown_and_written_as_ever(enter, tmp_path):
    measurement, _ = run_up(n_speed=40)
    (tmp_path / "run.csv").write_text(as_csv(measurement))
    ended = identified(enter)
    [line] = ended.events()
    assert "notation" not in line and IdentificationRecord.from_data(line).notation == Notation()
    assert "rpm, 2 channels (x at 0.1 m, y at 0.1 m), amplitudes (0-peak) and phases\n" in ended.out
    bode, polar, orbits = blocks_of(ended)
    phase, amplitude, _ = bode.stacks[0]
    assert (phase.title, phase.y.label, amplitude.y.label) == ("x at 0.1 m", "phase lag (°)", "amplitude (µm 0-peak)")
    assert amplitude.x.label == "speed (rpm)" and "µm 0-peak" in polar.caption
    assert measured(amplitude).y == pytest.approx(np.abs(measurement.values[:, 0]) * 1e6, rel=1e-5)
    assert (orbits.unit, orbits.speed_unit, orbits.decimals, *orbits.planes) == ("µm", "rpm", 0, "0.1 m")


@pytest.fixture
def fleet(raw, tmp_path):
    """A machine whose file is in mil pp, and one whose file has no notation."""
    folder = tmp_path / "fleet"
    folder.mkdir()
    shutil.copy(tmp_path / "run.csv", folder / "own.csv")
    (folder / "plain.csv").write_text(as_csv(run_up(n_speed=40)[0]))


def of_fleet(enter, *words):
    """Printed text of a fleet, and by the name of its file the row and the text of each machine on the page."""
    ended = enter(*WORDS, "measurement.path=fleet/*.csv", *words, output="results/identify_fleet")
    assert ended.code == 0, ended.err + ended.out
    page = report_named("identification").make(read_plan(ended.output), ended.output).page()
    table, details = page.sections[0].blocks[0].frame.set_index("file"), page.sections[-1].blocks
    return ended, table, {each.title: each.blocks[0].text for each in details}


@pytest.mark.slow
def test_a_fleet_shows_each_machine_in_the_units_of_its_file(fleet, enter):
    ended, table, text = of_fleet(enter)
    assert table.loc["fleet/own.csv", "noise"].endswith(("mil pp", "%")) and "µm" not in text["fleet/own.csv"]
    assert "2 channels (3X, 3Y), amplitudes (mil pp) and phases (lag)" in text["fleet/own.csv"]
    assert "2 channels (x at 0.1 m, y at 0.1 m), amplitudes (0-peak) and phases\n" in text["fleet/plain.csv"]
    assert "mil" not in table.loc["fleet/plain.csv", "noise"]
    files = ended.table("identify").set_index("file")
    assert files.loc["fleet/own.csv", "kxx"] == pytest.approx(files.loc["fleet/plain.csv", "kxx"], rel=1e-3)
    assert "noise_um" in files and not any("mil" in name for name in files)


@pytest.mark.slow
def test_units_of_the_command_line_hold_for_all_machines_of_a_fleet(fleet, enter):
    _, table, text = of_fleet(enter, "units=mm_rms,Hz")
    for name in ("fleet/own.csv", "fleet/plain.csv"):
        assert "amplitudes (mm rms)" in text[name] and " Hz, 2 channels" in text[name]
        assert table.loc[name, "noise"].endswith(("mm rms", "%"))


def test_a_row_of_a_fleet_names_the_probe_of_a_cause():
    """25.4 µm 0-peak of noise are 2 mil pp; columns of the file stay in µm, with the place in m."""
    level = dataclasses.replace(RECORD.noise.before, relative=0.0, floor=25.4e-6)
    applied = (dataclasses.replace(RECORD.applied[0], location="x at 0.1 m"),)
    noise = dataclasses.replace(RECORD.noise, before=level, after=level)
    plain = changed(verdict="named", applied=applied, noise=noise)
    own = dataclasses.replace(plain, notation=Notation("mil", "pp", "lag", names={"x at 0.1 m": "3X"}))
    shown, as_ever = diagnosed(own), diagnosed(plain)
    assert (shown.shown()["location"], shown.shown()["noise"]) == ("3X", "2 mil pp")
    assert (as_ever.shown()["location"], as_ever.shown()["noise"]) == ("x at 0.1 m", "25 µm")
    assert shown.columns() == as_ever.columns() and shown.columns()["noise_um"] == pytest.approx(25.4)


def test_an_agreement_is_shown_in_a_notation_and_its_per_cent_stay(plan):
    curves = curves_of(measured=[[25.4e-6, 12.7e-6]] * 4, identified=[[50.8e-6, 12.7e-6]] * 4, true=None)
    own = Notation("mil", "pp", "lag", "Hz", {"x at 0.1 m": "3X", "y at 0.1 m": "3Y"})
    found, as_ever = agreement(curves, "identified", own), agreement(curves, "identified")
    assert found.difference == pytest.approx(as_ever.difference) and found.size == pytest.approx(as_ever.size)
    chart = agreement_chart(plan, 1, "identified", [found])
    [(first, below, second, _)] = chart.stacks
    assert (first.title, second.title) == ("3X", "3Y")
    assert (first.x.label, first.y.label) == ("speed (Hz)", "amplitude (mil pp)")
    assert drawn(first)["identified"].y == pytest.approx([4.0] * 4)
    assert drawn(first)["measured"].y == pytest.approx([2.0] * 4)
    assert drawn(first)["measured"].x == pytest.approx(np.linspace(200, 1500, 4) / 2 / np.pi)
    assert below.elements[0].said == "{y:.2g} % at {x:.1f} Hz" and "rpm" not in chart.title and " Hz" in chart.title
    plain = agreement_chart(plan, 1, "identified", [as_ever]).stacks[0][0]
    assert (plain.title, plain.x.label, plain.y.label) == ("x at 0.1 m", "speed (rpm)", "amplitude (µm 0-peak)")


@pytest.mark.parametrize(("words", "unit", "scale"), [((), "mil pp", 1.0), (("units=um_0pk",), "µm 0-peak", 12.7)])
def test_a_summary_draws_responses_in_the_units_of_the_file(raw, enter, words, unit, scale):
    ended = identified(enter, "table=summary", "figures=[response]", *words)
    page = report_named("summary").make(read_plan(ended.output), ended.output).page()
    chart = page.charts()["identify_response.png"]()
    first = chart.stacks[0][0]
    assert first.title == "3X" and first.y.label == f"amplitude ({unit})"
    assert drawn(first)["measured"].y == pytest.approx(scale * raw["3X mil pp"], rel=1e-3)

"""A file in mil pp, lag and own probe names: texts, charts and records of its identification show what the file shows."""

import json

import numpy as np
import pytest

from bench.plan.page import Drawn, Orbits
from bench.plan.plan import read_plan
from bench.plan.report import report_named
from ksmea.measurement.notation import Notation
from ksmea.records.identification import IdentificationRecord
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Points, Words
from ksmea.show.identification_text import residual_frame
from ksmea.units import RPM
from measurements.run_up_csv import as_csv
from tests.bench.test_identify_file import run_up

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

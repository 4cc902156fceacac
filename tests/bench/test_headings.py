"""Headings that say what their columns hold: units in snake case, senses of phases, and options that contradict them."""

import os
from pathlib import Path

import numpy as np
import pytest

from bench import main
from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.unit_texts import amplitude_unit, sense_in_heading, speed_unit, unit_in_heading

ROOT = Path(__file__).resolve().parents[2]
CASES = Path(os.environ.get("KSMEA_DATA", ROOT.parent / "shared" / "data")).parent / "cases" / "imports"
SPEED = np.arange(500.0, 2000.0, 100.0)
AMPLITUDE, ANGLE = 3 + SPEED / 500, SPEED / 20  # µm zero to peak, degrees


def table(path, speed, amplitude, phase, unit=1.0):
    rows = [
        f"{speed},{amplitude},{phase}",
        *(f"{n},{a / unit:.12g},{p:.12g}" for n, a, p in zip(SPEED, AMPLITUDE, ANGLE)),
    ]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    columns = [f"speed={speed}", f"amplitude={amplitude}", f"phase={phase}"]
    return {"path": str(path), "format": "csv", "columns": columns, "probes": ["@0.1@x"]}


@pytest.mark.parametrize(
    ("heading", "unit", "detector"),
    [
        ("X_um_pp", "um", "pp"), ("X [mils pk-pk]", "mil", "pp"), ("A µm 0-pk", "um", "0pk"), ("1y_mm_s", "mm/s", ""),
        ("vel_mm/s_rms", "mm/s", "rms"), ("acc_g_rms", "g", "rms"), ("probe_g", "", ""), ("Bearing_in", "", ""), ("amp_min", "", ""), ("X_in_pp", "in", "pp"), ("X_mil", "mil", ""),
    ],
)  # fmt: skip
def test_a_heading_ends_in_its_unit_where_that_cannot_be_a_name(heading, unit, detector):
    found = amplitude_unit(unit_in_heading(heading))
    assert (found.unit, found.detector) == (unit, detector) if unit else found is None or not found.unit


def test_speeds_and_senses_in_several_languages():
    for heading in ("speed_rpm", "Drehzahl [U/min]", "vitesse tr/min", "velocità (giri/min)", "转速 转/分"):
        assert speed_unit(unit_in_heading(heading)) == "rpm", heading
    assert speed_unit(unit_in_heading("shaft_Hz")) == "Hz"
    for heading, sense in (
        ("Phase Lag [deg]", "lag"),
        ("phase_lead_deg", "lead"),
        ("Phase nacheilend", "lag"),
        ("retard °", "lag"),
    ):
        assert sense_in_heading(heading) == sense
    assert sense_in_heading("lead or lag") == sense_in_heading("Lake flange phase") == ""


def test_a_table_whose_headings_say_all_needs_no_answer(tmp_path):
    source = File(**table(tmp_path / "all.csv", "speed_rpm", "X_mil_pp", "X_phase_lag_deg", unit=12.7))
    values = source.read().values[:, 0] * 1e6
    np.testing.assert_allclose(values, AMPLITUDE * np.exp(-1j * np.radians(ANGLE)), rtol=1e-9)


@pytest.mark.parametrize(
    ("headings", "option", "said"),
    [
        (("rpm", "X [um pp]", "Phase Lag [deg]"), {"phase": "lead"}, "expected phase=lag, which the heading of the phase says, got lead"),
        (("rpm", "X_um_pp", "X_lead_deg"), {"phase": "lag"}, "expected phase=lead, which the heading of the phase says, got lag"),
        (("rpm", "X_um_pp", "lag"), {"unit": "mil"}, "expected unit=um, which the file says, got mil"),
        (("rpm", "X_um_pp", "lag"), {"amplitude": "0pk"}, "expected amplitude=pp, which the file says, got 0pk"),
        (("n_rpm", "X_um_pp", "lag"), {"speed_unit": "Hz"}, "expected speed_unit=rpm, which the file says, got Hz"),
    ],
)  # fmt: skip
def test_an_option_that_contradicts_a_heading_is_refused(tmp_path, headings, option, said):
    with pytest.raises(SettingError) as error:
        File(**table(tmp_path / "against.csv", *headings), **option)
    assert said in str(error.value) and "\n" not in str(error.value)


@pytest.mark.skipif(not CASES.is_dir(), reason=f"no published cases in {CASES}")
@pytest.mark.parametrize(("name", "options"), [("h1", ["--phase", "lag"]), ("h3", [])])
def test_two_published_tables_are_suggested_whole(tmp_path, monkeypatch, capsys, name, options):
    """One run-up in µm pp and in mil pp, whose lag at 1800 rpm is 90° with 600 µm pp."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.csv").write_bytes((CASES / f"{name}.csv").read_bytes())
    given = [
        "import",
        "run.csv",
        "--format",
        "csv",
        "--probe",
        "X@0.1@x",
        "--probe",
        "Y@0.1@y",
        *options,
        "--out",
        "out.csv",
    ]
    assert main.run(given) == 2
    command = capsys.readouterr().err.splitlines()[-1]
    columns = [part.strip().strip("'") for part in command.split("--column")[1:]]
    columns[-1] = columns[-1].split(" --")[0].strip("'")
    assert (
        main.run([*given, *(word for each in columns for word in ("--column", each.split(" --")[0].strip("'")))]) == 0
    )
    data = File(path="out.csv").read()
    at = int(np.argmin(np.abs(data.speed * 30 / np.pi - 1800)))
    # four decimals of 23.622 mil
    np.testing.assert_allclose(data.values[at] * 1e6, [-300j, -300], rtol=1e-4, atol=1e-3)

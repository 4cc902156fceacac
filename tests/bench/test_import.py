"""Files of instruments: each format gives the vectors that it was made of, and what a file leaves open is asked for."""

import dataclasses
import os
import re
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import main
from instrument_files import (
    OMEGA,
    SPEED,
    TABLES,
    VALUES,
    csv_wide,
    mat,
    system1,
    uff,
    waveform,
    written,
)
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from measurements.file import File
from measurements.formats.binary.mat import read_mat
from measurements.formats.probe_positions import model_direction
from measurements.run_up_csv import rows_as_csv

DATA = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
XY = (Channel(0.1, "x"), Channel(0.1, "y"))
RUN_UP = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg"


def public(name):
    if not (DATA / name).exists():
        pytest.skip(f"no {name} in {DATA}; KSMEA_DATA names the directory of public data")
    return DATA / name


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def as_words(settings):
    """Settings as options of import."""
    for name, value in settings.items():
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, list):
            single = option.removesuffix("s")
            yield from (word for each in value for word in (single, str(each)))
        else:
            yield from (option, str(value))


@pytest.mark.parametrize("name", TABLES)
def test_each_format_gives_the_vectors_it_was_made_of(folder, name):
    example = TABLES[name]()
    data = written(example).read()
    assert data.channels == XY
    # rel: the digits that the file prints
    assert data.speed == pytest.approx(OMEGA, rel=1e-9)
    assert data.values == pytest.approx(VALUES, rel=example.precision)
    assert data.noise is None and not data.phase_known


@pytest.mark.parametrize("name", [*TABLES, "waveform"])
def test_an_imported_file_is_the_same_measurement_exactly(folder, name, capsys):
    example = waveform(noise=0.1) if name == "waveform" else TABLES[name]()
    direct = written(example).read()
    assert main.run(["import", example.name, *as_words(example.settings), "--out", "run.csv"]) == 0
    told = capsys.readouterr().out
    back = ksmea.read_measurement("run.csv")
    assert np.array_equal(back.speed, direct.speed) and back.channels == direct.channels
    assert np.array_equal(back.values, direct.values)
    assert (back.noise is None) == (direct.noise is None)
    if back.noise is not None:
        assert np.array_equal(back.noise.floor, direct.noise.floor)
    lines = Path("run.csv").read_text("utf-8").splitlines()
    head, rows = ([line for line in lines if line.startswith("#") is told] for told in (True, False))
    longest = max((cell for line in rows[1:] for cell in re.findall(r"[\d.]+", line)), key=len)
    assert len(longest.replace(".", "").lstrip("0")) <= 15  # what conversions leave behind fifteen digits is rounding
    senses = {"system1": "lag", "adre": "lag", "waveform": "lead"}
    sense = example.settings.get("phase") or senses[example.settings["format"]]
    for word in (example.name, f"format {example.settings['format']}", f"phase {sense}"):
        assert any(word in line for line in head), word
    assert "slow roll: not subtracted" in "\n".join(head) and "written: run.csv" in told


@pytest.mark.parametrize("missing", [1, 4, 40])
def test_a_matlab_file_whose_variable_ends_early_is_refused(missing):
    """Its tag says as many bytes as there are: loadmat ends the process on such a file (SciPy 1.17)."""
    whole = mat().content
    size = int.from_bytes(whole[132:136], "little") - missing
    cut = whole[:132] + size.to_bytes(4, "little") + whole[136:-missing]
    with pytest.raises(SettingError, match=r"^run.mat: .* ends early"):
        read_mat(cut, "run.mat", [])


def test_the_public_system_1_example(folder):
    """Values by hand: 0.217 mil pp is 0.217 · 25.4 / 2 µm, a lag of 47° a lead of −47°; the third row is not valid."""
    path = public("formats/system1_bode_legacy_example.csv")
    source = File(path=str(path), format="system1", probes=["@0.3"], rotation="ccw")
    data = source.read()
    assert data.channels == (Channel(0.3, "45"),)
    assert data.speed * 30 / np.pi == pytest.approx([234, 241, 255])
    assert np.abs(data.values[:, 0]) == pytest.approx(np.array([0.217, 0.231, 0.240]) * 12.7e-6)
    assert np.angle(data.values[:, 0], deg=True) == pytest.approx([-47, -48, -48])
    assert "1 not valid" in source.remarks[0] and source.time == pytest.approx([0, 1, 5])


def test_the_real_run_up_is_read_as_its_owners_say(folder):
    """RK-4: µm zero to peak and phase lead, so that nothing but the names changes."""
    path = public("rk4/runup_bode_first_critical.csv")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    columns = ["speed=rpm", "amplitude=amp_1x_um_0pk", "phase=phase_1x_deg"]
    answers = {"unit": "um", "amplitude": "0pk", "speed_unit": "rpm"}
    data = File(path=str(path), format="csv", columns=columns, probes=["@0.12@x"], phase="lead", **answers).read()
    order = np.argsort(table[:, 0])
    expected = (table[:, 1] * 1e-6 * np.exp(1j * np.radians(table[:, 2])))[order]
    assert data.values[:, 0] == pytest.approx(expected, rel=1e-12)
    assert data.history is not None  # a row per turn: how the speed went is seen


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("binary8byte.uff", "dataset 1: expected a function over the speed, got a time history; give format=waveform"),
        ("sample_dataset58_psd.uff", "got a power spectral density; export order tracks"),
        ("TestLab_161_164_18_15_82.uff", "expected a dataset 58, got 15, 18, 82, 151, 164"),
        ("non_ascii_header.uff", "got a frequency response function"),
        ("dataset_milestone_in_header.uff", "expected 2508876 points, which it says to have, got 42"),
        ("time-history-not-all-columns-filled.uff", "got a time history"),
    ],
)
def test_public_universal_files_that_are_no_run_ups_are_refused(folder, name, message):
    with pytest.raises(SettingError) as refused:
        File(path=str(public(f"uff/{name}")), format="uff", probes=["@0.1@x"])
    assert message in str(refused.value)


OPEN = {  # what a file leaves open, and the setting that the refusal names
    "probes": (system1, {"probes": []}, "give probes=[name@m@direction,…] for 'A', 'B'"),
    "rotation": (system1, {"probes": ["A@0.1", "B@0.1@y"]}, "give rotation=ccw or cw"),
    "unit": (mat, {"unit": None}, "give unit=mil"),
    "amplitude": (mat, {"amplitude": None}, "give amplitude=pp, 0pk or rms"),
    "phase": (mat, {"phase": None}, "give phase=lag, lead or none"),
    "speed_unit": (mat, {"speed_unit": None}, "give speed_unit=rpm, Hz or rad/s"),
    "columns": (csv_wide, {"columns": []}, "expected a line with the headings speed_rpm"),
    "a detector that the file states": (
        csv_wide,
        {"amplitude": "rms"},
        "expected amplitude=pp, which the file says, got rms",
    ),
    "a unit that the file states": (system1, {"unit": "um"}, "expected unit=mil, which the file says, got um"),
    "a probe that is not there": (system1, {"probes": ["C@0.1@x"]}, "unknown probe in probes: 'C'"),
    "a column that is not there": (
        csv_wide,
        {"columns": ["speed=rpm"]},
        "expected a line with the headings rpm, got none",
    ),
    "a direction": (system1, {"probes": ["A@0.1@up", "B@0.1@y"]}, "expected a direction x, y, H, V"),
    "a place with a decimal comma": (
        system1,
        {"probes": ["A@0,1@x", "B@0.1@y"]},
        "expected a decimal point, got a comma in 'A@0,1@x'; write A@0.1@x",
    ),
    "an angle with a decimal comma": (
        system1,
        {"probes": ["A@0.1@-22,5", "B@0.1@y"]},
        "expected a decimal point, got a comma in 'A@0.1@-22,5'; write A@0.1@-22.5",
    ),
    "a voltage": (mat, {"unit": "mV"}, "got the voltage 'mV'; give a unit and what 1 of the file is in it"),
    "one channel twice": (
        system1,
        {"probes": ["A@0.1@x", "B@0.1@H"]},
        "expected each channel once, got x at 0.1 m from A and B",
    ),
    "format": (csv_wide, {"format": "run_up", "columns": [], "phase": None}, "expected none with format=run_up"),
    "harmonics": (system1, {"harmonics": [1.0, 2.0]}, "expected 2X, which harmonics names, got 1X"),
}


@pytest.mark.parametrize("case", OPEN)
def test_what_a_file_leaves_open_is_asked_for(folder, case):
    example, changes, message = OPEN[case]
    with pytest.raises(SettingError) as refused:
        written(example(), **changes)
    assert message in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "rotation", "expected"),
    [
        ("x", None, "x"),
        ("H", None, "x"),
        ("v", "ccw", "y"),
        ("V", "cw", "y"),
        ("30°", None, "30"),
        ("45R", "ccw", "45"),
        ("45° Left", "ccw", "135"),
        ("45R", "cw", "135"),  # turning clockwise, the right probe is passed after the left one
        ("45 left", "cw", "45"),
        ("H", "cw", "180"),
        ("90° Right", "ccw", "x"),
    ],
)
def test_directions_as_people_name_them(text, rotation, expected):
    assert model_direction(text, rotation, "probe") == expected


def test_a_forward_orbit_is_forward_for_either_sense_of_rotation():
    """Probes at 45L and 45R of a shaft on a circular orbit: what turns towards a probe first leads there."""
    for rotation, sense in (("ccw", 1), ("cw", -1)):
        right, left = np.radians(90 - 45), np.radians(90 + 45)
        read = [np.exp(-1j * sense * each) for each in (right, left)]  # of x + iy = e^{± iΩt} in the machine's axes
        model = [Channel(0.1, model_direction(text, rotation, "")).forward_factor for text in ("45R", "45L")]
        assert read[1] / read[0] == pytest.approx(model[1] / model[0])


def test_a_skew_pair_of_an_instrument_is_identified(folder):
    """System 1 with probes at 45° left and right: the same values as of probes in x and y, within their intervals."""
    rotor = ksmea.load_problem("three_disk", directions=["45", "135"])
    made = ksmea.synthetic_measurement(rotor, relative=0.02, kind="complex", noise_known=False, rng=4).measurement
    lines = []
    for number, (name, side) in enumerate((("A", "Right"), ("B", "Left"))):
        lines += [
            f"Point Name,{name}",
            f"Probe Angle,45° {side}",
            "X-Axis Unit,rpm",
            "Y-Axis Unit,mil pp",
            "Variable,1X",
        ]
        lines += ["X-Axis Value,Y-Axis Value,Phase"]
        for speed, value in zip(made.speed * 30 / np.pi, made.values[:, number]):
            lines.append(f"{speed:.6f},{abs(value) / 12.7e-6:.8g},{-np.angle(value, deg=True):.6f}")
    Path("pair.csv").write_text("\n".join(lines), encoding="utf-8")
    data = ksmea.read_measurement("pair.csv", format="system1", probes=["A@0.1", "B@0.1"], rotation="ccw")
    assert data.values == pytest.approx(made.values, rel=1e-6)
    found = ksmea.identify(ksmea.load_problem("three_disk"), data, rng=1)
    for name, true in (("kxx", 50.0), ("kyy", 70.0), ("u", 200.0)):
        assert found[name].low < true < found[name].high


def test_excel_and_universal_files_name_the_extra_where_it_is_absent(folder, monkeypatch):
    import sys

    for module, example in (("openpyxl", TABLES["excel"]()), ("pyuff", uff())):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(SettingError) as refused:
            written(example)
        assert f"read by {module}" in str(refused.value) and "pip install 'ksmea-bench[formats]'" in str(refused.value)


def test_matlab_7_3_is_refused_with_the_cure(folder):
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b" ") + b"\x89HDF\r\n\x1a\n"
    with pytest.raises(SettingError, match=r"save it by save\('run\.mat', …, '-v7'\)"):
        written(dataclasses.replace(mat(), content=header))


def test_a_table_of_our_own_from_a_spreadsheet_needs_no_roles(folder):
    rows = ["1000;0,1;x;2,5;30", "1200;0,1;x;3,5;-31,5"]
    Path("own.csv").write_text("\n".join([RUN_UP.replace(",", ";"), *rows]), encoding="utf-8")
    data = File(path="own.csv", format="csv").read()
    assert data.values[:, 0] == pytest.approx(np.array([2.5, 3.5]) * 1e-6 * np.exp(1j * np.radians([30, -31.5])))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--format", "cvs", "--out", "run.csv"], "unknown value for format: 'cvs'; did you mean 'csv'"),
        (["--format", "csv", "--fase", "lag", "--out", "run.csv"], "did you mean '--phase'"),
        (["--format", "csv", "--slow-roll", "much", "--out", "run.csv"], "--slow-roll: expected a number or null"),
        (["--format", "csv", "--out", "wide.csv"], "expected no wide.csv yet"),
        (["--format", "csv", "more.csv", "--out", "run.csv"], "expected one file, got 2"),
        (["--format", "csv", "--format", "csv", "--out", "run.csv"], "expected --format once"),
        (["--format", "csv", "--out"], "expected a value after --out"),
    ],
)
def test_words_that_import_does_not_know(folder, capsys, words, message):
    Path("wide.csv").write_bytes(csv_wide().content)
    assert main.run(["import", "wide.csv", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert not Path("run.csv").exists()


def test_a_synthetic_measurement_is_exported_without_its_truth(folder, capsys):
    words = ["problem=three_disk", "problem.sensors=[0.1,0.5]", "measurement.kind=complex", "measurement.relative=0.02"]
    assert (
        main.run(["export", "measurement", "--out", "made.csv", *words, "measurement.truth={kxx: 40.0}", "seed=3"]) == 0
    )
    text = Path("made.csv").read_text("utf-8")
    assert "kxx" not in text and "40" not in text.splitlines()[0]
    data = ksmea.read_measurement("made.csv")
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5])
    made = ksmea.synthetic_measurement(rotor, relative=0.02, kind="complex", truth={"kxx": 40.0}, rng=3).measurement
    assert data.values == pytest.approx(made.values, rel=1e-7)
    assert main.run(["export", "measurement", "--out", "made.csv"]) == 2
    assert "expected no made.csv yet" in capsys.readouterr().err


def test_rows_are_written_as_they_were_read(folder):
    source = written(system1())
    Path("again.csv").write_text(rows_as_csv(source.used_rows), encoding="utf-8")
    assert File(path="again.csv").used_rows.amplitude == source.used_rows.amplitude


def test_harmonics_of_a_tabular_list_are_taken_along(folder):
    """2X of the list is 0.2 µm pp with a lag of 25° at every speed."""
    data = written(TABLES["adre"](), harmonics=[1.0, 2.0]).read()
    assert [str(channel) for channel in data.channels] == ["x at 0.1 m", "2X x at 0.1 m", "y at 0.1 m", "2X y at 0.1 m"]
    assert data.values[:, 0] == pytest.approx(VALUES[:, 0], rel=1e-9)
    assert data.values[:, [1, 3]] == pytest.approx(np.full((len(SPEED), 2), 0.1e-6 * np.exp(-1j * np.radians(25))))


def test_flagged_vectors_and_samples_that_stand_twice_are_left_out_and_counted(folder):
    example = TABLES["adre"]()
    lines = example.content.decode("utf-16").split("\r\n")
    at = [index for index, line in enumerate(lines) if line.startswith("1|A|") and "|DT-R|" in line]
    cells = lines[at[3]].split("|")
    cells[9] += "BMA"
    lines[at[3]] = "|".join(cells)
    lines.insert(at[5] + 1, lines[at[5]])
    source = written(dataclasses.replace(example, content="\r\n".join(lines).encode("utf-8")), incomplete="drop")
    assert "rows left out: 1 twice, 1 flagged" in source.remarks[0]
    assert len(source.read().speed) == len(SPEED) - 1


def test_volts_become_displacement_by_a_scale(folder):
    """200 mV/mil: 0.4 V zero to peak are 2 mil."""
    Path("volts.csv").write_text("rpm,A (V pk),deg\n1000,0.4,10\n1100,0.2,20\n", encoding="utf-8")
    columns = ["speed=rpm", "amplitude=A (V pk)", "phase=deg"]
    answers = {"speed_unit": "rpm", "phase": "lead", "probes": ["@0.1@x"], "columns": columns}
    data = File(path="volts.csv", format="csv", unit="mil", scale=5.0, **answers).read()
    assert np.abs(data.values[:, 0]) == pytest.approx(np.array([2.0, 1.0]) * 25.4e-6)
    with pytest.raises(SettingError, match="got 'V pk'"):
        File(path="volts.csv", format="csv", unit="mil", **answers)


def test_a_long_table_whose_channels_are_rows_is_refused_at_once(folder):
    rows = "\n".join(f"{600 + row / 100},p{row},1,0" for row in range(5000))
    Path("odd.csv").write_text(f"rpm,probe,um,deg\n{rows}\n", encoding="utf-8")
    columns = ["speed=rpm", "channel=probe", "amplitude=um", "phase=deg"]
    with pytest.raises(SettingError, match="expected at most 1000 probes and harmonics, got 5000"):
        File(path="odd.csv", format="csv", columns=columns, probes=["@0.1@x"])

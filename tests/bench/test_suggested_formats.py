"""Formats and columns that are suggested for files that several formats could read."""

import numpy as np
import pytest
from scipy.io import savemat

from measurements.formats.column_guess import guessed_columns, guessed_unmarked, guessed_waveforms
from measurements.formats.detection import suggested_format


def suggestion(path):
    return suggested_format(path.name, path.read_bytes()).name


def test_a_time_and_a_speed_are_samples_if_several_lie_in_a_turn(tmp_path):
    for name, step, expected in (("samples", 1e-3, "waveform"), ("vectors", 1.0, "csv")):
        time = step * np.arange(50)
        rows = np.stack([time, np.full(50, 1500.0), np.cos(time)], axis=1)
        for separator, decimal in ((",", "."), (";", ",")):
            lines = [separator.join(f"{each:.4f}" for each in row).replace(".", decimal) for row in rows]
            head = separator.join(("time_s", "speed_rpm", "A_um"))
            (tmp_path / f"{name}.csv").write_text("\n".join([head, *lines]))
            assert suggestion(tmp_path / f"{name}.csv") == expected, (name, separator)


def test_variables_with_a_keyphasor_are_waveforms(tmp_path):
    savemat(tmp_path / "wave.mat", {"t": np.arange(9.0), "trigger": np.arange(9.0), "A": np.arange(9.0)})
    savemat(tmp_path / "run.mat", {"n": np.arange(9.0), "A": np.arange(9.0)})
    assert (suggestion(tmp_path / "wave.mat"), suggestion(tmp_path / "run.mat")) == ("waveform", "mat")
    (tmp_path / "cut.mat").write_bytes((tmp_path / "wave.mat").read_bytes()[:150])
    assert suggestion(tmp_path / "cut.mat") == "mat"  # by its name; reading it says what is wrong
    tdms = pytest.importorskip("nptdms", reason="npTDMS is not installed")
    with tdms.TdmsWriter(str(tmp_path / "rec.tdms")) as writer:
        step = {"wf_increment": 1e-3}
        writer.write_segment([tdms.ChannelObject("Data", name, np.arange(9.0), step) for name in ("Trigger", "A")])
    assert suggestion(tmp_path / "rec.tdms") == "waveform"


def test_numbers_of_probes_behind_words_for_amplitudes_and_phases_are_their_names():
    columns = guessed_columns(["s.speed_rpm", "s.A1X_um_pp", "s.lag1X_deg", "s.A1Y_um_pp", "s.lag1Y_deg"])
    assert columns[1:3] == ("amplitude.1X=s.A1X_um_pp", "phase.1X=s.lag1X_deg")
    assert guessed_columns(["rpm", "amp1", "ph1", "amp2", "ph2"])[1:3] == ("amplitude.1=amp1", "phase.1=ph1")
    assert guessed_columns(["rpm", "A1 um", "A2 um", "B1 deg", "B2 deg"]) == ()


def test_names_of_signals_have_no_units():
    assert guessed_waveforms(["time_ms", "KPH", "1X_um", "DE vert. [mm/s]"]) == (
        "time=time_ms", "keyphasor=KPH", "signal.1X=1X_um", "signal.DE vert.=DE vert. [mm/s]",
    )  # fmt: skip
    assert guessed_unmarked(["t", "probe_g"]) == ("time=t", "signal.probe_g=probe_g")
    assert (
        guessed_unmarked(["t", "n", "rpm", "A"])
        == guessed_unmarked(["n", "A"])
        == guessed_unmarked(["t", "KPH", "A"])
        == ()
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("time_s,A_um,B_um\n0,1,2\n0.001,2,2\n0.002,3,2\n", "waveform"),
        ("t (ms);A (µm)\n0,0;1,5\n0,2;2,5\n0,4;3,5\n", "waveform"),
        ("time_s,A_um\n0,1\n1,2\n2,3\n", "csv"),  # too slow for turns of a shaft
        ("time_s,speed_rpm,A_um\n0,1000,1\n10,1010,2\n20,1020,3\n", "csv"),  # vectors of many turns
        ("time_s,A_um,A_phase_deg\n0,1,3\n0.001,2,3\n0.002,3,3\n", "csv"),
        ("time_s,A_um\nx,1\ny,2\nz,3\n", "csv"),
    ],
)
def test_times_in_short_steps_without_a_speed_are_samples(text, expected):
    assert suggested_format("run.csv", text.encode()).name == expected

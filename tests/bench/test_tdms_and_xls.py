"""TDMS files and Excel files before 2007: as tables and as waveforms, by libraries that may be absent."""

import io
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument_files import PLACES, SPEED, VALUES, WIDE, sampled
from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.detection import suggested_format

XLS = Path(__file__).resolve().parents[1] / "data" / "run.xls"
TABLE = {"format": "excel", "columns": WIDE, "probes": PLACES, "phase": "lag"}


@pytest.fixture
def tdms():
    return pytest.importorskip("nptdms", reason="npTDMS is not installed")


def written(tdms, path, *channels):
    """A file with channels of name, values and properties, in one group unless the name has another."""
    with io.BytesIO() as file:
        with tdms.TdmsWriter(file) as writer:
            for name, values, properties in channels:
                group, _, channel = name.rpartition("/")
                writer.write_segment([tdms.ChannelObject(group or "Data", channel, values, properties)])
        path.write_bytes(file.getvalue())
    return str(path)


def test_a_waveform_of_tdms_is_read_by_its_own_step_and_units(tdms, tmp_path):
    time, key, signals, vectors = sampled()
    step = {"wf_increment": float(time[1] - time[0]), "unit_string": "um"}
    parts = [
        ("KPH", key, {"wf_increment": step["wf_increment"]}),
        ("A", signals[:, 0], step),
        ("B", signals[:, 1], step),
    ]
    path = written(tdms, tmp_path / "wave.tdms", *parts)
    columns = ["keyphasor=KPH", "signal.A=A", "signal.B=B"]
    data = File(path=path, format="waveform", columns=columns, probes=PLACES).read()
    expected = vectors[:, 0] * np.exp(2j * np.pi * 0.01)  # the triangle's half height
    np.testing.assert_allclose(data.values * 1e6, np.tile(expected, (len(data.speed), 1)), rtol=5e-4)
    with pytest.raises(SettingError, match="the headings suggest those below"):
        File(path=path, format="waveform")
    with pytest.raises(SettingError, match="expected unit=um, which the file says, got mil"):
        File(path=path, format="waveform", columns=columns, probes=PLACES, unit="mil")


def test_a_table_of_tdms_and_names_that_several_groups_have(tdms, tmp_path):
    of_a, of_b = (
        [
            (f"{probe}/amplitude", np.abs(values) * 2e6, {"unit_string": "um pp"}),
            (f"{probe}/lag", -np.angle(values, deg=True), {}),
        ]
        for probe, values in zip("AB", VALUES.T)
    )
    path = written(tdms, tmp_path / "run.tdms", ("N/n_rpm", SPEED, {}), *of_a, *of_b, ("N/notes", ["a", "b"], {}))
    columns = [
        "speed=n_rpm",
        *(
            f"{role}.{probe}={probe}/{name}"
            for probe in "AB"
            for role, name in (("amplitude", "amplitude"), ("phase", "lag"))
        ),
    ]
    data = File(path=path, format="tdms", columns=columns, probes=PLACES).read()
    np.testing.assert_allclose(data.values, VALUES, rtol=1e-9)
    assert suggested_format("run.tdms", Path(path).read_bytes()).name == "tdms"


@pytest.mark.parametrize("cut", [4, 40, 200])
def test_a_damaged_tdms_file_is_refused_in_one_line(tdms, tmp_path, capsys, cut):
    path = written(tdms, tmp_path / "run.tdms", ("n", SPEED, {}))
    Path(path).write_bytes(Path(path).read_bytes()[:cut])
    with pytest.raises(SettingError) as error:
        File(
            path=path,
            format="tdms",
            columns=["speed=n", "amplitude=n"],
            probes=["@0.1@x"],
            unit="um",
            amplitude="pp",
            speed_unit="rpm",
        )
    assert "\n" not in str(error.value) and capsys.readouterr().err == ""


def test_channels_of_other_rates_are_refused(tdms, tmp_path):
    _, key, signals, _ = sampled()
    parts = [("KPH", key, {"wf_increment": 1e-4}), ("A", signals[:, 0], {"wf_increment": 2e-4})]
    path = written(tdms, tmp_path / "wave.tdms", *parts)
    columns = ["time=time", "keyphasor=KPH", "signal.A=A"]
    with pytest.raises(SettingError, match=r"got steps of 0.0001, 0.0002 s"):
        File(path=path, format="waveform", columns=columns, probes=["A@0.1@x"], unit="um")


def test_an_old_excel_file_is_read_as_a_new_one_is():
    pytest.importorskip("xlrd", reason="xlrd is not installed")
    source = File(path=str(XLS), **{**TABLE, "columns": [*WIDE, "time=time"]})
    np.testing.assert_allclose(source.read().values, VALUES, rtol=1e-9)
    np.testing.assert_allclose(source.time, 2 * np.arange(len(SPEED)), atol=1e-3)  # dates have steps of a millisecond
    with pytest.raises(SettingError, match="unknown sheet 'Bod'"):
        File(path=str(XLS), sheet="Bod", **TABLE)


@pytest.mark.parametrize("cut", [100, 2000, 6000])
def test_a_damaged_old_excel_file_is_refused_in_one_line(tmp_path, cut, capsys):
    pytest.importorskip("xlrd", reason="xlrd is not installed")
    (tmp_path / "cut.xls").write_bytes(XLS.read_bytes()[:cut])
    with pytest.raises(SettingError) as error:
        File(path=str(tmp_path / "cut.xls"), **TABLE)
    assert "\n" not in str(error.value) and capsys.readouterr().out == ""


@pytest.mark.parametrize(("module", "path", "format_"), [("xlrd", XLS, "excel"), ("nptdms", "a.tdms", "tdms")])
def test_the_extra_is_named_if_it_is_absent(tmp_path, monkeypatch, module, path, format_):
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / "a.tdms").write_bytes(b"TDSm" + bytes(100))
    with pytest.raises(SettingError, match=r"which is not installed; pip install 'ksmea-bench\[formats\]'"):
        File(path=str(tmp_path / path), format=format_, columns=["speed=n", "amplitude=n"])

"""Variables of .mat files beyond numbers: cell arrays are read, objects of MATLAB refused with the lines that make numbers of them."""

import struct

import numpy as np
import pytest
from scipy.io import savemat

from bench import main
from instrument_files import OMEGA, PLACES, SPEED, VALUES
from ksmea.errors import SettingError
from measurements.file import File

ANSWERS = {"format": "mat", "probes": PLACES, "phase": "lead", "unit": "um", "amplitude": "0pk", "speed_unit": "rpm"}


def cells(rows):
    made = np.empty((len(rows), len(rows[0])), dtype=object)
    for at, row in enumerate(rows):
        made[at, :] = row
    return made


def rows():
    return [
        [float(n), *(each for value in pair for each in (abs(value) * 1e6, np.angle(value, deg=True)))]
        for n, pair in zip(SPEED, VALUES)
    ]


@pytest.mark.parametrize(
    ("content", "names"),
    [
        (
            cells([["rpm", "A", "A phase", "B", "B phase"], *rows()]),
            ["run.rpm", "run.A", "run.A phase", "run.B", "run.B phase"],
        ),
        (cells(rows()), [f"run[{n}]" for n in range(1, 6)]),
        (cells([[np.array(each)[:, None] for each in zip(*rows())]]), [f"run[{n}]" for n in range(1, 6)]),
    ],
)
def test_cell_arrays_are_columns(tmp_path, content, names):
    savemat(tmp_path / "run.mat", {"run": content})
    roles = ["speed", "amplitude.A", "phase.A", "amplitude.B", "phase.B"]
    data = File(
        path=str(tmp_path / "run.mat"), columns=[f"{role}={name}" for role, name in zip(roles, names)], **ANSWERS
    ).read()
    np.testing.assert_allclose(data.values, VALUES, rtol=1e-9)
    np.testing.assert_allclose(data.speed, OMEGA, rtol=1e-9)


def element(kind, body):
    return struct.pack("<II", kind, len(body)) + body + bytes(-len(body) % 8)


def opaque(name, kind):
    """A variable of a class of MATLAB's own (MCOS): flags with class 17, name, system and class as texts, and a matrix of references."""
    flags = element(6, struct.pack("<II", 17, 0))
    texts = b"".join(element(1, each) for each in (name.encode(), b"MCOS", kind.encode()))
    inner = element(6, struct.pack("<II", 13, 0)) + element(5, struct.pack("<ii", 6, 1)) + element(1, b"")
    inner += element(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1))
    return element(14, flags + texts + element(14, inner))


def matlab(*variables):
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM" + b"".join(variables)


@pytest.mark.parametrize(
    ("kind", "cure"),
    [
        ("table", "got the table T: s = table2struct(T, 'ToScalar', true); save('run.mat', '-struct', 's', '-v7')"),
        (
            "timetable",
            "got the timetable T: s = table2struct(timetable2table(T), 'ToScalar', true); f = fieldnames(s); t = s.(f{1});",
        ),
        ("datetime", "got the dates T: T = seconds(T - T(1))"),
        ("containers.Map", "got T, of the class containers.Map: take out its numbers"),
    ],
)
def test_objects_of_matlab_are_refused_with_what_to_type_there(tmp_path, monkeypatch, capsys, kind, cure):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.mat").write_bytes(matlab(opaque("T", kind)))
    with pytest.raises(SettingError) as error:
        File(path="run.mat", columns=["speed=T.rpm", "amplitude=T.A"], **ANSWERS)
    assert cure in str(error.value) and "\n" not in str(error.value)
    assert main.run(["import", "run.mat"]) == 2 and cure in capsys.readouterr().err


def test_numbers_beside_an_object_are_read(tmp_path):
    savemat(tmp_path / "plain.mat", {"n": SPEED, "A": VALUES[:, 0] * 1e6})
    plain = (tmp_path / "plain.mat").read_bytes()
    (tmp_path / "run.mat").write_bytes(plain + opaque("T", "table"))
    settings = {**ANSWERS, "probes": ["@0.1@x"]}
    data = File(
        path=str(tmp_path / "run.mat"), columns=["speed=n", "response.A=A"], **{**settings, "probes": ["A@0.1@x"]}
    ).read()
    np.testing.assert_allclose(data.values[:, 0], VALUES[:, 0], rtol=1e-9)
    with pytest.raises(SettingError, match="got the table T"):
        File(path=str(tmp_path / "run.mat"), columns=["speed=n", "response.A=T.A"], **settings)


def test_cells_of_texts_alone_say_what_to_do(tmp_path):
    savemat(tmp_path / "run.mat", {"run": cells([["a", "b"], ["c", "d"]])})
    with pytest.raises(SettingError, match=r"got the cell array run with no column of numbers: run = cell2mat"):
        File(path=str(tmp_path / "run.mat"), columns=["speed=run.a"], **ANSWERS)

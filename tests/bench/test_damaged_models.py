"""Damaged rotor models of other programs are imported as rotors or refused in one visible line; `damaged_files` says how to try many more."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import event, given

from bench import main as bench_main
from damaged_files import (
    FAULTS,
    cut,
    damaged,
    other_byte,
    other_cell,
    other_json,
    other_line,
    other_value,
    outcome_of,
    recoded,
    swapped,
    truncated,
)
from ksmea.errors import SettingError
from problems.rotor_file import RotorFile
from ross_models import as_toml, bearing, element, model

TOKENS = [
    *(
        b"0",
        b"-1",
        b"1",
        b"1e308",
        b"1e-308",
        b"nan",
        b"inf",
        b"true",
        b"[]",
        b"{}",
        b"[[1.0], [2.0]]",
        b"99999999999999999999",
        b'"a\\nb"',
    ),
    *(b"", b"abc", b"1,5", b"'x'", b"\x1b[2J", b"\x00", b"\xb5", "\u202e".encode(), b"x" * 5000),
]
JSON = [
    None, True, 0, -1, 1, 9, 10**30, 1.5, 1e308, 1e-308, float("nan"), float("inf"), "", "x", "2.3.0", "\x1b[2J", "a\nb", "x" * 5000,
    [], [0], [[]], [1.0, 2.0], [[1.0], [2.0]], {}, {"E": 1}, {"a": {"b": []}},
]  # fmt: skip
KEYS = ["n", "n_link", "speed", "ShaftElement_x", "\x1b[2J", "GearElement_x"]
MODEL = model(
    "3.1.0",
    ShaftElement__sleeve=element(2, odl=0.09, odr=0.08, idl=0.05, idr=0.05),
    SealElement__seal=bearing(3, mxx=[1.0]),
    BearingElement__pedestal=bearing(5),
    BearingElement__housed=bearing(1, n_link=5),
    PointMass__p={"n": 5, "m": 2.0},
)
SHAFT = b"""element,layer,length [mm],outer_diameter [mm],inner_diameter [mm],young_modulus [GPa],density [kg/m3],poisson_ratio
1,1,100,40,0,210,7850,0.3
2,1,100,50,0,210,7850,0.3
2,2,100,80,50,0.0001,8700,0.34
3,1,100,40,10,210,7850,0.3
"""
DISKS = b"position [mm],mass [kg],polar_inertia [kg m2],diametral_inertia [kg m2]\n100,5,0.02,0.01\n200,2,0,0\n"
BEARING = b"speed [rpm],kxx [N/m],kxy [N/m],kyy [N/m],cxx [N s/m],cyy [N s/m]\n1000,1e7,0,2e7,1e3,2e3\n2000,2e7,1e5,3e7,1e3,2e3\n"
ANSYS = "\n".join(
    [
        *(
            "one",
            "two",
            "three",
            f"{2:10d}{0:10d}{1:10d}",
            f"{1:10d}{1000:10.2f}",
            f"{1e7:15.7E}" * 4,
            f"{1e3:15.7E}" * 4,
        ),
        *(f"{2:10d}{2000:10.2f}", f"{2e7:15.7E}" * 4, f"{2e3:15.7E}" * 4),
    ]
).encode()
CSV = (*[other_cell(TOKENS)] * 3, other_line, swapped, other_byte, cut, truncated, recoded)
OF_TABLES = [
    "--shaft",
    "shaft.csv",
    "--disks",
    "disks.csv",
    "--bearing",
    "bearing.csv@0",
    "--seal",
    "bearing.csv@station4",
]
TARGETS = {  # content, slips, and the arguments
    "model.json": (json.dumps(MODEL).encode(), (*[other_json(JSON, KEYS)] * 4, other_byte), ["model.json"]),
    "model.toml": (
        as_toml(MODEL).encode(),
        (*[other_value(TOKENS)] * 3, other_line, other_byte, cut, truncated),
        ["model.toml"],
    ),
    "shaft.csv": (SHAFT, CSV, OF_TABLES),
    "disks.csv": (DISKS, CSV, OF_TABLES),
    "bearing.csv": (BEARING, CSV, OF_TABLES),
    "bearing.txt": (ANSYS, CSV, ["--shaft", "shaft.csv", "--bearing", "bearing.txt@0"]),
}


def import_it(words):
    """All the way to a response: what was written is a rotor."""
    for path in Path().glob("rotor*"):
        path.unlink()
    refused = []
    code = bench_main.run(
        ["import", "rotor", *words, "--unbalance", "0.1", "--probe", "1X@0.1", "--out", "rotor.yaml"], refused.append
    )
    if refused:
        assert code == 2 and not list(Path().glob("rotor*"))
        raise SettingError("\n".join(refused))
    problem = RotorFile(file="rotor.yaml").build()
    assert np.all(np.isfinite(problem.response(((problem.parameters.lower + problem.parameters.upper) / 2)[None])))


@pytest.mark.parametrize("target", TARGETS)
def test_damaged_models_are_imported_or_refused_in_one_visible_line(target, tmp_path, monkeypatch):
    content, slips, words = TARGETS[target]
    monkeypatch.chdir(tmp_path)
    for name, (healthy, _, _) in TARGETS.items():
        Path(name).write_bytes(healthy)
    endings = set()
    import_it(words)

    @given(damaged(content, slips))
    def is_imported_or_refused(content):
        def read():
            Path(target).write_bytes(content)
            import_it(words)

        outcome = outcome_of(read)
        event(outcome.ending)
        endings.add(outcome.ending)
        assert outcome.ending not in FAULTS, outcome.detail

    is_imported_or_refused()
    assert "refused" in endings

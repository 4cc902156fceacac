"""Rotors from tables of shaft, disks and bearings: SI and US units, sheets of XLTRC2, places, and what is refused."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.units import INCH, POUND, POUND_FORCE
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor_file import RotorFile
from problems.rotor_import.ross import read_ross
from problems.rotor_import.tables import Sheets, Station, read_sheets
from problems.rotor_import.yaml_text import Wanted, rotor_yaml

DATA = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")) / "rotors"
LBF_PER_IN = POUND_FORCE / INCH
SHAFT = """element,layer,length [mm],outer_diameter [mm],young_modulus [GPa],density [kg/m3],poisson_ratio
1,1,100,40,210,7850,0.3
2,1,200,50,210,7850,0.3
"""
BEARING = "speed [rpm],kxx [N/m],kyy [N/m],cxx [N s/m],cyy [N s/m]\n1000,1e7,2e7,1e3,2e3\n2000,2e7,3e7,1e3,2e3\n"


def public(name):
    if not DATA.exists():
        pytest.skip(f"no rotor models in {DATA.parent}; KSMEA_DATA names the directory of public data")
    return str(DATA / name)


def built(rotor, folder):
    path = folder / "rotor.yaml"
    path.write_text(rotor_yaml(rotor, Wanted()), encoding="utf-8")
    return RotorFile(file=str(path)).build().rotor


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shaft.csv").write_text(SHAFT, encoding="utf-8")
    (tmp_path / "bearing.csv").write_text(BEARING, encoding="utf-8")
    return tmp_path


def sheets(units):
    return Sheets(
        public(f"tables/shaft_layers_{units}.csv"),
        public(f"tables/disks_layers_{units}.csv"),
        bearings=[
            (public(f"tables/bearing_table_{units}.csv"), 0.08),
            (public(f"tables/bearing_table_{units}.csv"), Station(9)),
        ],
    )


def test_si_and_us_tables_are_one_rotor(folder):
    si, us = (built(read_sheets(sheets(units)), folder) for units in ("si", "us"))
    for own, other in zip(matrices(si), matrices(us), strict=True):
        # the files have 12 digits, of which differences in the matrices leave one less
        assert np.abs(own - other).max() <= 2e-11 * np.abs(own).max()
    for own, other in zip(si.bearings, us.bearings, strict=True):
        assert own.position == pytest.approx(other.position, rel=5e-12)
        assert own.table.speed == pytest.approx(other.table.speed, rel=5e-12)
        # 12 digits in both files, which leave a number that begins with 1 as much as 5e-12 in each
        assert np.array(own.table.rows) == pytest.approx(np.array(other.table.rows), rel=1e-11)


def matrices(rotor):
    found = assemble_free(rotor)
    return found.mass, found.stiffness, found.gyroscopic


def test_tables_are_the_models_that_they_were_made_of(folder):
    of_table = built(replace(read_sheets(sheets("si")), bearings=[], seals=[]), folder)
    of_model = built(replace(read_ross(public("ross-2.3.0/layers.toml")), bearings=[], seals=[]), folder)
    for own, other in zip(matrices(of_table), matrices(of_model), strict=True):
        assert np.abs(own - other).max() <= 1e-11 * np.abs(own).max()  # 12 digits in the tables
    own = read_sheets(sheets("si")).bearings[0]["table"]
    other = read_ross(public("ross-2.3.0/tables.toml")).bearings[0]["table"]
    assert own.keys() == other.keys()
    for name, values in own.items():
        assert values == pytest.approx(other[name], rel=5e-12)


def test_places_are_metres_or_stations_and_meet_nodes_in_printed_digits(folder):
    places = [("bearing.csv", 0.0), ("bearing.csv", 0.10001), ("bearing.csv", Station(3)), ("bearing.csv", 0.12)]
    found = [each["position"] for each in read_sheets(Sheets("shaft.csv", bearings=places)).bearings]
    assert found == pytest.approx([0.0, 0.1, 0.3, 0.12], abs=1e-12)
    with pytest.raises(SettingError, match="station from 1 to 3, got 4"):
        read_sheets(Sheets("shaft.csv", bearings=[("bearing.csv", Station(4))]))


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (SHAFT.replace("length [mm]", "length"), "length: expected its unit in the heading"),
        (SHAFT.replace("[GPa]", "[psf]"), "unknown unit of modulus 'psf'"),
        (SHAFT.replace(",poisson_ratio", "").replace(",0.3", ""), "expected a column shear_modulus"),
        (SHAFT.replace("2,1,200", "1,2,200"), "expected layers of one length at node 0, got 0.1 and 0.2 m"),
        (SHAFT.replace("2,1,200", "4,1,200"), "got none at node 1"),
        (SHAFT.replace("2,1,200", "1.5,1,200"), "element: expected a whole number from 1 on, got 1.5"),
        (SHAFT.replace("2,1,200", "2,1,nan"), "length: expected a number, got 'nan'"),
        (SHAFT.replace("element,layer", "bore,layer"), "unknown column 'bore'"),
        (SHAFT.partition("\n")[0], "expected headings and rows of numbers"),
        (
            SHAFT.replace("element,", "").replace("1,1,", "1,").replace("2,1,", "2,"),
            "expected a column element with the column layer",
        ),
    ],
)
def test_bad_tables_are_refused_in_one_line(folder, table, said):
    (folder / "shaft.csv").write_text(table, encoding="utf-8")
    with pytest.raises(SettingError) as caught:
        read_sheets(Sheets("shaft.csv"))
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_a_layer_may_carry_mass_alone(folder):
    head, first, second, _ = SHAFT.split("\n")
    rows = [f"{head},carries", f"{first},", f"{second},", "2,2,200,80,210,7850,0.3,mass"]
    (folder / "shaft.csv").write_text("\n".join(rows), encoding="utf-8")
    plain, layered = ([entry.get("layers") for entry in read_sheets(Sheets("shaft.csv")).shaft] for _ in "12")
    assert (
        plain
        == layered
        == [None, [{"outer_diameter": 0.08, "inner_diameter": 0.0, "material": "material", "carries": "mass"}]]
    )


XLTRC2_SHAFT = [
    ["XLTRC2 Spreadsheet", "made for this test"],
    [],
    ["", "", "", "inches", "inches", "inches", "inches", "inches", "", "", "lb", "", "", "lbm/in3", "psi", "psi"],
    [
        *("elemnum", "subelem", "layer", "length", "od_left", "id_left", "od_right", "id_right", "matnum", "shear", "axial"),
        *("", "matno", "rhoa", "ea", "ga"),
    ],
    [1, 1, 1, 4.0, 2.0, 0.0, 2.0, 0.0, 1, 1, 0.0, "", 1, 0.283, 30e6, 11.5e6],
    [2, 1, 1, 5.0, 3.0, 0.5, 3.0, 0.5, 1, 1, 100.0, "", 2, 0.3, 1.0, 1.0],
    [2, 1, 2, 5.0, 5.0, 3.0, 5.0, 3.0, 2, 1, 0.0, "", "", "", "", ""],
    [3, 1, 1, 4.0, 2.0, 0.0, 1.5, 0.0, 1, 0, 0.0, "", "", "", "", ""],
    ["end of the shaft"],
    [9, 9, 9, 9.0, 9.0, 9.0, 9.0, 9.0, 9, 9, 9.0],
]  # fmt: skip
XLTRC2_DISKS = [
    ["Added mass"],
    ["", "lbm", "lbm in2", "lbm in2"],
    ["n", "m", "Ip", "It"],
    [1, 0, 0, 0],
    [2, 20.0, 100.0, 60.0],
    [4, 1.5, 0, 0],
]
XLTRC2_BEARING = [
    ["Speed", "Kxx", "Kxy", "Kyx", "Kyy", "Cxx", "Cxy", "Cyx", "Cyy"],
    ["rpm", *["lb/in"] * 4, *["lb-s/in"] * 4],
    [2000, 1e5, 1e4, -1e4, 2e5, 100, 0, 0, 150],
    [4000, 2e5, 2e4, -2e4, 3e5, 90, 0, 0, 140],
]


def test_sheets_of_xltrc2_are_read(folder):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for name, rows in (("Model", XLTRC2_SHAFT), ("Disks", XLTRC2_DISKS), ("Left", XLTRC2_BEARING)):
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save("model.xlsx")
    rotor = read_sheets(Sheets("model.xlsx#Model", "model.xlsx#Disks", bearings=[("model.xlsx#Left", Station(1))]))
    assert (
        rotor.left_out
        == [
            "columns subelem of model.xlsx",
        ]
        or "subelem" in rotor.left_out[0]
    )
    shaft = built(rotor, folder)
    assert shaft.node_positions == pytest.approx(INCH * np.array([0, 4, 9, 13]))
    first, second, third = shaft.segments
    assert first.material.density == pytest.approx(0.283 * POUND / INCH**3)
    assert first.material.shear_modulus == pytest.approx(11.5e6 * POUND_FORCE / INCH**2)
    assert second.axial_force == pytest.approx(100 * POUND_FORCE)
    (sleeve,) = second.layers
    assert (sleeve.material.young_modulus, sleeve.material.poisson_ratio) == pytest.approx((LBF_PER_IN / INCH, -0.5))
    assert third.outer_radius_right == pytest.approx(0.75 * INCH) and third.shear_flexibility == 0
    (disk,), (lumped,) = shaft.disks, shaft.masses
    assert (disk.position, disk.polar_inertia) == pytest.approx((4 * INCH, 100 * POUND * INCH**2))
    assert (lumped.position, lumped.mass) == pytest.approx((13 * INCH, 1.5 * POUND))
    stiffness, damping, _ = shaft.bearings[0].matrices_at(np.array([4000 * np.pi / 30]))
    assert stiffness[0] == pytest.approx(LBF_PER_IN * np.array([[2e5, 2e4], [-2e4, 3e5]]))
    assert damping[0] == pytest.approx(LBF_PER_IN * np.array([[90, 0], [0, 140]]))


def test_a_sheet_of_xltrc2_without_units_is_refused(folder):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (row for number, row in enumerate(XLTRC2_SHAFT) if number != 2):
        book.active.append(row)
    book.save("model.xlsx")
    with pytest.raises(SettingError, match="length: expected its unit in the row above, got nothing"):
        read_sheets(Sheets("model.xlsx"))


def test_a_table_of_ansys_is_the_one_of_the_csv(folder):
    found = read_sheets(Sheets("shaft.csv", bearings=[(public("tables/bearing_table_ansys_layout.txt"), 0.0)]))
    expected = read_sheets(Sheets("shaft.csv", bearings=[(public("tables/bearing_table_si.csv"), 0.0)]))
    own, other = found.bearings[0]["table"], expected.bearings[0]["table"]
    assert own.keys() == other.keys()
    for name, values in own.items():
        assert values == pytest.approx(other[name], rel=6e-8)  # eight digits in the text
    assert "ANSYS" in found.remarks[0]


ANSYS = ["one", "two", "three", f"{1:10d}{1:10d}{1:10d}", f"{1:10d}{600:10.2f}", f"{2.0:15.7E}" * 4, f"{3.0:15.7E}" * 4]


def test_pounds_and_rpm_of_ansys_are_converted(folder):
    (folder / "b.txt").write_text("\n".join(ANSYS), encoding="utf-8")
    (own,) = read_sheets(Sheets("shaft.csv", bearings=[("b.txt", 0.0)])).bearings
    assert (own["kxy"], own["cyy"]) == pytest.approx((2 * LBF_PER_IN, 3 * LBF_PER_IN))


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (ANSYS[:-1], "expected three lines for each of 1 speeds, got 2 lines"),
        ([*ANSYS[:-1], f"{3.0:15.7E}" * 3], "line 7: expected a number, got nothing"),
        ([*ANSYS[:-1], f"{'x':>15}" * 4], "line 7: expected a number, got 'x'"),
        (["8, 3, 8, 0, 0, 0, 0", "500, 1, 2, 3, 4, 5, 6, 7, 8"], "got one of DyRoBeS with the number 3"),
    ],
)
def test_bad_texts_of_bearings_are_refused_in_one_line(folder, lines, said):
    (folder / "b.txt").write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(SettingError) as caught:
        read_sheets(Sheets("shaft.csv", bearings=[("b.txt", 0.0)]))
    assert said in str(caught.value) and "\n" not in str(caught.value)

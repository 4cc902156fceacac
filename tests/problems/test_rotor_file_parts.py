"""Parts of a rotor file: tables, supports, seals, cones, layers, couplings, probes on housings."""

import os
from pathlib import Path

import numpy as np
import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.bearing import COEFFICIENTS, Pedestal
from problems.rotor.finite_elements.segments import CouplingSegment
from problems.rotor.response.unknowns import BearingTarget, PedestalTarget
from problems.rotor_file import RotorFile

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
TABLES = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")) / "rotors/tables"

WHOLE = """\
units: {length: mm, modulus: GPa, density: g/cm3, mass: kg, inertia: kg m2, stiffness: MN/m, damping: kN s/m, force: kN,
        angular_stiffness: kN m/rad, unbalance: g mm, angle: deg, speed: rpm}
materials:
  steel: {young_modulus: 210, density: 7.85, poisson_ratio: 0.3}
  sleeve: {young_modulus: 7e-6, density: 7.85, poisson_ratio: 0.3}
shaft:
  - {length: 100, outer_diameter: 40, outer_diameter_right: 60, material: steel, elements: 2}
  - {length: 200, outer_diameter: 60, stiffness_outer_diameter: 55, material: steel, elements: 4, axial_force: -3,
     layers: [{outer_diameter: 80, inner_diameter: 60, material: sleeve},
              {outer_diameter: 90, inner_diameter: 80, outer_diameter_right: 84, material: steel, carries: mass}]}
  - {length: 50, outer_diameter: 90, coupling: {stiffness: [4, 5], angular_stiffness: 25, damping: 0.05, masses: [3.1, 2.7],
     polar_inertias: 0.005, diametral_inertias: [0.0031, 0.0028]}}
  - {length: 150, outer_diameter: 50, material: steel, elements: 3, theory: euler_bernoulli, rotary_inertia: false,
     gyroscopic: false, internal_damping: 2e-6, standing_damping: {mass: 3, stiffness: 1e-6}}
disks:
  - {position: 200, mass: 8, polar_inertia: 0.06, diametral_inertia: 0.035}
masses:
  - {position: 300, mass: 1.5}
  - {position: 350, mass: 0, polar_inertia: 0.01}
bearings:
  - position: 0
    table: {speed: [600, 1500, 6000], kxx: [10, 20, 30], kyy: [30, 20, 10], cxx: [5, 6, 7], cyy: [5, 5, 5], mxx: [1, 2, 3]}
    support: {mass: 20, kyy: 60, kxy: 1, cxx: 2, loss_factor: 0.03}
  - {position: 500, kxx: 20, cxx: 1, cyy: 2, mxx: 3, myx: 0.5}
seals:
  - {position: 200, kxy: 0.5, kyx: -0.5, myy: 2}
couplings:
  - {position: 325}
unbalance:
  - {position: 200, magnitude: 30, phase: 90}
speeds: {from: 600, to: 6000, number: 20}
probes:
  - {position: 20, direction: x, relative_to: bearing 1}
  - {position: 20, direction: 45, relative_to: bearing 1}
  - {position: 480, direction: y}
unknowns:
  - {name: stiffness, lower: 0.5, upper: 2, reference: 1, sets: [bearing 1 stiffness factor]}
  - {name: cxx, lower: 0.5, upper: 2, sets: [bearing 1 cxx factor]}
  - {name: kyy, lower: 5, upper: 50, reference: 20, sets: [bearing 2 kyy]}
  - {name: seal, lower: 0, upper: 2, sets: [seal 1 cxx, seal 1 cyy]}
  - {name: support, lower: 20, upper: 90, sets: [support 1 kxx]}
"""


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(content, name="my.yaml"):
        (tmp_path / name).write_text(content, encoding="utf-8")
        return name

    return write


def refused(content, write):
    with pytest.raises(SettingError) as caught:
        RotorFile(file=write(content))
    text = str(caught.value)
    assert "\n" not in text and len(text) < 300
    return text


def test_every_part_is_read(write):
    settings = RotorFile(file=write(WHOLE))
    problem = settings.build()
    rotor = problem.rotor
    cone, layered, coupling, thin = rotor.segments
    assert (cone.outer_radius, cone.outer_radius_right) == pytest.approx((0.02, 0.03))
    assert (layered.stiffness_outer_radius, layered.axial_force) == pytest.approx((0.0275, -3e3))
    sleeve, hub = layered.layers
    assert sleeve.material.young_modulus == pytest.approx(7e3)
    assert (hub.carries, hub.inner_radius, hub.outer_radius_right) == (
        "mass",
        pytest.approx(0.04),
        pytest.approx(0.042),
    )
    expected = CouplingSegment(
        0.05, (4e6, 5e6), (25e3, 25e3), (50.0, 50.0), (0.0, 0.0), (3.1, 2.7), (0.005,) * 2, (0.0031, 0.0028), 0.045
    )
    for name in ("stiffness", "angular_stiffness", "damping", "masses", "polar_inertias", "diametral_inertias"):
        assert getattr(coupling, name) == pytest.approx(getattr(expected, name))
    assert (thin.shear_flexibility, thin.rotary_inertia, thin.gyroscopic) == (0.0, False, False)
    assert (thin.internal_damping, thin.standing_damping) == (2e-6, (3.0, 1e-6))
    assert all(mass.is_lumped for mass in rotor.masses)
    sizes = [(mass.position, mass.mass, mass.polar_inertia, mass.diametral_inertia) for mass in rotor.masses]
    assert np.array(sizes) == pytest.approx(np.array([[0.3, 1.5, 0.0, 0.0], [0.35, 0.0, 0.01, 0.0]]))
    left, right = rotor.bearings
    np.testing.assert_allclose(left.table.speed, np.array([600, 1500, 6000]) * np.pi / 30)
    row = dict(zip(COEFFICIENTS, left.table.rows[1]))
    assert (row["kxx"], row["cxx"], row["mxx"], row["kxy"]) == pytest.approx((20e6, 6e3, 2.0, 0.0))
    assert left.pedestal == Pedestal(kxx=55e6, kxy=1e6, kyy=60e6, cxx=2e3, mxx=20.0, myy=20.0, loss_factor=0.03)
    assert (right.mxx, right.myx) == (3.0, 0.5)
    assert (rotor.seals[0].kxy, rotor.seals[0].myy) == (5e5, 2.0)
    assert rotor.couplings == (0.325,)
    assert [rotor.housing_of(channel) for channel in problem.channels] == [0, 0, None]
    targets = [item.targets for item in problem.unknowns]
    assert targets[:2] == [(BearingTarget(0, "stiffness_factor"),), (BearingTarget(0, "cxx_factor"),)]
    assert targets[3:] == [(BearingTarget(2, "cxx"), BearingTarget(2, "cyy")), (PedestalTarget(0, "kxx"),)]
    assert settings.reference() == pytest.approx({"stiffness": 1.0, "kyy": 20e6})
    x = problem.parameters.to_si(np.random.default_rng(1).random((4, 5)))
    assert np.abs(problem.response(x) / problem.dense_response(x) - 1).max() < 1e-8


def test_a_mesh_leaves_couplings_as_they_are(write):
    segments = RotorFile(file=write(WHOLE), mesh=19).build().rotor.segments
    assert [segment.n_element for segment in segments] == [4, 8, 1, 6]


@pytest.mark.parametrize("name", ["bearing_table_si.csv", "bearing_table_us.csv"])
def test_a_table_beside_the_file(write, tmp_path, name):
    """The samples in SI and in US units hold one bearing; its numbers in the SI file are the expected ones."""
    if not TABLES.exists():
        pytest.skip(f"no tables at {TABLES}; KSMEA_DATA names the directory of public data")
    (tmp_path / name).write_bytes((TABLES / name).read_bytes())
    inline = WHOLE[WHOLE.index("    table: {speed") : WHOLE.index("    support:")]
    settings = RotorFile(file=write(WHOLE.replace(inline, f"    table: {name}\n")))
    table = settings.build().rotor.bearings[0].table
    expected = np.genfromtxt(TABLES / "bearing_table_si.csv", delimiter=",", skip_header=1)
    np.testing.assert_allclose(table.speed, expected[:, 0], rtol=1e-9)
    np.testing.assert_allclose(np.array(table.rows)[:, :8], expected[:, 1:], rtol=1e-11)  # twelve digits in each
    before = settings.fingerprint()
    (tmp_path / name).write_bytes((TABLES / name).read_bytes().replace(b"00", b"01", 1))
    assert RotorFile(file="my.yaml").fingerprint() != before  # another table is another problem


def test_units_may_stand_in_a_row_of_their_own(write, tmp_path):
    sheet = "speed;Kxx;kyy;cxx;cyy\nrpm;lbf/in;lbf/in;lbf·s/in;lbf·s/in\n600;1000;2000;3;3\n900;1100;2100;4;4\n"
    (tmp_path / "t.csv").write_text(sheet, encoding="utf-8")
    inline = WHOLE[WHOLE.index("    table: {speed") : WHOLE.index("    support:")]
    table = RotorFile(file=write(WHOLE.replace(inline, "    table: t.csv\n"))).build().rotor.bearings[0].table
    assert table.rows[0][0] == pytest.approx(1000 * 175.12683524647636)


def test_a_sheet_of_a_workbook(write, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "notes"
    sheet = book.create_sheet("left")
    for row in (["speed [rpm]", "kxx [MN/m]", "kyy [MN/m]"], [600, 10, 20], [900, 12, 22.5]):
        sheet.append(row)
    book.save(tmp_path / "model.xlsx")
    inline = WHOLE[WHOLE.index("    table: {speed") : WHOLE.index("    support:")]
    content = WHOLE.replace(inline, "    table: model.xlsx#left\n    cxx: 1\n    cyy: 1\n").replace("cxx factor", "kxy")
    content = content.replace("{name: cxx, lower: 0.5", "{name: kxy, lower: -2").replace(
        "stiffness factor", "kyy factor"
    )
    table = RotorFile(file=write(content)).build().rotor.bearings[0].table
    assert table.rows[1][:4] == (12e6, 0.0, 0.0, 22.5e6)
    text = refused(WHOLE.replace(inline, "    table: model.xlsx\n"), write)
    assert "expected the name of one sheet, as in model.xlsx#notes, got none; there are notes, left" in text


@pytest.mark.parametrize(
    ("sheet", "words"),
    [
        ("speed,kxx\n600,1\n", "speed: expected its unit in the heading, such as 'speed [rad/s]', got none"),
        ("speed [rpm],kxx [N/mm]\n600,1\n500,2\n", "t.csv: row 3, speed: expected a number above 600, got 500"),
        ("speed [rpm],kxx [N/mm]\n\n600,1\n600,2\n", "t.csv: row 4, speed: expected a number above 600, got 600"),
        ("speed [rpm],kxx [N/mm]\n-600,1\n", "row 2, speed: expected a number of at least 0, got -600"),
        (
            "speed [rpm];kxx [N/mm]\n600;1,5\n",
            "row 2, kxx: expected a number, got '1,5'; write decimal points, no commas",
        ),
        ("speed [rpm],kxx [N/mm]\n600,1,5\n", "row 2: expected 2 cells as in the heading, got 3; write decimal points"),
        ("speed [rpm],kxx [N/mm]\n600,1_000\n", "row 2, kxx: expected a number, got '1_000'"),
        ("speed [rpm],kxx [N/mm]\n600,1e300\n", "row 2, kxx: expected a stiffness of at most 1e+15, got 1e+300"),
        ("speed,kxx\nrpm,N/mm\n", "expected 1 to 10000 rows of numbers, got 0"),
        ("speed [rpm],kxx [N/mm]\n600,\n", "row 2, kxx: expected a number, got nothing"),
        ("speed [rpm],kxx [N/mm]\n600,nan\n", "row 2, kxx: expected a number, got 'nan'"),
        ("speed [rpm],kxx [stone]\n600,1\n", "kxx: unknown unit of stiffness 'stone'"),
        ("speed [rpm],kxz [N/mm]\n600,1\n", "unknown column 'kxz'; did you mean"),
        ("speed [rpm],kxx [N/mm],kxx [N/mm]\n600,1,1\n", "expected each column once, got kxx again"),
        ("kxx [N/mm]\n600\n", "expected columns speed and any of"),
        ("speed [rpm],kxx [N/mm]\n", "expected headings and rows of numbers, got 1 rows"),
        ("\x00\x01\n\x02", "unknown column"),
    ],
)
def test_a_table_that_cannot_be_read(write, tmp_path, sheet, words):
    (tmp_path / "t.csv").write_text(sheet, encoding="utf-8")
    inline = WHOLE[WHOLE.index("    table: {speed") : WHOLE.index("    support:")]
    text = refused(WHOLE.replace(inline, "    table: t.csv\n"), write)
    assert text.startswith("my.yaml: bearings[1].table: ") and words in text


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("carries: mass", "carries: load", "layers[2].carries: unknown part 'load'"),
        ("outer_diameter_right: 60", "outer_diameter_right: sixty", "outer_diameter_right: expected a number"),
        ("theory: euler_bernoulli", "theory: euler", "unknown beam theory 'euler'; did you mean 'euler_bernoulli'"),
        ("stiffness: [4, 5]", "stiffness: [4, 5, 6]", "coupling.stiffness: expected a number or two of them"),
        ("relative_to: bearing 1}\n  - {position: 480", "relative_to: bearing 3}\n  - {position: 480", "probes[2].relative_to: expected a bearing from 1 to 2"),
        ("45, relative_to: bearing 1", "45, relative_to: bearing 2", "probes[2].relative_to: expected a bearing on a support, got bearing 2"),
        ("bearing 1 stiffness factor", "bearing 2 stiffness factor", "expected a bearing with a table for a stiffness factor"),
        ("{mass: 20, kyy: 60, kxy: 1", "{mass: 20, kxx: 1, kyy: 60, kxy: 1", "since unknown support sets it"),
        ("support 1 kxx", "support 3 kxx", "expected a support from 1 to 2"),
        ("seal 1 cxx,", "seal 2 cxx,", "expected a seal from 1 to 1"),
        ("{mass: 20, kyy: 60", "{mass: 20, mxx: 1, kyy: 60", "expected either mass or mxx and myy"),
        ("{mass: 20, kyy: 60", "{mass: 20", "bearings[1].support.kyy: expected a value, got nothing"),
        ("kxx: [10, 20, 30]", "kxx: [10, 20]", "expected 3 numbers, as many as of speed, got 2"),
        ("bearing 1 cxx factor", "bearing 1 kxx factor", "unknowns[2].sets[1]: expected each number to be set once, got 'bearing 1 kxx factor', which stiffness sets"),
        ("bearing 1 cxx factor", "bearing 1 cxy factor", "expected a table with more than zeros for a cxy factor"),
        ("{name: cxx, lower: 0.5, upper: 2", "{name: cxx, lower: 0.5, upper: 1e300", "unknowns[2].upper: expected a number above 0.5 and at most 1e+06"),
        ("young_modulus: 210", "young_modulus: 0.210", "expected 1 to 1500 GPa, got 0.21 GPa, which is implausible"),
        ("mass: 1.5}", "mass: -1}", "masses[1].mass: expected a number at least 0"),
    ],
)  # fmt: skip
def test_a_slip_is_named_with_its_place(write, old, new, words):
    assert WHOLE.count(old) == 1
    assert words in refused(WHOLE.replace(old, new), write)


def test_a_shaft_that_turns_from_y_to_x_is_seen_with_y_reversed(write):
    """A mirror image: y motions and angles change sign, and nothing else."""
    plain = WHOLE.replace("relative_to: bearing 1", "relative_to: bearing 1").replace("direction: 45", "direction: y")
    problem = RotorFile(file=write(plain)).build()
    reversed_signs = (
        plain.replace("kxy: 1,", "kxy: -1,")
        .replace("myx: 0.5", "myx: -0.5")
        .replace("kxy: 0.5, kyx: -0.5", "kxy: -0.5, kyx: 0.5")
        .replace("phase: 90", "phase: -90")
        .replace("direction: y", "direction: -90")
    )
    other = RotorFile(file=write(reversed_signs + "rotation: y to x\n", "mirrored.yaml")).build()
    assert other.channels == problem.channels
    x = problem.parameters.to_si(np.full((1, 5), 0.4))
    np.testing.assert_allclose(other.response(x), problem.response(x), rtol=1e-12)


def test_a_rotor_to_draw_needs_no_bearings_probes_or_unknowns(write):
    start = WHOLE.index("bearings:")
    free = WHOLE[:start] + "bearings: []\nspeeds: [600, 6000]\n"
    problem = RotorFile(file=write(free)).build()
    assert (problem.rotor.bearings, problem.channels, len(problem.parameters)) == ((), (), 0)
    assert problem.missing == ("bearings", "unbalance", "unknowns")
    passive = free.replace(", axial_force: -3", "").replace("internal_damping: 2e-6, ", "")
    drawing = str(ksmea.load_problem(write(passive)).draw())
    assert "0 bearings" in drawing and "Stable up to 9000 rpm" in drawing


def test_a_measurement_by_the_probes_of_a_housing_reads_against_it(write):
    """A measurement brings its own channels. Where all probes of the file at a place are fixed to one housing, all of the measurement are;
    else those in the same direction."""
    problem = RotorFile(file=write(WHOLE)).build()
    seen = problem.at(problem.speed[:3], (Channel(0.02, "x"), Channel(0.02, "y"), Channel(0.48, "y")))
    assert [seen.rotor.housing_of(channel) for channel in seen.channels] == [0, 0, None]
    mixed = WHOLE.replace("direction: 45, relative_to: bearing 1}", "direction: 45}")
    problem = RotorFile(file=write(mixed)).build()
    assert [problem.rotor.housing_of(Channel(0.02, each)) for each in ("x", "45", "y")] == [0, None, None]


def test_a_number_of_a_bearing_stands_in_one_place(write):
    """In the table, in the bearing, or with an unknown; one that is nowhere is asked for."""
    assert "bearings[1].kxx: expected no value, since the table has it" in refused(
        WHOLE.replace("  - position: 0\n", "  - position: 0\n    kxx: 3\n"), write
    )
    said = refused(WHOLE.replace("bearing 1 cxx factor", "bearing 1 cxx"), write)
    assert (
        "bearings[1].table: expected no cxx in it, since unknown cxx sets it; remove the column, or set 'cxx factor'"
        in said
    )
    said = refused(WHOLE.replace(" cyy: [5, 5, 5],", ""), write)
    assert "bearings[1].cyy: expected a value, got nothing; add it" in said


def test_all_numbers_of_a_support_may_be_unknown(write):
    content = WHOLE.replace("{mass: 20, kyy: 60, kxy: 1, cxx: 2, loss_factor: 0.03}", "{}")
    content = content.replace("[support 1 kxx]", "[support 1 kxx, support 1 kyy]")
    targets = RotorFile(file=write(content)).build().unknowns[-1].targets
    assert targets == (PedestalTarget(0, "kxx"), PedestalTarget(0, "kyy"))
    mass = "  - {name: m, lower: 1, upper: 90, sets: [support 1 mass]}\n"
    assert "since unknown m sets it" in refused(WHOLE + mass, write)
    given = refused(WHOLE.replace("{mass: 20,", "{mxx: 20,") + mass, write)
    assert "bearings[1].support.mxx: expected either mass or mxx and myy" in given


def test_a_measured_support_is_a_table_over_frequency(write, tmp_path):
    table = "frequency [Hz],re_zxx [MN/m],im_zxx [MN/m],re_zyy [MN/m],re_zyx [MN/m]\n10,50,1,60,0\n100,40,10,55,0.5\n"
    (tmp_path / "support.csv").write_text(table)
    supported = WHOLE.replace("{mass: 20, kyy: 60, kxy: 1, cxx: 2, loss_factor: 0.03}", "{table: support.csv}")
    supported = supported.replace("[support 1 kxx]", "[bearing 2 kxy]")
    pedestal = RotorFile(file=write(supported)).build().rotor.bearings[0].pedestal
    frequency = 2 * np.pi * np.array([10.0, 100.0])
    assert pedestal.impedance(frequency)[:, 0, 0] == pytest.approx([50e6 + 1e6j, 40e6 + 10e6j])
    assert pedestal.impedance(frequency)[:, 1, 0] == pytest.approx([0, 0.5e6])
    (tmp_path / "support.csv").write_text("frequency [Hz],re_zxx [MN/m]\n10,50\n")
    said = refused(supported, write)
    assert "support.table: expected columns frequency, re_zxx, re_zyy and any of" in said


def test_a_sleeve_may_be_soft_where_something_else_is_stiff(write):
    """A slip in the unit of one material of several is still seen: a segment of it alone would be soft, or a disk."""
    for old, new in (
        ("outer_diameter: 50, material: steel", "outer_diameter: 50, material: sleeve"),
        ("inner_diameter: 60, material: sleeve", "inner_diameter: 60, material: steel"),  # used nowhere
    ):
        said = refused(WHOLE.replace(old, new), write)
        assert "materials.sleeve.young_modulus: expected 1 to 1500 GPa, got 7e-06 GPa" in said
    swapped = WHOLE.replace("stiffness_outer_diameter: 55, material: steel", "material: sleeve")
    swapped = swapped.replace("inner_diameter: 60, material: sleeve", "inner_diameter: 60, material: steel")
    assert RotorFile(file=write(swapped)).build().rotor.segments[1].material.young_modulus == pytest.approx(7e3)


def test_mirrored_unknowns_have_mirrored_limits(write):
    cross = WHOLE.replace(
        "lower: 5, upper: 50, reference: 20, sets: [bearing 2 kyy]", "lower: -5, upper: 50, reference: 20, sets: [SETS]"
    )
    cross = cross.replace("kxx: 20, cxx: 1", "kxx: 20, kyy: 20, cxx: 1") + "rotation: y to x\n"
    settings = RotorFile(file=write(cross.replace("SETS", "bearing 2 kxy")))
    k = settings.build().parameters.items[2]
    assert (k.lower, k.upper, settings.reference()["kyy"]) == (-50e6, 5e6, -20e6)
    said = refused(cross.replace("SETS", "bearing 2 kxy, seal 1 kyy"), write)
    assert (
        "my.yaml: rotation: expected unknowns that set either cross-coupled coefficients or direct ones, got kyy"
        in said
    )


ON_SUPPORTS = """\
units: {length: m, modulus: GPa, density: kg/m3, stiffness: MN/m, damping: kN s/m, unbalance: g mm, angle: deg, speed: rpm}
materials:
  steel: {young_modulus: 211, density: 7810, poisson_ratio: 0.2993}
shaft:
  - {length: 0.5, outer_diameter: 0.05, material: steel, elements: 6}
  - {length: 0.5, outer_diameter: 0.05, material: steel, elements: 6}
  - {length: 0.5, outer_diameter: 0.05, material: steel, elements: 6}
disks:
  - {position: 0.5, outer_diameter: 0.28, inner_diameter: 0.05, thickness: 0.07, material: steel}
  - {position: 1.0, outer_diameter: 0.35, inner_diameter: 0.05, thickness: 0.07, material: steel}
bearings:
  - {position: 0, support: SUPPORT}
  - {position: 1.5, support: SUPPORT}
unbalance: [{position: 0.5, phase: 0}]
speeds: {from: 300, to: 4500, number: 15}
probes:
  - {position: 0.05, direction: x, relative_to: bearing 1}
  - {position: 0.05, direction: y, relative_to: bearing 1}
  - {position: 1.45, direction: x, relative_to: bearing 2}
  - {position: 1.45, direction: y, relative_to: bearing 2}
unknowns:
  - {name: u, lower: 10, upper: 2000, sets: [unbalance 1 magnitude]}
  - {name: kxx, lower: 0.5, upper: 50, sets: [bearing 1 kxx, bearing 2 kxx]}
  - {name: kyy, lower: 0.5, upper: 50, sets: [bearing 1 kyy, bearing 2 kyy]}
  - {name: cxx, lower: 0.05, upper: 20, sets: [bearing 1 cxx, bearing 2 cxx]}
  - {name: cyy, lower: 0.05, upper: 20, sets: [bearing 1 cyy, bearing 2 cyy]}
"""
OF_SUPPORTS = """\
  - {name: sx, lower: 2, upper: 200, sets: [support 1 kxx, support 2 kxx]}
  - {name: sy, lower: 2, upper: 200, sets: [support 1 kyy, support 2 kyy]}
"""
SUPPORTS = {"known": ("{kxx: 16.667, kyy: 25, loss_factor: 0.03}", ""), "unknown": ("{loss_factor: 0.03}", OF_SUPPORTS)}


@pytest.mark.parametrize("support", SUPPORTS)
def test_a_machine_on_soft_supports_with_probes_on_its_housings(support, write):
    """A housing without mass moves by v = z_b q / (z_b + z_p), in x and y apart: the probes at a bearing's place read q − v of the
    motion that probes on the ground read."""
    given, further = SUPPORTS[support]
    content = ON_SUPPORTS.replace("SUPPORT", given) + further
    content = content.replace("position: 0.05", "position: 0").replace("position: 1.45", "position: 1.5")
    by_ground = content.replace(", relative_to: bearing 1", "").replace(", relative_to: bearing 2", "")
    problem, ground = (RotorFile(file=write(each)).build() for each in (content, by_ground))
    assert [problem.rotor.housing_of(channel) for channel in problem.channels] == [0, 0, 1, 1]
    x = np.array([2e-4, 5e6, 8e6, 2e3, 3e3, 16.667e6, 25e6][: len(problem.parameters)])
    support_stiffness = np.array([16.667e6, 25e6]) * (1 + 0.03j)
    film = x[1:3] + 1j * problem.speed[:, None] * x[3:5]
    part = np.tile(support_stiffness / (film + support_stiffness), 2)
    # Rounding of a solution near resonance: 1e-13 times its condition
    np.testing.assert_allclose(problem.response(x[None])[0], part * ground.response(x[None])[0], rtol=1e-9)


def test_the_example_of_most_keys_has_one_response_by_both_routes():
    problem = RotorFile(file=str(EXAMPLES / "machine.yaml")).build()
    assert len(problem.rotor.seals) == 1 and problem.remarks_at(problem.speed) == ()
    x = problem.parameters.to_si(np.random.default_rng(2).random((3, 4)))
    assert np.abs(problem.response(x) / problem.dense_response(x) - 1).max() < 1e-8

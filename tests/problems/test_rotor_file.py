"""A rotor from a file: the example is the three-disk rotor, and every slip is named with its place."""

import dataclasses
import math
import os
from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.settings.strict_yaml import LARGEST
from problems.rotor.finite_elements.bearing import COEFFICIENTS, Bearing
from problems.rotor.finite_elements.data import UnbalancePlane
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.unknowns import BearingTarget, UnbalanceTarget
from problems.rotor_file import RotorFile
from problems.three_disk import ThreeDisk

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "rotor.yaml"

SMALL = """\
units: {length: mm, modulus: GPa, density: g/cm3, mass: g, inertia: kg mm2, stiffness: N/mm, damping: N s/mm,
        unbalance: g mm, angle: deg, speed: rpm}
materials:
  steel: {young_modulus: 210, density: 7.85, poisson_ratio: 0.3}
shaft:
  - {length: 200, outer_diameter: 10, material: steel, elements: 4}
  - {length: 300, outer_diameter: 20, inner_diameter: 5, material: steel, elements: 6}
disks:
  - {position: 200, mass: 800, polar_inertia: 600, diametral_inertia: 350}
bearings:
  - {position: 0, kxx: 1e3, kyy: 2e3, kxy: -50, cxx: 0.1, cyy: 0.2}
  - {position: 500, kxx: 1000, cxx: 0.1, cyy: 0.2}
unbalance:
  - {position: 200, magnitude: 30, phase: 90}
  - {position: 350}
speeds: [600, 900, 1200.5]
probes:
  - {position: 123, direction: y}
unknowns:
  - {name: k, lower: 100, upper: 9e3, sets: [bearing 2 kyy]}
  - {name: m, lower: 1, upper: 50, reference: 20, sets: [unbalance 2 magnitude]}
  - {name: a, lower: -180, upper: 180, reference: -45, sets: [unbalance 2 phase]}
"""


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Write a rotor file and stand in its directory."""
    monkeypatch.chdir(tmp_path)

    def write(content, name="my.yaml"):
        data = content if isinstance(content, bytes) else content.encode()
        (tmp_path / name).write_bytes(data)
        return name

    return write


def refused(**settings):
    """Message as the user reads it: always one line."""
    with pytest.raises(SettingError) as caught:
        RotorFile(**settings)
    text = str(caught.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize("mesh", [None, 21])
def test_example_is_the_three_disk_rotor(mesh):
    settings, published = RotorFile(file=str(EXAMPLE), mesh=mesh), ThreeDisk(mesh=mesh or 13)
    problem, expected = settings.build(), published.build()
    assert problem.rotor == expected.rotor
    assert problem.channels == expected.channels
    assert problem.parameters.names == expected.parameters.names
    assert settings.reference() == pytest.approx(published.reference())
    x = expected.parameters.to_si(np.random.default_rng(3).random((10, 5)))
    # The two are assembled alike; a unit's conversion may round once, and needles magnify that.
    assert problem.response(x) == pytest.approx(expected.response(x), rel=1e-9)


def test_reduced_response_is_the_dense_one(write):
    for problem in (RotorFile(file=str(EXAMPLE)).build(), RotorFile(file=write(SMALL)).build()):
        x = problem.parameters.to_si(np.random.default_rng(4).random((10, len(problem.parameters))))
        assert np.abs(problem.response(x) / problem.dense_response(x) - 1).max() < 1e-8


def test_every_quantity_is_converted(write):
    settings = RotorFile(file=write(SMALL))
    problem = settings.build()
    thin, thick = problem.rotor.segments
    assert (thin.length, thin.outer_radius, thin.inner_radius, thin.n_element) == pytest.approx((0.2, 0.005, 0, 4))
    assert (thick.length, thick.outer_radius, thick.inner_radius) == pytest.approx((0.3, 0.01, 0.0025))
    assert (thin.material.young_modulus, thin.material.density) == pytest.approx((210e9, 7850))
    (disk,) = problem.rotor.disks
    assert dataclasses.astuple(disk) == pytest.approx(dataclasses.astuple(Disk(0.2, 0.8, 600e-6, 350e-6)))
    left, right = problem.rotor.bearings
    expected = Bearing(0.0, kxx=1e6, kxy=-5e4, kyy=2e6, cxx=100, cyy=200)
    numbers = [[getattr(each, name) for name in COEFFICIENTS] for each in (left, expected)]
    assert numbers[0] == pytest.approx(numbers[1])
    assert right.position == pytest.approx(0.5)
    plane = problem.rotor.unbalance[0]
    assert dataclasses.astuple(plane) == pytest.approx(dataclasses.astuple(UnbalancePlane(0.2, 30e-6, math.pi / 2)))
    assert problem.speed == pytest.approx(np.array([600, 900, 1200.5]) * math.pi / 30)
    assert [str(channel) for channel in problem.channels] == ["y at 0.123 m"]
    assert problem.parameters.lower == pytest.approx([1e5, 1e-6, -math.pi])
    assert problem.parameters.upper == pytest.approx([9e6, 50e-6, math.pi])
    assert [parameter.unit for parameter in problem.parameters] == ["N/mm", "g mm", "deg"]
    assert [item.targets for item in problem.unknowns] == [
        (BearingTarget(1, "kyy"),),
        (UnbalanceTarget(1, "magnitude"),),
        (UnbalanceTarget(1, "phase"),),
    ]
    assert settings.reference() == pytest.approx({"m": 20e-6, "a": -math.pi / 4})


def test_numbers_are_read_as_calculators_do(write):
    # YAML 1.1 takes 1e3 for a text, 0123 for 83 and 2:03 for 123.
    assert RotorFile(file=write(SMALL.replace("position: 123", "position: 0123"))).build().channels[0].position == 0.123
    assert "'2:03'" in refused(file=write(SMALL.replace("position: 123", "position: 2:03")))


def test_a_key_may_be_taken_over_and_overridden(write):
    text = SMALL.replace("{position: 0, kxx: 1e3", "&left {position: 0, kxx: 1e3").replace(
        "{position: 500, kxx: 1000, cxx: 0.1, cyy: 0.2}", "{<<: *left, position: 500}"
    )
    message = refused(file=write(text))
    assert "bearings[2].kyy: expected no value, since unknown k sets it" in message
    tied = text.replace("kyy: 2e3, ", "").replace("[bearing 2 kyy]", "[bearing 1 kyy, bearing 2 kyy]")
    assert RotorFile(file=write(tied)).build().rotor.bearings[1].kxy == pytest.approx(-5e4)


def test_mesh_takes_the_place_of_the_files(write):
    name = write(SMALL)
    counts = [segment.n_element for segment in RotorFile(file=name, mesh=5).build().rotor.segments]
    assert counts == [2, 3]
    assert "mesh: expected at least 2 elements, got 1" in refused(file=name, mesh=1)
    assert "mesh: expected a number at least 1" in refused(file=name, mesh=0)


def test_fingerprint_is_that_of_the_content(write):
    first = RotorFile(file=write(SMALL))
    before = first.fingerprint()
    assert RotorFile(file=write(SMALL, "copy.yaml")).fingerprint() == before
    write(SMALL.replace("upper: 9e3", "upper: 8e3"))
    assert RotorFile(file="my.yaml").fingerprint() != before
    assert first.fingerprint() == before  # it goes with what was read
    assert first.build().parameters.upper[0] == pytest.approx(9e6)


def test_file_is_required():
    assert refused().startswith("file: expected the YAML file of a rotor, got none; give problem.file=")


SLIPS = [  # what is replaced in SMALL, by what, and what is said
    ("mass: 800", "mass: heavy", "disks[1].mass: expected a number above 0 (g), got 'heavy'"),
    ("mass: 800", "mass: -1", "disks[1].mass: expected a number above 0 (g), got -1"),
    ("mass: 800", "mass: .nan", "disks[1].mass: expected a number above 0 (g), got '.nan'"),
    ("mass: 800", "mass: 1e999", "disks[1].mass: expected a number above 0 (g), got inf"),
    ("mass: 800", "mass: " + "9" * 400, "disks[1].mass: expected a number above 0 (g), got 999"),
    ("mass: 800", "mass:", "disks[1].mass: expected a number above 0 (g), got nothing"),
    ("mass: 800", "mass: [1, 2]", "disks[1].mass: expected a number above 0 (g), got a list"),
    ("mass: 800", "mass: true", "disks[1].mass: expected a number above 0 (g), got 'true'"),
    ("mass: 800", "mas: 800", "disks[1]: unknown key 'mas'; did you mean 'mass'?"),
    ("mass: 800, ", "", "disks[1].mass: expected a value, got nothing; add it"),
    ("mass: 800", "mass: 800, thickness: 3", "disks[1]: expected either outer_diameter"),
    ("polar_inertia: 600", "polar_inertia: -6", "disks[1].polar_inertia: expected a number at least 0 (kg mm2)"),
    (
        "{position: 200, mass",
        "{position: 600, mass",
        "disks[1].position: disk at 0.6 m: expected a position on the shaft",
    ),
    ("{position: 200, mass", "{position: 210, mass", "disks[1].position: disk at 0.21 m: expected a node of the mesh"),
    ("{position: 200, mass", "{position: one, mass", "disks[1].position: expected a number (mm), got 'one'"),
    ("{position: 500", "{position: 501", "bearings[2].position: bearing at 0.501 m: expected a position"),
    ("{position: 350", "{position: -1", "unbalance[2].position: unbalance at -0.001 m: expected a position"),
    ("{position: 123", "{position: 777", "probes[1].position: probe at 0.777 m: expected a position"),
    ("direction: y", "direction: z", "probes[1].direction: unknown direction 'z'"),
    ("direction: y}", "direction: y}\n  - {position: 123.0, direction: y}", "probes[2]: expected each probe once"),
    ("length: mm", "length: furlong", "units.length: unknown unit of length 'furlong'; "),
    ("length: mm", "length: 3", "units.length: expected a text, got 3"),
    ("length: mm, ", "", "units.length: expected the unit of every length in the file, got nothing; known: m, cm"),
    ("length: mm", "lenght: mm", "units: unknown key 'lenght'; did you mean 'length'?"),
    ("young_modulus: 210", "young_modulus: 0", "materials.steel.young_modulus: expected a number above 0 (GPa), got 0"),
    ("poisson_ratio: 0.3", "poisson_ratio: 0.6", "poisson_ratio: expected a number above -1 and at most 0.5, got 0.6"),
    ("  steel: {young", "  steel: {young_modulus: 1}\n  7: {young", "materials: expected names of materials that are"),
    ("{young_modulus: 210, density: 7.85, poisson_ratio: 0.3}", "hard", "materials.steel: expected a mapping"),
    (
        "material: steel, elements: 4",
        "material: steal, elements: 4",
        "shaft[1].material: unknown material 'steal'; did",
    ),
    ("elements: 4", "elements: 4.5", "shaft[1].elements: expected a whole number from 1 to 1000, got 4.5"),
    ("elements: 4", "elements: 1000000", "shaft[1].elements: expected a whole number from 1 to 1000, got 1000000"),
    (
        "inner_diameter: 5",
        "inner_diameter: 20",
        "shaft[2].inner_diameter: expected less than the outer_diameter, 20, got 20",
    ),
    ("length: 200", "length: 0", "shaft[1].length: expected a number above 0 (mm), got 0"),
    ("kxx: 1e3", "kxz: 1e3", "bearings[1]: unknown key 'kxz'; did you mean 'k"),
    ("kxx: 1e3, ", "", "bearings[1].kxx: expected a value, got nothing; add it"),
    ("kxx: 1000", "kxx: 1000, kyy: 3", "bearings[2].kyy: expected no value, since unknown k sets it; remove one"),
    ("magnitude: 30", "magnitude: -30", "unbalance[1].magnitude: expected a number at least 0 (g mm), got -30"),
    (", phase: 90", "", "unbalance[1].phase: expected a value, got nothing; add it"),
    ("{position: 350}", "{position: 350, phase: 1}", "unbalance[2].phase: expected no value, since unknown a sets it"),
    ("[600, 900, 1200.5]", "[600, 500]", "speeds[2]: expected speeds that rise, got 500 after 600"),
    ("[600, 900, 1200.5]", "[0, 500]", "speeds[1]: expected a number above 0 (rpm), got 0"),
    ("[600, 900, 1200.5]", "[]", "speeds: expected a list with at least one entry, got an empty list"),
    ("[600, 900, 1200.5]", "fast", "speeds: expected a mapping (key: value), got 'fast'"),
    ("[600, 900, 1200.5]", "{from: 9, to: 5, number: 3}", "speeds.to: expected a number above 9 (rpm), got 5"),
    ("[600, 900, 1200.5]", "{from: 9, to: 10, number: 0}", "speeds.number: expected a whole number from 1 to 100000"),
    ("[600, 900, 1200.5]", "{from: 9, to: 10}", "speeds.number: expected a value, got nothing"),
    ("name: m,", "name: k,", "unknowns[2].name: expected each name once, got 'k' again"),
    ("name: m,", "name: 7,", "unknowns[2].name: expected a text, got 7"),
    ("name: m,", "name: my mass,", "unknowns[2].name: expected letters, digits and _ after a letter, got 'my mass'"),
    ("lower: 100,", "lower: 9000,", "unknowns[1].upper: expected a number above 9000 (N/mm), got 9000"),
    ("lower: 1,", "lower: -1,", "unknowns[2].lower: expected a number at least 0 (g mm), got -1"),
    ("reference: 20", "reference: 60", "unknowns[2].reference: expected a number at least 1 and at most 50 (g mm)"),
    ("[bearing 2 kyy]", "[bearing 3 kyy]", "unknowns[1].sets[1]: expected a bearing from 1 to 2, got '3'"),
    ("[bearing 2 kyy]", "[bearing 0 kyy]", "unknowns[1].sets[1]: expected a bearing from 1 to 2, got '0'"),
    ("[bearing 2 kyy]", "[bearing 2 kyz]", "unknowns[1].sets[1]: unknown part of bearing 'kyz'; did you mean"),
    ("[bearing 2 kyy]", "[baering 2 kyy]", "unknowns[1].sets[1]: unknown thing 'baering'; did you mean 'bearing'?"),
    ("[bearing 2 kyy]", "[kyy]", "unknowns[1].sets[1]: expected such as 'bearing 1 kxx'"),
    ("[bearing 2 kyy]", "bearing 2 kyy", "unknowns[1].sets: expected a list with at least one entry"),
    ("[bearing 2 kyy]", "[bearing 2 kyy, bearing 2 cyy]", "unknowns[1].sets[2]: expected a stiffness as in the first"),
    ("[unbalance 2 phase]", "[unbalance 2 magnitude]", "unknowns[3].sets[1]: expected each number to be set once"),
    ("probes:", "sensors:", "my.yaml: unknown key 'sensors'"),
    ("probes:\n  - {position: 123, direction: y}\n", "probes: 3\n", "probes: expected a list with at least one entry"),
    ("probes:\n  - {position: 123, direction: y}\n", "probes: [1]\n", "probes[1]: expected a mapping"),
    ("mass: 800", "mass: 800, mass: 900", "my.yaml line 9: expected YAML, got the key 'mass' a second time"),
    ("shaft:\n", "shaft: [\n", "my.yaml line "),
    ("mass: 800", "mass: !!python/object:os.system 1", "could not determine a constructor for the tag"),
    ("mass: 800", "mass: !!int heavy", "my.yaml: expected YAML, got invalid literal for int()"),
    ("mass: 800", "mass: *nobody", "line 9: expected YAML, got undefined alias 'nobody'"),
]


@pytest.mark.parametrize(("old", "new", "said"), SLIPS)
def test_a_slip_is_named_with_its_place(write, old, new, said):
    assert SMALL.count(old) == 1
    message = refused(file=write(SMALL.replace(old, new)))
    assert message.startswith("my.yaml") and message.count("my.yaml") == 1
    assert said in message
    assert len(message) < 300


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "my.yaml: expected a mapping with the rotor's description, got nothing"),
        ("# only remarks\n", "got nothing"),
        ("{}", "got an empty mapping"),
        ("- 1\n- 2\n", "got a list"),
        ("rotor", "got 'rotor'"),
        ("a: 1\n---\nb: 2\n", "my.yaml line 2: expected YAML"),
        (
            "a: [1, 2\nb: }",
            "my.yaml line 2: expected YAML, got a syntax error (expected ',' or ']', but got ':'); look there",
        ),
        ("? [1, 2]\n: 3\n", "unhashable"),
        ("{1: 2}", "unknown key '1'"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "my.yaml: expected a YAML text in UTF-8, got other bytes at 0"),
        (b"\x00\x01\x02\x03", "my.yaml: expected YAML, got unacceptable character"),
        (b"\xff\xfeu\x00n\x00", "my.yaml: expected a YAML text in UTF-8"),
        ("[" * 1500, "nested too deeply"),
        ("a: &a [*a]\n", "unknown key 'a'"),
        ("#" * (LARGEST + 1), f"expected at most {LARGEST} bytes"),
    ],
)
def test_what_is_no_description(write, content, said):
    assert said in refused(file=write(content))


def test_no_such_file_and_a_directory(write, tmp_path):
    assert refused(file="nowhere.yaml").startswith("nowhere.yaml: expected a YAML file, found none")
    assert refused(file=str(tmp_path)).endswith("got a directory; name a file in it")


def test_a_pipe_is_no_file_and_what_is_too_large_is_not_read(write, tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe.yaml")
    assert "got something that is not a regular file" in refused(file=str(tmp_path / "pipe.yaml"))
    large = write("#" * (LARGEST + 1))
    monkeypatch.setattr(Path, "read_bytes", lambda path: pytest.fail("it was read"))
    assert f"expected at most {LARGEST} bytes" in refused(file=large)


def test_random_damage_never_escapes(write):
    """Bytes of the example changed, cut out or doubled: a description or one line about it, never a traceback."""
    rng = np.random.default_rng(5)
    content = SMALL.encode()
    for _ in range(300):
        start, length = rng.integers(len(content)), rng.integers(1, 12)
        middle = [b"", content[start : start + length] * 2, rng.integers(0, 256, length, dtype=np.uint8).tobytes()]
        broken = content[:start] + middle[rng.integers(3)] + content[start + length :]
        name = write(broken)
        try:
            RotorFile(file=name)
        except SettingError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "young_modulus: 210",
            "young_modulus: 210000",
            "materials.steel.young_modulus: expected 1 to 1500 GPa, got 210000 GPa",
        ),
        ("young_modulus: 210", "young_modulus: 0.21", "expected 1 to 1500 GPa, got 0.21 GPa, which is implausible"),
        ("{length: mm,", "{length: m,", "shaft[1].length: expected segments of at most 50 m together, got 500 m"),
    ],
)
def test_a_size_that_no_rotor_has_names_the_unit_to_check(old, new, expected, tmp_path):
    (tmp_path / "rotor.yaml").write_text(SMALL.replace(old, new))
    with pytest.raises(SettingError) as error:
        RotorFile(file=str(tmp_path / "rotor.yaml"))
    assert expected in str(error.value) and "check units." in str(error.value) and "\n" not in str(error.value)

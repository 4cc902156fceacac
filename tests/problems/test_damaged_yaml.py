"""Rotor files with slips of the pen: sizes, plausible numbers, merges and quoted text, each refused in one visible line."""

import time
from pathlib import Path

import pytest

from ksmea.errors import SettingError, shortened, unknown, visible, visible_lines
from ksmea.settings.document import PLAUSIBLE
from ksmea.settings.strict_yaml import LARGEST, parse
from ksmea.units import SI_PER_UNIT
from problems.extended_file import ExtendedFile
from problems.rotor_file import RotorFile
from problems.rotor_settings import check_ports, check_size
from problems.three_disk import ThreeDisk

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
ROTOR = (EXAMPLES / "rotor.yaml").read_text()


def refused(tmp_path, text, settings_class=RotorFile):
    (tmp_path / "my.yaml").write_text(text)
    started = time.monotonic()
    with pytest.raises(SettingError) as caught:
        settings_class(file=str(tmp_path / "my.yaml"))
    assert time.monotonic() - started < 5 and str(caught.value).isprintable()
    return str(caught.value).removeprefix(f"{tmp_path}/my.yaml")


def changed(old, new):
    assert old in ROTOR
    return ROTOR.replace(old, new, 1)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("young_modulus: 200", "young_modulus: 1e300", "materials.steel.young_modulus: expected a modulus between"),
        (
            "density: 7800",
            "density: 1e-300",
            "materials.steel.density: expected a density between 0.001 and 1e+06 kg/m3",
        ),
        ("length: 0.2, outer", "length: 1e200, outer", "shaft[1].length: expected a length between 1e-09 and 1e+04 m"),
        ("outer_diameter: 0.24", "outer_diameter: 1e170", "disks[1].outer_diameter: expected a length"),
        ("upper: 100, reference: 50", "upper: 1e300, reference: 50", "unknowns[1].upper: expected a stiffness between"),
        ("to: 1500", "to: 1e9", "speeds.to: expected a speed between 1e-06 and 1e+06 rad/s"),
        ("inner_diameter: 0.1,", "inner_diameter: 0.23999999999999996,", "expected less than the outer_diameter"),
        ("elements: 2}", "elements: 1000}", "mesh: expected at most 1000 elements in all, got 1011"),
    ],
)
def test_numbers_and_sizes_are_plausible(tmp_path, old, new, said):
    assert said in refused(tmp_path, changed(old, new))


def test_too_many_of_a_thing_are_refused_before_anything_is_built(tmp_path):
    bearings = "".join(f"  - {{position: {place}}}\n" for place in range(201))
    said = refused(tmp_path, changed("bearings:\n", f"bearings:\n{bearings}"))
    assert ": bearings: expected at most 200 entries, got 203; take fewer" in said


def test_many_seals_with_unknowns_at_many_speeds_are_refused(tmp_path):
    """Known ones cost nothing."""
    speeds = changed("number: 53", "number: 5000")
    seals = "seals:\n" + "  - {position: 0.5}\n" * 60
    (tmp_path / "my.yaml").write_text(speeds + seals.replace("}", ", kxx: 1, kyy: 1, cxx: 1, cyy: 1}"))
    assert len(RotorFile(file=str(tmp_path / "my.yaml")).build().rotor.seals) == 60
    sets = ", ".join(f"seal {number} kxx" for number in range(1, 61))
    unknown_one = f"  - {{name: seal, lower: 1, upper: 2, sets: [{sets}]}}\n"
    said = refused(tmp_path, speeds + unknown_one + seals)
    # 2·10⁷ entries over 126 rows (two ports each of 62, two probes) and 125 columns
    assert "speeds: expected at most 1269 with 2 probes, 62 bearings, 1 planes, got 5000" in said


def test_many_probes_at_many_speeds_are_refused():
    check_ports(6000, n_bearing=2, n_plane=1, n_probe=600)
    with pytest.raises(SettingError, match=r"at most 999 with 4000 probes, 2 bearings, 1 planes, got 6000 \(1.9 GB\)"):
        check_ports(6000, n_bearing=2, n_plane=1, n_probe=4000)


def test_plausible_ranges_hold_every_unit():
    assert PLAUSIBLE.keys() == SI_PER_UNIT.keys()


@pytest.mark.parametrize(
    "settings", [{"mesh": 10**6}, {"n_speed": 10**9}, {"mesh": 1000, "n_speed": 5300}, {"speed_to": 1e300}]
)
def test_a_problem_too_large_is_refused_by_name_and_in_an_extended_file(tmp_path, settings):
    with pytest.raises(SettingError, match="expected at most"):
        ThreeDisk(**settings)
    words = ", ".join(f"{key}: {value}" for key, value in settings.items())
    said = refused(tmp_path, f"problem: {{name: three_disk, {words}}}\neffects: []\n", ExtendedFile)
    assert said.startswith(": problem: ") and "expected at most" in said


def test_sizes_are_bounded_by_the_cost_of_bands():
    check_size(400, 2000)
    check_size(400, 6234)  # · 1604 degrees of freedom: 10⁷
    with pytest.raises(SettingError, match=r"speeds: expected at most 6234 with 400 elements, got 6235 \(3.5 GB\)"):
        check_size(400, 6235)


def test_nesting_and_length_are_bounded(tmp_path):
    assert "nested too deeply" in refused(tmp_path, "a: " + "[" * 100_000)
    assert "nested too deeply" in refused(tmp_path, "".join("  " * n + "a:\n" for n in range(100)))
    assert f"expected at most {LARGEST} bytes" in refused(tmp_path, "- a\n" * LARGEST)


def test_a_key_from_two_merges_is_refused():
    text = b"a: &a {x: 1}\nb: &b {<<: *a, x: 2, y: 3}\nc: {<<: *b, y: 4}\n"
    assert parse(text, "f")["c"] == {"x": 2, "y": 4} and parse(text, "f")["b"] == {"x": 2, "y": 3}
    with pytest.raises(SettingError, match=r"f line 1: expected YAML, got the key 'x' from two merges"):
        parse(text + b"d: {<<: [*a, *b]}\n", "f")


@pytest.mark.parametrize("sign", ["\x1b[2J", "\u202e", "\x07", "\u2028", "\x9b31m"])
def test_what_a_message_quotes_is_visible(tmp_path, sign):
    text = f'problem: {{name: three_disk, "{sign.encode("unicode_escape").decode()}{"x" * 5000}": 1}}\neffects: []\n'
    said = refused(tmp_path, text.replace("\\x", "\\x").replace("'", ""), ExtendedFile)
    assert len(said) < 400
    assert visible(f"a{sign}b").isprintable() and visible_lines(f"a{sign}\nb").count("\n") == 1


def test_names_are_cut_and_listed_up_to_a_number():
    said = str(unknown("material", "x" * 9999, [f"m{number}" for number in range(999)]))
    assert said.isprintable() and len(said) < 1000 and said.endswith(", 939 more")
    assert shortened("a\x1bb\n c") == "a\\x1bb c"

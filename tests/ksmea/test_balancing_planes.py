"""Planes as people have them: units of the file kept in all output, holes, and planes that nearly do the same."""

import json

import numpy as np
import pytest

import ksmea
from balancing_cases import corrections
from ksmea.balancing.correction import condition_number, well_shown
from ksmea.errors import SettingError
from ksmea.problem.alignment import aligned
from ksmea.show.json_units import with_units
from problems.three_disk import ThreeDisk

BARE, FIRST, SECOND = (
    np.array([8 + 2j, 3 - 4j]),
    np.array([0.3, 0.1j]),
    np.array([-0.05j, 0.25 + 0.1j]),
)  # µm, µm/(g mm)
ROWS = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,run\n"
PLANE = "planes: [{position: 0.2, radius: 120 mm}]\n"


def job(folder, planes, *weights, responses=None):
    """A file with a bare run and one with each weight (text of the YAML, kg m complex in each plane)."""
    lines = [ROWS]
    for number, own in enumerate([(0, 0), *(each for _, each in weights)]):
        values = BARE + 1e6 * (own[0] * FIRST + own[1] * SECOND)
        for position, value in zip((0.1, 0.5), values):
            lines.append(f"1500,{position},x,{abs(value):.12g},{np.degrees(np.angle(value)):.12g},r{number}\n")
    (folder / "job.csv").write_text("".join(lines))
    runs = "".join(f"  - {{name: r{n}, weights: [{{{text}}}]}}\n" for n, (text, _) in enumerate(weights, start=1))
    (folder / "job.yaml").write_text(f"file: job.csv\n{planes}runs:\n  - {{name: r0}}\n{runs}")
    return ksmea.balance(ksmea.read_measurement(folder / "job.yaml"))


KG_M = -np.linalg.solve(np.column_stack([FIRST, SECOND]), BARE) * 1e-6
OZ_IN = 0.028349523125 * 0.0254


@pytest.mark.parametrize(
    "sizes, planes, si, units",
    [
        (("size: 0.04 oz in", "size: 0.04 oz in"), "", (OZ_IN, OZ_IN), ("oz in", "oz in")),
        (("size: 0.04 oz-in", "size: 30 g mm"), "", (OZ_IN, 1e-6), ("oz in", "g mm")),
        (("size: 0.25 g @ 120 mm", "size: 0.3 g @ 80 mm"), "", (1.2e-4, 8e-5), ("g @ 120 mm", "g @ 80 mm")),
        (
            ("size: 0.01 oz", "size: 0.01 oz @ 4.5 in"),
            "planes: [{position: 0.2, radius: 4 in}]\n",
            (OZ_IN * 4, OZ_IN * 4.5),
            ("oz @ 4 in", "oz @ 4.5 in"),
        ),
        (("g_mm: 30", "g_mm: 30"), PLANE.replace("}", ", unit: g}"), (1.2e-4, 1e-6), ("g @ 120 mm", "g mm")),
    ],
)
def test_the_unit_of_the_file_is_that_of_all_output(tmp_path, sizes, planes, si, units):
    value = {"g_mm: 30": 30e-6, "size: 30 g mm": 30e-6, "size: 0.25 g @ 120 mm": 3e-5, "size: 0.3 g @ 80 mm": 2.4e-5}
    value |= dict.fromkeys(("size: 0.04 oz in", "size: 0.04 oz-in"), 0.04 * OZ_IN)
    value |= {"size: 0.01 oz": 0.04 * OZ_IN, "size: 0.01 oz @ 4.5 in": 0.045 * OZ_IN}
    one, two = (value[size] for size in sizes)
    found = job(
        tmp_path, planes,
        (f"position: 0.2, {sizes[0]}", (one, 0)), (f"position: 0.4, {sizes[1]}, angle_deg: 90", (0, 1j * two)),
    )  # fmt: skip
    np.testing.assert_allclose(corrections(found), KG_M / si, rtol=1e-8)
    assert tuple(found.record.correction.units) == units
    assert [plane.unit for plane in found.record.planes] == list(units)
    np.testing.assert_allclose(
        [plane.coefficients[0].size for plane in found.record.planes],
        np.abs([FIRST[0], SECOND[0]]) * 1e6 * si,
        rtol=1e-8,
    )
    shown = str(found) + json.dumps(with_units(found.record)) + found.to_frame().to_csv()
    assert ("g mm" in shown) == ("g mm" in units) and all(f"µm/({unit})" in shown for unit in units)


@pytest.mark.parametrize(
    "sizes, planes, units",
    [
        (("size: 5 g", "size: 5 g"), "", ("g", "g")),
        (("size: 5 g", "size: 5 oz"), "", ("g", "oz")),
        (("size: 5 g", "size: 5 g @ 80 mm"), "", ("g", "g @ 80 mm")),
        (
            ("size: 5 washers", "size: 5"),
            "planes: [{position: 0.2, unit: washers}, {position: 0.4, unit: M6 bolts}]\n",
            ("washers", "M6 bolts"),
        ),
    ],
)
def test_masses_at_one_radius_and_units_of_ones_own_need_no_radius(tmp_path, sizes, planes, units):
    """Five units in each plane act like 30 g mm, so that one is 6 g mm: corrections are numbers of what was put on."""
    found = job(
        tmp_path, planes,
        (f"position: 0.2, {sizes[0]}", (3e-5, 0)), (f"position: 0.4, {sizes[1]}, angle_deg: 90", (0, 3e-5j)),
    )  # fmt: skip
    np.testing.assert_allclose(corrections(found), KG_M / 6e-6, rtol=1e-8)
    assert found.record.correction.units == units
    shown = str(found) + json.dumps(with_units(found.record)) + found.to_frame().to_csv()
    assert "g mm" not in shown and all(f"µm/({unit})" in shown for unit in units)


def test_sizes_without_a_radius_are_split_onto_holes_and_never_given_to_a_rotor_model(tmp_path):
    planes = "planes: [{position: 0.2, unit: washers, holes: 12, step: 1 washers}]\n"
    weights = (("position: 0.2, size: 5 washers", (3e-5, 0)), ("position: 0.4, size: 5 g", (0, 3e-5)))
    [split] = job(tmp_path, planes, *weights).record.correction.splits
    assert all(each.size == round(each.size) and each.unit == "washers" for each in split.weights)
    measured = ksmea.read_measurement(tmp_path / "job.yaml")
    message = (
        r"run r1: expected weights in kg m of unbalance for a rotor model, got washers at 0.2 m; give radius in planes"
    )
    with pytest.raises(SettingError, match=message):
        aligned(ThreeDisk(sensors=[0.1, 0.5]).build(), measured)


def test_weights_go_into_the_holes_of_their_plane(tmp_path):
    planes = "planes: [{position: 0.2, radius: 120 mm, holes: 12, first_angle_deg: 15, occupied: [2]}]\n"
    runs = (("position: 0.2, size: 0.25 g", (3e-5, 0)), ("position: 0.4, size: 30 g mm", (0, 3e-5)))
    found = job(tmp_path, planes, *runs).record.correction
    [split] = found.splits
    put_on = sum(each.size * np.exp(1j * np.radians(each.angle)) for each in split.weights) * 1.2e-4
    assert put_on == pytest.approx(KG_M[0], rel=1e-8) and 2 not in [each.hole for each in split.weights]
    assert all(each.angle == pytest.approx(15 + 30 * (each.hole - 1)) for each in split.weights)
    assert max(each.size for each in found.left_split) < 1e-6
    coarse = job(tmp_path, planes.replace("occupied: [2]", "step: 0.1 g"), *runs)
    [split], left = coarse.record.correction.splits, coarse.record.correction.left_split
    missing = split.missing.size * np.exp(1j * np.radians(split.missing.angle)) * 1.2e-4 * 1e6  # g mm
    np.testing.assert_allclose([each.size for each in left], np.abs(missing * FIRST), rtol=1e-6)
    assert "In the holes of the planes" in str(coarse) and "Missing at 0.2 m" in str(coarse)
    assert all(round(each.size * 10, 6) == round(each.size * 10) for each in split.weights)


@pytest.mark.parametrize(
    "weight, planes, said",
    [
        ("size: 5 g", "planes: [{position: 0.2, unit: oz in}]\n", "expected weights that can be compared, got some in g and"),
        ("size: 5 g", "planes: [{position: 0.2, unit: 3 g}]\n", "planes[1].unit: expected a unit such as g, oz in or washers"),
        ("size: 5 g", "planes: [{position: 0.2, holes: 4, most: 3 g mm}]\n", "planes[1].most: expected weights that can be"),
        ("size: 5 washers", "", "a unit of your own needs the plane's unit"),
        ("size: 5", "", "expected a size above 0 such as 2.5 oz in"),
        ("size: 0 g mm", "", "expected a size above 0"),
        ("size: 5 g furlong", "", "expected a size such as"),
        ("size: 5 g mm, g_mm: 5", "", "unknown key 'size'"),
        ("size: 5 g", PLANE.replace("120 mm", "120"), "planes[1].radius: expected a"),
        ("size: 5 g", PLANE.replace("}", ", step: 1 g}"), "planes[1].step: expected holes with it"),
        ("size: 5 g", PLANE.replace("}", ", holes: 2, occupied: [1, 2]}"), "expected a free hole"),
        ("size: 5 g", PLANE.replace("}", ", holes: 4, occupied: [5]}"), "expected a list of holes from 1 to 4"),
        ("size: 5 g", PLANE.replace("}", ", holes: [0, 90], first_angle_deg: 1}"), "planes[1].first_angle_deg"),
        ("size: 5 g", PLANE.replace("}", ", holes: 4, step: 1 g, sizes: [1 g]}"), "got both"),
    ],
)  # fmt: skip
def test_a_wrong_size_or_plane_is_one_clear_line(tmp_path, weight, planes, said):
    with pytest.raises(SettingError) as error:
        job(tmp_path, planes, (f"position: 0.2, {weight}", (3e-5, 0)))
    assert said in str(error.value) and "\n" not in str(error.value)


def test_the_condition_number_of_two_planes_in_closed_form():
    """Unit columns with cosine c between them: √((1 + c) / (1 - c)); scaling a plane's unit changes nothing."""
    for angle in (0.5, 0.1, 0.01):
        one, two = np.array([1, 0]), np.array([np.cos(angle), np.sin(angle) * np.exp(1j)])
        expected = np.sqrt((1 + np.cos(angle)) / (1 - np.cos(angle)))
        assert condition_number(np.vstack([BARE, one, 300 * two])) == pytest.approx(expected, rel=1e-6)


def test_nearly_dependent_planes_get_a_warning_and_no_promise(tmp_path):
    """Readings with errors of 1 %: weights are off by far more than the part that readings show."""
    rng, coefficients = np.random.default_rng(3), np.array([[0.8, 0.6], [0.84, 0.634]])
    true = np.array([5 * np.exp(-2.6j), 3 * np.exp(2.1j)])
    wrong = coefficients * (1 + 0.01 * rng.standard_normal((2, 2)))
    response = -true @ coefficients
    stacked = np.vstack([response * (1 + 0.01 * rng.standard_normal(2)), wrong])
    assert condition_number(stacked) > 30
    left = response + well_shown(stacked) @ coefficients
    assert np.linalg.norm(left) < 0.05 * np.linalg.norm(response)
    weights = [f"{{position: {place}, size: 10 g mm}}" for place in (0.1, 0.4)]
    runs = [stacked[0], stacked[0] + 10 * wrong[0], stacked[0] + 10 * wrong[1]]
    lines = [
        f"1500,{place},x,{abs(value)},{np.degrees(np.angle(value))},r{number}\n"
        for number, values in enumerate(runs)
        for place, value in zip((0.1, 0.4), values)
    ]
    (tmp_path / "job.csv").write_text(ROWS + "".join(lines))
    (tmp_path / "job.yaml").write_text(
        f"file: job.csv\nruns: [{{name: r0}}, {{name: r1, weights: [{weights[0]}]}}, {{name: r2, weights: [{weights[1]}]}}]"
    )
    found = ksmea.balance(ksmea.read_measurement(tmp_path / "job.yaml"))
    said = str(found)
    assert "Warning: the planes are nearly dependent (condition number" in said and "With them" not in said
    assert found.record.correction.condition == pytest.approx(condition_number(stacked), rel=1e-3)

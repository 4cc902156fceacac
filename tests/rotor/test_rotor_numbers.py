"""Numbers of a rotor as unknowns: the rotor that they make, against rotors made otherwise, and the slopes of its response."""

import dataclasses
import itertools

import numpy as np
import pytest

from ksmea.numerics.differences import central_differences
from ksmea.plugins import registry
from ksmea.problem.held import HeldProblem
from ksmea.problem.load import Load
from ksmea.problem.problem import Problem
from problems.rotor_file import RotorFile
from tolerant_pump import EXACT, PUMP, UNCERTAIN, pump, true_values


def rotor_file(folder, name, **changed):
    path = folder / f"{name}.yaml"
    path.write_text(PUMP.format(**EXACT | changed))
    return RotorFile(str(path)).build()


@pytest.mark.parametrize(
    ("name", "sizes", "written"),
    [
        ("steel_youngs_modulus", 1.5, {"modulus": 205 + 1.5 * 4.1}),
        ("steel_density", -2, {"density": 7690}),
        ("segment_2_outer_diameter", 3, {"diameter": 0.0576}),
        ("disk_2_mass", 2, {"mass": 9.18}),
        ("bearing_1_kxy", 1, {"cross": 0.7}),
        ("probe_position_at_0_16_m", 2, {"probe": 0.168}),
        ("direction_y_at_0_16_m", -1, {"direction": 88}),
    ],
)
def test_a_number_that_is_off_is_a_file_that_says_so(tmp_path, name, sizes, written):
    settings = pump(tmp_path, **UNCERTAIN)
    problem, x = settings.build().joint, true_values(settings, **{name: sizes})
    other = rotor_file(tmp_path, "other", **written)
    own = np.array([settings.reference()[each] for each in other.parameters.names])
    expected = other.response(own[None])[0]
    # 1e-9: a diameter in the file is rounded to 1e-12 m, and two routes of elimination
    assert np.abs(problem.response(x[None])[0] - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("name", "settings", "size", "written"),
    [
        ("youngs_modulus", {}, 0.04, {"modulus": 205 * 1.04}),
        ("mass", {}, 0.05, {"density": 7850 * 1.05, "mass": 9.45, "polar": 0.063, "diametral": 0.03465}),
        ("probe_position", {"position": 0.16}, 0.02, {"probe": 0.18}),
        ("probe_rotation", {"position": 0.16, "direction": "y"}, np.radians(8), {"direction": 98}),
    ],
)
def test_an_effect_that_is_a_wrong_number_is_a_file_that_says_so(tmp_path, name, settings, size, written):
    problem = registry.create("effect", name, settings).added_to(rotor_file(tmp_path, "plain"))
    other = rotor_file(tmp_path, "other", **written)
    own = true_values(pump(tmp_path))
    expected = other.response(own[None])[0]
    # 1e-9: matrices and elimination round otherwise
    found = problem.response(np.append(own, size)[None])[0]
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_a_gain_multiplies_what_its_probe_reads(tmp_path):
    settings = pump(tmp_path, gain="{value: 1, sd: 2 %}")
    problem = settings.build().joint
    as_stated, off = (
        problem.response(true_values(settings, **each)[None])[0] for each in ({}, {"gain_x_at_0_16_m": 3})
    )
    assert np.allclose(off[:, 0], 1.06 * as_stated[:, 0], rtol=1e-12, atol=0)
    assert np.array_equal(off[:, 1:], as_stated[:, 1:])


@pytest.mark.parametrize("moved", ["disk", "bearing"])
def test_what_moves_beside_its_node_is_there(tmp_path, moved):
    """Against a rotor whose mesh has a node at the new place: a uniform shaft, of which the place of a node changes nothing else."""

    def shaft(disk, bearing, elements=None):
        marks = [0.0, bearing["node"], disk["node"], 0.7]
        pieces = [
            f"  - {{length: {right - left:.12g}, outer_diameter: 0.045, material: steel, elements: {round(100 * (right - left))}}}"
            for left, right in itertools.pairwise(marks)
        ]
        text = PUMP.format(**EXACT)
        head, rest = text.split("shaft:\n")[0], text[text.index("speeds:") :]
        body = "\n".join(
            [
                "shaft:",
                *pieces,
                "disks:",
                f"  - {{position: {disk['text']}, mass: 9, polar_inertia: 0.06, diametral_inertia: 0.033}}",
                "bearings:",
                f"  - {{position: {bearing['text']}}}",
                "  - {position: 0.7}",
                "unbalance:",
                "  - {position: 0.33, phase: 0}",
                "",
            ]
        )
        path = tmp_path / f"{moved}{len(list(tmp_path.iterdir()))}.yaml"
        path.write_text(head + body + rest)
        return RotorFile(str(path))

    at = {"disk": 0.25, "bearing": 0.1}
    step = 0.004
    sd = {name: f"{{value: {value}, sd: {step}}}" for name, value in at.items()}
    there = {name: {"node": value, "text": value} for name, value in at.items()}
    known = shaft(**there | {moved: {"node": at[moved], "text": sd[moved]}})
    new = at[moved] + step
    other = shaft(**there | {moved: {"node": new, "text": new}}).build()
    off = {f"{moved}_1_position": 1}
    own = np.array([known.reference()[name] for name in other.parameters.names])
    expected, still = other.response(own[None])[0], known.build().response(own[None])[0]
    found = known.build().joint.response(true_values(known, **off)[None])[0]
    change = np.abs(expected - still).max()
    assert change > 1e-3 * np.abs(expected).max()  # it matters
    # 5 % of the change: inside an element of 10 mm a force misses ab/(κGAl) = 2e-11 m/N of the flexibility in shear, 2e-4 of the whole
    assert np.abs(found - expected).max() < 0.05 * change


EFFECTS = (None, "runout", "youngs_modulus", "flexible_pedestal", "probe_position", "annular_seal", "disk_position",
           "residual_bow", "bearing_position", "added_mass", "external_damping")  # fmt: skip


def joint_with(effect, folder):
    """The joint problem of the pump, with an effect at its first place or without."""
    problem = pump(folder, **UNCERTAIN).build().joint
    if effect is None:
        return problem
    return registry.create("effect", effect, {}).locations(problem)[0].added_to(problem)


@pytest.mark.parametrize("effect", EFFECTS)
def test_slopes_are_those_of_the_response(tmp_path, effect):
    """By central differences; responses to loads too, and the dense route beside."""
    problem = joint_with(effect, tmp_path)
    parameters = problem.parameters
    x = parameters.to_si(np.random.default_rng(1).uniform(0.4, 0.6, len(parameters)))
    response, slope = problem.linearised(x)
    assert np.abs(response - problem.dense_response(x[None])[0]).max() < 1e-9 * np.abs(response).max()
    steps = np.where([item.is_input for item in parameters], 1e-3, 1e-5) * parameters.width
    around = central_differences(x, steps, parameters.lower, parameters.upper)
    expected = around.derivative(problem.response(around.points))
    # 1e-4 of the largest slope of an unknown, and rounding of 1e-11 of the response: third derivatives times the step squared
    allowed = 1e-4 * np.abs(expected).max(axis=(0, 1)) + 1e-11 * np.abs(response).max() / steps
    assert np.all(np.abs(slope - expected).max(axis=(0, 1)) < allowed)
    loads = (Load(0.85, "x", "force"), Load(0.12, "y", "force"))
    columns, change = problem.linearised_per_load(x, loads)
    by_differences = Problem.linearised_per_load(problem, x, loads)
    assert np.abs(columns - by_differences[0]).max() < 1e-8 * np.abs(columns).max()
    largest = np.abs(change).max(axis=(0, 1, 2))
    assert np.all(np.abs(change - by_differences[1]).max(axis=(0, 1, 2)) < 2e-3 * largest + 1e-7 * largest.max())


def test_a_housing_probe_moves_with_its_housing(tmp_path):
    text = PUMP.format(**EXACT | UNCERTAIN).replace("{position: 0.55}", "{position: 0.55, support: {kxx: 90, kyy: 60}}")
    text = text.replace(
        "  - {position: 0.51, direction: x}",
        "  - {position: {value: 0.51, sd: 0.003}, direction: x, relative_to: bearing 2}",
    )
    text = text.replace(
        "  - {position: 0.51, direction: y}",
        "  - {position: {value: 0.51, sd: 0.003}, direction: y, relative_to: bearing 2}",
    )
    (tmp_path / "housing.yaml").write_text(text)
    settings = RotorFile(str(tmp_path / "housing.yaml"))
    problem = settings.build().joint
    x = true_values(settings, probe_position_at_0_51_m=2, direction_y_at_0_16_m=1)
    moved = dataclasses.replace(settings.build().plain.rotor)
    assert problem.physics.rotor_with(x).housing_probes[0].position == pytest.approx(0.516)
    assert moved.housing_probes[0].position == 0.51
    response, _ = problem.linearised(x)
    for other in (problem.response(x[None])[0], problem.dense_response(x[None])[0]):
        assert np.abs(response - other).max() < 1e-9 * np.abs(response).max()


@pytest.mark.parametrize(("name", "size"), [("probe_position", 0.004), ("probe_rotation", np.radians(7))])
def test_effects_on_housing_probes_are_numbers_of_them(tmp_path, name, size):
    """Probes that a housing carries are moved by an effect as by a number of the file, and still read against it."""
    text = PUMP.format(**EXACT).replace("{position: 0.55}", "{position: 0.55, support: {kxx: 90, kyy: 60}}")
    stated = [f"  - {{position: 0.51, direction: {direction}}}" for direction in "xy"]
    position, turned = (0.514, ("x", "y")) if name == "probe_position" else (0.51, (7, 97))

    def machine(position, directions):
        changed = text
        for line, direction in zip(stated, directions):
            probe = f"  - {{position: {position}, direction: {direction}, relative_to: bearing 2}}"
            changed = changed.replace(line, probe)
        (tmp_path / "housing.yaml").write_text(changed)
        return RotorFile(str(tmp_path / "housing.yaml")).build()

    plain, other = machine(0.51, ("x", "y")), machine(position, turned)
    problem = registry.create("effect", name, {"position": 0.51}).added_to(plain)
    own = true_values(pump(tmp_path))
    x = np.append(own, size)
    expected = other.response(own[None])[0]
    for response in (problem.response(x[None])[0], problem.linearised(x)[0], problem.dense_response(x[None])[0]):
        assert np.abs(response - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["probe_position", "probe_rotation"])
def test_slopes_of_moved_probes_are_those_of_the_response(tmp_path, name):
    problem = registry.create("effect", name, {"position": 0.16}).added_to(rotor_file(tmp_path, "plain"))
    parameters, x = problem.parameters, np.append(true_values(pump(tmp_path)), 0.01)
    around = central_differences(x, 1e-5 * parameters.width, parameters.lower, parameters.upper)
    expected = around.derivative(problem.response(around.points))
    allowed = 1e-4 * np.abs(expected).max(axis=(0, 1))  # third derivatives times the square of the step of the probes
    assert np.all(np.abs(problem.linearised(x)[1] - expected).max(axis=(0, 1)) < allowed)


@pytest.mark.parametrize("effect", [None, "runout", "probe_position", "added_mass", "residual_bow"])
def test_held_numbers_are_no_unknowns_and_act(tmp_path, effect):
    """By the rotor that has them, and by the joint problem at these values of them."""
    problem = joint_with(effect, tmp_path)
    parameters = problem.parameters
    x = parameters.to_si(np.random.default_rng(2).uniform(0.4, 0.6, len(parameters)))
    held, behind = problem.holding_inputs(x), HeldProblem(problem, parameters.own, x)
    assert (
        held.parameters.names == behind.parameters.names == tuple(parameters.names[index] for index in parameters.own)
    )
    for response, expected in (
        (held.response(x[None, parameters.own]), behind.response(x[None, parameters.own])),
        (held.linearised(x[parameters.own])[1], behind.linearised(x[parameters.own])[1]),
    ):
        scale = np.abs(expected).max(axis=tuple(range(expected.ndim - 1)))
        assert np.all(np.abs(response - expected) < 1e-6 * scale)  # slopes are differences over 1e-6 of each range

"""Numbers of a rotor file that are known to a tolerance: how they are written, what they become, what is refused."""

from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.problem.parameters import Prior
from problems.rotor.inputs.tolerances import TYPICAL
from tolerant_pump import UNCERTAIN, pump


def numbers(problem):
    return {item.name: item for item in problem.joint.parameters if item.is_input}


def test_a_number_has_its_value_its_deviation_and_a_name(tmp_path):
    problem = pump(tmp_path, **UNCERTAIN).build()
    found = numbers(problem)
    values = {name: item.prior.value for name, item in found.items()}
    sds = {name: item.prior.sd for name, item in found.items()}
    expected = {
        "steel_youngs_modulus": (205e9, 4.1e9),
        "steel_density": (7850.0, 80.0),
        "segment_2_outer_diameter": (0.057, 0.0002),
        "disk_2_position": (0.85, 0.003),
        "disk_2_mass": (9.0, 0.09),
        "bearing_1_position": (0.12, 0.002),
        "bearing_1_kxy": (0.5e6, 0.2e6),
        "probe_position_at_0_16_m": (0.16, 0.004),
        "gain_x_at_0_16_m": (1.0, 0.02),
        "direction_y_at_0_16_m": (np.pi / 2, 2 * np.pi / 180),
    }
    assert values == pytest.approx({name: value for name, (value, _) in expected.items()})
    assert sds == pytest.approx({name: sd for name, (_, sd) in expected.items()})
    assert found["disk_2_mass"].words == "mass of disk 2" and found["steel_density"].words == "density of steel"
    assert problem.parameters.names == ("k1", "k2", "c", "u")  # what a search sees


def test_exact_numbers_are_as_they_were_to_the_last_bit(tmp_path):
    exact, known = pump(tmp_path).build(), pump(tmp_path, **UNCERTAIN).build()
    none = pump(
        tmp_path, **{name: text.replace("sd: 2 %", "sd: 0") for name, text in UNCERTAIN.items() if "2 %" in text}
    )
    assert exact.joint is exact and numbers(none.build()) == {}
    x = exact.parameters.to_si(np.random.default_rng(0).random((5, 4)))
    assert np.array_equal(exact.response(x), known.response(x)) and np.array_equal(
        exact.response(x), none.build().response(x)
    )
    for one, other in zip(exact.linearised(x[0]), known.linearised(x[0])):
        assert np.array_equal(one, other)


def test_as_stated_the_joint_problem_is_the_problem(tmp_path):
    problem = pump(tmp_path, **UNCERTAIN).build()
    joint = problem.joint
    own = problem.parameters.to_si(np.full(4, 0.3))
    known = dict(zip(problem.parameters.names, own))
    x = np.array([known.get(item.name, item.stated) for item in joint.parameters])
    # 1e-12: two routes of elimination
    assert np.abs(joint.response(x[None]) / problem.response(own[None]) - 1).max() < 1e-11


def test_a_density_moves_rings_of_the_material_too(tmp_path):
    joint = pump(tmp_path, density="{value: 7850, sd: 1 %}").build().joint
    light, heavy = (joint.physics.rotor_with(np.append(joint.plain.parameters.lower, rho)) for rho in (7850.0, 8635.0))
    assert heavy.disks[0].mass == pytest.approx(1.1 * light.disks[0].mass, rel=1e-12)
    assert heavy.disks[1].mass == light.disks[1].mass == 9.0
    assert heavy.segments[1].mass == pytest.approx(1.1 * light.segments[1].mass, rel=1e-12)


def test_typical_tolerances_are_given_to_all_that_state_none(tmp_path):
    own = {"mass": "{value: 9.0, sd: 3 %}", "gain": "{value: 1, sd: 0}"}
    problem = pump(tmp_path, more="tolerances: typical", **own).build()
    found = numbers(problem)
    assert found["disk_2_mass"].prior.sd == pytest.approx(0.27)
    assert found["steel_youngs_modulus"].prior.sd == pytest.approx(TYPICAL.young_modulus * 205e9)
    assert "gain_x_at_0_16_m" not in found and found["gain_x_at_0_51_m"].prior.sd == TYPICAL.gain
    assert {"probe_position_at_0_16_m", "probe_position_at_0_51_m", "disk_1_mass", "disk_1_inertia"} <= set(found)
    wider = pump(tmp_path, more="tolerances: {gain: 5 %, probe_position: 0.01, direction: 0}").build()
    sds = {name: item.prior.sd for name, item in numbers(wider).items()}
    assert (sds["gain_x_at_0_51_m"], sds["probe_position_at_0_51_m"]) == (0.05, 0.01)
    assert not any(name.startswith("direction") for name in sds)


def test_limits_make_a_number_unknown(tmp_path):
    problem = pump(
        tmp_path, modulus="{value: 205, lower: 180, upper: 220}", cross="{value: 1, lower: 0, upper: 5}"
    ).build()
    assert set(problem.parameters.names) == {"k1", "k2", "c", "u", "bearing_1_kxy", "steel_youngs_modulus"}
    assert problem.joint is problem and not len(problem.parameters.with_prior)
    stiff, soft = (np.append(problem.parameters.lower[:-1], modulus) for modulus in (220e9, 180e9))
    assert np.abs(problem.response(stiff[None]) - problem.response(soft[None])).max() > 0
    both = pump(tmp_path, modulus="{value: 205, sd: 4, lower: 180, upper: 220}").build()
    assert both.parameters.items[-1].prior == Prior(205e9, 4e9) and not both.parameters.items[-1].is_input


def test_an_unknown_may_have_a_prior(tmp_path):
    settings = pump(tmp_path)
    text = Path(settings.file).read_text().replace("reference: 10,", "reference: 10, value: 10, sd: 20 %,")
    (tmp_path / "prior.yaml").write_text(text)
    problem = type(settings)(str(tmp_path / "prior.yaml")).build()
    assert problem.parameters.items[2].prior == Prior(1e4, 2e3)


def test_a_rotor_that_turns_the_other_way_has_the_mirrored_numbers(tmp_path):
    """With y reversed in all that the file says, it is the same machine."""
    one = pump(tmp_path, cross="{value: 0.5, sd: 0.2}", direction="{value: 60, sd: 2}").build().joint
    other = pump(
        tmp_path, cross="{value: -0.5, sd: 0.2}", direction="{value: -60, sd: 2}", more="rotation: y to x"
    ).build()
    other = other.joint
    assert other.channels[1] == one.channels[1]
    names = other.parameters.names
    assert [name.replace("-60", "60") for name in names] == list(one.parameters.names)
    u = np.linspace(0.3, 0.6, len(names))
    x, mirrored = one.parameters.to_si(u), other.parameters.to_si(u)
    for index, item in enumerate(other.parameters):
        if item.prior is not None and np.sign(item.prior.value) != np.sign(one.parameters.items[index].prior.value):
            mirrored[index] = -x[index]
    # amplitudes: y at 0.51 m is read the other way
    assert np.allclose(np.abs(other.response(mirrored[None])), np.abs(one.response(x[None])), rtol=1e-10, atol=0)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"mass": "{value: 9, sd: -1}"}, r"disks\[2\].mass.sd: expected a number at least 0, got -1"),
        ({"mass": "{value: 9, sd: 1 kg}"}, r"disks\[2\].mass.sd: expected a number, or per cent such as '2 %'"),
        ({"mass": "{value: 9}"}, r"disks\[2\].mass.sd: expected a standard deviation, or lower and upper limits"),
        ({"mass": "{value: 9, sd: 1, upper: 4, lower: 2}"}, r"disks\[2\].mass.value: expected a number"),
        ({"mass": "{value: 9, sds: 1}"}, r"disks\[2\].mass: unknown key 'sds'; did you mean 'sd'?"),
        (
            {"gain": "{value: 1.1, sd: 2 %}"},
            r"probes\[1\].gain: expected 1, or its tolerance; divide the measured values",
        ),
        ({"gain": "1.1"}, r"probes\[1\].gain: expected 1, or its tolerance"),
        ({"more": "tolerances: usual"}, "tolerances"),
        ({"more": "tolerances: {gains: 2 %}"}, "unknown tolerance 'gains'; did you mean 'gain'?"),
    ],
)
def test_a_slip_is_named_with_its_place(tmp_path, changed, message):
    with pytest.raises(SettingError, match=message):
        pump(tmp_path, **changed).build()


def test_a_number_that_cannot_be_uncertain_is_refused(tmp_path):
    settings = pump(tmp_path)
    text = Path(settings.file).read_text().replace("length: 0.12,", "length: {value: 0.12, sd: 0.001},")
    (tmp_path / "length.yaml").write_text(text)
    with pytest.raises(SettingError, match=r"shaft\[1\].length: expected a plain number, since length cannot have"):
        type(settings)(str(tmp_path / "length.yaml")).build()


def test_a_number_that_is_searched_has_no_typical_tolerance_too(tmp_path):
    searched = {"modulus": "{value: 205, sd: 4, lower: 180, upper: 220}", "gain": "{value: 1, lower: 0.9, upper: 1.1}"}
    names = pump(tmp_path, more="tolerances: typical", **searched).build().joint.parameters.names
    assert [name for name in names if "youngs_modulus" in name or name.startswith("gain_x_at_0_16")] == [
        "steel_youngs_modulus",
        "gain_x_at_0_16_m",
    ]

"""The cause that a diagnosis names first, where numbers of the rotor file are known to a tolerance."""

from types import SimpleNamespace

import pytest

from bench.reports.diagnosis.first_names import EFFECT_OF_NUMBER, first_names
from ksmea import load_problem
from ksmea.plugins import registry
from ksmea.records.inputs import InputRecord


def record(*inputs, explanations=()):
    return SimpleNamespace(inputs=inputs, explanations=explanations)


def explanation(*names):
    return SimpleNamespace(effects=[SimpleNamespace(name=name) for name in names])


def pulled(name, pull, is_contradicted=True):
    return InputRecord(name, name, "×", 1.0, 1.0, 0.02, 1.1, 0.01, pull, is_contradicted)


def test_an_explanation_goes_before_a_pull():
    found = record(
        pulled("steel_density", 9.0), explanations=[explanation("runout", "channel_gain"), explanation("mass")]
    )
    assert first_names(found) == ("channel_gain", "runout")


@pytest.mark.parametrize(
    ("name", "effect"),
    [
        ("gain_45_at_0_1_m", "channel_gain"),
        ("plane_gain_at_0_16_m", "channel_gain"),
        ("direction_135_at_0_1_m", "probe_rotation"),
        ("probe_position_at_0_78_m", "probe_position"),
        ("steel_youngs_modulus", "youngs_modulus"),
        ("disk_2_mass", "disk_mass"),
        ("segment_2_outer_diameter", "segment_2_outer_diameter"),  # of no effect
    ],
)
def test_the_largest_contradicted_pull_counts_whatever_its_sign(name, effect):
    assert first_names(record(pulled("steel_density", 3.9), pulled(name, -4.2), pulled("x", 5.0, False))) == (effect,)


def test_nothing_is_named_where_no_number_is_contradicted():
    assert first_names(record(pulled("disk_1_mass", 2.0, False))) == ()


def test_every_typical_number_is_an_effect_of_the_library():
    joint = load_problem("rotor", file="docs/examples/rig.yaml", tolerances="typical").problem.joint
    numbers = [item.name for item in joint.parameters if item.is_input]
    assert len(numbers) == 16
    found = {first_names(record(pulled(name, 4.0)))[0] for name in numbers}
    assert found <= set(registry.registered("effect")) and found <= {effect for _, effect in EFFECT_OF_NUMBER}

"""Run-ups that another finite-element program has made, each with one thing that the model lacks: does the diagnosis name it?

They take ROSS (the extra `peers`), in this environment or in one of its own whose interpreter `ROSS_PYTHON` names:

    ROSS_PYTHON=/path/to/python python -m pytest tests/test_peer_data.py

A run-up takes 53 speeds through four critical speeds, with 5 % noise and a floor of 0.1 µm that the diagnosis is not told, nor
where phases begin. A diagnosis with the whole library takes half a minute. Sweeps are left out, since ROSS integrates an hour for each.
"""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ksmea
from ksmea.plugins import registry

HELPERS = Path(__file__).parent / "helpers"
PYTHON = os.environ.get("ROSS_PYTHON") or (sys.executable if importlib.util.find_spec("ross") else None)
pytestmark = pytest.mark.skipif(
    PYTHON is None, reason="ROSS is not here: install the extra `peers`, or name its ROSS_PYTHON"
)

HIDDEN = {  # what the script hides, in the units of the unknowns; angles count from the phase origin, 0.6 rad
    "added_mass": {"added_mass": 4.0},
    "axial_force": {"axial_force": 300.0},
    "channel_gain": {"channel_gain": 15.0},
    "cross_coupling_antisymmetric": {"kxy_antisymmetric": 0.2},
    "cross_coupling_symmetric": {"kxy_symmetric": 2.0},
    "external_damping": {"external_damping": 5.0 * 7800 * np.pi * 0.05**2},
    "flexible_pedestal": {
        "pedestal_compliance_x": 1 / 0.15,
        "pedestal_compliance_y": 1 / 0.2,
        "pedestal_mass": 30.0,
        "pedestal_loss_factor": 2.0,
    },
    "hub_stiffening": {"hub_stiffening": 100 * (1.3**4 - 1)},
    "mass": {"mass_change": 2.0},
    "probe_rotation": {"probe_rotation": np.degrees(0.2)},
    "residual_bow": {"bow_x": 5 * np.cos(1.1), "bow_y": 5 * np.sin(1.1)},
    "runout": {"runout_x": 1.5 * np.cos(1.4), "runout_y": 1.5 * np.sin(1.4)},
    "shear_theory": {"shear_flexibility_change": -100.0},
    "speed_dependent_damping": {"damping_slope": 300.0},
    "speed_dependent_stiffness": {"stiffness_slope": 20.0},
    "timing_delay": {"timing_delay": 200.0},
    "unbalance": {"unbalance_x": 80 * np.cos(1.5), "unbalance_y": 80 * np.sin(1.5)},
    # 60 and 60 MN/m beside 40 and 80: bearing 1 against 2, or 2 against 1
    "unequal_bearings": {"stiffness_difference_x": (50.0, -100 / 3), "stiffness_difference_y": (-25.0, 100 / 3)},
    "youngs_modulus": {"youngs_modulus_change": 3.0},
}


MACHINES = ("pump", "turbine", "rig")  # of other kinds
# What is hidden in them, by machine; nothing where a shape decides the size, or it is of either bearing
HIDDEN_IN_MACHINES = {
    "added_mass": {"added_mass": (0.8, 4.0, 0.06)},
    "channel_gain": {"channel_gain": (15.0,) * 3},
    "cross_coupling_antisymmetric": {"kxy_antisymmetric": (3.0, 4.0, 0.03)},
    "flexible_pedestal": {"pedestal_mass": (100.0, 150.0, 2.5)},
    "probe_position": {"probe_position_change": (40.0, 60.0, 20.0)},
    "residual_bow": {},
    "runout": {"runout_x": tuple(size / 3 * np.cos(1.4) for size in (10.0, 12.0, 20.0))},
    "speed_dependent_stiffness": {"stiffness_slope": (30.0,) * 3},
    "unbalance": {"unbalance_x": tuple(size * np.cos(1.5) for size in (50.0, 400.0, 10.0))},
    "unequal_bearings": {},
}


def made_by(script, folder):
    """The folder with a file for each cause."""
    words = [str(PYTHON), str(HELPERS / script), str(folder)]
    made = subprocess.run(words, check=False, capture_output=True, text=True, timeout=900)
    assert made.returncode == 0, made.stderr[-2000:]
    return folder


@pytest.fixture(scope="module")
def run_ups(tmp_path_factory):
    return made_by("run_ups_by_ross.py", tmp_path_factory.mktemp("run_ups"))


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    return made_by("machines_by_ross.py", tmp_path_factory.mktemp("machines"))


def diagnosed(folder, name):
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    return ksmea.diagnose(rotor, ksmea.read_measurement(folder / f"{name}.csv"), locate=False)


def test_a_right_model_explains_the_data_of_another_program(run_ups):
    found = diagnosed(run_ups, "none")
    assert found.verdict == "adequate"


@pytest.mark.parametrize("name", list(HIDDEN))
def test_what_another_program_hides_is_in_the_reported_set(run_ups, name):
    if name not in registry.registered("effect"):
        pytest.skip(f"no effect is called {name}")
    found = diagnosed(run_ups, name)
    require_reported(found, name, HIDDEN[name])


def require_reported(found, name, sizes):
    assert found.verdict in ("named", "ambiguous")
    assert name in found.record.ambiguity_group, str(found)
    if found.named == (name,):
        table = found.coefficients().set_index("unknown")
        for unknown, value in sizes.items():
            low, size, high = table.loc[unknown, ["after_low", "after", "after_high"]]
            # 95 % intervals, widened to twice their half-width; NaN is no end
            outside = [
                each < size - 2 * (size - low) or each > size + 2 * (high - size) for each in np.atleast_1d(value)
            ]
            assert not all(outside), f"{unknown} {size}"


@pytest.mark.parametrize("machine", MACHINES)
def test_a_right_model_of_a_machine_explains_its_data(machines, machine):
    assert diagnosed_machine(machines, machine, "none").verdict == "adequate"


@pytest.mark.parametrize("name", list(HIDDEN_IN_MACHINES))
@pytest.mark.parametrize("machine", MACHINES)
def test_what_is_hidden_in_a_machine_is_in_the_reported_set(machines, machine, name):
    place = MACHINES.index(machine)
    sizes = {unknown: values[place] for unknown, values in HIDDEN_IN_MACHINES[name].items()}
    require_reported(diagnosed_machine(machines, machine, name), name, sizes)


def diagnosed_machine(folder, machine, name):
    rotor = ksmea.load_problem(folder / f"{machine}.yaml")
    return ksmea.diagnose(rotor, ksmea.read_measurement(folder / f"{machine}_{name}.csv"), locate=False)

"""Run-ups that another finite-element program has made, each with one thing that the model lacks: does the diagnosis name it?

They take ROSS (the extra `peers`), in this environment or in one of its own whose interpreter `ROSS_PYTHON` names:

    ROSS_PYTHON=/path/to/python python -m pytest tests/test_peer_data.py

A run-up takes 53 speeds through four critical speeds, with 5 % noise and a floor of 0.1 µm that the diagnosis is not told, nor
where phases begin. Sweeps are left out, since ROSS integrates an hour for each.
"""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

import ksmea
from ksmea import registry

SCRIPT = Path(__file__).parent / "helpers" / "run_ups_by_ross.py"
PYTHON = os.environ.get("ROSS_PYTHON") or (sys.executable if importlib.util.find_spec("ross") else None)
pytestmark = pytest.mark.skipif(
    PYTHON is None, reason="ROSS is not here: install the extra `peers`, or name its ROSS_PYTHON"
)

HIDDEN = (
    "added_mass",
    "axial_force",
    "channel_gain",
    "cross_coupling_antisymmetric",
    "cross_coupling_symmetric",
    "external_damping",
    "flexible_pedestal",
    "hub_stiffening",
    "mass",
    "probe_rotation",
    "residual_bow",
    "runout",
    "shear_theory",
    "speed_dependent_damping",
    "speed_dependent_stiffness",
    "timing_delay",
    "unbalance",
    "unequal_bearings",
    "youngs_modulus",
)


@pytest.fixture(scope="module")
def run_ups(tmp_path_factory):
    """The folder with a file for each cause."""
    folder = tmp_path_factory.mktemp("run_ups")
    words = [str(PYTHON), str(SCRIPT), str(folder)]
    made = subprocess.run(words, check=False, capture_output=True, text=True, timeout=900)
    assert made.returncode == 0, made.stderr[-2000:]
    return folder


def diagnosed(folder, name):
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    return ksmea.diagnose(rotor, ksmea.read_measurement(folder / f"{name}.csv"), locate=False)


def test_a_right_model_explains_the_data_of_another_program(run_ups):
    found = diagnosed(run_ups, "none")
    assert found.verdict == "adequate"


@pytest.mark.parametrize("name", HIDDEN)
def test_what_another_program_hides_is_in_the_reported_set(run_ups, name):
    if name not in registry.registered("effect"):
        pytest.skip(f"no effect is called {name}")
    found = diagnosed(run_ups, name)
    assert found.verdict in ("named", "ambiguous")
    assert name in found.record.ambiguity_group, str(found)

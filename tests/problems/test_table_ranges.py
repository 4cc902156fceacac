"""Where a table of a bearing ends before the speeds, its last values are taken, and whatever is reported of the model says so."""

import numpy as np
import pytest

import ksmea
from problems.rotor_file import RotorFile

ROTOR = """\
units: {length: mm, modulus: GPa, density: g/cm3, mass: kg, inertia: kg m2, stiffness: MN/m, damping: kN s/m, unbalance: g mm,
        angle: deg, speed: rpm}
materials:
  steel: {young_modulus: 210, density: 7.85, poisson_ratio: 0.3}
shaft:
  - {length: 300, outer_diameter: 40, material: steel, elements: 3}
  - {length: 300, outer_diameter: 40, material: steel, elements: 3}
disks:
  - {position: 300, mass: 8, polar_inertia: 0.06, diametral_inertia: 0.035}
bearings:
  - {position: 0, table: {speed: [1000, 3000], kxx: [9, 12], kyy: [8, 11], cxx: [5, 4], cyy: [5, 4]}}
  - {position: 600, table: {speed: [1000, 3000], kxx: [9, 12], kyy: [8, 11], cxx: [5, 4], cyy: [5, 4]}}
seals:
  - {position: 300, table: {speed: [SEAL, 4000], kxx: [1, 2]}, }
unbalance:
  - {position: 300, phase: 0}
speeds: {from: 1000, to: 4000, number: 16}
probes:
  - {position: 100, direction: x}
  - {position: 100, direction: y}
  - {position: 500, direction: x}
  - {position: 500, direction: y}
unknowns:
  - {name: factor, lower: 0.5, upper: 2, reference: 1, sets: [bearing 1 stiffness factor, bearing 2 stiffness factor]}
  - {name: u, lower: 10, upper: 500, reference: 100, sets: [unbalance 1 magnitude]}
"""
SAID = (
    "bearing 1, bearing 2: the table from 1000 to 3000 rpm does not reach all speeds, 1000 to 4000 rpm; its values at the nearest end are"
    " taken there"
)


@pytest.fixture
def loaded(tmp_path):
    (tmp_path / "rotor.yaml").write_text(ROTOR.replace("SEAL", "900"))
    return ksmea.load_problem(str(tmp_path / "rotor.yaml"))


def test_each_range_is_named_once_with_all_that_have_it(loaded, tmp_path):
    problem = loaded.problem
    assert problem.remarks_at(problem.speed) == (SAID,)
    assert problem.remarks_at(problem.speed[:5]) == ()
    (tmp_path / "short.yaml").write_text(ROTOR.replace("SEAL", "1500"))
    short = RotorFile(file=str(tmp_path / "short.yaml")).build()
    assert len(said := short.remarks_at(short.speed)) == 2 and said[1].startswith(
        "seal 1: the table from 1500 to 4000 rpm"
    )


def test_beyond_its_table_a_bearing_keeps_the_last_values(loaded):
    bearing = loaded.problem.rotor_at(np.array([1.0, 1e-4])).bearings[0]
    stiffness = bearing.matrices_at(2 * np.pi / 60 * np.array([10.0, 1000.0, 3000.0, 9000.0]))[0]
    assert stiffness[:, 0, 0] == pytest.approx([9e6, 9e6, 12e6, 12e6])


def test_all_that_is_reported_says_so(loaded):
    data = ksmea.synthetic_measurement(loaded, relative=0.02, floor=0.01, kind="complex")
    assert f"note: {SAID}" in str(ksmea.identify(loaded, data))
    assert f"note: {SAID}" in str(ksmea.identifiability(loaded, relative=0.02, variations=[]))
    assert "note: bearing 1, bearing 2: the table from" in str(
        ksmea.plan(loaded, relative=0.02, add=1, sensors=0, trial_phases=[])
    )
    assert f"Note: {SAID}" in str(ksmea.diagnose(loaded, data, effects=["runout"]))
    assert f"Note: {SAID}" in str(ksmea.locate(loaded, data, positions=[0.3], kinds=["force"]))


def test_a_drawing_says_so(loaded):
    """Its speeds begin at rest."""
    assert "bearing 1, bearing 2: the table from 1000 to 3000 rpm does not reach all speeds" in str(loaded.draw())

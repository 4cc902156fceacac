"""A rotor in US units is the rotor in SI: sizes of units by their definitions, and one machine written twice."""

import numpy as np
import pytest

from ksmea.units import SI_PER_UNIT
from problems.rotor_file import RotorFile

# As handbooks print them, to their digits: the inch is 0.0254 m, the pound 0.45359237 kg, standard gravity 9.80665 m/s²
PRINTED = {
    ("length", "ft"): 0.3048,
    ("length", "mil"): 2.54e-5,
    ("modulus", "psi"): 6894.757,
    ("modulus", "ksi"): 6.894757e6,
    ("density", "lb/in3"): 27679.905,
    ("mass", "lbf s2/in"): 175.12684,
    ("inertia", "lb in2"): 2.926397e-4,
    ("stiffness", "lbf/in"): 175.12684,
    ("damping", "lbf s/in"): 175.12684,
    ("angular_stiffness", "lbf in/rad"): 0.11298483,
    ("force", "lbf"): 4.4482216,
    ("unbalance", "oz in"): 7.2007789e-4,
}

ROTOR = """\
units: {{length: {length}, modulus: {modulus}, density: {density}, mass: {mass}, inertia: {inertia}, stiffness: {stiffness},
        damping: {damping}, unbalance: {unbalance}, angle: deg, speed: rpm}}
materials:
  steel: {{young_modulus: {E}, density: {rho}, poisson_ratio: 0.29}}
shaft:
  - {{length: {half}, outer_diameter: {thick}, material: steel, elements: 4}}
  - {{length: {half}, outer_diameter: {thick}, outer_diameter_right: {thin}, material: steel, elements: 4}}
disks:
  - {{position: {half}, mass: {m}, polar_inertia: {Ip}, diametral_inertia: {Id}}}
bearings:
  - {{position: 0, kxx: {k}, kyy: {k}, cxx: {c}, cyy: {c}, mxx: {m}}}
  - {{position: {whole}, kyy: {k}, cxx: {c}, cyy: {c}}}
unbalance:
  - {{position: {half}, magnitude: {u}, phase: 0}}
speeds: {{from: 600, to: 6000, number: 7}}
probes:
  - {{position: {half}, direction: x}}
unknowns:
  - {{name: k, lower: {low}, upper: {high}, sets: [bearing 2 kxx]}}
"""
QUANTITIES = {
    **dict.fromkeys(("half", "whole", "thick", "thin"), "length"),
    "E": "modulus", "rho": "density", "m": "mass", "Ip": "inertia", "Id": "inertia", "c": "damping", "u": "unbalance",
    **dict.fromkeys(("k", "low", "high"), "stiffness"),
}  # fmt: skip
SIZES = {
    "half": 0.3, "whole": 0.6, "thick": 0.05, "thin": 0.04, "E": 2.06e11, "rho": 7840.0, "m": 9.0, "Ip": 0.05, "Id": 0.03,
    "k": 2e7, "c": 4e3, "u": 1e-4, "low": 1e6, "high": 1e8,
}  # fmt: skip
US = {
    "length": "in", "modulus": "psi", "density": "lb/in3", "mass": "lb", "inertia": "lb in2", "stiffness": "lbf/in",
    "damping": "lbf s/in", "unbalance": "oz in",
}  # fmt: skip


@pytest.mark.parametrize(("quantity", "unit"), PRINTED)
def test_a_unit_has_its_printed_size(quantity, unit):
    assert SI_PER_UNIT[quantity][unit] == pytest.approx(
        PRINTED[quantity, unit], rel=2e-7
    )  # half of the last of seven printed digits


def test_a_machine_in_us_units_moves_as_in_si(tmp_path):
    first = {quantity: next(iter(SI_PER_UNIT[quantity])) for quantity in US}  # of each quantity the SI unit
    responses = []
    for units in (first, US):
        sizes = {
            name: repr(size / SI_PER_UNIT[QUANTITIES[name]][units[QUANTITIES[name]]]) for name, size in SIZES.items()
        }
        (tmp_path / "rotor.yaml").write_text(ROTOR.format(**units, **sizes))
        responses.append(RotorFile(file=str(tmp_path / "rotor.yaml")).build().response(np.array([[3e7]])))
    np.testing.assert_allclose(*responses, rtol=1e-10)  # rounding of the units, times the condition near resonance

"""Every kind of segment and link in a machine, against a route of its own (`tests/helpers/second_elements.py`)."""

import dataclasses

import numpy as np
import pytest

from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter
from problems.rotor.finite_elements.bearing import Bearing, Pedestal, SpeedTable
from problems.rotor.finite_elements.data import HousingProbe, Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, Layer, Material, ShaftSegment
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Unknown
from tests.helpers.second_elements import response
from tiers import mostly_slow

STEEL, BRONZE = Material(2.1e11, 7850.0, 0.3), Material(1.1e11, 8800.0, 0.34)
SLEEVE = Material(6895.0, 7850.0, 0.3)
SPEED = np.linspace(80.0, 700.0, 6)
CHANNELS = (Channel(0.1, "x"), Channel(0.1, "y"), Channel(0.9, "x"), Channel(0.9, "y"))
N_ELEMENT, N_STEP = 8, 12


def machine(seed, **changes):
    """0.3 m, 0.2 m of the kind in question, 0.5 m: a tabulated bearing on a pedestal, one on the ground, a seal with mass."""
    rng = np.random.default_rng(seed)

    def about(value):
        return value * rng.uniform(0.8, 1.25)

    rows = np.array([2e7, 2e6, -2e6, 3e7, 2e4, 5e2, 5e2, 2e4, 4.0, 0.0, 0.0, 4.0]) * rng.uniform(0.7, 1.4, (4, 12))
    table = SpeedTable((100.0, 300.0, 500.0, 650.0), tuple(map(tuple, rows.tolist())))
    support = Pedestal(
        kxx=about(6e7), kxy=2e6, kyx=1e6, kyy=about(4e7), cxx=3e3, cyy=2e3, mxx=12.0, myy=15.0, loss_factor=0.03
    )
    middle = changes.pop("middle", ShaftSegment(0.2, 0.04, STEEL, N_ELEMENT))
    given = {
        "segments": (ShaftSegment(0.3, 0.04, STEEL, N_ELEMENT * 3 // 2), middle, ShaftSegment(0.5, 0.035, STEEL, 2 * N_ELEMENT + 4)),
        "disks": (Disk(0.3, about(20.0), 0.3, 0.17), Disk(0.75, about(12.0), 0.1, 0.06)),
        "bearings": (
            Bearing(0.0, table=table, pedestal=support),
            Bearing(1.0, kxx=about(3e7), kxy=2e6, kyx=-2e6, kyy=about(2e7), cxx=2e4, cyy=1e4),
        ),
        "seals": (Bearing(0.6, kxx=1e6, kxy=5e5, kyx=-5e5, kyy=1e6, cxx=2e3, cyy=2e3, mxx=3.0, myy=2.0),),
        "unbalance": (UnbalancePlane(0.3, 2e-4), UnbalancePlane(0.75, 1e-4, 0.7)),
        "housing_probes": (HousingProbe(0.1, "y", 0),),
    }  # fmt: skip
    return Rotor(**{**given, **changes})


def shaft(**changes):
    return {"middle": ShaftSegment(0.2, 0.04, STEEL, N_ELEMENT, **changes)}


THICK = ShaftSegment(0.2, 0.15, STEEL, N_ELEMENT)
CONE = {"outer_radius_right": 0.025, "inner_radius": 0.01, "inner_radius_right": 0.005}
COUPLING = CouplingSegment(
    0.2, (4e7, 5e7), (3e5, 2e5), (400.0, 300.0), (30.0, 40.0), (3.0, 5.0), (0.02, 0.03), (0.012, 0.017)
)
LAYERS = (Layer(0.055, BRONZE, 0.04, outer_radius_right=0.045), Layer(0.07, SLEEVE, 0.055))
CASES = {
    "cylinder": shaft(),
    "cone": shaft(**CONE),
    "layers": shaft(layers=LAYERS),
    "mass and stiffness alone": shaft(
        layers=(Layer(0.05, STEEL, 0.04, carries="mass"), Layer(0.045, BRONZE, 0.04, carries="stiffness"))
    ),
    "stiffness diameter": shaft(stiffness_outer_radius=0.03),
    "shear coefficient": {"middle": dataclasses.replace(THICK, shear_coefficient=0.1)},
    "no inertia of rotation": {"middle": dataclasses.replace(THICK, rotary_inertia=False)},
    "no gyroscopic moment": {"middle": dataclasses.replace(THICK, gyroscopic=False)},
    "tension of a segment": shaft(axial_force=3e6),
    "compression of the shaft": {"axial_force": -4e5, **shaft(**CONE)},
    "turning damping of a segment": shaft(internal_damping=2e-3),
    "turning damping of the shaft": {"internal_damping": 1e-4},
    "standing damping": shaft(standing_damping=(30.0, 1e-4), **CONE),
    "lumped masses": {"masses": (Disk(0.4, 6.0, 0.04, 0.03, is_lumped=True), Disk(0.5, 0.0, 0.02, 0.0, is_lumped=True))},
    "coupling": {"middle": COUPLING},
}  # fmt: skip


@pytest.mark.parametrize("seed", mostly_slow([1, 2], but=[1]))
@pytest.mark.parametrize("name", CASES)
def test_response_is_that_of_many_linear_steps(name, seed):
    """Both meshes err with the square of their lengths: of the first machine by 1.1e-4 of a channel's largest motion at most, and 8.4e-4 where layers share
    the motion of the rotor's own nodes alone, but of all steps here."""
    rotor = machine(seed, **CASES[name])
    unknown = Unknown(Parameter("kxx", "N/m", 1.0, 1e6, 1e9), (BearingTarget(1, "kxx"),))
    value = 2.7e7
    bearing = dataclasses.replace(rotor.bearings[1], kxx=value)
    own = dataclasses.replace(rotor, bearings=(rotor.bearings[0], bearing))
    found = RotorProblem(rotor, (unknown,), SPEED, CHANNELS).response(np.array([[value]]))[0]
    expected = response(own, SPEED, CHANNELS, N_STEP)
    tolerance = 2e-3 if name == "layers" else 3e-4
    assert np.max(np.abs(found - expected) / np.abs(expected).max(axis=0)) < tolerance

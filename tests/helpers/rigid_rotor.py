"""A rotor whose stability is known in closed form, as a problem with one unknown."""

import dataclasses

import numpy as np

from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Unknown

STIFFNESS, DAMPING = 1e6, 300.0  # N/m, N s/m of each bearing
MASS = 20.0  # kg
NATURAL = np.sqrt(2 * STIFFNESS / MASS)  # rad/s, of its bounce


def rigid_rotor(damping=DAMPING):
    """A disk in the middle of a rigid shaft without mass on two equal bearings.

    2k and 2c on the mass alone, as the disk is so narrow that its tilting is far above.
    """
    light = Material(young_modulus=2e14, density=1e-3, poisson_ratio=0.3)
    half = ShaftSegment(0.3, 0.05, light, 2)
    bearings = tuple(Bearing(z, kxx=STIFFNESS, kyy=STIFFNESS, cxx=damping, cyy=damping) for z in (0.0, 0.6))
    return Rotor((half, half), (Disk(0.3, MASS, polar_inertia=0.01, diametral_inertia=0.02),), bearings)


def problem_of(rotor, speed):
    """Rotor with unknown unbalance on its first disk and unknown kxx of its first two bearings."""
    stiffness = rotor.bearings[0].kxx
    targets = tuple(BearingTarget(index, name) for index in (0, 1) for name in ("kxx", "kyy"))
    unknown = Unknown(Parameter("kxx", "N/m", 1.0, 0.5 * stiffness, 2 * stiffness), targets)
    rotor = dataclasses.replace(rotor, unbalance=(UnbalancePlane(rotor.disks[0].position, 1e-4),))
    return RotorProblem(rotor, (unknown,), np.atleast_1d(speed).astype(float), (Channel(0.0, "x"), Channel(0.0, "y")))

"""Data that hide effects: made on a finer mesh by the dense solver, another route than the model that is fitted."""

import dataclasses

import numpy as np
import pytest

from ksmea.fits.search import Effort
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins import registry
from ksmea.studies.library import library
from measurements.hidden_size import drawn_size
from problems.three_disk import ThreeDisk

SENSORS = [0.1, 0.2, 0.5]  # the second node and two disks
TRUTH = {"kxx": 50e6, "kyy": 70e6, "cxx": 500.0, "cyy": 700.0, "u": 2e-4, "phase_origin": 0.6}
NOISE = Noise(0.07, 1e-7)


# Options of a diagnosis whose effect stands out
FEW_STARTS = {
    "locate": False,
    "split": False,
    "screening": 512,
    "starts": 4,
    "scan": 64,
    "scan_values": 8,
    "effect_starts": 3,
}
# neither averages nor a further measurement, which come after the verdict and take half of the time
VERDICT = Effort(average=False, split=False)
# at most half of the default
LESS = dataclasses.replace(VERDICT, screening=1024, starts=6, scan=64, scan_values=8, effect_starts=3)
STEADY = Measurement(np.ones(1), (Channel(0.1, "x"),), np.ones((1, 1), dtype=complex), None, "one run at 1X")


COMMON = (  # an effect of each kind of hook, and what looks like it: all effects take a diagnosis twice as long
    "channel_gain", "cross_coupling_antisymmetric", "cross_coupling_symmetric", "flexible_pedestal", "internal_damping",
    "mass", "probe_rotation", "residual_bow", "runout", "speed_dependent_damping", "speed_dependent_stiffness",
    "unbalance", "unequal_bearings", "youngs_modulus",
)  # fmt: skip


def registered_effects(*without):
    """Effects of a diagnosis of steady data at 1X without names."""
    return library((), without, STEADY)[0]


def common_effects(*without):
    """A library that is large enough for effects to look alike in, and small enough for tests."""
    return library(COMMON, without)[0]


@pytest.fixture(scope="session")
def rotor():
    """The baseline model that data are fitted with."""
    return ThreeDisk(sensors=SENSORS).build().with_phase_origin()


@pytest.fixture(scope="session")
def hide():
    """A measurement with an effect (or none) whose location and size the seed draws, of a stable rotor; what was hidden, for the test alone."""
    fine = ThreeDisk(mesh=26, sensors=SENSORS).build().with_phase_origin()
    truth = np.array([TRUTH[name] for name in fine.parameters.names])

    def call(name, seed, kind="complex", told=None):
        rng = np.random.default_rng([seed, 77])
        problem, located, size = fine, None, np.empty(0)
        if name is not None:
            locations = list(registry.create("effect", name, {}).locations(fine))
            located = locations[rng.integers(len(locations))]
            size = drawn_size(located, fine, truth, Observable(kind), rng)
            problem = located.added_to(fine)
        response = problem.dense_response(np.append(truth, size)[None])[0]
        values = observe(response, kind, NOISE, rng)
        return Measurement(fine.speed, fine.channels, values, told, "test"), located, size

    return call

"""Laws that are not linear in the motion, in data of harmonic balance with three harmonics and twice as many elements."""

import numpy as np
import pytest

from harmonic_balance import balanced_response
from ksmea.location.force_law import fitted_laws
from ksmea.location.location import locate
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from problems.rotor.response import dense
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
SENSORS = [0.1, 0.5, 1.0]
FINE = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=60).build()
ROTOR = rotor_at(FINE.rotor, FINE.unknowns, TRUTH)
POSITION = 1.0  # the third disk
# beside the sharpest resonances the curves fold over; measured in a run-up they would jump there
MOTION = dense.dense_response(ROTOR, FINE.speed, [Channel(POSITION, axis) for axis in "xy"])
SPEED = FINE.speed[np.linalg.norm(MOTION, axis=1) < 15e-6]
PROBLEM = ThreeDisk(sensors=SENSORS).build().at(SPEED, FINE.channels)


def cubic(orbit, turn):
    return -3e15 * np.sum(orbit**2, axis=-1, keepdims=True) * orbit


def stop(orbit, turn):
    return -2e6 * np.maximum(1 - 4e-6 / np.linalg.norm(orbit, axis=-1, keepdims=True), 0) * orbit


def rub(orbit, turn):
    normal = stop(orbit, turn)
    return normal + 0.3 * np.stack([-normal[..., 1], normal[..., 0]], axis=-1)


def asymmetric(orbit, turn):
    """In r = x + i y: −Δ e^{2iα} e^{2iΩt} conj(r), of a stiffness Δ cos(2 (angle − α)) that turns with the shaft."""
    force = -(6e5 + 4e5j) * turn**2 * np.conj(orbit @ [1, 1j])
    return np.stack([force.real, force.imag], axis=-1)


HIDDEN = {
    "cubic_spring": (cubic, [3e15]),
    "spring_above_an_amplitude": (stop, [2e6, 4e-6]),
    "rub": (rub, [2e6, 4e-6, 0.3]),
    "rotating_asymmetry": (asymmetric, [6e5, 4e5]),
}


@pytest.mark.parametrize(
    "key",
    mostly_slow(["cubic_spring", "rotating_asymmetry", "rub", "spring_above_an_amplitude"], but=["cubic_spring"]),
)
def test_the_law_that_acts_is_found_with_its_size(key):
    force_at, sizes = HIDDEN[key]
    response = balanced_response(ROTOR, SPEED, FINE.channels, POSITION, force_at)
    values = observe(response, "complex", Noise(0.02, 5e-8), np.random.default_rng(len(key)))
    data = Measurement(SPEED, PROBLEM.channels, values, None, "test")
    found = locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[POSITION], quantities=["force"])
    best, *others = fitted_laws(found.sites, found.noise)
    assert best.law.key == key
    assert best.p > 0.001  # one draw each
    assert np.all(np.abs(best.values - sizes) < 4 * best.sd)
    assert np.all(best.sd < 0.3 * np.abs(sizes))
    linear = [law for law in others if law.law.key in ("unbalance", "spring", "damper", "mass", "cross_coupling")]
    assert len(linear) == 5 and all(law.p < 0.001 for law in linear)

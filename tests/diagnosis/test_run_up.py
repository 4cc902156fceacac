"""A rotor that is measured while its speed sweeps: told from a steady one, and the rate found."""

import numpy as np
import pytest

from ksmea import registry
from ksmea.diagnosis.diagnosis import diagnose
from ksmea.measurement import Measurement, Noise, observe
from problems.rk4_two_disk import RK4TwoDisk
from swept_rotor import swept_response

EFFECTS = ("run_up_acceleration", "speed_dependent_damping", "unbalance")
SETTINGS = RK4TwoDisk(sensors=[0.12, 0.44], directions=["x", "y"], n_speed=60)
NOISE = Noise(0.05, 1e-7)


def diagnosed(rate, seed):
    """The diagnosis of data that are integrated over time, or steady."""
    problem = SETTINGS.build()
    x = np.array([SETTINGS.reference()[name] for name in problem.parameters.names])
    response = swept_response(problem, x, rate) if rate else problem.dense_response(x[None])[0]
    values = observe(response, "complex", NOISE, np.random.default_rng(seed))
    measurement = Measurement(problem.speed, problem.channels, values, None, "test")
    effects = {name: registry.create("effect", name, {}) for name in EFFECTS}
    return diagnose(problem, measurement, effects, np.random.default_rng(seed))


@pytest.mark.parametrize(("rate", "direction", "seed"), [(24.0, "run-up", 0), (-15.0, "coast-down", 1)])
def test_a_sweep_is_named_with_its_rate(rate, direction, seed):
    """Within the 95 % interval widened to twice its half-width: 99.99 %."""
    found = diagnosed(rate, seed)
    assert found.verdict == "named" and found.named == ("run_up_acceleration",)
    assert str(found.applied[0].effect) == direction
    interval = found.best_estimate.intervals[-1]
    assert abs(rate - (interval.low + interval.high) / 2) < interval.high - interval.low


def test_steady_data_are_no_sweep():
    found = diagnosed(0.0, 2)
    assert found.verdict == "adequate" and found.named == ()

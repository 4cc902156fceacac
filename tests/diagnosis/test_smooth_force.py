"""A force that is a smooth function of speed: what it is between the measured speeds, and how well that is known."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.location.force_law import fitted_laws, smooth_fits
from ksmea.location.location import locate
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.nonlinear.smooth_law import smooth
from ksmea.problem.case import Case
from ksmea.problem.load import Load
from problems.three_disk import ThreeDisk

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
SENSORS = [0.1, 0.5, 1.0]
PROBLEM = ThreeDisk(sensors=SENSORS, n_speed=40).build()
FINE = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=40).build()
LOADS = [Load(1.0, "x"), Load(1.0, "y")]


def hidden(speed):
    """A force that grows in the middle of the band and turns its phase by a radian, N (n_speed, 2)."""
    size = 20 + 40 * np.exp(-(((speed - 800) / 300) ** 2))
    return np.stack([size * np.exp(1j * speed / 1300), 0.5j * size], axis=1)


@pytest.fixture(scope="module")
def site():
    response = FINE.response(TRUTH[None])[0] + np.einsum(
        "sck,sk->sc", FINE.load_response(TRUTH[None], LOADS)[0], hidden(FINE.speed)
    )
    values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(3))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, values, None, "test")
    return locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[1.0], quantities=["force"])


def test_no_simple_law_holds_and_a_smooth_one_does(site):
    assert all(fit.p < 1e-6 for fit in fitted_laws(site.sites, site.noise))
    [fit] = smooth_fits(site.sites, site.noise)
    assert fit.p > 0.001  # one draw
    assert len(fit.values) in (4 * 4, 4 * 6)  # of 4 to 12 knots: the force has one bump


def test_between_measured_speeds_it_lies_in_its_band(site):
    [fit] = smooth_fits(site.sites, site.noise)
    between = (PROBLEM.speed[1:] + PROBLEM.speed[:-1]) / 2
    amplitude, sd = fit.amplitude(between)
    off = np.abs(amplitude - np.abs(hidden(between))) / sd
    # 78 values of about 20 independent numbers, and what 6 knots do not follow
    assert np.mean(off < 2) > 0.8 and off.max() < 5
    assert np.median(sd / amplitude) < 0.2


def test_outside_of_the_measured_speeds_it_refuses(site):
    [fit] = smooth_fits(site.sites, site.noise)
    for speed in (PROBLEM.speed[0] - 1, PROBLEM.speed[-1] + 1):
        with pytest.raises(SettingError, match=r"expected speeds from 200 to 1500 rad/s, where it was measured, got"):
            fit.amplitude(np.array([500.0, speed]))


def test_it_goes_through_its_knots_and_keeps_a_constant():
    law = smooth(np.array([100.0, 250.0, 300.0, 600.0]))
    values = np.random.default_rng(0).standard_normal((1, 16))
    at_knots = law.at_motion(values, np.array([100.0, 250.0, 300.0, 600.0]), np.zeros((1, 4, 2)))[0]
    parts = values.reshape(4, 2, 2)
    np.testing.assert_allclose(at_knots, parts[..., 0] + 1j * parts[..., 1], atol=1e-9)
    anywhere = law.at_motion(np.full((1, 16), 3.0), np.linspace(100, 600, 50), np.zeros((1, 50, 2)))
    np.testing.assert_allclose(anywhere, 3 + 3j, rtol=1e-9)

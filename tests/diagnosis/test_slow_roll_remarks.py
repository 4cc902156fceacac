"""Remarks on slow roll: a vector at low speed that the model does not predict is said with its size and angle, and noise is not."""

import numpy as np
import pytest

from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.studies.diagnose import DiagnosisOptions, diagnosis
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1], n_speed=40, speed_from=20, speed_to=900).build()
REFERENCE = ThreeDisk().reference()
TRUTH = np.array([REFERENCE[name] for name in PROBLEM.parameters.names])
NOISE = Noise(0.03, 3e-7)
QUICK = DiagnosisOptions(screening=512, starts=4, locate=False, split=False, average=False)


def remarks(vector, seed):
    rng = np.random.default_rng(seed)
    response = PROBLEM.response(TRUTH[None])[0]
    response[:, 0] += vector
    values = observe(response, "complex", NOISE, rng)
    measurement = Measurement(PROBLEM.speed, PROBLEM.channels, values, NOISE, "made")
    found = diagnosis(Case.of(PROBLEM, measurement), {}, np.random.default_rng(0), options=QUICK)
    return [each for each in found.remarks if each.startswith("slow roll")]


def test_a_constant_reading_of_one_probe_is_said_with_its_vector():
    vector = 2.5e-6 * np.exp(1j * np.deg2rad(120))
    [said] = remarks(vector, 0)
    assert said.startswith("slow roll of probe x at 0.1 m: 2.")
    angle = float(said.split(" at ")[2].split("°")[0])
    assert angle == pytest.approx(120, abs=10)  # noise of 0.3 µm, mean of some rows: 2°, and 5° of the fit


@pytest.mark.parametrize("seed", range(4))
def test_noise_is_no_slow_roll(seed):
    assert not remarks(0.0, seed)

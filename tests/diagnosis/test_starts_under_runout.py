"""A runout as large as the response off its resonances: searches of the whole box find the maximum near the truth all the same."""

import numpy as np
import pytest

from ksmea.fits.fitting import fit_baseline, likely_maxima
from ksmea.fits.search import Effort, Search
from ksmea.fits.starts import screened_both_ways
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk

LIMITS = {"kxx": [5, 500], "kyy": [5, 500]}  # wide, as one sets them who does not know the values
PROBLEM = ThreeDisk(sensors=[0.1], n_speed=40, limits=LIMITS).build().with_phase_origin()
REFERENCE = ThreeDisk().reference() | {"phase_origin": 0.6}
TRUTH = np.array([REFERENCE[name] for name in PROBLEM.parameters.names])
NOISE = Noise(0.03, 1e-7)


def measured(seed, kind="complex"):
    """The response plus a vector of one to six times its median amplitude in each channel."""
    rng = np.random.default_rng(seed)
    response = PROBLEM.response(TRUTH[None])[0]
    size = np.median(np.abs(response)) * rng.uniform(1, 6)
    runout = size * np.exp(1j * rng.uniform(0, 2 * np.pi, response.shape[1]))
    return Measurement(PROBLEM.speed, PROBLEM.channels, observe(response + runout, kind, NOISE, rng), None, "made")


@pytest.mark.parametrize("seed", range(4))
def test_the_maximum_near_the_truth_is_found(seed):
    measurement = measured(seed)
    likelihood = likelihood_of(Case(PROBLEM, measurement))
    near_truth = nearest_maximum(likelihood, PROBLEM.parameters.to_cube(TRUTH))
    fit = fit_baseline(Case(PROBLEM, measurement), Search(np.random.default_rng(0), Effort())).best
    assert fit.deviance < near_truth.deviance + 0.01
    middle = likelihood.at(likelihood.start(np.full(len(TRUTH), 0.5)))
    assert likely_maxima(likelihood, middle)[0].deviance < near_truth.deviance + 0.01


@pytest.mark.parametrize("kind", ["complex", "amplitude"])
def test_a_multiple_of_the_response_fits_by_shape_whatever_its_size_and_phase(kind):
    problem = PROBLEM if kind == "complex" else ThreeDisk(sensors=[0.1], n_speed=40).build()
    names = problem.parameters.names
    truth = np.array([REFERENCE[name] for name in names])
    values = observe(problem.response(truth[None])[0], kind, Noise(0.0, 0.0), np.random.default_rng(0))
    measurement = Measurement(problem.speed, problem.channels, values, NOISE, "made")
    other = truth.copy()
    other[names.index("u")] *= 1.5
    if kind == "complex":
        other[names.index("phase_origin")] += 1.0
    _, found = screened_both_ways(Case(problem, measurement), problem.parameters.to_cube(np.array([other])))
    assert found.misfits[0] == pytest.approx(0.0, abs=1e-12)
    assert problem.parameters.to_si(found.points[0]) == pytest.approx(truth, rel=1e-9)

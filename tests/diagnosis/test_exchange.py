"""One effect in place of another. A shaft whose modulus is a times as large has the response of one with the mass divided by a, on
bearings and with an unbalance divided by a: K a + Z − Ω² M = a (K + Z / a − Ω² M / a)."""

import numpy as np
import pytest

from ksmea.diagnosis.rivals import in_place_of
from ksmea.diagnosis.trials import Candidate, trial_of
from ksmea.fits.fitting import fit_from_values, fit_nearby
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.2, 0.5])
PROBLEM, NOISE = SETTINGS.build(), Noise(0.02, 1e-7)
TRUTH = np.array([SETTINGS.reference()[name] for name in PROBLEM.parameters.names])
FACTOR = 1.06  # by which resonances move 30 times as far as they are wide


@pytest.fixture(scope="module")
def trials():
    """The modulus, which is in the data, as fitted, and others as fitted from the model without effects."""
    found = {}
    for name in ("youngs_modulus", "mass", "runout"):
        candidate = Candidate(name, registry.create("effect", name, {}).locations(PROBLEM)[0])
        extended = candidate.beside(PROBLEM)
        if name == "youngs_modulus":
            x = np.append(TRUTH, FACTOR - 1)
            values = observe(extended.response(x[None])[0], "complex", NOISE, np.random.default_rng(3))
            data = Measurement(PROBLEM.speed, PROBLEM.channels, values, NOISE, "made")
            baseline = fit_from_values(Case(PROBLEM, data), TRUTH)
            fit = fit_from_values(Case(extended, data), x)
        else:
            fit = fit_nearby(extended, baseline)
        found[name] = trial_of(candidate, fit, baseline, 3)
    return found


def test_a_mass_takes_the_place_of_a_modulus_that_it_cannot_be_told_from(trials):
    lead, mass = trials["youngs_modulus"], trials["mass"]
    u = in_place_of(lead, mass, len(TRUTH))
    fit = fit_from_values(Case(mass.fit.problem, lead.fit.likelihood.measurement), mass.fit.problem.parameters.to_si(u))
    start = fit.likelihood.deviance(fit.likelihood.start(u))
    assert start < lead.fit.deviance + 1  # where it leads, resonances are those of the data
    assert fit.deviance == pytest.approx(lead.fit.deviance, abs=1e-3)  # as what both predict is the same
    scale = 1 / (1 + lead.fit.x[-1])
    expected = np.append(lead.fit.x[:-1] * scale, scale - 1)
    # within a hundredth of a standard error: the fits end within 1e-4 of the deviance
    sd = np.sqrt(np.diag(np.linalg.inv(fit.point.information))) * fit.problem.parameters.width
    assert np.all(np.abs(fit.x - expected) < 0.02 * sd)


def test_what_no_valley_leads_to_is_left(trials):
    assert in_place_of(trials["youngs_modulus"], trials["runout"], len(TRUTH)) is None

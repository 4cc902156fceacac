"""Trials: the most promising effect first, and scans left out where data are near the baseline model."""

import numpy as np
import pytest

from ksmea.diagnosis import trials as module
from ksmea.diagnosis.trials import NEAR, candidates, fitted, refined
from ksmea.fits import fitting
from ksmea.fits.fitting import BaselineFits, fit_baseline, fit_from_scan, nearby, promised_from
from ksmea.fits.search import Effort, Search
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=24)
PROBLEM, NOISE = SETTINGS.build(), Noise(0.05, 1e-7)
EFFECTS = {name: registry.create("effect", name, {}) for name in ("runout", "speed_dependent_stiffness", "mass")}
EFFORT = Effort(screening=512, starts=6)
SEARCH = Search(np.random.default_rng(0), EFFORT)


@pytest.fixture(scope="module")
def near():
    """Data with a runout that a fit without it leaves a deviance of some tens of, the baseline fits, and the trials."""
    own = [SETTINGS.reference()[name] for name in PROBLEM.parameters.names]
    runout = EFFECTS["runout"].locations(PROBLEM)[0].added_to(PROBLEM)
    response = runout.response(np.array([[*own, 1.1e-7, 0.0]]))[0]
    values = observe(response, "complex", NOISE, np.random.default_rng(2))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, values, NOISE, "made")
    baseline = fit_baseline(Case(PROBLEM, data), Search(np.random.default_rng(0), EFFORT))
    return data, baseline, fitted(baseline.best, candidates(PROBLEM, EFFECTS), SEARCH)


def test_the_first_step_promises_what_a_linear_effect_reaches(near):
    """A runout adds to the response: only noise that depends on the response bends its deviance, by some per cent."""
    _data, baseline, trials = near
    assert trials[0].name == "runout" and 15 < trials[0].deviance_drop < 100
    promised = promised_from(nearby(trials[0].fit.problem, baseline.best))
    assert promised == pytest.approx(trials[0].deviance_drop, rel=0.2)


def test_trials_are_ranked_alike_in_whatever_order_candidates_come(near):
    _data, baseline, trials = near
    again = fitted(baseline.best, candidates(PROBLEM, EFFECTS)[::-1], SEARCH)
    assert [(one.name, one.location) for one in again] == [(one.name, one.location) for one in trials]


def test_beside_a_fit_that_is_enough_no_effect_is_scanned_and_rivals_are_found(near, monkeypatch):
    _data, baseline, trials = near
    scanned, search = [], Search(np.random.default_rng(0), EFFORT.of_first_scans)
    by_scans = refined(trials, baseline, search)
    monkeypatch.setattr(module, "fit_from_scan", lambda fit, *_: scanned.append(fit) or fit)
    found = refined(trials, baseline, search, lambda fit: True)
    assert [fit.problem.parameters.names for fit in scanned] in ([], [trials[0].fit.problem.parameters.names])
    drops = {(one.name, one.location): one.deviance_drop for one in found}
    for one in by_scans:
        if one.deviance_drop > by_scans[0].deviance_drop - NEAR:  # 0.01: fits end where a step promises 1e-4
            assert drops[one.name, one.location] == pytest.approx(one.deviance_drop, abs=0.01)


def test_near_the_baseline_model_fits_from_nearby_find_what_scans_do(near, monkeypatch):
    _data, baseline, trials = near
    effort = EFFORT.of_first_scans
    by_scans = refined(trials, baseline, Search(np.random.default_rng(0), effort))
    monkeypatch.setattr(module, "fit_from_scan", lambda *_: pytest.fail("an effect was scanned"))
    nearby = refined(trials, baseline, SEARCH.with_effort(effort, is_scanned=False))
    highest = by_scans[0].deviance_drop
    drops = {(one.name, one.location): one.deviance_drop for one in nearby}
    for one in by_scans:
        if one.deviance_drop > highest - NEAR:  # 0.01: fits end where a step promises 1e-4
            assert drops[one.name, one.location] == pytest.approx(one.deviance_drop, abs=0.01)


def test_a_scan_fits_from_points_that_come_nearer_to_the_data_than_the_fit(near, monkeypatch):
    """A slope of the stiffness is no runout: no value of it leads nearer to these data, and nothing is fitted again."""
    _data, baseline, trials = near
    [slope] = [trial for trial in trials if trial.name == "speed_dependent_stiffness"]
    alone = BaselineFits(baseline.best, (), baseline.screened)
    monkeypatch.setattr(fitting, "maxima_from", lambda *_: pytest.fail("a point that is no nearer was fitted from"))
    assert fit_from_scan(slope.fit, alone, EFFORT) is slope.fit


def test_a_scan_leaves_the_maximum_that_a_fit_from_nearby_ends_in():
    """A shaft a quarter heavier, by a finer mesh: what else moves the resonances as far is found where fits from nearby stop short."""
    finer = ThreeDisk(sensors=[0.1, 0.5], n_speed=24, mesh=26).build()
    heavier = EFFECTS["mass"].added_to(finer)
    own = [SETTINGS.reference()[name] for name in PROBLEM.parameters.names]
    values = observe(heavier.response(np.array([[*own, 0.25]]))[0], "complex", NOISE, np.random.default_rng(3))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, values, NOISE, "made")
    baseline = fit_baseline(Case(PROBLEM, data), Search(np.random.default_rng(0), EFFORT))
    pulled = candidates(PROBLEM, {"axial_force": registry.create("effect", "axial_force", {})})
    [trial] = fitted(baseline.best, pulled, SEARCH)
    assert fit_from_scan(trial.fit, baseline, EFFORT).deviance < trial.fit.deviance - 100


def test_only_the_most_promising_are_fitted_where_so_many_are_asked_for(near):
    _data, baseline, trials = near
    found = fitted(baseline.best, candidates(PROBLEM, EFFECTS), SEARCH, most=1)
    assert [(trial.candidate, trial.p) for trial in found] == [(trials[0].candidate, trials[0].p)]  # corrected for all

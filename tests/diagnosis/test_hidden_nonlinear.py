"""Cubic bearings in data that were integrated over time: named beside what looks like them, with their size."""

import numpy as np

from integrated_rotor import integrated_response
from ksmea.diagnosis.trials import candidates, fitted
from ksmea.fits.fitting import fit_baseline
from ksmea.fits.search import Effort, Search
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.rk4_two_disk import RK4TwoDisk

SETTINGS = RK4TwoDisk(sensors=[0.12, 0.44], directions=["x", "y"], n_speed=24)
PROBLEM = SETTINGS.build()
TRUTH = np.array([SETTINGS.reference()[name] for name in PROBLEM.parameters.names])
CUBIC = 2e13  # N/m³, by which the resonance leans over most of its width, and does not fold
BEARINGS = [bearing.position for bearing in PROBLEM.rotor.bearings]
LITTLE = Effort(screening=500, starts=6)


def test_cubic_bearings_are_the_best_explanation_with_their_size():
    """One draw; the size within 10 %, several times what 3 % of noise leaves of it."""
    response = integrated_response(
        PROBLEM, TRUTH, BEARINGS, lambda q: -CUBIC * np.sum(q**2, axis=1, keepdims=True) * q, n_turn=50
    )
    balanced = (
        registry.create("effect", "cubic_stiffness", {}).added_to(PROBLEM).response(np.append(TRUTH, CUBIC)[None])[0]
    )
    # the modes that are left out, and free motions after 50 turns: a few thousandths
    assert np.abs(balanced - response).max() < 0.01 * np.abs(response).max()
    values = observe(response, "complex", Noise(0.03, 1e-7), np.random.default_rng(0))
    measurement = Measurement(PROBLEM.speed, PROBLEM.channels, values, None, "test")
    names = ("cubic_stiffness", "speed_dependent_stiffness", "runout")
    effects = {name: registry.create("effect", name, {}) for name in names}
    baseline = fit_baseline(Case(PROBLEM, measurement), Search(np.random.default_rng(0), LITTLE)).best
    best, *others = fitted(baseline, candidates(PROBLEM, effects), Search(np.random.default_rng(0), LITTLE))
    cubic = [trial for trial in (best, *others) if trial.name == "cubic_stiffness"]
    rival = max(trial.delta_bic for trial in others if trial.name != "cubic_stiffness")
    assert best in cubic and best.delta_bic > 30 and best.delta_bic > 6 + rival
    (all_alike,) = [trial for trial in cubic if trial.location == "all bearings"]
    # twice as much at one end does nearly the same to two planes: within the 6 that are ambiguous
    assert best.delta_bic - all_alike.delta_bic < 6 and abs(all_alike.fit.x[-1] / CUBIC - 1) < 0.1

"""Fits stay where the rotor is stable, and no size beyond counts as observable: a rigid rotor with cross-coupling, κ < c ω_n."""

import numpy as np
import pytest

from ksmea.diagnosis.observability import smallest_detectable
from ksmea.diagnosis.trials import Candidate, fitted
from ksmea.fits.fitting import Fit, fit_from_values
from ksmea.fits.search import Search
from ksmea.fits.stable_fits import settled_stable, stable_fit
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from rigid_rotor import DAMPING, MASS, NATURAL, STIFFNESS, problem_of, rigid_rotor

CRITICAL = DAMPING * NATURAL  # N/m
PLAIN = problem_of(rigid_rotor(), np.linspace(150.0, 600.0, 19))
EFFECT = registry.create("effect", "cross_coupling_antisymmetric", {})
EXTENDED = EFFECT.added_to(PLAIN)
NOISE = Noise(0.05, 1e-9)


def measured(cross):
    """Data of the synchronous response, which is finite on both sides of the threshold."""
    response = EXTENDED.response(np.array([[STIFFNESS, cross]]))[0]
    values = observe(response, "complex", NOISE, np.random.default_rng(0))
    return Measurement(PLAIN.speed, PLAIN.channels, values, NOISE, "test")


def baseline(data):
    return fit_from_values(Case(PLAIN, data), np.array([STIFFNESS]))


def test_a_size_beyond_the_threshold_is_not_named():
    data = measured(1.3 * CRITICAL)
    free = fit_from_values(Case(EXTENDED, data), np.array([STIFFNESS, 1.3 * CRITICAL]))
    assert free.x[1] > 1.1 * CRITICAL and not EXTENDED.is_stable(free.x)  # the data alone lead there
    [trial] = fitted(
        baseline(data), [Candidate("cross_coupling_antisymmetric", EFFECT)], Search(np.random.default_rng(0))
    )
    stiffness, found = trial.fit.x
    limit = DAMPING * np.sqrt(2 * stiffness / MASS)
    # as near as it may come; flexibility of the shaft moves the threshold by less than 1e-4
    assert EXTENDED.is_stable(trial.fit.x) and 0.9 * limit < found < 1.0001 * limit
    assert free.deviance < trial.fit.deviance < baseline(data).deviance


def test_a_stable_fit_is_left_as_it_is():
    data = measured(0.5 * CRITICAL)
    free = fit_from_values(Case(EXTENDED, data), np.array([STIFFNESS, 0.5 * CRITICAL]))
    assert stable_fit(free, free.point.theta) is free


@pytest.mark.parametrize("part", [0.5, 0.97, 1.2])
def test_intervals_end_where_the_rotor_becomes_unstable(part):
    data = measured(part * CRITICAL)
    free = fit_from_values(Case(EXTENDED, data), np.array([STIFFNESS, part * CRITICAL]))
    start = np.append(baseline(data).u, EXTENDED.parameters.to_cube(np.zeros(2))[1:])
    fit, estimated = settled_stable(stable_fit(free, start), 0.95)
    interval = estimated.intervals[1]
    assert interval.low < fit.x[1] <= interval.high and estimated.point is fit.point
    assert EXTENDED.is_stable(np.array([fit.x[0], interval.high]))
    # noise of 5 % at 19 speeds leaves some per cent of the threshold: 0.97 of it cannot be told from beyond, half of it can
    beyond = np.array([fit.x[0], interval.high + 0.02 * CRITICAL])
    assert EXTENDED.is_stable(beyond) == (part == 0.5)


def test_where_no_start_is_stable_the_fit_stays():
    data = measured(1.3 * CRITICAL)
    free = fit_from_values(Case(EXTENDED, data), np.array([STIFFNESS, 1.3 * CRITICAL]))
    assert stable_fit(free, free.point.theta) is free


def test_the_largest_size_that_is_told_is_stable():
    data = measured(0.0)
    fit: Fit = baseline(data)
    [found] = smallest_detectable(fit, Candidate("cross_coupling_antisymmetric", EFFECT), 0.01)
    # 1 %: the fitted stiffness, and a bisection to 0.1 % of the limit, which is four times the threshold
    assert found.largest == pytest.approx(CRITICAL, rel=0.01) and found.size < found.largest


def test_a_fit_that_cannot_be_a_rival_is_given_up_among_stable_values():
    """Where the maximum among all values lies above a deviance, so does every stable one: none is searched for."""
    data = measured(1.3 * CRITICAL)
    free = fit_from_values(Case(EXTENDED, data), np.array([STIFFNESS, 1.3 * CRITICAL]))
    start = np.append(baseline(data).u, EXTENDED.parameters.to_cube(np.zeros(2))[1:])
    searched = stable_fit(free, start)
    given_up = stable_fit(free, start, below=free.deviance - 1)
    assert EXTENDED.is_stable(given_up.x) and given_up.deviance >= searched.deviance > free.deviance
    assert given_up.likelihood.model.evaluations == 0
    assert stable_fit(free, start, below=searched.deviance + 50).deviance == pytest.approx(searched.deviance, abs=1e-3)

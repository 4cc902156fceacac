"""Screened least squares: the choice of starts, the count, and minima that starts at random miss."""

import numpy as np
import pytest

from ksmea.errors import BudgetSpent, SettingError
from ksmea.numerics.objective import Objective
from landscapes import LOWEST, rosenbrock
from optimizers.lm import LM

FREQUENCY = np.linspace(0.05, 1.0, 60)
RESONANCE = np.array([[0.37, 0.62]])


def amplitude(resonance):
    """Response (k, 60) of two lightly damped oscillators with natural frequencies (k, 2)."""
    stiffness = resonance[:, None, :] ** 2 - FREQUENCY[:, None] ** 2
    return np.sum(1 / np.hypot(stiffness, 0.02 * FREQUENCY[:, None]), axis=2)


def peaks(u):
    """Residuals with a minimum wherever a peak meets one of the measured ones or the gap between two frequencies."""
    return amplitude(u) - amplitude(RESONANCE)


def mean_log_ratio(u):
    return np.mean(np.abs(np.log(amplitude(u) / amplitude(RESONANCE))), axis=1)


def at_the_resonances(minimum):
    return np.allclose(np.sort(minimum.u), RESONANCE, rtol=0, atol=1e-6)


def test_defaults():
    assert (LM().screening, LM().starts) == (8000, 15)


def test_the_screening_is_the_same_for_any_batch():
    sizes = []

    def screening_at(u):
        sizes.append(len(u))
        return np.sum(np.abs(u - LOWEST), axis=1)

    results = []
    for batch in (1000, 300, 10_000):
        objective = Objective(5, lambda u: u - LOWEST, screening_at=screening_at)
        results.append(LM(screening=2000, batch=batch).minimize(objective, np.random.default_rng(0)))
    assert sizes == [1000, 1000] + [300] * 6 + [200] + [2000]
    assert results[0].value == results[1].value == results[2].value


def test_starts_off_the_bounds_and_the_count():
    """Screening, misfit at the starts, then at most `max_iterations` points from each start."""
    seen = []

    def residuals_at(u):
        seen.append(u.copy())
        return u - LOWEST

    lm = LM(screening=64, starts=4, max_iterations=3, margin=0.2)
    objective = Objective(5, residuals_at, jacobian_at=lambda u: np.eye(5), screening_at=lambda u: np.sum(u, axis=1))
    minimum = lm.minimize(objective, np.random.default_rng(0))
    starts = seen[0]
    assert starts.shape == (4, 5) and starts.min() == 0.2
    assert 64 + 4 + 4 <= minimum.evaluations <= 64 + 4 + 4 * 3
    assert minimum.evaluations == 64 + sum(map(len, seen))
    assert 4 <= minimum.jacobians <= 4 * 3


def test_half_of_a_budget_is_screened_counting_what_was_spent_before():
    screened = []

    def screening_at(u):
        screened.append(len(u))
        return np.sum(np.abs(u - LOWEST), axis=1)

    objective = Objective(5, lambda u: u - LOWEST, screening_at=screening_at, budget=120)
    objective(np.full((20, 5), 0.5))
    with pytest.raises(BudgetSpent):
        LM().minimize(objective, np.random.default_rng(0))
    assert screened == [50] and objective.evaluations == 120


@pytest.mark.parametrize("jacobian_at", [None, lambda u: np.eye(5)], ids=["differences", "given"])
def test_it_finds_the_lowest_point_of_a_sphere(jacobian_at):
    objective = Objective(5, lambda u: u - LOWEST, jacobian_at=jacobian_at)
    assert LM().minimize(objective, np.random.default_rng(0)).value < 1e-20


@pytest.mark.parametrize("seed", range(3))
def test_it_follows_the_bent_valley_of_rosenbrock(seed):
    minimum = LM().minimize(Objective(5, rosenbrock), np.random.default_rng(seed))
    assert np.allclose(minimum.u, 0.75, rtol=0, atol=1e-8)


def test_a_minimum_on_the_bounds_is_approached():
    target = np.array([-0.2, 1.3, 0.5, 0.5, 0.5])
    minimum = LM(screening=256).minimize(Objective(5, lambda u: u - target), np.random.default_rng(0))
    assert np.allclose(minimum.u, np.clip(target, 0, 1), rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_screening_leads_to_the_global_minimum_among_many(seed):
    objective = Objective(2, peaks, screening_at=mean_log_ratio)
    assert at_the_resonances(LM(screening=500, starts=3).minimize(objective, np.random.default_rng(seed)))


def test_as_many_starts_without_screening_miss_it():
    lm = LM(screening=0, starts=3)
    found = [at_the_resonances(lm.minimize(Objective(2, peaks), np.random.default_rng(seed))) for seed in range(20)]
    assert np.mean(found) < 0.2  # none of twenty, when this was written


def test_a_derivative_without_a_value_holds_its_parameter():
    def jacobian_at(u):
        jacobian = np.eye(5)
        jacobian[:, 2] = np.nan
        return jacobian

    objective = Objective(5, lambda u: u - LOWEST, jacobian_at=jacobian_at)
    minimum = LM(screening=64, starts=1).minimize(objective, np.random.default_rng(0))
    assert np.allclose(np.delete(minimum.u - LOWEST, 2), 0, atol=1e-6)


def test_settings_out_of_range_are_refused():
    with pytest.raises(SettingError, match="starts"):
        LM(starts=0)
    with pytest.raises(SettingError, match="margin"):
        LM(margin=0.6)

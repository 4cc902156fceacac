"""Whitened sensitivities: columns of the noise, differences, projections; against densities, expansions and
regression."""

import numpy as np
import pytest

from ksmea.likelihood.fisher import (
    of_unknowns,
    projected,
    span,
    whitened_difference,
    whitened_noise_sensitivity,
    whitened_sensitivity,
)
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable

NOISE = Noise(0.2, 0.3)
EACH_OBSERVABLE = pytest.mark.parametrize("observable", list(Observable))


def random_response(seed, *shape):
    real, imaginary = np.random.default_rng(seed).standard_normal((2, *shape))
    return real + 1j * imaginary


@EACH_OBSERVABLE
def test_rows_of_the_means_are_the_differences_of_responses_to_first_order(observable):
    response, sensitivity = random_response(0, 6, 2), random_response(1, 6, 2, 3)
    step = 1e-7 * np.array([1.0, -2.0, 0.5])
    whitened = whitened_sensitivity(response, sensitivity, NOISE, observable)
    difference = whitened_difference(response + sensitivity @ step, response, NOISE, observable)
    assert len(difference) == 12 * observable.dimensions and len(whitened) == 12 * (observable.dimensions + 1)
    assert difference / 1e-7 == pytest.approx(whitened[: len(difference)] @ step / 1e-7, abs=1e-5)


@EACH_OBSERVABLE
def test_the_noise_has_the_information_of_the_variance_of_its_score(observable):
    """By simulation: d ln p / d ln relative and d ln floor are n (|r|²/s² − 1) ∂s²/(2 s²), ∂s² = 2 (relative |μ|)² and
    2 floor²."""
    magnitude = np.array([[1.5]])
    rng = np.random.default_rng(5)
    first, second = rng.standard_normal((2, 200_000))
    squared = first**2 if observable is Observable.AMPLITUDE else (first**2 + second**2) / 2  # |r|²/s²
    parts = 2 * np.array([(0.2 * 1.5) ** 2, 0.3**2]) / (2 * NOISE.sd(1.5) ** 2)
    score = observable.dimensions * (squared - 1)[:, None] * parts
    found = whitened_noise_sensitivity(magnitude, NOISE, observable)
    # a fourth moment: standard error √(96/200 000) = 2 % at most
    assert found.T @ found == pytest.approx(score.T @ score / len(score), rel=0.05)


@EACH_OBSERVABLE
def test_unknown_noise_adds_its_two_columns(observable):
    response, sensitivity = random_response(2, 5, 2), random_response(3, 5, 2, 4)
    known = whitened_sensitivity(response, sensitivity, NOISE, observable)
    unknown = whitened_sensitivity(response, sensitivity, NOISE, observable, noise_known=False)
    assert np.array_equal(unknown[:, :4], known)
    assert np.array_equal(unknown[:, 4:], whitened_noise_sensitivity(np.abs(response), NOISE, observable))
    assert of_unknowns(unknown, 4) == pytest.approx(projected(known, unknown[:, 4:]))


def test_a_floor_of_each_datum_is_its_own():
    floor = np.array([[0.1, 0.2], [0.3, 0.4]])
    response = random_response(4, 2, 2)
    found = whitened_noise_sensitivity(np.abs(response), Noise(0.0, floor), Observable.AMPLITUDE)
    # without a relative part s is the floor itself: d ln s² / d ln floor = 2, over √2
    assert (
        found[:4] == pytest.approx(0) and found[4:, 0] == pytest.approx(0) and found[4:, 1] == pytest.approx(np.sqrt(2))
    )


def test_what_is_left_is_the_inverse_of_the_block_of_the_inverse():
    """Fitting others along: the Schur complement of the information."""
    whole = np.random.default_rng(6).standard_normal((20, 5))
    left = of_unknowns(whole, 2)
    covariance = np.linalg.inv(whole.T @ whole)
    assert left.T @ left == pytest.approx(np.linalg.inv(covariance[:2, :2]), rel=1e-10)


def test_without_nuisance_everything_is_left():
    whole = np.random.default_rng(7).standard_normal((6, 3))
    assert of_unknowns(whole, 3) is not None and np.array_equal(of_unknowns(whole, 3), whole)


def test_a_span_leaves_out_what_is_rounding():
    columns = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-13], [0.0, 0.0]])
    directions = span(columns)
    assert np.abs(directions[:, 0]) == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0]) and directions.shape == (3, 1)
    assert span(np.array([[1.0, 0.0], [0.0, 1e-3]]), tolerance=1e-2).shape == (2, 1)

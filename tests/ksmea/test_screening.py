"""Screening: points apart, thinned and spread evenly, and the mean |ln ratio| by hand."""

import numpy as np
import pytest

from ksmea.numerics.screening import Screened, joined, log_ratio, mean_log_misfit, ranked, sobol


def test_screening_points_fill_the_cube_evenly():
    points = sobol(1024, 5, np.random.default_rng(0))
    assert np.array_equal(np.sort(np.floor(points * 1024), axis=0), np.tile(np.arange(1024.0)[:, None], 5))
    assert sobol(1, 5, np.random.default_rng(0)).shape == (1, 5)


def test_without_a_generator_the_sequence_is_that_of_van_der_corput():
    assert sobol(5, 1)[:, 0].tolist() == [0.0, 0.5, 0.75, 0.25, 0.375]


def test_starts_are_the_best_points_that_keep_their_distance():
    points = np.array([[0.5, 0.5], [0.55, 0.5], [0.5, 0.65], [0.0, 0.0], [0.9, 0.9]])
    found = ranked(points, np.array([1.0, 2.0, 3.0, 4.0, 0.0]))
    assert found.apart(3, 0.1).points.tolist() == [[0.9, 0.9], [0.5, 0.5], [0.5, 0.65]]
    assert found.apart(3, 0.0).points.tolist() == [[0.9, 0.9], [0.5, 0.5], [0.55, 0.5]]
    assert found.apart(5, 2.0).points.tolist() == [[0.9, 0.9]]


def test_points_apart_are_the_best_of_their_neighbourhoods():
    found = Screened(np.array([[0.1], [0.11], [0.5], [0.52], [0.9]]), np.arange(5.0))
    assert found.apart(3, 0.05).points[:, 0].tolist() == [0.1, 0.5, 0.9]
    assert found.apart(2, 0.05).misfits.tolist() == [0.0, 2.0]


def test_equal_points_are_one_where_a_distance_is_asked_for():
    found = Screened(np.full((4, 2), 0.3), np.zeros(4))
    assert len(found.apart(4, 1e-12).points) == 1 and len(found.apart(4, 0.0).points) == 4


def test_thinning_keeps_the_best_and_the_worst_and_most_of_the_good():
    found = Screened(np.arange(1000.0)[:, None], np.arange(1000.0))
    kept = found.thinned(100)[:, 0]
    assert kept[0] == 0 and kept[-1] == 999 and len(kept) <= 100
    assert np.sum(kept < 250) == pytest.approx(50, abs=3)


def test_screenings_are_joined_by_rising_misfit_and_equal_ones_stay_in_order():
    one = Screened(np.array([[0.1], [0.2]]), np.array([1.0, 3.0]))
    other = Screened(np.array([[0.3], [0.4]]), np.array([0.0, 3.0]))
    assert joined(one, other).points[:, 0].tolist() == [0.3, 0.1, 0.2, 0.4]
    assert joined(one, other).best(2).misfits.tolist() == [0.0, 1.0]


def test_the_misfit_of_a_factor_is_its_logarithm_whichever_way():
    measured = np.array([[1.0, 2.0], [3.0, 4.0]])
    predicted = np.stack([2 * measured, measured / 2, measured])
    assert mean_log_misfit(log_ratio(predicted, measured)) == pytest.approx([np.log(2), np.log(2), 0.0])


def test_the_misfit_of_a_turn_is_its_angle():
    measured = np.array([[1.0 + 1.0j, 2.0j]])
    predicted = np.stack([measured * np.exp(0.3j), measured * np.exp(-0.3j), measured * np.exp(1j * (2 * np.pi - 0.3))])
    assert mean_log_misfit(log_ratio(predicted, measured)) == pytest.approx([0.3, 0.3, 0.3])


def test_a_prediction_of_nothing_is_as_bad_as_numbers_go():
    found = log_ratio(np.zeros((1, 1, 1)), np.ones((1, 1)))
    assert np.isfinite(found).all() and found[0, 0, 0] < -700

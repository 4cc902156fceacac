"""Central differences: order of convergence, exact for parabolas, and inside the box."""

import numpy as np
import pytest

from ksmea.numerics.differences import central_differences, cube_differences

BOX = np.zeros(1), np.ones(1)


def slope(function, x, step, box=BOX):
    differences = central_differences(np.atleast_1d(x), step, *box)
    return differences.derivative(function(differences.points))


def test_differences_converge_with_the_square_of_the_step():
    errors = [abs(slope(np.sin, 0.5, step)[0, 0] - np.cos(0.5)) for step in (1e-2, 1e-3)]
    assert np.log(errors[0] / errors[1]) / np.log(10) == pytest.approx(2.0, abs=0.01)


def test_a_parabola_is_differentiated_exactly():
    box = np.zeros(3), np.full(3, 10.0)
    x = np.array([1.0, 5.0, 9.0])
    assert slope(lambda u: u**2, x, 0.5, box) == pytest.approx(np.diag(2 * x), rel=1e-14)


def test_on_a_limit_they_are_one_sided_and_never_outside():
    steps = np.array([0.1, 0.2, 0.3])
    lower, upper = np.array([0.0, -1.0, 2.0]), np.array([4.0, 1.0, 2.5])
    x = np.array([0.0, 1.0, 2.2])  # on the lower limit, on the upper one, and near both
    differences = central_differences(x, steps, lower, upper)
    assert np.all((differences.points >= lower) & (differences.points <= upper))
    assert differences.widths == pytest.approx([0.1, 0.2, 0.5])
    matrix = np.arange(6.0).reshape(3, 2)
    assert differences.derivative(differences.points @ matrix) == pytest.approx(matrix.T)


def test_values_of_any_shape_keep_it_and_the_unknowns_come_last():
    u = np.array([0.2, 0.0])
    differences = cube_differences(u)
    assert differences.points.shape == (4, 2)
    values = np.exp(1j * differences.points @ np.ones((2, 1)))[:, :, None] * np.ones((4, 1, 3))
    found = differences.derivative(values)
    assert found.shape == (1, 3, 2)
    # one-sided at u = 0: half a step of 1e-5 times the second derivative of 1
    assert found == pytest.approx(np.full((1, 3, 2), 1j * np.exp(0.2j)), abs=6e-6)

"""Residuals over the unit cube, of test functions whose minima are known."""

import numpy as np

LOWEST = np.array([0.31, 0.62, 0.17, 0.74, 0.45])


def sphere(u):
    return u - LOWEST


def rosenbrock(u):
    """Residuals of the chained Rosenbrock function of x = 4 u − 2, zero at x = 1.

    The product of neighbours makes the valley bend through all dimensions. Source: Moré, Garbow and Hillstrom 1981, no. 21.
    """
    x = 4 * u - 2
    return np.concatenate([10 * (x[:, 1:] - x[:, :-1] ** 2), 1 - x[:, :-1]], axis=1)


def rastrigin(u):
    """Residuals of Rastrigin's function Σ x² + 10 (1 − cos 2πx) of x = 8 (u − LOWEST), zero at LOWEST.

    A local minimum beside each whole number, the next best ones near 1.
    """
    x = 8 * (u - LOWEST[: u.shape[1]])
    return np.concatenate([x, np.sqrt(20) * np.sin(np.pi * x)], axis=1)


def noted(residuals_at):
    """Unchanged residuals, and a list of the batches that are requested."""
    seen = []

    def noting(u):
        seen.append(u.copy())
        return residuals_at(u)

    return noting, seen

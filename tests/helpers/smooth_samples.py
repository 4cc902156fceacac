"""Samples of a smooth function, and a surrogate of them."""

import numpy as np
from scipy.stats import qmc


def latin_hypercube(n, d, seed):
    return qmc.LatinHypercube(d, rng=np.random.default_rng(seed)).random(n)


def smooth(u):
    """Points (n, 2) → three outputs of different size and smoothness, (n, 3)."""
    return np.column_stack(
        [np.sin(3 * u[:, 0]) + u[:, 1] ** 2, 100 * np.exp(-u[:, 0] * u[:, 1]), np.cos(5 * u[:, 1]) / (1.2 + u[:, 0])]
    )


def fit(settings, u, y, seed=0):
    return settings.fit(u, y, np.random.default_rng(seed))

"""Gaussian-process regression by scikit-learn: one anisotropic Gaussian correlation for all outputs, constant mean.

Its own optimiser within our limits of θ = 1/(2ℓ²), started at ℓ = 0.5: from its default start and in its default limits it ends
at ℓ = 1e-5, where every prediction is the mean.
"""

from __future__ import annotations

import warnings

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF

from benchmarks.harness.task import Task
from benchmarks.tasks.responses import fit_by, predict_by, read

LENGTHS = (1 / np.sqrt(2 * 1e3), 1 / np.sqrt(2 * 1e-3))  # θ from 1e-3 to 1e3


def fitted(u: np.ndarray, y: np.ndarray, kernel: RBF | None = None) -> GaussianProcessRegressor:
    """With a kernel given, that one, nothing estimated."""
    start = RBF(np.full(u.shape[1], 0.5), LENGTHS) if kernel is None else kernel
    optimizer = "fmin_l_bfgs_b" if kernel is None else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # of lengths at their limits
        return GaussianProcessRegressor(start, normalize_y=True, optimizer=optimizer).fit(u, y)


def fit(samples: str) -> Task:
    return fit_by(fitted, samples)


def predict(samples: str, points: int) -> Task:
    return predict_by(fitted, samples, points)


def append(samples: str) -> Task:
    """A fit of all samples with the kernel as it is: it has no cheaper way."""
    data = read(samples)
    kernel = fitted(data.u, data.y).kernel_
    u, y = np.vstack([data.u, data.more_u]), np.vstack([data.y, data.more_y])
    return Task(lambda turn: fitted(u, y, kernel))

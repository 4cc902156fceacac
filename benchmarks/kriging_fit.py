"""Time of a Kriging fit against scikit-learn's GaussianProcessRegressor, both in one run, and their held-out errors.

    OPENBLAS_NUM_THREADS=1 python benchmarks/kriging_fit.py

Both estimate one anisotropic Gaussian correlation for all 106 outputs by maximum likelihood. Times depend on the
machine and on what else it does; the ratio, from alternated repeats, is what the script is for.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from statistics import median

import numpy as np
from scipy.stats import qmc
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF

from surrogates.kriging import Kriging

SAMPLE_COUNTS = (40, 70, 100, 200)
N_REPEAT = 5
N_HELD_OUT = 1000


def two_mass_amplitudes(u: np.ndarray) -> np.ndarray:
    """Points (n, 5) of the unit cube → ln amplitude of both masses of a damped chain at 53 speeds, (n, 106).

    Stiffnesses 1–2, dampings 0.05–0.15 and force 0.5–1.5; the speeds span both resonances.
    """
    k1, k2, c1, c2, force = (np.array([1, 1, 0.05, 0.05, 0.5]) + u * np.array([1, 1, 0.1, 0.1, 1])).T[:, :, None]
    speed = np.linspace(0.2, 2.6, 53)
    ground, link = k1 + 1j * speed * c1, k2 + 1j * speed * c2
    first, second = ground + link - speed**2, link - speed**2
    determinant = first * second - link**2
    response = np.stack([force * link / determinant, force * first / determinant], axis=2)  # force on the second mass
    return np.log(np.abs(response)).reshape(len(u), -1)


def fit_kriging(u: np.ndarray, y: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Our default but for the objective: DACE's, like scikit-learn's, weighs outputs by their residuals."""
    return Kriging(objective="dace").fit(u, y, np.random.default_rng(0)).predict


def fit_kriging_likelihood(u: np.ndarray, y: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    return Kriging(objective="likelihood").fit(u, y, np.random.default_rng(0)).predict


def fit_scikit_learn(u: np.ndarray, y: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Its default optimiser within our default bounds of θ = 1/(2ℓ²), started at ℓ = 0.5: from its default start and in
    its default bounds it ends at ℓ = 1e-5, where every prediction is the mean."""
    bounds = (1 / np.sqrt(2 * Kriging().theta_upper), 1 / np.sqrt(2 * Kriging().theta_lower))
    kernel = RBF(np.full(u.shape[1], 0.5), bounds)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # of lengths at their bounds
        return GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=0).fit(u, y).predict


FITS = {"Kriging, dace": fit_kriging, "Kriging, likelihood": fit_kriging_likelihood, "scikit-learn": fit_scikit_learn}


def main() -> None:
    held_out = qmc.LatinHypercube(5, rng=np.random.default_rng(99)).random(N_HELD_OUT)
    expected = two_mass_amplitudes(held_out)
    print(f"{'n':>4}  {'fit':<20}{'median s':>10}{'scikit-learn / it':>19}{'held-out RMSE of ln amplitude':>31}")
    for n in SAMPLE_COUNTS:
        u = qmc.LatinHypercube(5, rng=np.random.default_rng(n)).random(n)
        y = two_mass_amplitudes(u)
        seconds = {name: [] for name in FITS}
        error = {}
        for _ in range(N_REPEAT):
            for name, fit in FITS.items():
                started = time.perf_counter()
                predict = fit(u, y)
                seconds[name].append(time.perf_counter() - started)
                error[name] = np.sqrt(np.mean((predict(held_out) - expected) ** 2))
        for name, times in seconds.items():
            ratio = median(seconds["scikit-learn"]) / median(times)
            print(f"{n:4d}  {name:<20}{median(times):10.4f}{ratio:19.1f}{error[name]:31.4f}")


if __name__ == "__main__":
    main()

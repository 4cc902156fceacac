"""The noise level of data of which free numbers have taken a part at each speed.

Restricted maximum likelihood.

With residuals r = y − q, what columns A (n_channel, k) can explain is free and says nothing of the noise. The n_channel − k
contrasts that A leaves have, with S = diag(s²), s² = (relative · |μ|)² + floor² and μ the fitted response, the deviance

    2 Σ over speeds of [ ln det S + ln det(A* S⁻¹ A) + r* (S⁻¹ − S⁻¹A (A* S⁻¹ A)⁻¹ A* S⁻¹) r ] + constant.

The plain likelihood of all residuals would take the part that A has removed for noise that is small, most of all where A
is large.

H. D. Patterson and R. Thompson, Biometrika 58 (1971) 545–554, doi 10.1093/biomet/58.3.545.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from ksmea.arrays import Array, ComplexArray
from ksmea.likelihood.likelihood import noise_limits
from ksmea.location.unknown_force import orthonormal, without
from ksmea.measurement.noise import Noise

N_LEVEL = 9  # levels of each part of the noise that a search is started from the best of


def restricted_noise(
    residual: ComplexArray, columns: ComplexArray, response: ComplexArray, values: ComplexArray, n_fitted: float
) -> Noise:
    """Relative part and floor of the noise by restricted maximum likelihood.

    It is estimated from residuals (n_speed, n_channel), columns (n_speed, n_channel, k), the fitted response (n_speed,
    n_channel) and measured values, all m. Both parts are corrected for `n_fitted` unknowns, or a share of them, that
    were also estimated.
    """
    magnitude = np.abs(response)

    def restricted_deviance(logarithms: Array) -> float:
        relative, floor = np.exp(logarithms)
        sd = Noise(relative, floor).sd(magnitude)
        whitened = columns / sd[..., None]
        left = without(orthonormal(whitened), (residual / sd)[..., None])
        gram = np.conj(np.swapaxes(whitened, 1, 2)) @ whitened
        return float(2 * (2 * np.sum(np.log(sd)) + np.sum(np.linalg.slogdet(gram)[1]) + np.sum(np.abs(left) ** 2)))

    lower, upper = noise_limits(values)
    grid = np.stack(np.meshgrid(*np.linspace(lower, upper, N_LEVEL).T), axis=-1).reshape(-1, 2)
    start = min(grid, key=restricted_deviance)
    best = minimize(restricted_deviance, start, method="L-BFGS-B", bounds=list(zip(lower, upper))).x
    n_speed, n_channel, n_free = columns.shape
    n_left = 2 * n_speed * (n_channel - n_free)
    relative, floor = np.exp(best) * np.sqrt(n_left / max(n_left - n_fitted, 1))
    return Noise(float(relative), float(floor))

"""Gaussian-process regression by scikit-learn: a second opinion on `kriging`.

C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning (2006), chapters 2 and 5. It differs from
universal Kriging in that the mean is known, the mean of the samples, and that θ and the process variance maximise the
likelihood of all outputs together.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import solve_triangular

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.plugins.surrogate import Predictor, Surrogate
from ksmea.plugins.transforms import TRANSFORMS
from ksmea.settings.settings import setting

if TYPE_CHECKING:
    from sklearn.gaussian_process import GaussianProcessRegressor

VARIANCE_LIMITS = (1e-3, 1e5)  # of the process variance, in variances of the samples' outputs


@dataclass(frozen=True)
class GPRPredictor(Predictor):
    """A fitted regressor and the standard deviation of each output among its samples (q,)."""

    regressor: GaussianProcessRegressor
    spread: Array

    def predict(self, u: Array) -> Array:
        """Points (k, d) → (k, q)."""
        return self.regressor.predict(u).reshape(len(u), -1)

    def variance(self, u: Array) -> Array:
        """Points (k, d) → variance of each output (k, q)."""
        _, sd = self.regressor.predict(u, return_std=True)
        return sd.reshape(len(u), -1) ** 2

    def leave_one_out(self) -> Array:
        """Root mean square leave-one-out error of each output (q,), mean and kernel as they are.

        α_i / (K⁻¹)_ii (Rasmussen & Williams, eq. (5.12)).
        """
        inverse = solve_triangular(self.regressor.L_, np.eye(len(self.regressor.L_)), lower=True)
        errors = self.regressor.alpha_.reshape(len(inverse), -1) / np.sum(inverse**2, axis=0)[:, None]
        return np.sqrt(np.mean(errors**2, axis=0)) * self.spread


@dataclass(frozen=True)
class GPR(Surrogate):
    """Settings of a Gaussian process with one kernel for all outputs, each in units of its own spread.

    >>> u = np.linspace(0.0, 1.0, 7)[:, None]
    >>> predictor = GPR().fit(u, np.sin(3 * u), np.random.default_rng(1))
    >>> print(f"{predictor.predict(np.array([[0.4]]))[0, 0]:.3f} {np.sin(1.2):.3f}")
    0.932 0.932
    """

    transform: str = setting("auto", "outputs that are modelled", choices=TRANSFORMS)
    kernel: str = setting(
        "gaussian", "correlation function; matern52 is of the distance, not a product", choices=("gaussian", "matern52")
    )
    theta: list[float] | None = setting(
        None,
        "fixed θ, one per parameter or one for all, with the variance of the samples; null: both estimated",
        unit="1/(width of the cube)²",
        above=0,
    )
    theta_lower: float = setting(1e-3, "lower limit of θ", unit="1/(width of the cube)²", above=0)
    theta_upper: float = setting(1e3, "upper limit of θ", unit="1/(width of the cube)²", above=0)
    restarts: int = setting(1, "searches for θ from random ones, after that from θ = 1", at_least=0)
    nugget: float = setting(
        1e-8, "added to the diagonal of the kernel matrix, in variances of the samples' outputs", above=0
    )

    def check(self) -> None:
        if self.theta_lower >= self.theta_upper:
            raise SettingError(
                f"theta_lower, theta_upper: expected lower < upper, got [{self.theta_lower:g}, {self.theta_upper:g}]"
            )

    def least_samples(self, d: int) -> int:
        """Two, so that outputs have a spread."""
        return 2

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> GPRPredictor:
        """Samples u (n, d) in the unit cube, outputs y (n, q)."""
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Matern  # a second to import, as in `rsm`

        d = u.shape[1]
        limits = self._length(self.theta_upper), self._length(self.theta_lower)
        if self.theta is not None and len(self.theta) not in (1, d):
            raise SettingError(f"theta: expected 1 or {d} values for {d} parameters, got {len(self.theta)}")
        length = self._length(np.broadcast_to(1.0 if self.theta is None else np.array(self.theta), (d,)))
        correlation = RBF(length, limits) if self.kernel == "gaussian" else Matern(length, limits, nu=2.5)
        if self.theta is not None:
            return self._fitted(correlation, u, y, {"optimizer": None})
        options = {"n_restarts_optimizer": self.restarts, "random_state": int(rng.integers(2**32))}
        return self._fitted(ConstantKernel(1.0, VARIANCE_LIMITS) * correlation, u, y, options)

    def refit(self, previous: Predictor, u: Array, y: Array, rng: np.random.Generator) -> GPRPredictor:
        """`fit` with one search, from the kernel of an earlier predictor."""
        if not isinstance(previous, GPRPredictor):
            raise TypeError(f"GPR: expected an earlier GPR predictor, got {type(previous).__name__}")
        fixed = {} if self.theta is None else {"optimizer": None}
        return self._fitted(previous.regressor.kernel_, u, y, fixed)

    def _fitted(self, kernel: Any, u: Array, y: Array, options: dict[str, Any]) -> GPRPredictor:
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor

        regressor = GaussianProcessRegressor(kernel, alpha=self.nugget, normalize_y=True, **options)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # θ at a limit, where an unknown has little influence
            try:
                regressor.fit(u, y)
            except np.linalg.LinAlgError as error:
                raise np.linalg.LinAlgError(
                    f"the kernel matrix of {len(u)} samples is not positive definite with a nugget of {self.nugget:g}:"
                    " samples nearly coincide; raise surrogate.nugget"
                ) from error
        return GPRPredictor(regressor, y.std(axis=0))

    def _length(self, theta: Any) -> Any:
        """Length scale ℓ of a kernel.

        Its θ is 1/(2ℓ²) in a Gaussian and 1/ℓ² in a Matérn one, as in `kriging`.
        """
        return 1.0 / np.sqrt((2.0 if self.kernel == "gaussian" else 1.0) * theta)

"""Kriging by this project and by other libraries, each imported where it is used.

Docs/speed.md says how alike they are.

- ours: universal, linear trend, one anisotropic Gaussian correlation for all outputs;
- scikit-learn: one anisotropic Gaussian correlation for all outputs, constant mean. Its own optimiser within our limits of
  θ = 1/(2ℓ²), started at ℓ = 0.5: from its default start and in its default limits it ends at ℓ = 1e-5, where every prediction is
  the mean;
- pydacefit (Blank): DACE of Lophaven, Nielsen & Søndergaard (2002) in Python, linear trend, anisotropic Gaussian correlation, all
  outputs with one θ, found by DACE's pattern search;
- SMT (Saves et al., Adv. Eng. Softw. 188 (2024) 103571, doi 10.1016/j.advengsoft.2023.103571): linear trend, squared exponential, its
  own start points and optimiser. One output: several have no θ in common there;
- OpenTURNS (Baudin, Dutfoy, Iooss & Popelin 2017, doi 10.1007/978-3-319-12385-1_64): linear trend, anisotropic squared exponential. One
  output: several at once are a matrix of n·q rows there.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.harness.task import Task
from benchmarks.tasks.data import N_DESIGN, read_samples

THETA = np.array([1e-3, 1e3])  # limits of θ
LENGTHS = tuple(1 / np.sqrt(2 * THETA[::-1]))


@dataclass(frozen=True)
class Library:
    """How a library fits points (n, 5) and outputs (n, q), predicts, and takes points."""

    fit: Callable[[np.ndarray, np.ndarray], Any]
    predict: Callable[[Any, Any], np.ndarray] = lambda model, points: model.predict(points)
    points: Callable[[np.ndarray], Any] = lambda u: u


def fit(model: str, samples: str) -> Task:
    """θ estimated and the model made, of another design in each turn; how good it is, at points held out."""
    library, data = LIBRARIES[model](), read_samples(samples)
    held_out = library.points(data.held_out_u)
    return Task(
        lambda turn: library.fit(data.u[turn % N_DESIGN], data.y[turn % N_DESIGN]),
        quality=lambda made: data.rmse(library.predict(made, held_out)),
        units=data.y.shape[2],
    )


def predict(model: str, samples: str, points: int) -> Task:
    """So many predictions of all outputs."""
    library, data = LIBRARIES[model](), read_samples(samples)
    made, u = library.fit(data.u[0], data.y[0]), library.points(data.many_u[:points])
    return Task(lambda turn: library.predict(made, u), values=lambda found: found, units=points * data.y.shape[2])


def fit_all(samples: str, outputs: int | None = None) -> Task:
    """A fit of the first so many outputs by ours, counted as one."""
    ours, data = by_us(), read_samples(samples)
    return Task(lambda turn: ours.fit(data.u[0], data.y[0, :, :outputs]))


def append(samples: str) -> Task:
    """One more sample with θ as it is."""
    data = read_samples(samples)
    model = by_us().fit(data.u[0], data.y[0])
    return Task(lambda turn: model.append(data.more_u, data.more_y))


def refit(samples: str) -> Task:
    """scikit-learn's fit of all samples and one more with the kernel as it is: it has no cheaper way."""
    data = read_samples(samples)
    kernel = fitted_by_sklearn(data.u[0], data.y[0]).kernel_
    u, y = np.vstack([data.u[0], data.more_u]), np.vstack([data.y[0], data.more_y])
    return Task(lambda turn: fitted_by_sklearn(u, y, kernel))


def by_us(objective: str = "dace") -> Library:
    from surrogates.kriging import Kriging

    return Library(lambda u, y: Kriging(objective=objective).fit(u, y, np.random.default_rng(0)))


def fitted_by_sklearn(u: np.ndarray, y: np.ndarray, kernel: Any = None) -> Any:
    """With a kernel given, that one, nothing estimated."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF

    start = RBF(np.full(u.shape[1], 0.5), LENGTHS) if kernel is None else kernel
    optimizer = "fmin_l_bfgs_b" if kernel is None else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # of lengths at their limits
        return GaussianProcessRegressor(start, normalize_y=True, optimizer=optimizer).fit(u, y)


def by_pydacefit() -> Library:
    """θ counts in standardised coordinates there, whose variance in a unit cube is 1/12.

    Our limits divided by 12.
    """
    from pydacefit.corr import corr_gauss
    from pydacefit.dace import DACE
    from pydacefit.regr import regr_linear

    def fitted(u: np.ndarray, y: np.ndarray) -> DACE:
        low, start, high = (np.full(u.shape[1], value) for value in (THETA[0] / 12, 0.2, THETA[1] / 12))
        model = DACE(regr_linear, corr_gauss, theta=start, thetaL=low, thetaU=high)
        model.fit(u, y)
        return model

    return Library(fitted)


def by_smt() -> Library:
    from smt.surrogate_models import KRG

    def fitted(u: np.ndarray, y: np.ndarray) -> KRG:
        model = KRG(poly="linear", corr="squar_exp", print_global=False)
        model.set_training_values(u, y)
        model.train()
        return model

    return Library(fitted, lambda model, points: model.predict_values(points))


def by_openturns() -> Library:
    import openturns as ot

    ot.Log.Show(ot.Log.NONE)
    ot.TBB.Disable()

    def fitted(u: np.ndarray, y: np.ndarray) -> ot.Function:
        d = u.shape[1]
        covariance = ot.SquaredExponential([0.5] * d)
        covariance.setNuggetFactor(1e-10)
        fitter = ot.GaussianProcessFitter(ot.Sample(u), ot.Sample(y), covariance, ot.LinearBasisFactory(d).build())
        fitter.setOptimizationBounds(ot.Interval([LENGTHS[0]] * d, [LENGTHS[1]] * d))
        fitter.run()
        regression = ot.GaussianProcessRegression(fitter.getResult())
        regression.run()
        return regression.getResult().getMetaModel()

    return Library(fitted, lambda model, points: np.array(model(points)), ot.Sample)


LIBRARIES: dict[str, Callable[[], Library]] = {
    "ours": by_us,
    "ours by likelihood": lambda: by_us("likelihood"),
    "scikit-learn": lambda: Library(fitted_by_sklearn),
    "pydacefit": by_pydacefit,
    "SMT": by_smt,
    "OpenTURNS": by_openturns,
}

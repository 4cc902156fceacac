"""Universal Kriging of the unbalance response.

Source: Han, Guo & Gao 2013, doi 10.1016/j.jsv.2012.12.025, eqs. (7)–(22).

What the paper leaves open is a setting here: the trend, the correlation, which outputs share θ and what θ minimises.
The defaults are what converged best on the three-disk rotor, whose peaks are sharp (damping ratio about 4e-4):
logarithmic outputs, a linear trend, one θ for all of them and DACE's Σσ². From 40 samples without noise that finds all
five unknowns within 0.1 % in 7 to 12 updates; a quadratic trend, which 40 samples hardly determine, and the mean ln σ²,
which easy outputs far from resonance rule, needed more or did not get there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.plugins.surrogate import Predictor, Surrogate
from ksmea.plugins.transforms import TRANSFORMS
from ksmea.settings.settings import setting
from surrogates.correlation import CORRELATIONS, SamplePairs
from surrogates.generalised_least_squares import DEGREES, n_terms, trend_over
from surrogates.kriging_predictor import KrigingPredictor, OutputGroup
from surrogates.theta_search import OBJECTIVES, ThetaObjective, isotropic_minima, search_theta

X_AND_Y = 2  # groups of outputs where nothing else is said


@dataclass(frozen=True)
class Kriging(Surrogate):
    """Settings of a Kriging surrogate.

    Samples that repeat another one exactly are left out, and counted in the predictor's notes; if their outputs
    differ, that is an error. Samples that nearly coincide are what the nugget is for.

    >>> u = np.linspace(0.0, 1.0, 7)[:, None]
    >>> predictor = Kriging(theta=[8.0]).fit(u, np.sin(3 * u), np.random.default_rng(1))
    >>> print(f"{predictor.predict(np.array([[0.4]]))[0, 0]:.3f} {np.sin(1.2):.3f}")
    0.932 0.932
    """

    transform: str = setting("auto", "outputs that are modelled", choices=TRANSFORMS)
    trend: str = setting(
        "linear",
        "polynomial trend, cross terms included; quadratic wants n of 2–3 times its terms",
        choices=tuple(DEGREES),
    )
    correlation: str = setting("gaussian", "correlation function", source="eq. (11)", choices=tuple(CORRELATIONS))
    theta_sharing: str = setting(
        "shared",
        "which outputs share θ: all, interleaved groups, or none; two groups (x and y) come close to none at little cost",
        choices=("shared", "groups", "per_output"),
    )
    groups: int | None = setting(
        None,
        "number of groups, output l in group l mod groups; null: two, which are x and y of one measuring plane. With more"
        " planes give the number of channels, whose outputs lie in turn",
        at_least=1,
    )
    objective: str = setting(
        "dace", "what θ minimises: mean ln σ² with ln|R|, or DACE's Σσ² with |R|", choices=OBJECTIVES
    )
    theta: list[float] | None = setting(
        None, "fixed θ, one per parameter or one for all; null: estimated", unit="1/(width of the cube)²", above=0
    )
    theta_lower: float = setting(1e-3, "lower limit of θ", unit="1/(width of the cube)²", above=0)
    theta_upper: float = setting(1e3, "upper limit of θ", unit="1/(width of the cube)²", above=0)
    theta_ladder: int = setting(
        7, "number of isotropic θ tried; gradient searches start from their local minima", at_least=1
    )
    restarts: int = setting(0, "further gradient searches from random θ", at_least=0)
    nugget: float = setting(
        1e-10, "added to the diagonal of R; grows in decades up to 1e-6 only while R cannot be factorised", at_least=0
    )

    def check(self) -> None:
        if self.theta_lower > self.theta_upper:
            raise SettingError(
                f"theta_lower, theta_upper: expected lower ≤ upper, got [{self.theta_lower:g}, {self.theta_upper:g}]; swap them"
            )

    def least_samples(self, d: int) -> int:
        """One more than the trend has terms, so that something is left to estimate σ² from."""
        return n_terms(self.trend, d) + 1

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> KrigingPredictor:
        """Samples u (n, d) in the unit cube, outputs y (n, q)."""
        return self._fit(u, y, lambda group, objective: self._estimated_theta(objective, rng))

    def refit(self, previous: Predictor, u: Array, y: Array, rng: np.random.Generator) -> KrigingPredictor:
        """Fit with the search started at the θ of an earlier predictor of these outputs.

        It has no ladder and no restarts.

        For loops that add a few samples at a time; a third to a half of the time of a fit. Neither rng nor anything of
        the earlier predictor but its θ is used.
        """
        if not isinstance(previous, KrigingPredictor):
            raise TypeError(f"Kriging: expected an earlier Kriging predictor, got {type(previous).__name__}")
        theta = previous.theta

        def theta_near_previous(group: int, objective: ThetaObjective) -> Array:
            return search_theta(objective, [theta[group]], self.theta_lower, self.theta_upper)

        return self._fit(u, y, theta_near_previous)

    def _fit(self, u: Array, y: Array, estimate_theta: Callable[[int, ThetaObjective], Array]) -> KrigingPredictor:
        """Model whose θ, by number of the group of outputs, is estimated by `estimate_theta` or fixed."""
        u, y, n_repeated = _without_repeats(u, y)
        n, d = u.shape
        if n < self.least_samples(d):
            raise SettingError(
                f"a {self.trend} trend in {d} parameters has {n_terms(self.trend, d)} terms and needs"
                f" {self.least_samples(d)} samples, got {n}: take more samples, or try trend=linear or trend=constant"
            )
        trend = trend_over(self.trend, u)
        mean, spread = y.mean(axis=0), y.std(axis=0)
        spread = np.where(spread > 0, spread, 1.0)
        standardised = (y - mean) / spread
        pairs, terms = SamplePairs.of(u), trend.terms(u)
        groups = []
        for number, outputs in enumerate(self._output_groups(y.shape[1])):
            objective = ThetaObjective(
                self.objective, CORRELATIONS[self.correlation], pairs, terms, standardised[:, outputs], self.nugget
            )
            theta = self._fixed_theta(self.theta, d) if self.theta is not None else estimate_theta(number, objective)
            groups.append(OutputGroup(outputs, theta, objective.estimate(theta)))
        return KrigingPredictor(u, y, CORRELATIONS[self.correlation], trend, groups, mean, spread, n_repeated)

    def _output_groups(self, q: int) -> Sequence[slice]:
        if self.theta_sharing == "shared":
            n_group = 1
        elif self.theta_sharing == "per_output":
            n_group = q
        else:
            n_group = min(self.groups or X_AND_Y, q)
        return [slice(group, None, n_group) for group in range(n_group)]

    def _fixed_theta(self, theta: Sequence[float], d: int) -> Array:
        if len(theta) not in (1, d):
            raise SettingError(f"theta: expected 1 or {d} values for {d} parameters, got {len(theta)}")
        return np.broadcast_to(np.array(theta, dtype=float), (d,))

    def _estimated_theta(self, objective: ThetaObjective, rng: np.random.Generator) -> Array:
        limits = self.theta_lower, self.theta_upper
        d = len(objective.pairs.squared)
        starts = isotropic_minima(objective, *limits, self.theta_ladder)
        starts += [np.exp(rng.uniform(np.log(limits[0]), np.log(limits[1]), size=d)) for _ in range(self.restarts)]
        return search_theta(objective, starts, *limits)


def _without_repeats(u: Array, y: Array) -> tuple[Array, Array, int]:
    """Samples without exact repeats, in their order, and the number left out."""
    u, y = np.asarray(u, dtype=float), np.asarray(y, dtype=float)
    if u.ndim != 2 or y.ndim != 2 or len(u) != len(y):
        raise ValueError(f"Kriging: expected samples (n, d) and outputs (n, q), got {u.shape} and {y.shape}")
    if not (np.isfinite(u).all() and np.isfinite(y).all()):
        raise ValueError("Kriging: samples and outputs must be finite; leave out samples that could not be evaluated")
    _, first, owner = np.unique(u, axis=0, return_index=True, return_inverse=True)
    kept = np.sort(first)
    if len(kept) == len(u):
        return u, y, 0
    difference = np.abs(y - y[first[owner.ravel()]])
    if np.any(difference > 1e-6 * y.std(axis=0)):
        raise ValueError(
            "Kriging: repeated samples have different outputs, which no interpolation can follow; average them first"
        )
    return u[kept], y[kept], len(u) - len(kept)

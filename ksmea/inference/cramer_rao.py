"""Cramér–Rao lower bound (CRLB) of unknowns before a measurement, from the Fisher information.

The covariance of an unbiased estimate is bounded below by the inverse of the information (`ksmea.likelihood.fisher`;
S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, eq. 3.24).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.likelihood.fisher import UNKNOWABLE, prior_rows, projected, whitened_sensitivity
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem, joint_values


@dataclass(frozen=True)
class Identifiability:
    """Information of data about the unknowns at x (d,), SI, as their whitened sensitivity J (m, d).

    JᵀJ is the Fisher information. Directions are judged in changes relative to `scale` (d,): the values, or the range
    of the search for a zero and for an angle.
    """

    x: Array
    whitened: Array
    scale: Array | None = None

    @property
    def information(self) -> Array:
        """Fisher information (d, d), 1/SI²."""
        return self.whitened.T @ self.whitened

    @property
    def crlb(self) -> Array:
        """Cramér–Rao lower bound, 1 σ: the smallest standard deviation (d,) of an unbiased estimate, SI.

        Infinite if most of it comes from directions that the data do not determine.
        """
        singular, directions = self._spectrum
        weighted = (directions / self._floored(singular)[:, None]) ** 2
        known = singular > UNKNOWABLE * singular[0]
        hidden = np.sum(weighted[~known], axis=0) > np.sum(weighted[known], axis=0)
        return np.where(hidden, np.inf, np.sqrt(np.sum(weighted, axis=0))) * self._scale

    @property
    def crlb_pct(self) -> Array:
        """The CRLB in per cent of the values (d,)."""
        return np.asarray(100 * self.crlb / np.abs(self.x))

    @property
    def worst_direction(self) -> Array:
        """Unit vector (d,) of the relative changes that the data determine least."""
        return np.asarray(self._spectrum[1][-1])

    @property
    def worst_crlb(self) -> float:
        """The CRLB of a relative change in that direction."""
        smallest = self._spectrum[0][-1]
        return float(1 / smallest) if smallest > 0 else np.inf

    @property
    def correlation(self) -> Array:
        """Correlation of the estimates (d, d) at the CRLB: ±1 if two unknowns are indistinguishable."""
        singular, directions = self._spectrum
        weighted = directions / self._floored(singular)[:, None]
        covariance = weighted.T @ weighted
        sd = np.sqrt(np.diag(covariance))
        return np.asarray(covariance / np.outer(sd, sd))

    @property
    def _scale(self) -> Array:
        scale = np.abs(self.x) if self.scale is None else self.scale
        return np.where(scale == 0, 1.0, scale)

    def _floored(self, singular: Array) -> Array:
        return np.maximum(singular, max(UNKNOWABLE * singular[0], np.finfo(float).tiny))

    @property
    def _spectrum(self) -> tuple[Array, Array]:
        """Singular values (d,), falling, and directions (d, d) by rows, of relative sensitivities.

        These are to relative changes of the unknowns.
        """
        scaled = self.whitened * self._scale
        missing = max(0, scaled.shape[1] - len(scaled))  # fewer data than unknowns tell nothing in some directions
        _, singular, directions = np.linalg.svd(np.pad(scaled, ((0, missing), (0, 0))), full_matrices=False)
        return singular, directions


def identifiability(
    problem: Problem,
    x: Array,
    noise: Noise,
    kind: str,
    *,
    noise_known: bool = True,
    beside: Array | None = None,
    exact: Collection[str] = (),
) -> Identifiability:
    """Information of data about the unknowns at x (d,), SI.

    The data are of a kind ('amplitude' or 'complex') with this noise.

    If the noise level is not known, the relative part and the floor of the noise are nuisance parameters. Numbers of the problem
    that are known to a tolerance are nuisance parameters as well, except for names in `exact`. `beside` are
    the values of all unknowns of the joint problem, used in place of x and these numbers as stated.
    """
    parameters, joint = problem.parameters, problem.joint
    values = joint_values(problem, joint, x) if beside is None else beside
    whitened = joint_sensitivity(joint, values, noise, kind, noise_known=noise_known)
    names = joint.parameters.names
    own = [names.index(name) for name in parameters.names]
    left_out = [*own, *(names.index(name) for name in exact)]
    others = np.setdiff1d(np.arange(whitened.shape[1]), left_out)
    width = np.append(joint.parameters.width, np.ones(whitened.shape[1] - len(names)))
    nuisance = whitened[:, others] * width[others]  # per SI some would fall below what `projected` takes for rounding
    has_no_size = (x == 0) | np.array([parameter.is_angle for parameter in parameters])
    scale = np.where(has_no_size, parameters.width, np.abs(x))
    return Identifiability(x, projected(whitened[:, own], nuisance), scale)


def joint_sensitivity(joint: Problem, x: Array, noise: Noise, kind: str, *, noise_known: bool = True) -> Array:
    """J (m, k) of data and priors, 1/SI.

    Columns are all unknowns of a joint problem at x (d,) SI, then the noise if its level is not known.
    """
    parameters = joint.parameters
    response, slope = Model(joint).linearise(parameters.to_cube(x))
    per_width, observable = slope / parameters.width, Observable(kind)
    whitened = whitened_sensitivity(response, per_width, noise, observable, noise_known=noise_known)
    if not len(parameters.with_prior):
        return whitened
    of_priors = prior_rows(parameters, whitened.shape[1])
    of_priors[:, : len(parameters)] /= parameters.width
    return np.vstack([whitened, of_priors])

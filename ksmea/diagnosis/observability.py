"""Observability: smallest detectable size of effects, and collinearity of two effects.

Both from sensitivities in units of the noise, the model's own unknowns and the noise level projected out: the part of
an effect that no other unknown can explain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
import scipy
from scipy.optimize import brentq

from ksmea.arrays import Array
from ksmea.diagnosis.trials import Candidate, Trial, best_by_name
from ksmea.fits.fitting import Fit, without_effects
from ksmea.likelihood.fisher import projected, span, whitened_sensitivity, with_prior_rows
from ksmea.numerics.parallel import Workers
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.stability import last_stable

POWER = 0.9  # chance of detecting an effect of the smallest detectable size


@dataclass(frozen=True)
class Detectable:
    """Smallest detectable and largest physical size of one unknown of an effect, SI.

    The former would be detected in 90 % of noise realisations; the latter leaves the rotor stable at the measured
    speeds.
    """

    parameter: Parameter
    size: float
    largest: float

    @property
    def is_observable(self) -> bool:
        return self.size < self.largest


def smallest_by_name(
    trials: Sequence[Trial], baseline: Fit, level: float, workers: Workers
) -> dict[str, tuple[str, tuple[Detectable, ...]]]:
    """For each effect, at its best location, the smallest sizes that the data would show."""
    by_name = best_by_name(trials)
    smallest = partial(smallest_detectable, baseline, level=level)
    sizes = workers.unseen.each(smallest, [trial.candidate for trial in by_name.values()])
    return {name: (trial.location, tuple(size)) for (name, trial), size in zip(by_name.items(), sizes)}


def smallest_detectable(baseline: Fit, candidate: Candidate, level: float) -> list[Detectable]:
    """For each unknown of an effect, alone; `level` is the p-value below which it counts as detected."""
    problem = candidate.effect.added_to(baseline.problem)
    parameters = candidate.effect.parameters(baseline.problem.machine)
    information = np.sum(_left_of_effect(baseline, problem, len(parameters)) ** 2, axis=0)
    needed = _noncentrality(len(parameters), level)
    return [
        Detectable(
            parameter,
            float(np.sqrt(needed / left)) * (parameter.upper - parameter.lower) if left > 0 else np.inf,
            _largest(baseline, problem, index),
        )
        for index, (parameter, left) in enumerate(zip(parameters, information), start=len(baseline.u))
    ]


def _largest(baseline: Fit, problem: Problem, index: int) -> float:
    """Largest size of one unknown of an effect, SI, alone.

    It is within its limits, and the rotor is stable with it.
    """
    parameter = problem.parameters.items[index]
    x = np.concatenate([baseline.x, np.zeros(len(problem.parameters) - len(baseline.x))])

    def is_stable(size: float) -> bool:
        x[index] = size
        return problem.is_stable(x)

    return max(abs(_last_stable(is_stable, end)) for end in (parameter.lower, parameter.upper))


def _last_stable(is_stable: Callable[[float], bool], end: float) -> float:
    """Size nearest to an end of its limits up to which from 0 the rotor is stable.

    It is within 0.1 % of the end.
    """
    if end == 0 or is_stable(end):
        return end
    return last_stable(lambda part: is_stable(part * end)) * end


def _left_of_effect(fit: Fit, problem: Problem, n_effect: int) -> Array:
    """Sensitivity (m, e) to the last unknowns of an extended problem at 0, all else projected out.

    `fit` is of the problem without them.
    """
    u = np.concatenate([fit.u, without_effects(problem, len(fit.u))])
    whitened, of_noise = _whitened(problem, u, fit, len(fit.u))
    return _without(whitened[:, -n_effect:], whitened[:, :-n_effect], of_noise)


def _without(effect: Array, others: Array, of_noise: Array) -> Array:
    """An effect's sensitivity if the other unknowns and the noise level are also fitted."""
    return projected(effect, _scaled(np.hstack([others, of_noise])))


def _scaled(columns: Array) -> Array:
    """Columns of unit length: what they span does not depend on units."""
    length = np.linalg.norm(columns, axis=0)
    unit: Array = columns[:, length > 0] / length[length > 0]
    return unit


def _whitened(problem: Problem, u: Array, fit: Fit, n_own: int) -> tuple[Array, Array]:
    """Sensitivities to the unknowns (m, d), and to the noise level (m, 2) or (m, 0) where that is known.

    The rows are the data and the priors of the first `n_own` unknowns. A prior of an effect's unknown, as a rate of the
    sweep by times of the rows, does not change the data and has no row, so that all effects have equal rows.
    """
    response, sensitivity = Model(problem).linearise(u)
    noise_known = not fit.likelihood.noise_is_estimated
    observable = fit.measurement.kind
    whitened = whitened_sensitivity(response, sensitivity, fit.noise, observable, noise_known=noise_known)
    whitened = with_prior_rows(whitened, Parameters(problem.parameters.items[:n_own]))
    return whitened[:, : len(u)], whitened[:, len(u) :]


def _noncentrality(n_unknown: int, level: float) -> float:
    """Noncentrality of χ² at which it exceeds its `level` quantile with probability POWER."""
    critical = scipy.stats.chi2.isf(level, n_unknown)
    return float(brentq(lambda value: scipy.stats.ncx2.sf(critical, n_unknown, value) - POWER, 1e-3, 1e4))


class Led(Protocol):
    """A fit with the unknowns of its effects last."""

    @property
    def fit(self) -> Fit: ...
    @property
    def n_unknown(self) -> int: ...


def collinearity(lead: Led, other: Candidate) -> float:
    """Collinearity of effects, as fitted, with another.

    The cosine between their change of the data and the nearest change that the other makes, if everything else is
    fitted too. At 1 the data cannot distinguish them. For effects that cannot act together it is 0 and says nothing.
    """
    reached = reach(lead, other)
    return 0.0 if reached is None else cosine(change_of(lead), reached)


def cosine(change: Array, reached: Array) -> float:
    """Between a change of the data (m,) and the nearest one among orthonormal ones (m, e)."""
    size = float(np.linalg.norm(change))
    return float(np.linalg.norm(reached.T @ change)) / size if size else 0.0


def change_of(lead: Led) -> Array:
    """Change of the data (m,) by the effects of a fit, in units of the noise.

    It is to first order, with everything else also fitted.
    """
    problem, u = lead.fit.problem, lead.fit.u
    n_own = len(u) - lead.n_unknown
    whitened, of_noise = _whitened(problem, u, lead.fit, n_own)
    size = u[n_own:] - without_effects(problem, n_own)
    return _without(whitened[:, n_own:] @ size[:, None], whitened[:, :n_own], of_noise)[:, 0]


def reach(lead: Led, other: Candidate) -> Array | None:
    """Orthonormal changes of the data (m, e) that another effect can make at a fit.

    Everything but the effects of the fit is also fitted. None if it cannot act together with them, or changes nothing.
    """
    u = lead.fit.u
    n_own, n_other = len(u) - lead.n_unknown, len(other.effect.parameters(lead.fit.problem.machine))
    if (problem := other.beside(lead.fit.problem)) is None:
        return None
    u = np.concatenate([u, without_effects(problem, len(u))])
    whitened, of_noise = _whitened(problem, u, lead.fit, n_own)
    return _basis(_without(whitened[:, -n_other:], whitened[:, :n_own], of_noise))


def own_reach(lead: Led, own: slice) -> Array | None:
    """`reach` of one of the effects of a fit, by its place among their unknowns."""
    u, n_own = lead.fit.u, len(lead.fit.u) - lead.n_unknown
    whitened, of_noise = _whitened(lead.fit.problem, u, lead.fit, n_own)
    return _basis(_without(whitened[:, n_own:][:, own], whitened[:, :n_own], of_noise))


def _basis(columns: Array) -> Array | None:
    return span(_scaled(columns), tolerance=1e-8) if np.any(columns) else None

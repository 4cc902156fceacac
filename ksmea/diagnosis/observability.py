"""Which effects data could show: the smallest detectable size, how collinear two effects are, and which further
measurement would tell them apart. All from sensitivities in units of the noise, those of the model's own unknowns and of
the noise level projected out: what is left of an effect when everything else is fitted along."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from ksmea.alignment import through
from ksmea.arrays import Array
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.diagnosis.fitting import Fit, without_effects
from ksmea.diagnosis.trials import Candidate, Trial
from ksmea.fisher import projected, span, whitened_difference, whitened_sensitivity
from ksmea.measurement import Noise
from ksmea.model import Model
from ksmea.parameters import Parameter
from ksmea.stability import last_stable
from ksmea.units import GRAM_MILLIMETRE, RPM

POWER = 0.9  # chance of detecting an effect of the smallest detectable size


@dataclass(frozen=True)
class Detectable:
    """The smallest size of one unknown of an effect (SI) that would be detected in 90 % of noise draws, and the largest that
    is physical and leaves the rotor stable at the measured speeds."""

    parameter: Parameter
    size: float
    largest: float

    @property
    def is_observable(self) -> bool:
        return self.size < self.largest


@dataclass(frozen=True)
class Split:
    """A further measurement and the deviance by which it is expected to tell two effects apart, now and with it."""

    measurement: str
    now: float
    then: float


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
    """The largest size of one unknown of an effect, SI, alone: within its limits, and with which the rotor is stable."""
    parameter = problem.parameters.items[index]
    x = np.concatenate([baseline.x, np.zeros(len(problem.parameters) - len(baseline.x))])

    def is_stable(size: float) -> bool:
        x[index] = size
        return problem.is_stable(x)

    return max(abs(_last_stable(is_stable, end)) for end in (parameter.lower, parameter.upper))


def _last_stable(is_stable: Callable[[float], bool], end: float) -> float:
    """The size nearest to an end of its limits up to which from 0 the rotor is stable, within 0.1 % of the end."""
    if end == 0 or is_stable(end):
        return end
    return last_stable(lambda part: is_stable(part * end)) * end


def _left_of_effect(fit: Fit, problem: Problem, n_effect: int) -> Array:
    """Sensitivity (m, e) to the last unknowns of an extended problem at 0, all else projected out; `fit` is of the
    problem without them."""
    u = np.concatenate([fit.u, without_effects(problem, len(fit.u))])
    whitened, of_noise = _whitened(problem, u, fit)
    return _without(whitened[:, -n_effect:], whitened[:, :-n_effect], of_noise)


def _without(effect: Array, others: Array, of_noise: Array) -> Array:
    """An effect's sensitivity when the other unknowns and the noise level are fitted along."""
    return projected(effect, _scaled(np.hstack([others, of_noise])))


def _scaled(columns: Array) -> Array:
    """Columns of unit length: what they span does not depend on units."""
    length = np.linalg.norm(columns, axis=0)
    unit: Array = columns[:, length > 0] / length[length > 0]
    return unit


def _whitened(problem: Problem, u: Array, fit: Fit) -> tuple[Array, Array]:
    """Sensitivities to the unknowns (m, d), and to the noise level (m, 2) or (m, 0) where that is known."""
    response, sensitivity = Model(problem).linearise(u)
    noise_known = not fit.likelihood.noise_is_estimated
    kind = fit.likelihood.measurement.kind
    whitened = whitened_sensitivity(response, sensitivity, fit.noise, kind, noise_known=noise_known)
    return whitened[:, : len(u)], whitened[:, len(u) :]


def _noncentrality(n_unknown: int, level: float) -> float:
    """Of χ² with so many degrees of freedom, such that it exceeds its `level` quantile with probability POWER."""
    critical = chi2.isf(level, n_unknown)
    return float(brentq(lambda value: ncx2.sf(critical, n_unknown, value) - POWER, 1e-3, 1e4))


def collinearity(trial: Trial, other: Candidate) -> float:
    """Collinearity of an effect, as fitted, with another: the cosine between its change of the data and the nearest change
    that the other makes, everything else being fitted along. At 1 the data cannot tell them apart."""
    problem = other.effect.added_to(trial.fit.problem)
    n_other = len(other.effect.parameters(trial.fit.problem.machine))
    u = np.concatenate([trial.fit.u, without_effects(problem, len(trial.fit.u))])
    whitened, of_noise = _whitened(problem, u, trial.fit)
    own = slice(len(u) - n_other - trial.n_unknown, len(u) - n_other)
    baseline = whitened[:, : own.start]
    size = trial.fit.u[own] - without_effects(trial.fit.problem, own.start)
    change = _without(whitened[:, own] @ size[:, None], baseline, of_noise)[:, 0]
    reach = _without(whitened[:, own.stop :], baseline, of_noise)
    if not np.any(change) or not np.any(reach):
        return 0.0
    directions = span(_scaled(reach), tolerance=1e-8)
    return float(np.linalg.norm(directions.T @ change) / np.linalg.norm(change))


def best_split(one: Fit, other: Fit) -> Split | None:
    """The further measurement that would tell two fitted effects apart best; None where none would."""
    now = _separation([(one.problem, other.problem)], one, other)
    present = (one.problem, other.problem)
    splits = [
        Split(name, now, _separation([present, added], one, other))
        for name, added in _further(one.problem, other.problem)
    ]
    best = max(splits, key=lambda split: split.then, default=None)
    return best if best is not None and best.then > now + 1.0 else None


def _further(one: Problem, other: Problem) -> Iterator[tuple[str, tuple[Problem, Problem]]]:
    """Measurements that might be added, as both models see them."""
    speed, channels = one.speed, one.channels
    for site in one.sites:
        probes = [Channel(float(site), direction) for direction in ("x", "y")]
        if not any(probe in channels for probe in probes):
            yield f"probes in x and y at {site:.3g} m", (through(one, probes), through(other, probes))
    highest = np.max(speed)
    higher = np.linspace(highest, 1.5 * highest, len(speed) // 2 + 1)[1:]
    name = f"speeds up to {higher[-1] / RPM:.0f} rpm"
    yield name, (one.at(higher, channels), other.at(higher, channels))
    magnitudes = [item.upper / 2 for item in one.parameters if item.is_unbalance]
    if magnitudes and one.takes_unbalance:
        magnitude = min(magnitudes)
        for site in one.sites:
            name = f"a second run with {magnitude / GRAM_MILLIMETRE:.3g} g mm at {site:.3g} m"
            yield name, (one.with_unbalance(site, magnitude, 0.0), other.with_unbalance(site, magnitude, 0.0))


def _separation(data: Sequence[tuple[Problem, Problem]], one: Fit, other: Fit) -> float:
    """Expected deviance difference between the model that makes the data and the other, all of whose unknowns are fitted
    along: the squared distance of the two predictions from the tangent of the other. Where each datum or run has a noise of its
    own, all have the median."""
    noise = Noise(float(np.median(one.noise.relative)), float(np.median(one.noise.floor)))
    kind = one.likelihood.measurement.kind
    distances, tangents = [], []
    for made, fitted in data:
        response = made.response(one.x[None])[0]
        found, slope = Model(fitted).linearise(fitted.parameters.to_cube(other.x))
        sensitivity = slope / fitted.parameters.width * other.problem.parameters.width
        distances.append(whitened_difference(response, found, noise, kind))
        whitened = whitened_sensitivity(found, sensitivity, noise, kind)
        tangents.append(whitened[: len(distances[-1])])
    distance = np.concatenate(distances)
    return float(np.sum(projected(distance[:, None], _scaled(np.vstack(tangents))) ** 2))

"""Further measurement that distinguishes effects which fit the data about as well.

Candidates, by rising effort: a run with a known weight at a disk, probes in another plane, a run at higher speeds.
Each is judged by all ordered pairs of explanations: one makes the data, the other is fitted to them with all of its
unknowns. The misfit of that fit, in units of the noise, is their separation. A linear fit ranks the candidates of a
kind; the first ones are judged by the full fit, which also holds outside the range of the linear one. With
amplitudes alone the signs of an effect's sizes may be open: each choice may be true, and a fit starts from all of
them.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.fits.fitting import Fit, without_effects
from ksmea.inference.maximisation import distinct, maximise
from ksmea.likelihood.fisher import projected, whitened_difference, whitened_sensitivity
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.campaign import Campaign, Run, Weight, shared_name
from ksmea.measurement.channel import Channel, further_directions, named
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.problem.alignment import aligned
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from ksmea.problem.trial_weights import trial_weights
from ksmea.units import RPM

# Deviance from which two explanations are told apart: noise moves it by twice its root, so that at 20 it stays above the 6
# within which effects are called ambiguous in 94 of 100 draws.
ENOUGH = 20.0
NEAR = 6.0  # deviance within which other signs explain the data about as well
MANY = 4  # sizes of an effect, or of two, whose signs are turned one by one
N_REFITTED = 3  # candidates of a kind that are judged by fits
HIGHER = 1.5  # times the highest speed, up to which a further run goes
EXPECTED_GAIN = 0.1  # of the deviance, below which a fit is at its end
MAX_ITERATIONS = 50  # of a fit to what another explanation predicts
FARTHER = 4.0  # times the least separation: fits of what linear ones hold to be farther away come no nearer
FURTHER = "further"  # name of the run that is added


@dataclass(frozen=True)
class Pair:
    """Two explanations by name, with their expected deviance difference.

    It is given now and after a further measurement.
    """

    one: str
    other: str
    now: float
    then: float


@dataclass(frozen=True)
class Split:
    """A further measurement in words, the layout of all data with it, and its effect on each pair.

    `weight` is the weight in a further run at the present speeds, None if no run carries one."""

    measurement: str
    layout: Layout
    pairs: tuple[Pair, ...]
    weight: Weight | None = None

    @property
    def distinguished(self) -> tuple[Pair, ...]:
        """Pairs of explanations that it distinguishes."""
        return tuple(pair for pair in self.pairs if pair.then >= ENOUGH)

    @property
    def together(self) -> tuple[Pair, ...]:
        """Pairs of explanations that it does not distinguish."""
        return tuple(pair for pair in self.pairs if pair.then < ENOUGH)


def best_split(explanations: Mapping[str, Fit], d: int, workers: Workers = ALONE) -> Split | None:
    """Further measurement of least effort that distinguishes all fitted explanations, or the best one.

    None if no measurement distinguishes any two. Explanations are keyed by name; the unknowns behind the first d belong
    to effects. Workers share the candidates."""
    names, first = tuple(explanations), next(iter(explanations.values()))
    fits = [_with_other_signs(fit, d) for fit in explanations.values()]
    pairs = list(itertools.combinations(range(len(fits)), 2))
    now = _Seen.of(fits, first.measurement.layout).separations(pairs)
    best, best_then = None, now
    for propose in (_with_weights, _through_other_planes, _at_higher_speeds):
        candidates = []
        for further in propose(first):
            candidates.append((further, _Seen.of(fits, further.layout)))
            workers.progress()
        candidates.sort(key=lambda candidate: _merit(candidate[1].linear_separations(pairs)), reverse=True)
        refitted = [seen for _, seen in candidates[:N_REFITTED]]
        separations = workers.each(partial(_Seen.separations, pairs=pairs), refitted)
        for (further, _), then in zip(candidates, separations):
            if _merit(then) > _merit(best_then):
                best, best_then = further, then
        if np.all(best_then >= ENOUGH):
            break
    if best is None or np.all(best_then < ENOUGH):
        return None
    named_pairs = (
        Pair(names[one], names[other], float(before), float(after))
        for (one, other), before, after in zip(pairs, now, best_then)
    )
    return Split(best.words, best.layout, tuple(named_pairs), best.weight)


def _with_other_signs(fit: Fit, d: int) -> tuple[Fit, ...]:
    """The fit, and those from other signs of its sizes that explain the data about as well.

    Of many sizes all signs are turned at once.
    """
    likelihood, u = fit.likelihood, fit.u
    zero, found = without_effects(fit.problem, d), [fit.point]
    others = list(itertools.product((1, -1), repeat=len(zero)))[1:] if len(zero) <= MANY else [(-1,)]
    for signs in others:
        turned = np.concatenate([u[:d], np.clip(zero + signs * (u[d:] - zero), 0, 1), fit.point.theta[len(u) :]])
        point = maximise(likelihood, turned, max_iterations=MAX_ITERATIONS, tolerance=EXPECTED_GAIN)
        if point.deviance < fit.deviance + NEAR:
            found.append(maximise(likelihood, point, max_iterations=MAX_ITERATIONS))
    return tuple(fit if point is fit.point else Fit(likelihood, point) for point in distinct(likelihood, found))


def _merit(separations: Array) -> tuple[int, float]:
    """Number of pairs distinguished, then the sum of the separations, each cut at `ENOUGH`.

    If all pairs are distinguished, their number and the least separation.
    """
    is_enough = separations >= ENOUGH
    if np.all(is_enough):
        return len(separations), float(np.min(separations))
    return int(np.sum(is_enough)), float(np.sum(np.minimum(separations, ENOUGH)))


@dataclass(frozen=True)
class _Further:
    """A measurement that might be added, in words, and the layout of all data with it."""

    words: str
    layout: Layout
    weight: Weight | None = None


def _with_weights(fit: Fit) -> Iterator[_Further]:
    layout = fit.measurement.layout
    for weight in trial_weights(fit.problem, fit.x):
        speed = layout.speed[layout.rows[0]]
        yield _Further(f"A further run with {weight}", _with_run(layout, speed, (weight,)), weight)


def _at_higher_speeds(fit: Fit) -> Iterator[_Further]:
    layout = fit.measurement.layout
    highest = np.max(layout.speed)
    speed = np.linspace(highest, HIGHER * highest, len(layout.speed[layout.rows[0]]) // 2 + 1)[1:]
    if len(speed):
        yield _Further(f"A further run up to {speed[-1] / RPM:.0f} rpm", _with_run(layout, speed, ()))


def _through_other_planes(fit: Fit) -> Iterator[_Further]:
    layout = fit.measurement.layout
    directions = further_directions(layout.channels)
    for site in fit.problem.sites:
        probes = tuple(Channel(float(site), direction) for direction in directions)
        if not any(probe in layout.channels for probe in probes):
            words = f"The same with further probes in {' and '.join(map(named, directions))} at {site:.4g} m"
            yield _Further(words, dataclasses.replace(layout, channels=(*layout.channels, *probes), locations=()))


def _with_run(layout: Layout, speed: Array, weights: tuple[Weight, ...]) -> Layout:
    """Layout with one more run, whose speed goes in the direction of the first run."""
    present = layout.campaign or Campaign((Run("present", len(layout.speed)),))
    runs = (*present.runs, Run(FURTHER, len(speed), weights, present.runs[0].direction))
    return dataclasses.replace(
        layout, speed=np.concatenate([layout.speed, speed]), campaign=dataclasses.replace(present, runs=runs)
    )


@dataclass(frozen=True)
class _Explanation:
    """Fitted explanation as a layout sees it: unknowns u (d,) in the unit cube, and prediction."""

    problem: Problem
    u: Array
    response: ComplexArray  # (n_speed, n_channel), m
    slope: ComplexArray  # (n_speed, n_channel, d)

    @classmethod
    def of(cls, fit: Fit, layout: Layout) -> _Explanation:
        problem = aligned(fit.problem, layout)
        known = dict(zip(fit.problem.parameters.names, fit.x))
        shared = {shared_name(name): value for name, value in known.items()}
        names = problem.parameters.names  # a phase origin may be new, and starts at 0
        x = np.array([known.get(name, shared.get(shared_name(name), 0.0)) for name in names])
        u = problem.parameters.to_cube(x)
        return cls(problem, u, *Model(problem).linearise(u))


@dataclass(frozen=True)
class _Seen:
    """All explanations evaluated in a layout, with the noise of the first fit."""

    explanations: tuple[tuple[_Explanation, ...], ...]  # of each name
    layout: Layout
    noise: Noise
    noise_is_estimated: bool

    @classmethod
    def of(cls, fits: Sequence[Sequence[Fit]], layout: Layout) -> _Seen:
        """If each datum or run has its own noise, the median is used for all."""
        first = fits[0][0]
        noise = Noise(float(np.median(first.noise.relative)), float(np.median(first.noise.floor)))
        explanations = tuple(tuple(_Explanation.of(fit, layout) for fit in own) for own in fits)
        return cls(explanations, layout, noise, first.likelihood.noise_is_estimated)

    @property
    def observable(self) -> Observable:
        return Observable(self.layout.kind)

    def separations(self, pairs: Sequence[tuple[int, int]]) -> Array:
        """Deviances by which the pairs are distinguished, whichever of the two makes the data."""
        found = np.array([self._least_fitted(pair) for pair in pairs])
        if not self.noise_is_estimated:
            return found
        n = self.explanations[0][0].response.size * self.observable.dimensions
        return np.asarray(n * np.log1p(found / n))  # what is not explained counts as noise

    def linear_separations(self, pairs: Sequence[tuple[int, int]]) -> Array:
        """Separations of the pairs by linear fits with known noise."""
        return np.array([min(itertools.starmap(self._linear, self._either_way(pair))) for pair in pairs])

    def _least_fitted(self, pair: tuple[int, int]) -> float:
        """The least separation of a pair by fits, those first that are nearest by linear ones.

        A fit that these hold to be many times as far as the least is left out, and one is given up where it would not
        come below it.
        """
        linear = [(self._linear(made, fitted), made, fitted) for made, fitted in self._either_way(pair)]
        least = np.inf
        for distance, made, fitted in sorted(linear, key=lambda each: each[0]):
            if distance > FARTHER * least:
                break
            least = min(least, self._fitted(made, fitted, least))
        return least

    def _either_way(self, pair: tuple[int, int]) -> list[tuple[_Explanation, _Explanation]]:
        """Any two explanations of a pair of names.

        The one that makes the data, and the one that is fitted to them.
        """
        one, other = (self.explanations[index] for index in pair)
        return [both for a, b in itertools.product(one, other) for both in ((a, b), (b, a))]

    def _linear(self, made: _Explanation, fitted: _Explanation) -> float:
        """Squared distance of what one explanation predicts from the tangent of another."""
        distance = whitened_difference(made.response, fitted.response, self.noise, self.observable)
        tangent = whitened_sensitivity(fitted.response, fitted.slope, self.noise, self.observable)[: len(distance)]
        length = np.linalg.norm(tangent, axis=0)
        scaled = tangent[:, length > 0] / length[length > 0]
        return float(np.sum(projected(distance[:, None], scaled) ** 2))

    def _fitted(self, made: _Explanation, fitted: _Explanation, least: float) -> float:
        """Deviance of an explanation fitted to the prediction of another, minus the deviance of the latter.

        The fit stops early if it would not come below `least`."""
        layout = self.layout
        predicted = Measurement(
            layout.speed,
            layout.channels,
            self.observable.seen(made.response),
            self.noise,
            layout.source,
            layout.phase_known,
            layout.campaign,
        )
        own = Likelihood(Model(made.problem), predicted).deviance(made.u)
        likelihood = Likelihood(Model(fitted.problem), predicted)
        best = maximise(
            likelihood, fitted.u, max_iterations=MAX_ITERATIONS, tolerance=EXPECTED_GAIN, ceiling=own + least
        )
        return max(best.deviance - own, 0.0)

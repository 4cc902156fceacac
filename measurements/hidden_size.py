"""Size of a hidden effect without a given size.

It is as large as the response itself, or as shows by a given drop of the deviance;
and the rotor stays stable.

A draw of an effect is kept if the rotor is stable with it, and the root mean square over speeds and channels of what it
changes, as the data see it, is between `NOTICED` times the root mean square of the response without it. Else all its
values are scaled by one factor to a change between these ends, log-uniformly distributed. If a physical limit or the
loss of stability comes before the upper end, the largest possible change replaces the upper end, and half of it
replaces the lower end if it is less. If a rotor is stable again with more of it, as on a film that is pushed far off
centre, an unstable size between is passed over downwards.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ksmea.arrays import Array
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter
from ksmea.problem.problem import Problem

# Of the rms of the response. The ends are a choice: a tenth stands out of noise of some per cent; two responses of one size
# that have nothing in common differ by √2, which is what a critical speed makes that is off by more than its width.
NOTICED = (0.1, 1.5)
SMALLEST = 1e-4  # of the largest size: the least that is considered
N_HALVING = 10  # of that range, in factors: the loss of stability is found within 1 %
UNSEEN = 1e-9  # of the rms of the response: rounding
N_SIZE = 33  # sizes that are looked at, each a third larger than the one before
N_BISECTION = 6  # of a third: the size is found within 1 %


def drawn_size(
    effect: AnyEffect, problem: Problem, x: Array, observable: Observable, rng: np.random.Generator
) -> Array:
    """Values (e,) SI of an effect's unknowns on a problem at values x (d,) SI of its own."""
    theta = np.array(effect.draw(problem, rng), dtype=float)
    part, offset = rng.random(2)
    extended = effect.added_to(problem)

    def is_stable(factor: float) -> bool:
        return extended.is_stable(np.append(x, factor * theta))

    largest = _largest_stable(is_stable, _largest_factor(theta, effect.parameters(problem)))
    if not largest:  # nor is the rotor without it
        return theta
    rising = largest * SMALLEST ** (1 - (np.arange(N_SIZE) + offset) / N_SIZE)
    factor = np.append(rising, 1.0)
    sets = np.hstack([np.tile(x, (len(factor), 1)), factor[:, None] * theta])
    *changes, drawn = relative_change(problem, extended, x, sets, observable)
    change = np.maximum.accumulate(changes)
    most = min(NOTICED[1], change[-1])
    least = min(NOTICED[0], most / 2)
    if most < UNSEEN or (least <= drawn <= NOTICED[1] and largest >= 1 and is_stable(1.0)):
        return theta * min(1.0, largest)
    wanted = least * (most / least) ** part
    # the largest size up to which no size changes more than is wanted
    index = max(int(np.searchsorted(change, wanted, side="right")) - 1, 0)
    while index and not is_stable(rising[index]):
        index -= 1
    return theta * rising[index]


def size_of_drop(
    effect: AnyEffect,
    problem: Problem,
    x: Array,
    drop: float,
    noise: Noise,
    observable: Observable,
    rng: np.random.Generator,
) -> Array:
    """Values (e,) SI with which the nearest fit without the effect has an expected deviance drop.

    The deviance of `drop` is in data without noise. The values are a draw, scaled by one factor, as far as its limits
    and the stability of the rotor admit.
    """
    theta = np.array(effect.draw(problem, rng), dtype=float)
    extended = effect.added_to(problem)
    largest = _largest_factor(theta, effect.parameters(problem))
    largest = _largest_stable(lambda size: extended.is_stable(np.append(x, size * theta)), largest)
    u = problem.parameters.to_cube(x)
    below, above = 0.0, largest
    for size in largest * SMALLEST ** (1 - np.arange(1, N_SIZE + 1) / N_SIZE):
        left, fitted = _left_by_fit(problem, extended, np.append(x, size * theta), noise, observable, u)
        if left >= drop:
            above = size
            break
        below, u = size, fitted
    for _ in range(N_BISECTION):
        size = (below + above) / 2
        left, fitted = _left_by_fit(problem, extended, np.append(x, size * theta), noise, observable, u)
        below, above, u = (below, size, u) if left >= drop else (size, above, fitted)
    return below * theta


def _left_by_fit(
    problem: Problem, extended: Problem, x: Array, noise: Noise, observable: Observable, start: Array
) -> tuple[float, Array]:
    """Deviance of a fit to the noise-free data of an extended problem, and the end of the fit.

    The fit starts from (d,) in the unit cube; the data are at values (d + e,) SI.
    """
    data = Measurement(problem.speed, problem.channels, observable.seen(extended.response(x[None])[0]), noise, "made")
    likelihood = Likelihood(Model(problem), data)
    fitted = maximise(likelihood, start).theta
    left = likelihood.left(fitted, problem.response(problem.parameters.to_si(fitted)[None])[0])
    return float(observable.dimensions * np.sum(np.abs(left) ** 2)), fitted


def relative_change(problem: Problem, extended: Problem, x: Array, sets: Array, observable: Observable) -> Array:
    """Rms change of the response by an effect, relative to the rms response without it, (n,).

    It is for values (n, d + e) SI of an extended problem and x (d,) of the problem without the effect.
    """
    without = observable.seen(problem.response(x[None])[0])
    changed = observable.seen(extended.response(sets)) - without
    return np.asarray(np.sqrt(np.mean(np.abs(changed) ** 2, axis=(1, 2)) / np.mean(np.abs(without) ** 2)))


def _largest_factor(theta: Array, parameters: tuple[Parameter, ...]) -> float:
    """The largest factor that keeps all values within their limits."""
    room = [
        (item.upper if value > 0 else item.lower) / value
        for item, value in zip(parameters, theta, strict=True)
        if value
    ]
    return min(room, default=1.0)


def _largest_stable(is_stable: Callable[[float], bool], largest: float) -> float:
    """The largest factor with which the rotor is stable, or one where it becomes unstable.

    It is 0 if none is found.
    """
    if is_stable(largest):
        return largest
    low, high = SMALLEST * largest, largest
    if not is_stable(low):
        return 0.0
    for _ in range(N_HALVING):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return low

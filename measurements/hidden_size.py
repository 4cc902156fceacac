"""How large a hidden effect is that nobody gives a size: as large as the response itself, and the rotor stays stable.

A draw of an effect says in which direction and proportion its unknowns stand. All of them are scaled by one factor, until
the root mean square over speeds and channels of what the effect changes, as the data see it, is a part between `NOTICED` of
that of the response without it, each factor as likely as any other. That range is a choice: a change of a tenth stands
out of noise of some per cent, and one of the whole is what a critical speed makes that is off by the 5 % which a
verified model may have (API 684, unbalance response verification), as it moves a sharp peak by more than its width. Where
a physical limit or the loss of stability comes before the whole, the largest change that is possible stands in its place.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ksmea.arrays import Array
from ksmea.contracts import AnyEffect, Problem
from ksmea.kind import Kind
from ksmea.parameters import Parameter

NOTICED = (0.1, 1.0)  # of the rms of the response
SMALLEST = 1e-4  # of the largest size: the least that is considered
N_HALVING = 10  # of that range, in factors: the loss of stability is found within 1 %
UNSEEN = 1e-9  # of the rms of the response: rounding
N_SIZE = 33  # sizes that are looked at, each a third larger than the one before


def drawn_size(effect: AnyEffect, problem: Problem, x: Array, kind: Kind, rng: np.random.Generator) -> Array:
    """Values (e,) SI of an effect's unknowns on a problem at values x (d,) SI of its own."""
    theta = np.array(effect.draw(problem, rng), dtype=float)
    part = np.exp(rng.uniform(*np.log(NOTICED)))
    extended = effect.added_to(problem)
    within_limits = _largest_factor(theta, effect.parameters(problem))
    largest = _largest_stable(lambda size: extended.is_stable(np.append(x, size * theta)), within_limits)
    if not largest:  # nor is the rotor without it
        return theta
    factor = largest * np.geomspace(SMALLEST, 1.0, N_SIZE)
    sets = np.hstack([np.tile(x, (N_SIZE, 1)), factor[:, None] * theta])
    change = np.maximum.accumulate(relative_change(problem, extended, x, sets, kind))
    if change[-1] < UNSEEN:
        return theta * factor[-1]
    wanted = part * min(NOTICED[1], change[-1])
    if wanted <= change[0]:
        return theta * factor[0]
    above = int(np.searchsorted(change, wanted))
    between = np.log(wanted / change[above - 1]) / np.log(change[above] / change[above - 1])
    return np.asarray(theta * factor[above - 1] * (factor[above] / factor[above - 1]) ** between)


def relative_change(problem: Problem, extended: Problem, x: Array, sets: Array, kind: Kind) -> Array:
    """The rms of what an effect changes relative to that of the response without it, (n,), for values (n, d + e) SI of an
    extended problem and x (d,) of the problem without it."""
    without = kind.seen(problem.response(x[None])[0])
    changed = kind.seen(extended.response(sets)) - without
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
    """The largest factor with which the rotor is stable: what has become unstable stays so as it grows. 0 where none is."""
    if is_stable(largest):
        return largest
    low, high = SMALLEST * largest, largest
    if not is_stable(low):
        return 0.0
    for _ in range(N_HALVING):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return low

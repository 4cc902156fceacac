"""Central differences inside a box, and a small memory of costly results.

The points are handed out and the values taken back, so that whoever evaluates them counts them and may do so in one
batch.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array

Number = TypeVar("Number", np.float64, np.complex128)

CUBE_STEP = 1e-5  # in the unit cube: near the cube root of the rounding error


@dataclass(frozen=True)
class CentralDifferences:
    """Differences about a point (d,).

    `points` (2 d, d) are to be evaluated, first those above it in each coordinate, then those below; `widths` (d,) are
    their distances.

    >>> parabola = central_differences(np.array([3.0, 1.0]), 0.5, np.zeros(2), np.full(2, 9.0))
    >>> parabola.derivative(parabola.points**2)
    array([[6., 0.],
           [0., 2.]])
    """

    points: Array
    widths: Array

    def derivative(self, values: NDArray[Number]) -> NDArray[Number]:
        """Values (2 d, …) at the points → derivatives (…, d)."""
        above, below = np.split(values, 2)
        return np.moveaxis((above - below) / self.widths.reshape(-1, *[1] * (values.ndim - 1)), 0, -1)


def central_differences(x: Array, step: Array | float, lower: Array, upper: Array) -> CentralDifferences:
    """Differences about x (d,) with a step to both sides, cut at the limits (d,) of a box.

    The step is one for all, or (d,). They are of second order, and of first order on a limit.

    The error is about step² + rounding / step, so the cube root of the rounding error is a good step.
    """
    above, below = np.minimum(x + step, upper), np.maximum(x - step, lower)
    own = np.eye(len(x), dtype=bool)
    return CentralDifferences(np.concatenate([np.where(own, above, x), np.where(own, below, x)]), above - below)


def cube_differences(u: Array) -> CentralDifferences:
    """Differences about a point (d,) of the unit cube, inside it."""
    return central_differences(u, CUBE_STEP, np.zeros(len(u)), np.ones(len(u)))


def differenced(
    function: Callable[[Array], NDArray[Number]], x: Array, step: Array | float, lower: Array, upper: Array
) -> tuple[NDArray[Number], NDArray[Number]]:
    """Function of points (n, d) with values (n, …) at x (d,), (…), and its derivatives (…, d).

    They are central differences inside a box.
    """
    differences = central_differences(x, step, lower, upper)
    values = function(np.concatenate([x[None], differences.points]))
    return values[0], differences.derivative(values[1:])


Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class Kept(OrderedDict[Key, Value]):
    """Large results of `recent` that stay in their process: another one receives none of them.

    >>> import pickle
    >>> pickle.loads(pickle.dumps(Kept(a=1)))
    Kept()
    """

    def __reduce__(self) -> tuple[type[Kept[Key, Value]], tuple[()]]:
        return Kept, ()


def recent(kept: OrderedDict[Key, Value], key: Key, make: Callable[[], Value], most: int) -> Value:
    """Return the value kept under a key, made if missing; the `most` last requested values are kept.

    >>> kept = OrderedDict([("a", 1), ("b", 2)])
    >>> recent(kept, "a", lambda: 0, 2), recent(kept, "c", lambda: 3, 2), list(kept)
    (1, 3, ['a', 'c'])
    """
    if key not in kept:
        kept[key] = make()
        if len(kept) > most:
            kept.popitem(last=False)
    kept.move_to_end(key)
    return kept[key]

"""Screening of the unit cube for starts of local searches; initial designs of experiments.

The sharp peaks of a lightly damped rotor give misfit and likelihood many narrow minima. The mean |ln ratio| of
predicted and measured responses has wide basins instead. It is computed at the points of a Sobol' sequence, and
searches start from the best of them that lie apart.

I. M. Sobol', USSR Comput. Math. Math. Phys. 7 (1967) 86–112, doi 10.1016/0041-5553(67)90144-9; scrambled as A. B. Owen,
J. Complexity 14 (1998) 466–489, doi 10.1006/jcom.1998.0487.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray


@dataclass(frozen=True)
class Screened:
    """Points (n, d) of the unit cube and their misfits (n,), best first; `ranked` makes them so."""

    points: Array
    misfits: Array

    def best(self, count: int) -> Screened:
        """The best points, `count` at most."""
        return Screened(self.points[:count], self.misfits[:count])

    def below(self, misfit: float) -> Screened:
        """The points whose misfit is lower than one; all that have a misfit where that is not one, nan.

        >>> ranked(np.array([[0.1], [0.2], [0.3]]), np.array([3.0, 1.0, 2.0])).below(2.0).points.ravel()
        array([0.2])
        """
        return self.best(int(np.searchsorted(self.misfits, misfit)))

    def apart(self, count: int, distance: float) -> Screened:
        """Best points, `count` at most, no nearer than `distance` to a better one among them.

        >>> ranked(np.array([[0.5], [0.1], [0.52], [0.9]]), np.array([1.0, 3.0, 2.0, 4.0])).apart(2, 0.1).points.ravel()
        array([0.5, 0.1])
        """
        chosen: list[int] = []
        left = np.arange(len(self.points))
        while len(left) and len(chosen) < count:
            chosen.append(int(left[0]))
            left = left[1:]
            left = left[np.linalg.norm(self.points[left] - self.points[chosen[-1]], axis=1) >= distance]
        return Screened(self.points[chosen], self.misfits[chosen])

    def thinned(self, count: int) -> Array:
        """Points (count, d) at most: the best, and fewer and fewer of those behind them."""
        last = len(self.points) - 1
        return np.asarray(self.points[np.unique(np.rint(last * np.linspace(0, 1, count) ** 2).astype(int))])


def ranked(points: Array, misfits: Array) -> Screened:
    """Points (n, d) by rising misfit (n,); of equal ones the first stays first."""
    order = np.argsort(misfits, kind="stable")
    return Screened(points[order], misfits[order])


def joined(*parts: Screened) -> Screened:
    """All points of several screenings."""
    return ranked(np.concatenate([part.points for part in parts]), np.concatenate([part.misfits for part in parts]))


def sobol(n: int, d: int, rng: np.random.Generator | None = None) -> Array:
    """The first n points (n, d) of a Sobol' sequence, scrambled where there is a generator.

    Balanced best where n is a power of two.
    """
    return np.asarray(
        scipy.stats.qmc.Sobol(d, scramble=rng is not None, rng=rng).random_base2((n - 1).bit_length())[:n]
    )


def log_ratio(predicted: Array | ComplexArray, measured: Array | ComplexArray) -> Array | ComplexArray:
    """ln(p / y): real of amplitudes, complex of responses with the phase wrapped to ±π.

    `measured` has no zeros; a prediction of 0 counts as the smallest number.
    """
    ratio, tiny = predicted / measured, np.finfo(float).tiny
    return np.log(np.maximum(ratio, tiny)) if np.isrealobj(ratio) else np.log(np.where(ratio == 0, tiny, ratio))


def mean_log_misfit(log_ratio: Array | ComplexArray) -> Array:
    """Mean |ln ratio| (k,) over all data of each prediction (k, …)."""
    return np.asarray(np.mean(np.abs(log_ratio), axis=tuple(range(1, log_ratio.ndim))))


def latin_hypercube(samples: int, d: int, rng: np.random.Generator) -> Array:
    """Latin hypercube (samples, d).

    Every one of `samples` equal slices of every coordinate holds one point.

    M. D. McKay, R. J. Beckman and W. J. Conover, Technometrics 21 (1979) 239–245, doi 10.2307/1268522. The paper names
    the Latin hypercube and no more, so nothing is optimised on top of it.
    """
    return scipy.stats.qmc.LatinHypercube(d, rng=rng).random(samples)

"""Correction weight of a plane split onto its holes.

Two neighbouring holes at α < θ < β, β − α < 180°, carry a weight of size m at θ exactly, and no lighter weights do:

    m_α = m sin(β − θ) / sin(β − α),    m_β = m sin(θ − α) / sin(β − α)

If one of them is heavier than a hole takes, the lightest weights with Σ m_h e^{iα_h} = w, 0 ≤ m_h ≤ most, are a linear programme,
whose vertices have at most two holes partly filled (Dantzig, *Linear Programming and Extensions*, 1963, ch. 5). If none do,
bounded least squares leave least. For weights of given sizes all pairs are tried of these holes and the two nearest further
free ones: given the first weight of a pair, the best second one is the size nearest to its projection. With two
holes that is exact; of more, pairs are replaced in turn until no pair does better.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog, lsq_linear

from ksmea.arrays import Array
from ksmea.measurement.campaign import Holes
from ksmea.units import TURN

SMALLEST = 1e-9  # part of the weight; less is rounding
N_BESIDE = 2  # holes tried in addition to the holes of free sizes; holes farther off only add weight
MAX_SIZES = 2000  # of weights that are tried in a hole; finer steps are rounded one by one


@dataclass(frozen=True)
class Split:
    """Sizes (kg m) in holes, which count from 1, and what the wanted weight is more than they are."""

    holes: tuple[int, ...]
    sizes: tuple[float, ...]
    left: complex


def split(weight: complex, holes: Holes) -> Split:
    """The lightest weights in holes that are a weight (kg m, complex), or come nearest to it."""
    free = np.array([index for index in range(len(holes.angles)) if index + 1 not in holes.occupied])
    directions = np.exp(1j * np.array(holes.angles)[free])
    if weight == 0:
        return Split((), (), 0j)
    sizes = _free_sizes(weight, directions, np.inf if holes.most is None else holes.most)
    if holes.step is not None or holes.sizes:
        sizes = _of_given_sizes(weight, directions, sizes, holes)
    used = np.flatnonzero(sizes > SMALLEST * abs(weight))
    return Split(
        tuple((free[used] + 1).tolist()),
        tuple(sizes[used].tolist()),
        complex(weight - sizes[used] @ directions[used]),
    )


def neighbours_share(weight: complex, first: complex, second: complex) -> tuple[float, float]:
    """Sizes in two directions e^{iα}, e^{iβ} that together are a weight.

    Cramer's rule for its real and imaginary parts.

    >>> [round(size, 6) for size in neighbours_share(2 + 0j, np.exp(-0.5j), np.exp(0.5j))]  # 2 sin 0.5 / sin 1
    [1.139494, 1.139494]
    """
    crossed = (first.conjugate() * second).imag  # sin(β − α)
    return float((weight.conjugate() * second).imag / crossed), float((first.conjugate() * weight).imag / crossed)


def _free_sizes(weight: complex, directions: Array, most: float) -> Array:
    """Sizes (n_hole,) between 0 and the most."""
    sizes = np.zeros(len(directions))
    ahead = np.mod(np.angle(directions / weight), TURN)  # from the weight to the hole, in the direction of rotation
    first, second = int(np.argmax(ahead)), int(np.argmin(ahead))
    if abs(np.imag(directions[first].conjugate() * directions[second])) > SMALLEST:
        pair = neighbours_share(weight, complex(directions[first]), complex(directions[second]))
        if all(-SMALLEST * abs(weight) <= size <= most for size in pair):
            sizes[[first, second]] = np.maximum(pair, 0)
            return sizes
    both = np.vstack([directions.real, directions.imag])
    wanted = np.array([weight.real, weight.imag]) / abs(weight)
    top = most / abs(weight)
    found = linprog(np.ones(len(sizes)), A_eq=both, b_eq=wanted, bounds=(0, top if np.isfinite(top) else None))
    nearest = np.asarray(found.x if found.status == 0 else lsq_linear(both, wanted, (0, top)).x, dtype=float)
    return nearest * abs(weight)


def _of_given_sizes(weight: complex, directions: Array, start: Array, holes: Holes) -> Array:
    """The sizes that there are, in as many holes as free sizes take, or two."""
    reach = max(float(start.max()), abs(weight))
    most = 2 * reach if holes.most is None else holes.most
    if holes.sizes:
        there = np.unique([0.0, *(size for size in holes.sizes if size <= most * (1 + SMALLEST))])
    else:
        assert holes.step is not None
        n = int(min(most, 2 * reach) / holes.step * (1 + SMALLEST))
        if n > MAX_SIZES:
            return np.asarray(np.minimum(np.round(start / holes.step), np.floor(most / holes.step)) * holes.step)
        there = holes.step * np.arange(n + 1)
    best = np.zeros(len(directions))
    by_distance = np.argsort(np.abs(np.angle(directions / weight)), kind="stable")
    beside = [hole for hole in by_distance.tolist() if start[hole] == 0][:N_BESIDE]
    tried = {*np.flatnonzero(start).tolist(), *beside}
    slots = [int(hole) for hole in np.argsort(-start) if hole in tried][: max(2, int(np.count_nonzero(start)))]
    if len(slots) == 1:
        best[slots] = _nearest(there, np.array([(weight / directions[slots[0]]).real]))
        return best
    best[slots] = _nearest(there, start[slots])
    while True:
        before = abs(weight - best @ directions)
        for index, other in itertools.combinations(range(len(slots)), 2):
            rest = best.copy()
            rest[[slots[index], slots[other]]] = 0
            allowed = [hole for hole in sorted(tried) if rest[hole] == 0]
            pair, sizes = _best_pair(complex(weight - rest @ directions), directions, allowed, there)
            if abs(weight - rest @ directions - sizes @ directions[pair]) < abs(weight - best @ directions):
                best, slots[index], slots[other] = rest, *pair
                best[pair] = sizes
        if abs(weight - best @ directions) > before - SMALLEST * abs(weight):
            return best


def _best_pair(wanted: complex, directions: Array, allowed: list[int], there: Array) -> tuple[list[int], Array]:
    """The two holes and their sizes that come nearest; of equally near ones the lightest."""
    pairs = np.array(list(itertools.combinations(allowed, 2)))
    first, second = directions[pairs].T
    left = wanted - first[:, None] * there  # (n_pair, n_size)
    other = _nearest(there, np.real(left * second.conj()[:, None]))
    off = np.round(np.abs(left - other * second[:, None]) / (SMALLEST * (abs(wanted) or 1.0)))
    least = np.flatnonzero(off.ravel() == off.min())
    heavy = (there + other).ravel()[least]
    pair, size = np.unravel_index(least[np.argmin(heavy)], off.shape)
    return pairs[pair].tolist(), np.array([there[size], other[pair, size]])


def _nearest(there: Array, wanted: Array) -> Array:
    """Nearest of the rising sizes to each wanted one."""
    upper = np.clip(np.searchsorted(there, wanted), 1, max(len(there) - 1, 1))
    if len(there) == 1:
        return np.zeros(np.shape(wanted))
    is_lower = wanted - there[upper - 1] <= there[upper] - wanted
    return np.asarray(np.where(is_lower, there[upper - 1], there[upper]))

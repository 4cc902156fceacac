"""Pairs of sites at which two unknown forces act: those of a coarse grid first, then ever nearer ones around the best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations, product

import numpy as np

from ksmea.arrays import Array
from ksmea.diagnosis.unknown_force import SiteFit, Unmodelled
from ksmea.records.location import PAIR

N_COARSE = 7  # positions of the grid: 21 pairs
N_BEST = 8  # pairs around which the search goes on
N_KEPT = 24  # pairs that are tested
Pair = tuple[int, int]  # indices of positions, the first one smaller


def fitted_pairs(positions: Array, fitted: Callable[[Sequence[Unmodelled]], list[SiteFit]]) -> list[SiteFit]:
    """The best fits of two forces at pairs of positions (m, rising): of all pairs of a grid, and around the best ones of those
    that are half as far apart, down to neighbours."""
    step = max(int(np.ceil((len(positions) - 1) / (N_COARSE - 1))), 1)
    grid = sorted({*range(0, len(positions), step), len(positions) - 1})
    found: dict[Pair, SiteFit] = {}

    def try_all(pairs: Sequence[Pair]) -> None:
        tried = [Unmodelled(PAIR, float(positions[a]), float(positions[b])) for a, b in pairs]
        found.update(zip(pairs, fitted(tried)))

    try_all(list(combinations(grid, 2)))
    while step > 1:
        step = (step + 1) // 2
        best = sorted(found, key=lambda pair: found[pair].point.excess)[:N_BEST]
        around = {pair for each in best for pair in _around(each, step, len(positions))}
        try_all(sorted(around - set(found)))
    return sorted(found.values(), key=lambda fit: fit.point.excess)[:N_KEPT]


def _around(pair: Pair, step: int, n_position: int) -> list[Pair]:
    moved = [(pair[0] + first, pair[1] + second) for first, second in product((-step, 0, step), repeat=2)]
    return [(first, second) for first, second in moved if 0 <= first < second < n_position]

"""Sites that explain the data, by a lack-of-fit test with free numbers at each speed; pairs of sites.

The statistics of the lack-of-fit test are computed from residuals that are projected off the free numbers at each speed as well as
off the tangent of the unknowns; simulated residuals are projected likewise. One more statistic is the size of the residuals: χ² if
the noise level is known. If not, the size is compared with the smallest of all sites: ln of χ² per degree of freedom, less its
smallest value. It is simulated with the same noise at all sites that are not rejected yet, as if each of them explained
the data: under any true site it is among them, so that sites are rather kept than rejected. Rejected sites have no part in the
smallest, which would only blunt the test.

Pairs of sites at which two unknown forces act are tried on a coarse grid first, then ever nearer to the best ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.fits.lack_of_fit import STATISTICS, as_complex, residual_statistics, upper_ranks
from ksmea.likelihood.fisher import span
from ksmea.location.unknown_force import ProjectedPoint, SiteFit, Unmodelled, without
from ksmea.measurement.measurement import Measurement
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.records.location import PAIR

N_SIMULATED = 2000
SIZE = "noise that other sites do not need"
ROUNDS = 2  # of the comparison with sites that are not rejected yet


@dataclass(frozen=True)
class SiteQuality:
    """`p` of the lack-of-fit test of a site, the smallest of `p_by_statistic` corrected for their number."""

    p: float
    p_by_statistic: dict[str, float]


def site_qualities(
    points: Sequence[ProjectedPoint],
    measurement: Measurement,
    level: float,
    rng: np.random.Generator,
    workers: Workers = ALONE,
) -> list[SiteQuality]:
    """The test of each site, by the same simulated noise for all of them; processes share the sites."""
    n_value = measurement.values.size * measurement.dimensions
    noise = as_complex(rng.standard_normal((N_SIMULATED, n_value)), measurement.values.shape)
    n_prior = len(points[0].whitened) - 2 * points[0].residual.size
    off = rng.standard_normal((N_SIMULATED, n_prior))
    sampled = partial(_sampled, measurement=measurement, noise=np.moveaxis(noise, 0, -1), off_priors=off)
    # (n_site, 1 + n_simulated, n_statistic), the data's own first
    statistics = np.stack(workers.unseen.each(sampled, points))
    if measurement.noise is not None:
        return _tested(statistics, STATISTICS)
    size = np.log(statistics[:, :, -1] / np.array([[point.n_left] for point in points]))
    is_kept = np.ones(len(points), dtype=bool)
    for _ in range(ROUNDS):
        smallest = np.min(size[is_kept], axis=0, initial=np.inf)
        smallest[0] = np.min(size[:, 0])
        statistics[:, :, -1] = size - np.minimum(smallest, size)
        qualities = _tested(statistics, (*STATISTICS[:-1], SIZE))
        is_kept = np.array([quality.p >= level for quality in qualities])
    return qualities


def _sampled(point: ProjectedPoint, measurement: Measurement, noise: ComplexArray, off_priors: Array) -> Array:
    """Statistics (1 + n_simulated, n_statistic) of the residuals at a site, of data and simulated noise.

    Noise is (n_speed, n_channel, n_simulated), deviations from priors (n_simulated, n_prior).
    """
    left = np.moveaxis(without(point.basis, noise), -1, 0)
    real = measurement.kind.real_parts(left.reshape(len(left), -1), axis=1)
    tangent = span(point.whitened)
    n_value, real = real.shape[1], np.concatenate([real, off_priors], axis=1)
    simulated = as_complex((real - (real @ tangent) @ tangent.T)[:, :n_value], point.residual.shape)
    both = [residual_statistics(left, measurement.rows, scale_free=False) for left in (point.residual[None], simulated)]
    return np.concatenate(both)


def _tested(statistics: Array, names: Sequence[str]) -> list[SiteQuality]:
    """Sites with p from statistics (n_site, 1 + n_simulated, n_statistic).

    The smallest rank of the data is compared with the smallest rank of every sample, the data included."""
    found = []
    for of_site in statistics:
        ranks = np.stack([upper_ranks(column) for column in of_site.T], axis=1) / len(of_site)
        smallest = ranks.min(axis=1)
        found.append(SiteQuality(float(np.mean(smallest <= smallest[0])), dict(zip(names, map(float, ranks[0])))))
    return found


N_COARSE = 7  # positions of the grid: 21 pairs
N_BEST = 8  # pairs around which the search goes on
N_KEPT = 24  # pairs that are tested
Pair = tuple[int, int]  # indices of positions, the first one smaller


def fitted_pairs(positions: Array, fitted: Callable[[Sequence[Unmodelled]], list[SiteFit]]) -> list[SiteFit]:
    """The best fits of two forces at pairs of positions (m, rising).

    All pairs of a grid are tried, then pairs half as far apart around the best ones, down to neighbours.
    """
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

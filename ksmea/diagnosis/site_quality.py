"""Is what a site leaves over noise? The lack-of-fit test of `fit_quality`, for models with free numbers at each speed.

The statistics are those of `fit_quality`, of residuals that have lost what is free at each speed besides the tangent of
the unknowns, and so have the simulated ones. One more looks at their size. Where the noise is known it is χ². Where it is
not, the size of the residuals is set against that of the sites that need least: ln of χ² per degree of freedom, less the
smallest of all sites. It is simulated with the same noise at all sites that are not rejected yet, as if each of them
explained the data: under any true site those that do are among them, so that sites are rather kept than rejected. The
others have no part in the smallest, which would only blunt the test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.diagnosis.fit_quality import STATISTICS, as_complex, residual_statistics, upper_ranks
from ksmea.diagnosis.unknown_force import ProjectedPoint, without
from ksmea.fisher import span
from ksmea.measurement import Measurement
from ksmea.processes import for_each

N_SIMULATED = 2000
SIZE = "noise that other sites do not need"
ROUNDS = 2  # of the comparison with sites that are not rejected yet


@dataclass(frozen=True)
class SiteQuality:
    """`p` of the lack-of-fit test of a site, the smallest of `p_by_statistic` corrected for their number."""

    p: float
    p_by_statistic: dict[str, float]


def site_qualities(
    points: Sequence[ProjectedPoint], measurement: Measurement, level: float, rng: np.random.Generator, workers: int = 1
) -> list[SiteQuality]:
    """The test of each site, by the same simulated noise for all of them; processes share the sites."""
    n_value = measurement.values.size * measurement.dimensions
    noise = as_complex(rng.standard_normal((N_SIMULATED, n_value)), measurement.values.shape)
    sampled = partial(_sampled, measurement=measurement, noise=np.moveaxis(noise, 0, -1))
    # (n_site, 1 + n_simulated, n_statistic), the data's own first
    statistics = np.stack(for_each(sampled, points, workers))
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


def _sampled(point: ProjectedPoint, measurement: Measurement, noise: ComplexArray) -> Array:
    """Statistics (1 + n_simulated, n_statistic) of what a site leaves of the data, and would of noise (n_speed, n_channel,
    n_simulated)."""
    left = np.moveaxis(without(point.basis, noise), -1, 0)
    real = measurement.kind.real_parts(left.reshape(len(left), -1), axis=1)
    tangent = span(point.whitened)
    simulated = as_complex(real - (real @ tangent) @ tangent.T, point.residual.shape)
    both = [residual_statistics(left, measurement.rows, scale_free=False) for left in (point.residual[None], simulated)]
    return np.concatenate(both)


def _tested(statistics: Array, names: Sequence[str]) -> list[SiteQuality]:
    """Sites with p from statistics (n_site, 1 + n_simulated, n_statistic): the smallest of each sample among those of all
    samples, the data's own included."""
    found = []
    for of_site in statistics:
        ranks = np.stack([upper_ranks(column) for column in of_site.T], axis=1) / len(of_site)
        smallest = ranks.min(axis=1)
        found.append(SiteQuality(float(np.mean(smallest <= smallest[0])), dict(zip(names, map(float, ranks[0])))))
    return found

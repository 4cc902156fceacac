"""Weights of each run from all other runs: its own weights and response are not used."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.balancing.estimation import WeightEstimate, estimated
from ksmea.balancing.fit import Fit, refitted


def folded(fit: Fit, runs: Indices, n_fold: int, progress: Callable[[], None]) -> dict[int, tuple[Fit, WeightEstimate]]:
    """Fit without each run, and the run's weights by that fit.

    Variance components, slopes and growth are from a fit without a whole fold of runs, dealt in turn. Coefficients
    and the drift are from all runs but the one. Runs that the fit left out as misfits are estimated as well, but
    have no influence on others.
    """
    found = {}
    planes = np.arange(len(fit.readings.planes))
    for number in range(min(n_fold, len(runs))):
        fold = runs[number::n_fold]
        without = refitted(dataclasses.replace(fit, used=np.setdiff1d(fit.used, fold)))
        for run in fold:
            used = np.setdiff1d(fit.used, [run])
            own = dataclasses.replace(without, used=used).without(np.array([run]))
            found[int(run)] = (own, estimated(own, int(run), planes))
        progress()
    return dict(sorted(found.items()))


def squared_errors(found: dict[int, tuple[Fit, WeightEstimate]]) -> Array:
    """|estimate - known|² / variance (n_run, n_plane) of weights estimated from the other runs."""
    return np.array(
        [
            np.abs(estimate.weights - fit.readings.weights[run]) ** 2 / np.diag(estimate.covariance).real
            for run, (fit, estimate) in found.items()
        ]
    )


def conformal_radius2(squared: Array, level: float) -> float:
    """Squared radius, in units of the variance, that holds a new run's weight with probability `level`.

    It holds whatever the distribution of the errors: it is the quantile of the errors over runs estimated from
    others. Infinite if the runs are too few.

    Vovk, Gammerman & Shafer, *Algorithmic Learning in a Random World*, 2005; Barber et al., Ann. Stat. 49 (2021)
    486–507.
    """
    n = squared.size
    rank = int(np.ceil((n + 1) * level))
    return float(np.sort(squared, axis=None)[rank - 1]) if rank <= n else float("inf")

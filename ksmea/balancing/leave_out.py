"""The weights of each run from all others: neither its weights nor its response have any part in what they are told by."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.balancing.estimation import WeightEstimate, estimated
from ksmea.balancing.fit import Fit, refitted


def folded(fit: Fit, runs: Indices, n_fold: int, progress: Callable[[], None]) -> dict[int, tuple[Fit, WeightEstimate]]:
    """The fit without each run, and the weights that it tells of the run. Variance components, slopes and growth are those of
    a fit without a whole fold of runs, dealt in turn; coefficients, and the drift, of all runs but the one.

    Runs that the fit left out as misfits are told as well, and tell nothing of others.
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
    """The squared radius, in units of the standard deviation, that holds the weight of a further run with a probability of
    `level`, whatever the distribution of the errors: their quantile over runs told by others.

    Vovk, Gammerman & Shafer, *Algorithmic Learning in a Random World*, 2005; Barber et al., Ann. Stat. 49 (2021) 486–507.
    """
    n = squared.size
    rank = int(np.ceil((n + 1) * level))
    return float(np.sort(squared, axis=None)[rank - 1]) if rank <= n else float("inf")

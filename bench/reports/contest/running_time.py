"""Expected running time (ERT): what it costs to reach a target when a run that does not is followed by another one.

ERT = costs of all runs until the target, or until their end where they do not reach it / number of runs that do (Auger &
Hansen, IEEE CEC 2005, 1777–1784; Hansen et al., Optim. Methods Softw. 36 (2021) 114–144, doi 10.1080/10556788.2020.1808977).
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array


def spent(hits: Array, ends: Array) -> Array:
    """What each run costs until each target, (n_run, n_target): `hits`, infinite where not reached, else its end (n_run,)."""
    return np.where(np.isfinite(hits), hits, np.asarray(ends)[:, None])


def expected_running_time(costs: Array, successes: Array) -> Array:
    """ERT of summed costs and numbers of successes, of any common shape; infinite where there is no success.

    Two runs reach the target at 10 and 30, one ends at 100 without:

    >>> float(expected_running_time(10.0 + 30.0 + 100.0, 2))
    70.0
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.asarray(successes) > 0, np.divide(costs, successes), np.inf)


def resampled_running_time(costs: Array, successes: Array, weights: Array) -> Array:
    """ERT (n, …) of samples of instances: costs and successes (n_instance, …), and how often each is drawn (n, n_instance)."""
    return expected_running_time(np.tensordot(weights, costs, 1), np.tensordot(weights, successes, 1))

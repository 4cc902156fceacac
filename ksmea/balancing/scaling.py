"""The spread between runs from runs with unknown weights, where those with known ones leave none to see it by.

Weights explain as many complex numbers of a run as there are unknown ones; what they leave of the others shows the spread.
"""
# Shorter than 40 lines: one estimate a file.

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.balancing.estimation import estimated
from ksmea.balancing.fit import COMMON, Fit


def scaled_by_unknown_runs(fit: Fit) -> Fit:
    """A fit whose covariance is not free, with one factor on it from what all its runs leave; entries count as uncorrelated."""
    data = fit.readings
    found = [
        estimated(fit, int(run), np.flatnonzero(np.isnan(data.weights[run])))
        for run in np.setdiff1d(np.arange(len(data.names)), data.is_known)
    ]
    n_left = sum(each.n_left for each in found)
    if fit.is_free or n_left == 0:
        return fit
    own = fit.dof if fit.method == COMMON else 0.0
    factor = (own + sum(each.chi2 for each in found)) / (own + n_left)
    components = dataclasses.replace(fit.components, spread=factor * fit.components.spread)
    return dataclasses.replace(fit, components=components, method=COMMON, dof=own + n_left)

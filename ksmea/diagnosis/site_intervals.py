"""Intervals of the model's own unknowns beside something unknown at a site, by the profile of what is left."""

from __future__ import annotations

import numpy as np
import scipy

from ksmea.diagnosis.location import HOPELESS
from ksmea.diagnosis.recovered_force import own_noise
from ksmea.diagnosis.unknown_force import SiteFit
from ksmea.intervals import Interval, checked_intervals, in_si, information_interval
from ksmea.records.location import UNSEEN


def site_intervals(fit: SiteFit, level: float) -> list[Interval]:
    """An interval of confidence `level` for each unknown, SI. Where the noise is not known it is as large as this site's own
    residuals have it, whatever other sites need: the quantile is that of F. Unknowns that the data do not show there are
    `UNSEEN`. Those of a model that is far from the data are not checked."""
    if fit.likelihood.measurement.noise is None:
        likelihood = fit.likelihood.with_sd(own_noise(fit) * fit.likelihood.sd)
        rise = float(scipy.stats.f.ppf(level, 1, fit.point.n_left))
    else:
        likelihood = fit.likelihood
        rise = float(scipy.stats.chi2.ppf(level, 1))
    point, intervals = likelihood.at(fit.point.theta), None
    if fit.point.excess <= HOPELESS:
        _, intervals = checked_intervals(likelihood, [point], np.full((1, likelihood.d), rise))
    if intervals is None:
        intervals = [information_interval(likelihood, point, index, rise) for index in range(likelihood.d)]
    seen = point.shown
    return [
        in_si(interval, item.lower, item.upper) if is_seen else Interval(-np.inf, np.inf, UNSEEN)
        for item, interval, is_seen in zip(likelihood.problem.parameters, intervals, seen)
    ]

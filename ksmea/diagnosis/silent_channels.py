"""What an effect cannot explain: harmonics of the rotation at which it moves nothing.

A force that is alike in opposite directions makes no 2X, a misaligned coupling no 3X. Whatever the size of such an effect, what was
measured there stays noise.
"""

from __future__ import annotations

import numpy as np

from ksmea.diagnosis.fitting import Fit
from ksmea.harmonic_balance import Mask

PART = 0.3  # of the way to their upper limits: unknowns of an effect that is asked where it moves anything


def least_deviance(fit: Fit, best: Fit) -> float:
    """The deviance that a fit's problem would leave if it predicted what the best fit does wherever it moves anything, with the noise
    that suits this: it comes no lower but by what noise allows. −∞ where it moves all channels."""
    silent = _silent(fit, len(best.u))
    if not np.any(silent):
        return -np.inf
    return best.likelihood.deviance_of(np.where(silent, 0.0, best.response()))


def _silent(fit: Fit, n_own: int) -> Mask:
    """The channels (n_channel,) beside 1X at which a problem has no response."""
    beside = np.array([not channel.is_1x for channel in fit.likelihood.measurement.channels])
    if not np.any(beside):
        return beside
    u = fit.u.copy()
    of_effect = slice(min(n_own, len(u)), None)
    zero = fit.problem.parameters.to_cube(np.zeros(len(u)))[of_effect]
    u[of_effect] = zero + PART * (1 - zero)
    try:
        response = fit.problem.response(fit.problem.parameters.to_si(u)[None])[0]
    except np.linalg.LinAlgError:  # no steady motion of that size
        return np.zeros_like(beside)
    return np.asarray(beside & ~np.any(response != 0, axis=0))

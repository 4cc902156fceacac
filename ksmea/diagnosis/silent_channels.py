"""What an effect cannot explain: harmonics of the rotation at which it moves nothing.

A force that is alike in opposite directions makes no 2X. Whatever the size of such an effect, what was measured there stays noise.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ksmea.arrays import Mask
from ksmea.diagnosis.fitting import Fit, without_effects
from ksmea.diagnosis.screening import scan_values

N_SIZE = 4  # of the values that a scan of an effect with one unknown has: it is asked at these where it moves anything


def least_deviance(fit: Fit, best: Fit, n_own: int) -> float:
    """About the lowest deviance of a fit's problem, whose first `n_own` unknowns are those without its effect: what it would leave
    if it predicted as the best fit does wherever it moves anything, and nothing elsewhere, with the noise that suits this. It comes
    lower where the best fit leaves more than noise. −∞ where it moves all channels, and of differences between runs."""
    if best.likelihood.measurement.is_by_differences:
        return -np.inf
    silent = _silent(fit, n_own)
    if not np.any(silent):
        return -np.inf
    return best.likelihood.deviance_of(np.where(silent, 0.0, best.response()))


def _silent(fit: Fit, n_own: int) -> Mask:
    """The channels (n_channel,) beside 1X at which a problem has no response: as fitted, and with none of several sizes."""
    beside = np.array([not channel.is_1x for channel in fit.likelihood.measurement.channels])
    if not np.any(beside):
        return beside
    sizes = scan_values(without_effects(fit.problem, n_own), N_SIZE)
    moves, n_asked = np.zeros_like(beside), 0
    for size in (fit.u[n_own:], *sizes):
        with suppress(np.linalg.LinAlgError):  # no steady motion of that size
            x = fit.problem.parameters.to_si(np.concatenate([fit.u[:n_own], size]))
            moves |= np.any(fit.problem.response(x[None])[0] != 0, axis=0)
            n_asked += 1
    return np.asarray(beside & ~moves & (n_asked > 1))

"""Model averaging: joint estimates of shared unknowns and of the response from several explanations.

Values and intervals of one model are too sure where the data leave others open. Over explanations m with weights w_m an unknown
θ has the distribution

    F(θ) = Σ w_m F_m(θ)        (Hoeting et al. 1999, eq. 1)

and the value Σ w_m θ_m (Burnham & Anderson 2002, section 4.2). F_m has half of its mass on either side of the maximum of the
likelihood θ_m, each as half of a normal distribution that ends where the interval of θ_m does, found by profiles where these
are no parabolas. An open side has its mass beyond all limits. The averaged interval reaches from the (1 − level)/2 quantile
of F to the (1 + level)/2 quantile.

Weights follow AIC, w_m ∝ exp(−(D_m + 2 k_m)/2) with the deviance D_m and k_m unknowns (Burnham & Anderson 2002, section
2.9); places of the same effects share one weight. They do not follow BIC, which names effects: it charges ln n for each unknown, known
or not by the data, and would leave an explanation of as low a deviance with two more unknowns a weight of 1/n, though the
data hold no evidence against it.

What the interval covers: the causes that the library has and that came near, each at its weight. It is meant to hold the true
value where one of them is the truth and has a fair weight; a member with a weight below (1 − level)/2 moves no end. A truth
outside of the library is covered by no average.

J. A. Hoeting, D. Madigan, A. E. Raftery and C. T. Volinsky, Bayesian model averaging: a tutorial, Stat. Sci. 14 (1999)
382–417, doi 10.1214/ss/1009212519; K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed.
(Springer, 2002), doi 10.1007/b97636.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from ksmea.arrays import Array
from ksmea.diagnosis.trials import NEAR, Explanation
from ksmea.fits.fitting import Fit
from ksmea.fits.stable_fits import settled_stable
from ksmea.inference.intervals import Estimate, Interval
from ksmea.likelihood.fisher import UNKNOWABLE
from ksmea.measurement.observable import amplitude_sensitivity
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.units import TURN

MAX_AVERAGED = 8  # explanations that are averaged, the best ones: each costs its intervals
FARTHEST = 10.0  # standard deviations from each member within which quantiles lie
N_HALVING = 60  # of that range


@dataclass(frozen=True)
class Averaged:
    """Averaged explanations with weights, unknowns with intervals, and amplitudes with intervals.

    Unknowns (d,) SI are of the baseline model, amplitudes (n_speed, n_channel) in m.
    """

    explanations: tuple[Explanation, ...]
    weights: Array
    values: Array
    intervals: tuple[Interval, ...]
    amplitude: Array
    amplitude_low: Array
    amplitude_high: Array


def averaged(
    explanations: Sequence[Explanation],
    best: Fit,
    estimated: Estimate,
    d: int,
    level: float,
    workers: Workers = ALONE,
) -> Averaged:
    """The average over explanations, best first, of which the first has the fit and the estimate given.

    D unknowns belong to the baseline model. Workers share the explanations.
    """
    members = tuple(explanations[:MAX_AVERAGED])
    others = [member.fit for member in members[1:]]
    known = [thing for fit in others for thing in fit.known]
    settled = [(best, estimated)]
    settled += workers.each(partial(settled_stable, level=level), others, known)
    weights = akaike_weights(
        np.array([fit.deviance for fit, _ in settled]),
        np.array([fit.likelihood.d for fit, _ in settled]),
        [member.names for member in members],
    )
    z = float(scipy.stats.norm.isf((1 - level) / 2))
    x = np.array([estimate.x[:d] for _, estimate in settled])  # (n_member, d)
    low = np.array([[interval.low for interval in estimate.intervals[:d]] for _, estimate in settled])
    high = np.array([[interval.high for interval in estimate.intervals[:d]] for _, estimate in settled])
    turning = np.array([item.is_full_turn for item in best.problem.parameters.items[:d]])
    turns = np.where(turning, TURN * np.rint((x - x[0]) / TURN), 0.0)
    centres = x - turns
    ends = mixture_interval(weights, centres, (x - low) / z, (high - x) / z, level)
    amplitudes = [_amplitude(fit) for fit, _ in settled]
    amplitude, sd = (np.array(parts) for parts in zip(*amplitudes))
    band = mixture_interval(weights, amplitude, sd, sd, level)
    return Averaged(
        members,
        weights,
        weights @ centres,
        tuple(Interval(float(one), float(other), "mixture") for one, other in zip(*ends)),
        np.asarray(np.tensordot(weights, amplitude, axes=1)),
        np.maximum(band[0], 0.0),
        band[1],
    )


def akaike_weights(deviance: Array, n_unknown: Array, names: Sequence[tuple[str, ...]]) -> Array:
    """w_m (n_member,) of models with these deviances and numbers of unknowns.

    Explanations of the same names share one weight.

    >>> akaike_weights(np.array([0.0, 0.0, 0.0]), np.array([6, 6, 6]), [("mass",), ("runout",), ("runout",)])
    array([0.5 , 0.25, 0.25])
    """
    criterion = deviance + 2 * n_unknown
    shared = np.array([names.count(own) for own in names])
    weights = np.exp(-(criterion - np.min(criterion)) / 2) / shared
    return np.asarray(weights / np.sum(weights))


def heaviest(names: Sequence[tuple[str, ...]], weights: Array) -> int:
    """Index of the explanation that leads several whose weights (n_member,) are known.

    The first one unless the weight of others of one name is clearly larger than its own, by as much as ΔBIC tells
    effects apart. BIC charges for unknowns that the data do not show, and may prefer an explanation that they all but
    exclude.

    >>> heaviest([("mass",), ("runout",), ("runout",)], np.array([0.01, 0.49, 0.5]))
    2
    >>> heaviest([("mass",), ("runout",)], np.array([0.1, 0.9]))
    0
    """
    of_name: dict[tuple[str, ...], float] = {}
    for own, weight in zip(names, weights.tolist()):
        of_name[own] = of_name.get(own, 0.0) + weight
    best = max(of_name, key=of_name.__getitem__)
    if of_name[best] <= np.exp(NEAR / 2) * of_name[names[0]]:
        return 0
    return int(np.argmax([weight if own == best else -1.0 for own, weight in zip(names, weights)]))


def mixture_interval(
    weights: Array, centres: Array, sd_low: Array, sd_high: Array, level: float
) -> tuple[Array, Array]:
    """Ends (…) of the interval of a mixture of two-piece normal distributions.

    They are around `centres` (n_member, …), infinite if open.
    """
    tail = (1 - level) / 2
    lower = _quantile(weights, centres, sd_low, sd_high, tail)
    return lower, -_quantile(weights, -centres, sd_high, sd_low, tail)


def _quantile(weights: Array, centres: Array, sd_low: Array, sd_high: Array, tail: float) -> Array:
    """Point at which the distribution function is `tail`, below one half, by bisection.

    −∞ if the distribution function is larger everywhere."""
    is_open = np.isinf(sd_low)
    reach = FARTHEST * np.where(is_open, 0.0, sd_low)
    low, high = np.min(centres - reach, axis=0), np.max(centres, axis=0)
    weights = weights.reshape(-1, *[1] * (centres.ndim - 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(N_HALVING):
            middle = (low + high) / 2
            off = middle - centres
            part = np.nan_to_num(off / np.where(off < 0, sd_low, sd_high), posinf=FARTHEST, neginf=-FARTHEST)
            is_below = np.sum(weights * scipy.stats.norm.cdf(part), axis=0) < tail
            low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return np.where(np.sum(weights * is_open / 2, axis=0) >= tail, -np.inf, (low + high) / 2)


def _amplitude(fit: Fit) -> tuple[Array, Array]:
    """Amplitudes of the response of a fit (n_speed, n_channel), m, and their standard deviations.

    These are by the delta method.
    """
    likelihood, whitened = fit.likelihood, fit.point.whitened
    response, slope = likelihood.model.linearise(fit.u)
    gradient = amplitude_sensitivity(response, slope)
    scale = np.linalg.norm(whitened, axis=0)
    known = scale > 0
    _, size, directions = np.linalg.svd(whitened[:, known] / scale[known], full_matrices=False)
    kept = size > np.sqrt(UNKNOWABLE) * size[0]
    own = known[: likelihood.d]
    along = (gradient[..., own] / scale[: likelihood.d][own]) @ directions[kept][:, : np.count_nonzero(own)].T
    return np.abs(response), np.asarray(np.linalg.norm(along / size[kept], axis=-1))

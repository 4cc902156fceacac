"""Equivalents of a pair of effects: one effect, or another pair.

Equal and opposite moments at two couplings bend a shaft as a bow does, and a gain of a plane with a mass may look like probes
that sit elsewhere. Fits alone do not show it: one effect may have ended in a lower maximum than the pair, and of the many pairs
only a part is fitted. So the change of the data that the pair makes is compared with what every other
effect, and every other pair, can do there to first order. Equivalents by that measure are fitted to what the pair
predicts, and from there to the data, as rivals of one effect are (`rivals`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import combinations, pairwise

import numpy as np

from ksmea.arrays import Array
from ksmea.diagnosis.observability import change_of, own_reach, reach
from ksmea.diagnosis.rivals import cosines_with, fits_towards, promises, tested
from ksmea.diagnosis.trials import BETTER, Candidate, Explanation, Trial, fitted, trial_of
from ksmea.fits.fitting import Fit
from ksmea.fits.search import Search

MAX_PAIRS = 4  # other pairs that are fitted, those most collinear with the best one
RANK = 1e-8  # of the squares of sines between what two effects can do, below which they can do one thing


def alone_in_place_of(pair: Explanation, trials: Sequence[Trial], baseline: Fit, search: Search) -> list[Trial]:
    """All trials, ranked again, if an effect alone is found to explain the data about as well as a pair.

    Otherwise empty.
    """
    cosines = cosines_with(pair, trials, search.workers)
    found = tested(pair, trials, cosines, baseline, search.workers)
    before = {(trial.name, trial.location): trial.fit.deviance for trial in trials}
    has_better = any(
        trial.fit.deviance < before[trial.name, trial.location] - BETTER and Explanation.of(trial).is_near(pair)
        for trial in found
    )
    return found if has_better else []


def pairs_in_place_of(
    pair: Explanation, trials: Sequence[Trial], known: Sequence[Explanation], baseline: Fit, search: Search
) -> list[Explanation]:
    """Further pairs that come near a pair and can make the same change of the data.

    `known` pairs have been fitted.
    """
    reached = search.workers.unseen.each(partial(_reach, pair), [trial.candidate for trial in trials])
    able = [(trial, basis) for trial, basis in zip(trials, reached) if basis is not None]
    candidates = [trial for trial, _ in able]
    cosines = _of_pairs(change_of(pair), [basis for _, basis in able])
    found: list[Explanation] = []
    n_pair = len(trials) * (len(trials) - 1) // 2
    for one, other in sorted(cosines, key=lambda both: -cosines[both]):
        first, second = sorted((candidates[one], candidates[other]), key=lambda trial: trial.fit.deviance)
        if len(found) == MAX_PAIRS or not promises(pair, cosines[one, other], first.n_unknown + second.n_unknown):
            break
        if not any(_is_of(each, first, second) for each in (pair, *known)):
            found += _fitted_as(pair, first, second, baseline, n_pair, search)
    return [each for each in found if each.is_near(pair)]


def _reach(pair: Explanation, candidate: Candidate) -> Array | None:
    if candidate in pair.applied:
        return own_reach(pair, pair.own_unknowns[pair.applied.index(candidate)])
    return reach(pair, candidate)


def _is_of(pair: Explanation, first: Trial, second: Trial) -> bool:
    return first.candidate in pair.applied and second.candidate in pair.applied


def _of_pairs(change: Array, bases: Sequence[Array]) -> dict[tuple[int, int], float]:
    """Cosines between a change (m,) and the nearest one by each two of orthonormal bases (m, e)."""
    size = float(np.linalg.norm(change))
    if not bases or not size:
        return {}
    ends = np.cumsum([0, *(basis.shape[1] for basis in bases)])
    own = [np.arange(start, stop) for start, stop in pairwise(ends)]
    whole = np.hstack(bases)
    gram, along = whole.T @ whole, whole.T @ change / size
    found = {}
    for one, other in combinations(range(len(bases)), 2):
        both = np.concatenate([own[one], own[other]])
        solved = np.linalg.pinv(gram[np.ix_(both, both)], rcond=RANK, hermitian=True) @ along[both]
        found[one, other] = float(np.sqrt(np.clip(along[both] @ solved, 0.0, 1.0)))
    return found


def _fitted_as(
    pair: Explanation, first: Trial, second: Trial, baseline: Fit, n_pair: int, search: Search
) -> list[Explanation]:
    """Pair of effects, fitted first to the prediction of another pair, then to the data."""
    found = []
    for near in fitted(first.fit, [second.candidate], search, n_candidate=n_pair):
        best = min([near.fit, *fits_towards(pair, near.fit, baseline)], key=lambda fit: fit.deviance)
        found.append(Explanation.of_pair(first, trial_of(near.candidate, best, first.fit, n_pair)))
    return found

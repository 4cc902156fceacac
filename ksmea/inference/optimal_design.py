"""Which data to add so that the unknowns become known best: D- and c-optimal choice from candidates.

The Fisher information of independent data adds up, M = M₀ + Σ Mᵢ: M₀ of the present data, Mᵢ of each addition. Chosen
are those additions for which the unknowns S that are requested are known best, whatever the others N are
(D_S-optimality):

    max  log det M − log det M_NN,

which is minus the log determinant of the covariance of S at the Cramér–Rao lower bound (CRLB). With S all unknowns it
is D-optimality; with S one of them it is c-optimality, minus the log of its variance. Parameters of the noise, where
its level is not known, are further members of N.

The choice grows one by one (greedy), then members are exchanged for better ones until no exchange helps, as V. V.
Fedorov, Theory of Optimal Experiments, 1972, and T. J. Mitchell, Technometrics 16 (1974) 203–210; A. C. Atkinson, A. N.
Donev and R. D. Tobias, Optimum Experimental Designs, with SAS, 2007. F. E. Udwadia, J. Eng. Mech. 120 (1994) 368–390,
places sensors by the same information. The optimum is local twice over: sensitivities hold near the values that they
were taken at, and exchanges of one member at a time may miss the best set.

Numbers of the model that are known to a tolerance are members of N too (`ksmea.inference.known_numbers`).

Unknowns count from 0 to 1 between their search limits throughout (the unit cube).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.inference.cramer_rao import Identifiability
from ksmea.inference.known_numbers import Numbers
from ksmea.likelihood.fisher import UNKNOWABLE, of_unknowns, whitened_sensitivity
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem, joint_values

# Where present data do not tell an unknown at all there is no determinant. Choices therefore also count on a standard
# deviation of this many times that of a value drawn evenly between its limits (1/√12): it decides next to nothing where
# a CRLB is narrower than the range (one as wide as 1/√12 is moved by 0.5 %), and knowledge far wider than the range, to
# 1e6 % instead of 1e8 %, is worth nothing. An assumption of ours; CRLBs and gains are stated without it.
PRIOR_WIDTHS = 10.0
RIDGE = 12 / PRIOR_WIDTHS**2
BETTER = 1e-6  # of the criterion, a log: exchanges that gain less are rounding
MAX_PASSES = 100


@dataclass(frozen=True)
class Criterion:
    """Criterion log det of the information about the unknowns `targets`.

    They are indices; all other unknowns are also fitted.
    """

    targets: tuple[int, ...]

    def value(self, information: Array) -> Array:
        """(…, k, k) → (…).

        >>> information = 1e4 * np.array([[4.0, 2.0], [2.0, 2.0]])  # its inverse is [[0.5, -0.5], [-0.5, 1]] / 1e4
        >>> round(1e4 * float(np.exp(-Criterion((1,)).value(information))), 3)
        1.0
        """
        regular = information + RIDGE * np.eye(information.shape[-1])
        others = [index for index in range(information.shape[-1]) if index not in self.targets]
        return _log_det(regular) - _log_det(regular[..., others, :][..., others])

    def reduction_pct(self, before: Array, after: Array) -> Array:
        """Decrease in per cent of the CRLB between two informations (…, k, k), the prior counted.

        For several unknowns it is of the geometric mean of the half axes of their confidence ellipsoid.
        """
        return -100 * np.expm1((self.value(before) - self.value(after)) / (2 * len(self.targets)))


def data_rows(
    problem: Problem, x: Array, noise: Noise, kind: str, *, noise_known: bool = True, numbers: Numbers | None = None
) -> Array:
    """Whitened sensitivities (n_part, n_speed, n_channel, k) of the data of a problem at x (d,), SI.

    The sum of their squares over any of the data is these data's information.

    The parts are the means and the variances. The k columns are the unknowns, the noise's relative part and its floor if its
    level is not known, and `numbers`, 0 if the problem lacks them. Default: all that the problem has.
    """
    joint, numbers = problem.joint, Numbers.of(problem) if numbers is None else numbers
    values = joint_values(problem, joint, x, numbers.values)
    response, sensitivity = Model(joint).linearise(joint.parameters.to_cube(values))
    rows = whitened_sensitivity(response, sensitivity, noise, Observable(kind), noise_known=noise_known)
    place = {name: index for index, name in enumerate(joint.parameters.names)}
    of_noise, absent = range(len(place), rows.shape[1]), rows.shape[1]
    own = [place[name] for name in problem.parameters.names]
    known = [place.get(name, absent) for name in numbers.names]
    # rows one after the other: sums over them are the same to the last bit, however many columns there are
    arranged = np.ascontiguousarray(np.pad(rows, ((0, 0), (0, 1)))[:, [*own, *of_noise, *known]])
    return arranged.reshape(-1, *response.shape, arranged.shape[-1])


def information(rows: Array) -> Array:
    """Fisher information (k, k) of data rows (m, k)."""
    return rows.T @ rows


def crlb(rows: Array, n_unknown: int) -> Array:
    """CRLB (n_unknown,), 1 σ, of data rows (m, k), without any prior; infinite where not identifiable."""
    return Identifiability(np.ones(n_unknown), of_unknowns(rows, n_unknown)).crlb


def mean_axis_reduction_pct(before: Array, after: Array, n_unknown: int) -> float:
    """Decrease in per cent of the mean half axis of the unknowns' confidence ellipsoid.

    It is their geometric mean, between two sets of data rows (m, k), without any prior. Axes that neither knows are
    left out: the sets must know equally many.
    """
    singular = [np.linalg.svd(of_unknowns(rows, n_unknown), compute_uv=False) for rows in (before, after)]
    n_known = min(int(np.sum(values > UNKNOWABLE * values[0])) for values in singular)
    if not n_known:
        return 0.0
    return float(-100 * np.expm1(np.mean(np.log(singular[0][:n_known] / singular[1][:n_known]))))


def choose(present: Array, candidates: Array, count: int, criterion: Criterion, repeats: int = 1) -> list[int]:
    """The `count` candidates to add to the present information (k, k), the one that tells most first.

    `candidates` are their informations (n, k, k); each may be chosen up to `repeats` times.

    A straight line over x = −1, 0, 1 is known best from measurements at its ends:

    >>> line = 1e4 * np.array([[[1.0, x], [x, x * x]] for x in (-1, 0, 1)])
    >>> sorted(choose(np.zeros((2, 2)), line, 4, Criterion((0, 1)), repeats=4))
    [0, 0, 2, 2]
    """
    if count > repeats * len(candidates):
        raise ValueError(f"expected to choose at most {repeats * len(candidates)} candidates, got {count}")
    chosen = _grown(present, candidates, count, criterion, Counter(dict.fromkeys(range(len(candidates)), repeats)))
    chosen = _exchanged(present, candidates, chosen, criterion, repeats)
    return _grown(present, candidates, count, criterion, Counter(chosen))


def _grown(present: Array, candidates: Array, count: int, criterion: Criterion, allowed: Counter[int]) -> list[int]:
    """One by one the candidate that helps most, each as often as allowed at most."""
    chosen: list[int] = []
    total = present
    for _ in range(count):
        left = [index for index, times in allowed.items() if times > chosen.count(index)]
        values = criterion.value(total + candidates[left])
        chosen.append(left[int(np.argmax(values))])
        total = total + candidates[chosen[-1]]
    return chosen


def _exchanged(
    present: Array, candidates: Array, chosen: Sequence[int], criterion: Criterion, repeats: int
) -> list[int]:
    """Each member in turn gives way to the candidate that is best in its place, until none does."""
    chosen = list(chosen)
    for _ in range(MAX_PASSES):
        before = list(chosen)
        for member in range(len(chosen)):
            others = chosen[:member] + chosen[member + 1 :]
            values = criterion.value(present + _sum(candidates, others) + candidates)
            values[[index for index, times in Counter(others).items() if times >= repeats]] = -np.inf
            best = int(np.argmax(values))
            if values[best] > values[chosen[member]] + BETTER:
                chosen[member] = best
        if chosen == before:
            break
    return chosen


def _sum(candidates: Array, indices: Iterable[int]) -> Array:
    """Always in the same order, so that a set has one value, however it was reached."""
    return np.asarray(np.sum(candidates[sorted(indices)], axis=0))


def _log_det(matrix: Array) -> Array:
    """(…, k, k) → (…); 0 of an empty matrix."""
    return np.asarray(np.linalg.slogdet(matrix)[1])

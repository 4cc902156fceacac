"""Numbers of a model that are known to a tolerance, in the choice of data to add.

Nuisance with a prior.

Their columns stand behind the unknowns and the parameters of the noise. Priors are present data, which no addition repeats.
A number that one addition alone sees, such as the gain of an added probe, is noise of its data: with G their sensitivity to
such numbers and S the variances of these, the covariance of whitened data is I + G S Gᵀ, and their sensitivity J becomes
(I + G S Gᵀ)^(−1/2) J. A number that several additions see, such as the position of a plane of two probes, keeps its column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.likelihood.fisher import prior_rows
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem


@dataclass(frozen=True)
class Numbers:
    """Numbers known to a tolerance, in the order of their columns.

    `values` (SI) by name, if they are not as stated.
    """

    items: tuple[Parameter, ...] = ()
    values: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem, values: Mapping[str, float] | None = None) -> Numbers:
        """All numbers of a problem that are known to a tolerance."""
        return cls(tuple(item for item in problem.joint.parameters if item.is_input), values or {})

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(item.name for item in self.items)

    @property
    def words(self) -> tuple[str, ...]:
        """Their names for people."""
        return tuple(item.words or item.name for item in self.items)

    @property
    def sd(self) -> Array:
        """Their standard deviations (n,) as stated, in the unit cube."""
        return Parameters(self.items).priors[1]

    def beyond(self, others: Numbers) -> Numbers:
        """The numbers that are not among others."""
        return Numbers(tuple(item for item in self.items if item.name not in others.names), self.values)

    def __add__(self, others: Numbers) -> Numbers:
        return Numbers((*self.items, *others.items), {**self.values, **others.values})

    def __len__(self) -> int:
        return len(self.items)


def prior_data(parameters: Parameters, numbers: Numbers, n_column: int) -> Array:
    """Priors of unknowns and numbers as data rows (n_prior, n_column).

    Unknowns are the first columns, numbers the last ones.
    """
    rows = prior_rows(Parameters((*parameters, *numbers.items)), len(parameters) + len(numbers))
    return np.insert(rows, [len(parameters)] * (n_column - rows.shape[1]), 0.0, axis=1)


def own_numbers_as_noise(blocks: Sequence[Array], sd: Array) -> tuple[list[Array], Indices]:
    """Additions as data rows (m, k), their last columns being numbers with standard deviations `sd` (n,).

    Numbers that one addition alone sees become its noise and lose their columns. Second, the indices of all numbers
    that several see.
    """
    start = blocks[0].shape[1] - len(sd)
    seen = np.array([np.any(block[:, start:] != 0, axis=0) for block in blocks])
    shared = np.flatnonzero(np.sum(seen, axis=0) > 1)
    made = []
    for block, sees in zip(blocks, seen):
        alone = np.setdiff1d(np.flatnonzero(sees), shared)
        is_finite = bool(np.all(np.isfinite(block)))  # amplitudes of no motion are not
        noisy = with_noise(block, block[:, start + alone] * sd[alone]) if is_finite else block
        made.append(noisy[:, [*range(start), *(start + shared)]])
    return made, shared


def with_noise(rows: Array, columns: Array) -> Array:
    """Data rows (m, k) with further noise of unit variance along each of the columns C (m, n).

    The rows are multiplied by (I + C Cᵀ)^(−1/2).

    >>> with_noise(np.array([[2.0], [1.0]]), np.array([[np.sqrt(3)], [0.0]])).tolist()  # of variance 1 + 3, and of 1
    [[1.0], [1.0]]
    """
    directions, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(rows - (directions * (1 - 1 / np.hypot(1.0, singular))) @ (directions.T @ rows))

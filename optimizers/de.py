"""Differential evolution: the paper's rand/1/bin in arrays, other strategies by scipy.

R. Storn and K. Price, Differential evolution, J. Global Optimization 11 (1997) 341–359, doi 10.1023/A:1008202821328;
the reference paper's optimiser, eqs. (25)–(28) and Table 5, doi 10.1016/j.jsv.2012.12.025.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from scipy.optimize import Bounds, differential_evolution

from ksmea.arrays import Array, Indices
from ksmea.numerics.isolation import finite
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting

STRATEGIES = tuple(
    f"{base}{crossover}"
    for crossover in ("bin", "exp")
    for base in ("rand1", "rand2", "best1", "best2", "randtobest1", "currenttobest1")
)


PAPERS = "rand1bin"


@dataclass(frozen=True)
class DE(Optimizer):
    """Differential evolution with rand/1 mutation, binomial crossover and greedy selection.

    Mutation v = z_r1 + F (z_r2 − z_r3), eq. (26); crossover with rate C; a trial replaces its parent where its
    misfit is not larger. It evaluates population · (generations + 1) points, in one batch per generation.
    Departure from the paper, which does not treat it: a coordinate that leaves the limits is drawn anew.
    """

    mutation_factor: float = setting(
        0.8, "F, the scale of difference vectors", source="Table 5", above=0.0, at_most=1.99
    )
    crossover_rate: float = setting(
        0.95, "C, the probability that a coordinate comes from the mutant", source="Table 5", at_least=0.0, at_most=1.0
    )
    population: int = setting(100, "members of the population", source="Table 5", at_least=5)
    generations: int = setting(
        100, "generations after the initial population; assumed, the paper does not state their number", at_least=1
    )
    strategy: str = setting(
        PAPERS, "mutation and crossover, in scipy's names", source="eqs. (26)–(27)", choices=STRATEGIES
    )

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Evolve a Latin hypercube of points."""
        first = scipy.stats.qmc.LatinHypercube(objective.dim, rng=rng).random(self.population)
        if self.strategy == PAPERS:
            self._evolve(objective, first, rng)
        else:
            self._evolve_by_scipy(objective, first, rng)
        return objective.result()

    def _evolve(self, objective: Objective, members: Array, rng: np.random.Generator) -> None:
        """Eqs. (26)–(28), each generation drawn and evaluated as arrays.

        Rand/1/bin from members (population, dim).
        """
        values = finite(objective(members))
        for _ in range(self.generations):
            trials = self._trials(members, rng)
            found = finite(objective(trials))
            is_better = found <= values
            members = np.where(is_better[:, None], trials, members)
            values = np.where(is_better, found, values)

    def _trials(self, members: Array, rng: np.random.Generator) -> Array:
        """One trial for each of the members (population, dim)."""
        n, dim = members.shape
        base, plus, minus = members[others(n, 3, rng)]
        mutants = base + self.mutation_factor * (plus - minus)
        is_crossed = rng.random((n, dim)) < self.crossover_rate
        is_crossed[np.arange(n), rng.integers(dim, size=n)] = True
        trials = np.where(is_crossed, mutants, members)
        is_outside = (trials < 0.0) | (trials > 1.0)
        return np.where(is_outside, rng.random((n, dim)), trials)

    def _evolve_by_scipy(self, objective: Objective, members: Array, rng: np.random.Generator) -> None:
        def misfits(points: Array) -> Array:  # points (d, population)
            return finite(objective(points.T))

        vectorised: Any = misfits  # for many points at once, which the types of scipy do not foresee
        strategy: Any = self.strategy  # one of STRATEGIES
        try:
            differential_evolution(
                vectorised,
                bounds=Bounds(np.zeros(objective.dim), np.ones(objective.dim)),
                strategy=strategy,
                mutation=self.mutation_factor,
                recombination=self.crossover_rate,
                maxiter=self.generations,
                init=members,
                rng=rng,
                vectorized=True,
                updating="deferred",
                polish=False,
                tol=0.0,
                atol=-1.0,  # below any spread: with 0 a population of equal misfits would end the run early
            )
        except RuntimeError as error:
            # scipy hides a ValueError of the objective, a singular matrix among them, behind a remark on map functions
            raise (error.__cause__ or error) from None


def others(n: int, number: int, rng: np.random.Generator) -> Indices:
    """For each of n members so many different other ones, all alike likely: indices (number, n)."""
    taken = np.arange(n)[None]
    for left in range(n - 1, n - 1 - number, -1):
        found = rng.integers(left, size=n)
        for each in np.sort(taken, axis=0):  # past those that are taken, the lowest first
            found += found >= each
        taken = np.vstack([taken, found])
    return taken[1:]

"""Genetic algorithm on a binary chromosome, by deap.

D. E. Goldberg, Genetic Algorithms in Search, Optimization and Machine Learning (1989), chapters 1 and 3;
F.-A. Fortin et al., DEAP, J. Machine Learning Research 13 (2012) 2171–2175.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from deap import algorithms, base, tools

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.numerics.isolation import global_generators
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting

CROSSOVERS = {"one_point": tools.cxOnePoint, "two_point": tools.cxTwoPoint}


class Misfit(base.Fitness):
    """A fitness that is better when it is smaller."""

    weights = (-1.0,)


class Chromosome(list):
    """Bits with the misfit of the point they stand for; the misfit is invalid until it has been evaluated."""

    def __init__(self, bits: Sequence[int]) -> None:
        super().__init__(bits)
        self.fitness = Misfit()

    def __deepcopy__(self, memo: dict) -> Chromosome:
        clone = Chromosome(self)  # bits are immutable: many times faster than deepcopy's way through a list
        clone.fitness.wvalues = self.fitness.wvalues  # a tuple: all that a fitness holds
        return clone


@dataclass(frozen=True)
class GA(Optimizer):
    """Generational genetic algorithm: tournament selection, crossover of neighbours, flips of bits.

    With `elites` = 0 it is deap's `eaSimple`. A generation evaluates, in one batch, the chromosomes that crossover or
    mutation has touched: on average population · [1 − (1 − crossover_rate)(1 − mutation_rate)] points.
    """

    crossover_rate: float = setting(
        0.5, "probability that two neighbours exchange bits", source="Table 5", at_least=0.0, at_most=1.0
    )
    mutation_rate: float = setting(
        0.1,
        "probability that an individual mutates; Table 5's value read as one per bit: mutation_rate=1 bit_flip_rate=0.1",
        source="Table 5",
        at_least=0.0,
        at_most=1.0,
    )
    bit_flip_rate: float | None = setting(
        None,
        "probability that a bit of a mutating individual flips; none: 1/chromosome_length",
        at_least=0.0,
        at_most=1.0,
    )
    chromosome_length: int = setting(52, "bits of a chromosome", source="Table 5", at_least=2)
    bits: list[int] | None = setting(
        None,
        "bits of each parameter; null: shared evenly, as the paper's 52 by five as 11, 11, 10, 10, 10. That is assumed, it does"
        " not say",
        at_least=1,
        at_most=52,  # digits of a float
    )
    gray: bool = setting(False, "read the bits as Gray code, where neighbouring values differ by one bit")
    population: int = setting(100, "individuals", source="Table 5", at_least=2)
    generations: int = setting(
        100, "generations after the initial population; assumed, the paper does not state their number", at_least=1
    )
    crossover: str = setting("two_point", "kind of crossover; assumed, not stated", choices=tuple(CROSSOVERS))
    tournament: int = setting(3, "individuals of which the best is selected; assumed, not stated", at_least=1)
    elites: int = setting(
        0, "best individuals that enter the next generation unchanged; assumed, not stated", at_least=0
    )

    def check(self) -> None:
        if self.bits is not None and sum(self.bits) != self.chromosome_length:
            raise SettingError(
                f"bits: expected a sum of chromosome_length = {self.chromosome_length}, got {list(self.bits)}, which is"
                f" {sum(self.bits)}; change bits or write chromosome_length={sum(self.bits)}"
            )
        if self.elites >= self.population:
            raise SettingError(f"elites: expected fewer than population = {self.population}, got {self.elites}")

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Evolve random chromosomes."""
        self.check_dimension(objective.dim)
        toolbox = self._toolbox()
        population = [
            Chromosome(bits) for bits in rng.integers(2, size=(self.population, self.chromosome_length)).tolist()
        ]
        with global_generators(rng):
            self._evaluate(population, objective)
            for _ in range(self.generations):
                parents = toolbox.select(population, self.population - self.elites)
                offspring = algorithms.varAnd(parents, toolbox, self.crossover_rate, self.mutation_rate)
                self._evaluate(offspring, objective)
                population = tools.selBest(population, self.elites) + offspring
        return objective.result()

    def _toolbox(self) -> base.Toolbox:
        flip_rate = 1.0 / self.chromosome_length if self.bit_flip_rate is None else self.bit_flip_rate
        toolbox = base.Toolbox()
        toolbox.register("select", tools.selTournament, tournsize=self.tournament)
        toolbox.register("mate", CROSSOVERS[self.crossover])
        toolbox.register("mutate", tools.mutFlipBit, indpb=flip_rate)
        return toolbox

    def _evaluate(self, population: list[Chromosome], objective: Objective) -> None:
        changed = [individual for individual in population if not individual.fitness.valid]
        if changed:
            for individual, value in zip(
                changed, objective(decode(np.array(changed), self._shared(objective.dim), self.gray))
            ):
                individual.fitness.values = (value,)

    def check_dimension(self, dim: int) -> None:
        """Raise `SettingError` if the bits are not shared among `dim` parameters."""
        if len(self._shared(dim)) != dim:
            raise SettingError(
                f"bits: expected one entry for each of {dim} parameters, got {len(self._shared(dim))} entries; leave it null"
            )
        if self.chromosome_length < dim:
            raise SettingError(
                f"chromosome_length: expected a bit at least for each of {dim} parameters, got {self.chromosome_length}"
            )

    def _shared(self, dim: int) -> list[int]:
        """Bits of each of `dim` parameters."""
        share, rest = divmod(self.chromosome_length, dim)
        return [share + (index < rest) for index in range(dim)] if self.bits is None else self.bits


def decode(chromosomes: Array, bits: Sequence[int], gray: bool = False) -> Array:
    """Points (n, d) of the unit cube that chromosomes (n, Σ bits) stand for.

    A parameter of b bits, the most significant first, is its integer / (2ᵇ − 1), so that both limits can be reached.

    >>> decode(np.array([[1, 0, 1, 1, 1], [0, 1, 0, 0, 0]]), [2, 3])
    array([[0.66666667, 1.        ],
           [0.33333333, 0.        ]])
    """
    genes = np.split(chromosomes, np.cumsum(bits)[:-1], axis=1)
    if gray:
        genes = [np.bitwise_xor.accumulate(gene, axis=1) for gene in genes]
    return np.column_stack([gene @ 2.0 ** np.arange(b)[::-1] / (2.0**b - 1.0) for gene, b in zip(genes, bits)])

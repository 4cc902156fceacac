"""Searches of a free objective.

They are by our optimisers, which shows the cost of their adapters and of counting points, and by the bare libraries, as
their documentation shows: points are counted by nobody, and the best one is the library's.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from benchmarks.harness.task import Task

DIM, CENTRE = 5, 0.3
BITS = 52
SHARES = np.cumsum([11, 11, 10, 10, 10])[:-1]


def sphere(u: np.ndarray) -> np.ndarray:
    """Points (n, 5) → (n,)."""
    return np.sum((u - CENTRE) ** 2, axis=1)


def here(optimizer: str, population: int, generations: int) -> Task:
    """One search of the sphere in five unknowns; a unit is a generation."""
    from ksmea.numerics.objective import Minimum, Objective
    from ksmea.plugins import registry

    settings = {"population": population, "generations": generations}
    if optimizer == "cmaes":  # it counts evaluations, not generations
        settings = {"population": population, "evaluations": population * generations}
    chosen = registry.create("optimizer", optimizer, settings)

    def run(turn: int) -> Minimum:
        return chosen.minimize(Objective(DIM, lambda u: u - CENTRE), np.random.default_rng(turn))

    return Task(run, quality=lambda found: found.value, units=generations)


def bare(optimizer: str, population: int, generations: int) -> Task:
    """One search by a library; its result is the misfit of the best point."""
    chosen = LIBRARIES[optimizer]
    return Task(lambda turn: chosen(population, generations, turn), quality=float, units=generations)


def by_scipy(population: int, generations: int, seed: int) -> float:
    from scipy.optimize import differential_evolution
    from scipy.stats.qmc import LatinHypercube

    rng = np.random.default_rng(seed)
    found = differential_evolution(
        lambda points: sphere(points.T),
        [(0.0, 1.0)] * DIM,
        strategy="rand1bin",
        mutation=0.8,
        recombination=0.95,
        maxiter=generations,
        init=LatinHypercube(DIM, rng=rng).random(population),
        rng=rng,
        vectorized=True,
        updating="deferred",
        polish=False,
        tol=0.0,
        atol=-1.0,
    )
    return float(found.fun)


def by_pyswarms(population: int, generations: int, seed: int) -> float:
    from pyswarms.single.global_best import GlobalBestPSO

    np.random.seed(seed)
    logging.disable(logging.CRITICAL)
    swarm = GlobalBestPSO(
        n_particles=population,
        dimensions=DIM,
        options={"w": 0.8, "c1": 0.5, "c2": 0.5},
        bounds=(np.zeros(DIM), np.ones(DIM)),
        bh_strategy="nearest",
    )
    return float(swarm.optimize(sphere, iters=generations + 1, verbose=False)[0])


def by_deap(population: int, generations: int, seed: int) -> float:
    """The `eaSimple` of its documentation, misfits of a generation in one batch."""
    import random

    from deap import algorithms, base, creator, tools

    random.seed(seed)
    if not hasattr(creator, "Smaller"):
        creator.create("Smaller", base.Fitness, weights=(-1.0,))
        creator.create("Chromosome", list, fitness=creator.Smaller)
    toolbox = base.Toolbox()
    toolbox.register("bit", random.randint, 0, 1)
    toolbox.register("individual", tools.initRepeat, creator.Chromosome, toolbox.bit, BITS)
    toolbox.register("population", tools.initRepeat, list, toolbox.individual)
    toolbox.register("mate", tools.cxTwoPoint)
    toolbox.register("mutate", tools.mutFlipBit, indpb=1 / BITS)
    toolbox.register("select", tools.selTournament, tournsize=3)
    toolbox.register("map", lambda _, individuals: [(value,) for value in sphere(decoded(list(individuals)))])
    toolbox.register("evaluate", lambda individual: individual)
    last, _ = algorithms.eaSimple(toolbox.population(population), toolbox, 0.5, 0.1, generations, verbose=False)
    return float(min(individual.fitness.values[0] for individual in last))


def decoded(chromosomes: list[list[int]]) -> np.ndarray:
    genes = np.split(np.array(chromosomes).reshape(-1, BITS), SHARES, axis=1)
    return np.column_stack(
        [gene @ 2.0 ** np.arange(gene.shape[1])[::-1] / (2.0 ** gene.shape[1] - 1) for gene in genes]
    )


def by_cma(population: int, generations: int, seed: int) -> float:
    import cma

    options = {"bounds": [0.0, 1.0], "popsize": population, "maxiter": generations, "seed": seed + 1, "verbose": -9}
    options |= {"tolfun": 0.0, "tolfunhist": 0.0, "tolx": 0.0, "tolstagnation": 10**9, "tolflatfitness": 10**9}
    search = cma.CMAEvolutionStrategy(np.random.default_rng(seed).random(DIM), 0.25, options)
    while not search.stop():
        points = search.ask()
        search.tell(points, sphere(np.array(points)).tolist())
    return float(search.result.fbest)


def by_pymoo(population: int, generations: int, seed: int) -> float:
    from pymoo.algorithms.soo.nonconvex.de import DE
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    class Sphere(Problem):
        def __init__(self) -> None:
            super().__init__(n_var=DIM, n_obj=1, xl=np.zeros(DIM), xu=np.ones(DIM))

        def _evaluate(self, x: np.ndarray, out: dict, *args: object, **keywords: object) -> None:
            out["F"] = sphere(x)

    algorithm = DE(pop_size=population, variant="DE/rand/1/bin", CR=0.95, F=0.8)
    return float(minimize(Sphere(), algorithm, ("n_gen", generations + 1), seed=seed + 1).F[0])


LIBRARIES: dict[str, Callable[[int, int, int], float]] = {
    "scipy": by_scipy,
    "pyswarms": by_pyswarms,
    "deap": by_deap,
    "cma": by_cma,
    "pymoo": by_pymoo,
}

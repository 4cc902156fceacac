"""How often the test of lack of fit rejects noise itself, of which no model has taken a part.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.lack_of_fit_rates results/diagnosis_effects

Complex data of 53 speeds and six channels. Statistics are ranked among 200 000 samples of unit noise; p of 100 000 further ones is
below each level as often as the level says, if the smallest of four p-values is corrected as it should be. With a folder of
`diagnosis_effects` the noise of its runs is tested as well, before any fit: for which of them even the true values would be refused.
How often a fit is refused is counted by `diagnosis_nulls`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from bench.plan.plan import Plan, generator, read_plan
from bench.plan.setup import Setup
from bench.reports.tables import interval
from ksmea.arrays import Array
from ksmea.fits.lack_of_fit import residual_statistics, upper_ranks
from ksmea.measurement.measurement import observe
from ksmea.measurement.noise import Noise

SHAPE, UNIT = (53, 6), Noise(0.0, 1.0)
RANKED, CHUNK, DRAWS = 200_000, 2000, 100_000
REFUSED = 0.005  # p of fits that are refused
LEVELS = (0.002, 0.005, 0.01, 0.05, 0.5)


def statistics_of_noise(rng: np.random.Generator, n: int) -> Array:
    """Of n draws, (n, 4), as synthetic measurements draw it."""
    draws = np.stack([observe(np.zeros(SHAPE), "complex", UNIT, rng) for _ in range(n)])
    return residual_statistics(draws, [slice(0, SHAPE[0])], scale_free=True)


def p_values(statistics: Array, known: Array) -> Array:
    """p (n,) of the smallest of the four p-values among known samples."""
    ranks = np.stack([upper_ranks(column) for column in known.T], axis=1) / len(known)
    smallest = np.sort(ranks.min(axis=1))
    above = [len(known) - np.searchsorted(np.sort(column), mine) for column, mine in zip(known.T, statistics.T)]
    return np.searchsorted(smallest, np.min(above, axis=0) / len(known), side="right") / len(known)


def told(name: str, p: Array) -> None:
    """Shares below each level; their intervals are wider by what the known samples leave open."""
    n = round(1 / (1 / len(p) + 1 / RANKED))
    for level in LEVELS:
        below = int(np.sum(p < level))
        low, high = interval(round(below * n / len(p)), n)
        share = f"{below / len(p):.2%}, 95 % interval {low:.2%} to {high:.2%}"
        print(f"{name}: p below {level:g} in {below} of {len(p)} ({share})")


def statistics_of_runs(plan: Plan) -> Array:
    """Of the noise of an experiment's runs, (n, 4)."""
    for cell in plan.cells:
        setup = Setup.of(cell.settings)
        shape = (len(setup.problem.speed), len(setup.problem.channels))
        if shape != SHAPE or setup.source.kind != "complex":
            raise SystemExit(f"{plan.name}: expected complex data of shape {SHAPE}, got {setup.source.kind} of {shape}")
    return np.concatenate([statistics_of_noise(generator(plan.seeds(run)["noise"]), 1) for run in plan.runs])


def main(folders: list[str]) -> None:
    rng = np.random.default_rng(0)
    known = np.concatenate([statistics_of_noise(rng, CHUNK) for _ in range(RANKED // CHUNK)])
    fresh = np.concatenate([statistics_of_noise(rng, CHUNK) for _ in range(DRAWS // CHUNK)])
    told("noise", p_values(fresh, known))
    for folder in folders:
        plan = read_plan(Path(folder))
        p = p_values(statistics_of_runs(plan), known)
        told(folder, p)
        for run, of_run in zip(plan.runs, p):
            if of_run < REFUSED:
                print(f"  {plan.cells[run.cell].place['label']}, repetition {run.repetition}: p {of_run:.4f}")


if __name__ == "__main__":
    main(sys.argv[1:])

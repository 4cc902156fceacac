"""An optimiser that keeps every property of its exam, and for each property one that breaks it."""

import itertools
import os
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ksmea import Minimum, Optimizer
from ksmea.errors import BudgetSpent
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class Shrinking(Optimizer):
    """Random points around the best one, in a box that shrinks."""

    points: int = setting(60, "points of a round", at_least=1)
    rounds: int = setting(60, "rounds", at_least=1)

    def minimize(self, objective, rng):
        for width in 0.5 * 0.9 ** np.arange(self.rounds):
            self.step(objective, objective.result().u, width, rng)
        return objective.result()

    def step(self, objective, best, width, rng):
        objective(np.clip(best + width * rng.uniform(-1, 1, (self.points, objective.dim)), 0, 1))


@dataclass(frozen=True)
class WithoutHelp(Shrinking):
    """A setting that says nothing of itself."""

    pace: float = 0.9


START = Path("start.csv")


@dataclass(frozen=True)
class WithPath(Shrinking):
    """A setting that no plan can hold."""

    file: Path = setting(START, "where it starts")


@dataclass(frozen=True)
class Unchecked(Shrinking):
    """It takes whatever it is given."""

    def __post_init__(self):
        pass


class Undecorated(Shrinking):
    """A plain class."""


@dataclass(frozen=True)
class BeyondBounds(Shrinking):
    """It leaves the clipping to others."""

    def step(self, objective, best, width, rng):
        objective(best + width * rng.uniform(-1, 1, (self.points, objective.dim)))


@dataclass(frozen=True)
class OwnResult(Shrinking):
    """It returns its last point for the best one."""

    def minimize(self, objective, rng):
        return Minimum(np.full(objective.dim, 0.5), 0.0, super().minimize(objective, rng).evaluations, 0)


@dataclass(frozen=True)
class GoesOn(Shrinking):
    """It swallows the end of its budget."""

    def step(self, objective, best, width, rng):
        for _ in range(10):
            with suppress(Exception):
                super().step(objective, best, width, rng)


@dataclass(frozen=True)
class Uncounted(Shrinking):
    """It evaluates behind the counter's back."""

    def step(self, objective, best, width, rng):
        objective._values(rng.random((self.points, objective.dim)))
        super().step(objective, best, width, rng)


RUNS = itertools.count()


@dataclass(frozen=True)
class Remembers(Shrinking):
    """Each run starts from another seed."""

    def minimize(self, objective, rng):
        return super().minimize(objective, np.random.default_rng(next(RUNS)))


@dataclass(frozen=True)
class ByProcess(Shrinking):
    """Its seed is the number of its process."""

    def minimize(self, objective, rng):
        return super().minimize(objective, np.random.default_rng(os.getpid()))


@dataclass(frozen=True)
class SharedGenerator(Shrinking):
    """It draws from the generator of the whole process, after seeding it."""

    def minimize(self, objective, rng):
        np.random.seed(3)
        return super().minimize(objective, rng)


@dataclass(frozen=True)
class OtherGenerator(Shrinking):
    """It draws from the generator of the whole process, and puts it back."""

    def minimize(self, objective, rng):
        state = np.random.get_state()
        own = np.random.default_rng(np.random.randint(2**31))
        np.random.set_state(state)
        return super().minimize(objective, own)


@dataclass(frozen=True)
class Weighs(Shrinking):
    """It goes on from the mean of its points, weighted by how far their misfits lie below the largest."""

    def minimize(self, objective, rng):
        best = np.full(objective.dim, 0.5)
        for width in 0.5 * 0.9 ** np.arange(self.rounds):
            points = np.clip(best + width * rng.uniform(-1, 1, (self.points, objective.dim)), 0, 1)
            values = objective(points)
            with np.errstate(invalid="ignore"):
                weights = (values.max() - values) ** 4
                best = np.sum(weights[:, None] * points, axis=0) / np.sum(weights)
        return objective.result()


@dataclass(frozen=True)
class WantsValues(Shrinking):
    """It cannot do without a value."""

    def step(self, objective, best, width, rng):
        super().step(objective, best, width, rng)
        if not np.isfinite(objective.result().value):
            raise RuntimeError("no start has a value")


@dataclass(frozen=True)
class Decomposes(Shrinking):
    """It decomposes residuals."""

    def step(self, objective, best, width, rng):
        np.linalg.svd(np.outer(*2 * [objective.residuals(rng.random(objective.dim))]))
        super().step(objective, best, width, rng)


@dataclass(frozen=True)
class Scales(Shrinking):
    """It divides by the spread of its values."""

    def step(self, objective, best, width, rng):
        values = objective(rng.random((self.points, objective.dim)))
        _ = 1 / float(values.max() - values.min())


@dataclass(frozen=True)
class Catches(Shrinking):
    """It takes every ValueError for its own."""

    def minimize(self, objective, rng):
        with suppress(ValueError):
            super().minimize(objective, rng)
        return objective.result()


@dataclass(frozen=True)
class Forks(Shrinking):
    """It forks, and both processes go on."""

    def minimize(self, objective, rng):
        os.fork()
        return super().minimize(objective, rng)


@dataclass(frozen=True)
class Hurries(Shrinking):
    """It ends after a minute."""

    def step(self, objective, best, width, rng):
        started = time.monotonic()
        super().step(objective, best, width, rng)
        if time.monotonic() - started > 60:
            raise BudgetSpent


BROKEN_OPTIMIZERS = [
    ("one_process_returns", Forks(), r"expected one process that returns, got 2; end a fork by os\._exit in the child"),
    ("clock_plays_no_part", Hurries(), r"however much time passes, got .*; end by the budget, not by a clock"),
    (
        "settings_are_documented",
        WithoutHelp(),
        r"help text of the setting pace, got none; write pace: … = ksmea.setting",
    ),
    ("settings_are_typed", WithPath(), r"of the setting file that a plan can hold, got a Path; give it bool, int"),
    ("settings_are_checked", Unchecked(), r"a SettingError, got none of points=object\(\); type points and call super"),
    ("it_is_frozen_and_pickles", Undecorated(), r"frozen dataclass Undecorated, .*; write that above the class"),
    ("asks_within_bounds", BeyondBounds(), r"coordinates from 0 to 1, got one that is 0\.\d+ outside; clip"),
    ("returns_the_objectives_result", OwnResult(), r"end with return objective.result\(\)"),
    (
        "ends_with_its_budget",
        GoesOn(),
        r"an end once 1 evaluations are spent, got 100 more calls; let BudgetSpent pass",
    ),
    ("ends_with_its_budget", Uncounted(), r"at most 1 points computed, got 61; ask by objective\(u\)"),
    (
        "same_seed_same_result",
        Remembers(),
        r"numbers in a second run, got \d+ that differ; keep nothing from run to run",
    ),
    (
        "workers_give_the_same",
        ByProcess(),
        r"numbers in another process, got \d+ that differ; depend on no order of sets",
    ),
    (
        "shared_generators_play_no_part",
        SharedGenerator(),
        r"left as they were, got another state; a library that draws",
    ),
    ("shared_generators_play_no_part", OtherGenerator(), r"with other states of random and numpy.random, got \d+ that"),
    ("survives_points_without_value", Weighs(), r"within 0.1 of the minimum, got one at .*; take \+inf for worse"),
    (
        "survives_no_value_anywhere",
        WantsValues(),
        r"worked off without an error, got RuntimeError: no start has a value",
    ),
    ("survives_infinite_residuals", Decomposes(), r"worked off without an error, got LinAlgError: "),
    (
        "survives_a_constant",
        Scales(),
        r"worked off without an error, got ZeroDivisionError: .*; mend where it is raised",
    ),
    (
        "errors_of_the_model_pass",
        Catches(),
        r"the model's own ValueError, got no error; catch nothing around the objective",
    ),
    (
        "finds_the_minimum_of_a_sphere",
        Shrinking(rounds=3),
        r"by 20000 evaluations, got one at .* after 180; .* state what",
    ),
]

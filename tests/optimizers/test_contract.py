"""Properties that every optimiser of the project has besides its exam (tests/test_exam.py).

With its default settings, in five dimensions, it uses a budget to the last point, and leaves logging, files and streams
alone.
"""

import importlib.metadata
import logging
import random
import subprocess
import sys

import numpy as np
import pytest
from omegaconf import OmegaConf

from ksmea.errors import BudgetSpent
from ksmea.numerics.objective import Objective

OPTIMIZERS = {entry.name: entry for entry in importlib.metadata.entry_points(group="ksmea.optimizers")}
DIM = 5
LOWEST = np.array([0.31, 0.62, 0.17, 0.74, 0.45])
BUDGETS = (1, 7, 99, 101, 250)

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(params=sorted(OPTIMIZERS))
def optimizer(request):
    return OPTIMIZERS[request.param].load()()


class Watched(Objective):
    """An objective that notes what the model below it computed."""

    def __init__(self, residuals_at=lambda u: u - LOWEST, **options):
        self.computed, self._model = [], residuals_at
        super().__init__(DIM, self._noted, **options)

    def _noted(self, u):
        self.computed.append(u.copy())
        return self._model(u)

    @property
    def points(self):
        return np.concatenate(self.computed)


def spent(optimizer, objective, seed=0):
    """Run until the budget ends it."""
    with pytest.raises(BudgetSpent):
        optimizer.minimize(objective, np.random.default_rng(seed))
    return objective


def test_settings_travel_through_configuration_files(optimizer):
    assert OmegaConf.to_object(OmegaConf.structured(type(optimizer))) == optimizer


@pytest.mark.parametrize("budget", BUDGETS)
def test_a_budget_is_used_exactly(optimizer, budget):
    objective = spent(optimizer, Watched(budget=budget))
    misfit = np.sum((objective.points - LOWEST) ** 2, axis=1)
    minimum = objective.result()
    assert len(objective.points) == minimum.evaluations == budget
    assert minimum.value == misfit.min()
    assert np.array_equal(minimum.u, objective.points[misfit.argmin()])


@pytest.mark.parametrize("budget", BUDGETS)
def test_a_budget_leaves_a_point_with_its_misfit_where_screening_is_another_function(optimizer, budget):
    screened = []

    def screening_at(u):
        screened.append(u.copy())
        return np.abs(u - LOWEST).sum(axis=1)

    objective = spent(optimizer, Watched(screening_at=screening_at, budget=budget))
    assert len(objective.points) + sum(map(len, screened)) == objective.evaluations == budget
    minimum = objective.result()
    assert minimum.value == pytest.approx(np.sum((minimum.u - LOWEST) ** 2), rel=1e-12)
    for (
        points
    ) in screened:  # the best screened point was evaluated, moved inside the bounds by a little where near them
        best = points[np.abs(points - LOWEST).sum(axis=1).argmin()]
        assert minimum.value <= np.sum((best - LOWEST) ** 2) + 0.01


def test_the_seed_decides_the_sequence_of_points(optimizer):
    first, again, other = (spent(optimizer, Watched(budget=999), seed).points for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


class Broken(ValueError):
    """Error that a model may raise: a singular matrix is a ValueError too."""


def broken(u):
    raise Broken("singular at this speed")


@pytest.mark.parametrize(
    "objective, ending",
    [(Watched, None), (lambda: Watched(budget=333), BudgetSpent), (lambda: Watched(broken), Broken)],
    ids=["finished", "budget spent", "model error"],
)
def test_nothing_around_it_changes(optimizer, objective, ending, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    root = logging.getLogger()
    handlers, level, configure = list(root.handlers), root.level, logging.config.dictConfig
    python_state, numpy_state = random.getstate(), np.random.get_state()
    if ending is None:
        optimizer.minimize(objective(), np.random.default_rng(0))
    else:
        with pytest.raises(ending):
            optimizer.minimize(objective(), np.random.default_rng(0))
    assert random.getstate() == python_state
    assert all(np.array_equal(was, now) for was, now in zip(numpy_state, np.random.get_state()))
    assert root.handlers == handlers and root.level == level
    assert logging.config.dictConfig is configure
    assert not list(tmp_path.iterdir())


FRESH_PROCESS = """
import importlib.metadata, logging, random, sys
import numpy as np
from ksmea.errors import BudgetSpent
from ksmea.numerics.objective import Objective
root = logging.getLogger()
before = list(root.handlers), root.level, random.getstate()
for entry in importlib.metadata.entry_points(group="ksmea.optimizers"):
    try:
        entry.load()().minimize(Objective(5, lambda u: u - 0.3, budget=250), np.random.default_rng(0))
    except BudgetSpent:
        pass
assert (list(root.handlers), root.level, random.getstate()) == before
"""


def test_a_fresh_process_prints_nothing_and_leaves_no_file(tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", FRESH_PROCESS], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert not list(tmp_path.iterdir())

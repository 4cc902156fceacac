"""Plugins that an exam refuses fail in a sweep too, in one line each.

They have values outside of limits, complex points or reserved names; a library that starts processes works in both.
"""

import subprocess
import sys

import pytest

from outside_package import plain_files

HEAD = """
import multiprocessing
from dataclasses import dataclass, replace

import numpy as np

from ksmea import Method, Optimizer, setting
from ksmea.identification.direct import Direct
from ksmea.settings.settings import part
"""
METHOD = '''
@dataclass(frozen=True)
class Mine(Method):
    """A search whose values are changed afterwards."""

    optimizer: Optimizer = part("what searches")

    def identify(self, problem, measurement, streams):
        found = Direct(self.optimizer).identify(problem, measurement, streams)
        return replace(found, x={change})
'''
OPTIMIZER = '''
@dataclass(frozen=True)
class Mine(Optimizer):
    """Asks for points."""

    {settings}

    def minimize(self, objective, rng):
        objective({points})
        return objective.result()
'''
RANDOM = "rng.random((20, objective.dim))"
POOL = '''
def double(value):
    return 2 * value

@dataclass(frozen=True)
class Mine(Optimizer):
    """Has a pool of processes."""

    def minimize(self, objective, rng):
        with multiprocessing.Pool(2) as pool:
            assert pool.map(double, range(8)) == [*range(0, 16, 2)]
        objective(rng.random((20, objective.dim)))
        return objective.result()
'''
EXAM = """
if __name__ == "__main__":
    from ksmea.testing import check_optimizer
    check_optimizer(Mine(), distance=1.0)
"""


@pytest.fixture
def sweep(enter, tmp_path):
    """A run with the plugin of a file, which is forgotten afterwards."""

    def call(text, *words):
        (tmp_path / "mine.py").write_text(HEAD + text + EXAM)
        return enter("plugins=[mine.py]", *words, "repetitions=1", "workers=1")

    with plain_files(tmp_path):
        yield call


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("2 * problem.parameters.upper", "method: expected values within their search limits, got another of kxx"),
        ("found.x * np.nan", "the identified values are not finite"),
        ("found.x + 0j", "method: expected 5 real values, got (5,) of type complex128"),
        ("found.x[:3]", "method: expected 5 real values, got (3,) of type float64"),
    ],
)
def test_values_outside_of_limits_are_a_failed_run(change, line, sweep):
    change = change.replace("problem.parameters.upper", "problem.parameters.to_si(np.ones(5))")
    ended = sweep(METHOD.format(change=change), "method=mine", "optimizer=random_search", "optimizer.evaluations=100")
    assert ended.code == 1 and "1 of 1 failed" in ended.out and line in ended.out


@pytest.mark.parametrize(
    ("points", "line"),
    [
        (f"{RANDOM} + 0.1j", "objective: expected real points, got complex ones"),
        (f"3 * {RANDOM}", "objective: expected coordinates from 0 to 1, got one that is"),
    ],
)
def test_points_outside_of_the_cube_are_a_failed_run(points, line, sweep):
    ended = sweep(OPTIMIZER.format(settings="", points=points), "method=direct", "optimizer=mine")
    assert ended.code == 1 and "1 of 1 failed" in ended.out and line in ended.out


RESERVED = ("name", "check", "parts", "seeded", "fingerprint")
EXAMINE = """
import runpy, traceback
for name in {names}:
    try:
        runpy.run_path(f"{{name}}.py", run_name="__main__")
    except Exception:
        print(name, traceback.format_exc().splitlines()[-1], sep=": ")
"""


def with_setting(name):
    settings = f"{name}: str = setting('OnePlusOne', 'name in the library')"
    return OPTIMIZER.format(settings=settings, points=RANDOM)


@pytest.fixture(scope="module")
def refusals(tmp_path_factory):
    """Last line of the exam of each plugin with a reserved name; without one if it is passed."""
    folder = tmp_path_factory.mktemp("exams")
    for name in RESERVED:
        (folder / f"{name}.py").write_text(HEAD + with_setting(name) + EXAM)
    code = EXAMINE.format(names=RESERVED)
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    return dict(line.split(": ", 1) for line in done.stdout.splitlines())


@pytest.mark.parametrize("name", RESERVED)
def test_reserved_names_are_refused_in_one_line_by_sweep_and_exam(name, sweep, refusals):
    ended = sweep(with_setting(name), "method=direct", "optimizer=mine")
    line = f"Mine: expected another name of a setting than '{name}', "
    assert ended.code == 2 and line in ended.err and ended.err.count("\n") == 1
    assert line in refusals[name]


def test_a_library_that_starts_processes_works_in_sweep_and_exam(sweep, tmp_path):
    ended = sweep(POOL, "method=direct", "optimizer=mine")
    assert ended.code == 0, ended.out
    exam = subprocess.run([sys.executable, "mine.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "one_process_returns" not in exam.stderr and "daemonic" not in exam.stderr, exam.stderr

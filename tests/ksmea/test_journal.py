"""Replayed evaluations are exactly those of the earlier attempt, and are not computed again."""

import numpy as np
import pytest

from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Streams
from ksmea.plugins.registry import plugin_class
from ksmea.problem.journal import Journal, JournaledProblem
from ksmea.problem.problem import Problem
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging
from tiers import mostly_slow


class PowerCut(BaseException):
    """The process ends here, as far as the run can tell."""


class Counted(Problem):
    """A problem that counts what it computes and may be cut off."""

    has_sensitivity = True

    def __init__(self, problem, cut_after=None):
        self.problem, self.cut_after, self.computed = problem, cut_after, 0
        self.parameters, self.speed, self.channels = problem.parameters, problem.speed, problem.channels

    def response(self, x):
        self._count(len(x))
        return self.problem.response(x)

    def sensitivity(self, x):
        self._count(1)
        return self.problem.sensitivity(x)

    def _count(self, n):
        if self.cut_after is not None and self.computed >= self.cut_after:
            raise PowerCut
        self.computed += n


@pytest.fixture(scope="module")
def problem():
    return ThreeDisk().build()


@pytest.fixture(scope="module")
def measurement(problem):
    x = problem.parameters.to_si(np.array([0.4, 0.6, 0.5, 0.7, 0.3]))
    noise = Noise(0.1, 0.0)
    values = observe(problem.response(x[None])[0], "amplitude", noise, np.random.default_rng(1))
    return Measurement(problem.speed, problem.channels, values, noise, "test")


def identify(method, problem, measurement):
    streams = Streams(*(np.random.default_rng(seed) for seed in (1, 2, 3)))
    return method.identify(problem, measurement, streams)


GENERATIONS = {"generations": 6, "population": 20}
EVALUATIONS = {"evaluations": 140}
CHEAP = {
    "cmaes": EVALUATIONS,
    "de": GENERATIONS,
    "dual_annealing": EVALUATIONS,
    "ga": GENERATIONS,
    "lm": {"screening": 200, "starts": 2},
    "nelder_mead": EVALUATIONS,
    "pso": GENERATIONS,
    "random_search": EVALUATIONS,
}


def cheap(name):
    return plugin_class("optimizer", name)(**CHEAP[name])


@pytest.mark.parametrize("name", mostly_slow(sorted(CHEAP), but=["cmaes", "de", "lm"]))
@pytest.mark.parametrize("method", ["direct", "ksmea"])
def test_a_run_cut_off_twice_ends_like_an_undisturbed_one(method, name, problem, measurement, tmp_path):
    made = {
        "direct": Direct(cheap(name)),
        "ksmea": KSMEA(Kriging(), cheap(name), 30, max_updates=4, final_step=True),
    }[method]
    undisturbed = Counted(problem)
    expected = identify(made, undisturbed, measurement)
    path = tmp_path / "run.journal"
    computed = 0
    for fraction in (0.5, 0.25, None):  # of the evaluations of a whole run, at each attempt
        cut_after = None if fraction is None else int(fraction * undisturbed.computed)
        counted = Counted(problem, cut_after)
        journal = Journal(path)
        try:
            found = identify(made, JournaledProblem(counted, journal), measurement)
        except PowerCut:
            found = None
        finally:
            journal.close()
        computed += counted.computed
    assert np.array_equal(found.x, expected.x)
    assert (found.misfit, found.stop, found.updates) == (expected.misfit, expected.stop, expected.updates)
    assert found.model_evaluations == expected.model_evaluations
    assert computed == undisturbed.computed  # nothing was computed twice


def test_a_torn_or_damaged_entry_and_all_behind_it_is_computed_again(problem, tmp_path):
    path = tmp_path / "run.journal"
    points = [problem.parameters.to_si(np.full((1, 5), value)) for value in (0.2, 0.5, 0.8)]
    journal = Journal(path)
    answers = [JournaledProblem(problem, journal).response(x) for x in points]
    journal.close()
    whole = path.read_bytes()
    entry = len(whole) // 3
    for damaged in (whole[:-5], whole[: 2 * entry + 40] + b"?" + whole[2 * entry + 41 :]):
        path.write_bytes(damaged)
        counted = Counted(problem)
        journal = Journal(path)
        again = [JournaledProblem(counted, journal).response(x) for x in points]
        journal.close()
        assert counted.computed == 1  # the third entry
        assert all(np.array_equal(one, other) for one, other in zip(again, answers))
        assert path.read_bytes() == whole


def test_a_batch_is_kept_one_parameter_set_at_a_time(problem, tmp_path):
    """A run killed within a population or the initial samples loses the set in work alone."""
    x = problem.parameters.to_si(np.random.default_rng(3).random((6, 5)))
    journal = Journal(tmp_path / "run.journal")
    with pytest.raises(PowerCut):
        JournaledProblem(Counted(problem, cut_after=4), journal).response(x)
    journal.close()
    counted = Counted(problem)
    assert np.array_equal(JournaledProblem(counted, Journal(tmp_path / "run.journal")).response(x), problem.response(x))
    assert counted.computed == 2


def test_other_questions_than_before_are_computed(problem, tmp_path):
    path = tmp_path / "run.journal"
    first, second = (problem.parameters.to_si(np.full((1, 5), value)) for value in (0.3, 0.6))
    journal = Journal(path)
    JournaledProblem(problem, journal).response(first)
    journal.close()
    journal = Journal(path)
    assert np.array_equal(JournaledProblem(problem, journal).response(second), problem.response(second))
    journal.close()
    journal = Journal(path)  # the old answer is gone, the new one kept
    counted = Counted(problem)
    JournaledProblem(counted, journal).response(second)
    assert counted.computed == 0


def test_a_response_is_never_taken_for_a_sensitivity(problem, tmp_path):
    x = problem.parameters.to_si(np.full((1, 5), 0.4))
    journal = Journal(tmp_path / "run.journal")
    JournaledProblem(problem, journal).response(x)
    journal.close()
    replaying = JournaledProblem(problem, Journal(tmp_path / "run.journal"))
    assert np.array_equal(replaying.sensitivity(x[0]), problem.sensitivity(x[0]))


def test_a_problem_without_sensitivity_has_none_behind_a_journal_either(problem, tmp_path):
    class ResponseOnly(Problem):
        parameters, speed, channels = problem.parameters, problem.speed, problem.channels

        def response(self, x):
            return problem.response(x)

    assert JournaledProblem(problem, Journal(tmp_path / "with.journal")).has_sensitivity
    assert not JournaledProblem(ResponseOnly(), Journal(tmp_path / "run.journal")).has_sensitivity

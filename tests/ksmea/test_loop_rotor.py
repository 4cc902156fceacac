"""KSMEA on the three-disk rotor with Kriging and DE, and what is refused before anything is run."""

import dataclasses
import pickle

import numpy as np
import pytest

from counted_runs import Counted, measured, streams
from ksmea.errors import SettingError
from ksmea.identification.ksmea import KSMEA
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.noise import Noise
from optimizers.de import DE
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging
from surrogates.none import NoSurrogate

REFERENCE = {"kxx": 50e6, "kyy": 70e6, "cxx": 500.0, "cyy": 700.0, "u": 2e-4}


NEAR_LIMITS = {"kxx": [30.0, 80.0], "kyy": [50.0, 100.0]}


SHORT_DE = DE(generations=30)


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk(limits=NEAR_LIMITS).build()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_without_noise_all_five_parameters_are_identified(rotor, seed):
    """SMC off, because without noise it can fire at a wrong optimum. The surrogate within 5e-8 m of the true model,
    summed over 106 responses of 1 to 100 µm, was found to leave 1e-4 of the parameters."""
    problem = Counted(rotor)
    measurement = measured(rotor, list(REFERENCE.values()))
    method = KSMEA(Kriging(), SHORT_DE, 80, smc=1.0, sdf=5e-8, max_updates=30)
    found = method.identify(problem, measurement, streams(seed))
    assert found.stop == "sdf" and found.history[-1].sdf < 5e-8 <= min(update.sdf for update in found.history[:-1])
    assert np.all(np.abs(found.x / list(REFERENCE.values()) - 1) < 1e-3)
    assert not any(found.at_limit)
    assert problem.agrees_with(found) and found.model_evaluations == 80 + found.updates
    assert found.updates == len(found.history)
    assert found.misfit == min(update.misfit for update in found.history) < found.history[0].misfit
    parts = found.seconds
    assert 0 < parts["model"] + parts["surrogate"] + parts["search"] <= parts["total"]


@pytest.fixture(scope="module")
def noisy(rotor):
    """10 % noise on amplitudes: the run, and the same run with a final step on the true model."""
    measurement = measured(rotor, list(REFERENCE.values()), "amplitude", Noise(0.1, 0.0), seed=3)
    runs = {}
    for final_step in (False, True):
        problem = Counted(rotor)
        method = KSMEA(Kriging(), SHORT_DE, 60, max_updates=5, final_step=final_step)
        runs[final_step] = problem, method.identify(problem, measurement, streams())
    return measurement, runs


def test_the_final_step_improves_the_likelihood(rotor, noisy):
    measurement, runs = noisy
    likelihood = Misfit(measurement, "likelihood")
    without, with_step = (
        likelihood.value(likelihood.observed(rotor.response(runs[final][1].x[None])))[0] for final in (False, True)
    )
    assert with_step < without
    assert runs[True][1].misfit == pytest.approx(with_step, rel=1e-9)  # what it says it reached


def test_the_final_step_is_counted_and_changes_nothing_before_it(noisy):
    _, runs = noisy
    (plain_problem, plain), (step_problem, step) = runs[False], runs[True]
    assert plain_problem.agrees_with(plain) and step_problem.agrees_with(step)
    assert plain.model_evaluations == 60 + plain.updates and plain.model_jacobians == 0
    assert step.model_evaluations > plain.model_evaluations and step.model_jacobians > 0
    assert same(plain.history, step.history) and plain.stop == step.stop


def test_the_same_streams_give_the_same_result(rotor, noisy):
    measurement, runs = noisy
    expected = runs[False][1]
    again = KSMEA(Kriging(), SHORT_DE, 60, max_updates=5).identify(rotor, measurement, streams())
    assert np.array_equal(again.x, expected.x) and again.surrogate_evaluations == expected.surrogate_evaluations
    assert same(again.history, expected.history)
    other = KSMEA(Kriging(), SHORT_DE, 60, max_updates=5).identify(rotor, measurement, streams(1))
    assert not same(other.history, expected.history)


def same(first, second):
    """Whether two histories agree to the last digit, whatever they hold."""
    return pickle.dumps([*map(dataclasses.asdict, first)]) == pickle.dumps([*map(dataclasses.asdict, second)])


def test_without_a_surrogate_the_true_model_is_searched_and_counted(rotor):
    problem = Counted(rotor)
    measurement = measured(rotor, list(REFERENCE.values()), "amplitude", Noise(0.1, 0.0))
    found = KSMEA(NoSurrogate(), SHORT_DE, 10).identify(problem, measurement, streams())
    assert found.stop == "smc" and found.updates <= 2  # prediction and model are the same
    assert problem.agrees_with(found)
    # the samples, the search, and the optimum once as prediction and once as true model
    assert found.model_evaluations == 10 + found.surrogate_evaluations + 2 * found.updates
    assert found.surrogate_evaluations >= 100 * 31  # DE's populations


@pytest.mark.parametrize(
    "settings, samples, text",
    [
        ({}, 6, "samples: expected at least 7 for this surrogate with 5 unknowns, got 6"),
        ({"budget": 30}, 31, "method.budget: expected more than the 31 initial samples, got 30"),
        ({"budget": 30}, 30, "method.budget: expected more than the 30 initial samples, got 30"),
        ({"nearest": 6}, 40, "method.nearest: expected at least 7 for this surrogate with 5 unknowns, got 6"),
    ],
)
def test_parts_that_cannot_work_together_are_refused(rotor, settings, samples, text):
    with pytest.raises(SettingError) as caught:
        KSMEA(Kriging(), DE(), samples, **settings).validate(rotor)
    assert str(caught.value).startswith(text) and "\n" not in str(caught.value)


def test_parts_that_just_work_together_are_taken(rotor):
    KSMEA(Kriging(), DE(), 7, budget=8, nearest=7).validate(rotor)


def test_an_optimizer_that_does_not_suit_the_unknowns_is_refused(rotor):
    class ForTwo(DE):
        def check_dimension(self, dim):
            raise SettingError(f"got {dim} unknowns")

    with pytest.raises(SettingError, match="got 5 unknowns"):
        KSMEA(Kriging(), ForTwo(), 40).validate(rotor)

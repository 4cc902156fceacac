"""Two causes at once: named together, also where the larger one hides the smaller, and where both are one effect at two places."""

import dataclasses

import numpy as np
import pytest

from ksmea.diagnosis import second_effects as module
from ksmea.diagnosis.diagnosis import diagnose
from ksmea.diagnosis.second_effects import _from_pair, distinct_firsts
from ksmea.diagnosis.trials import (
    Candidate,
    Explanation,
    Trial,
    best_of_names,
    candidates,
    fitted,
    ranked_explanations,
    trial_of,
)
from ksmea.fits.fitting import Fit, fit_baseline, fit_from_values, fit_nearby
from ksmea.fits.search import Effort, Search
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk
from tests.diagnosis.conftest import LESS, SENSORS, TRUTH, registered_effects

NOISE = Noise(0.05, 5e-8)
SEARCH = Search(np.random.default_rng(0))


N_SPEED = 27  # half of the default: effects that change the rotor are reduced at each


@pytest.fixture(scope="module")
def rotor():
    """The baseline model that data are fitted with."""
    return ThreeDisk(sensors=SENSORS, n_speed=N_SPEED).build().with_phase_origin()


@pytest.fixture(scope="module")
def fine():
    """Another mesh and route than the model that is fitted."""
    return ThreeDisk(mesh=26, sensors=SENSORS, n_speed=N_SPEED).build().with_phase_origin()


def few(*names):
    return {name: effect for name, effect in registered_effects().items() if name in names}


def located(fine, name, place=0):
    return registered_effects()[name].locations(fine)[place]


def measured(fine, effects, values, seed):
    problem = fine
    for effect in effects:
        problem = effect.added_to(problem)
    x = np.array([*(TRUTH[name] for name in fine.parameters.names), *values])
    data = observe(problem.dense_response(x[None])[0], "complex", NOISE, np.random.default_rng(seed))
    return Measurement(fine.speed, fine.channels, data, None, "test")


@pytest.mark.slow
def test_a_runout_behind_a_large_slope_of_the_stiffness_is_named_too(rotor, fine):
    """Alone it is not even among the effects that are significant: what the slope leaves is a hundred times as large."""
    effects = [located(fine, "speed_dependent_stiffness"), located(fine, "runout", 1)]
    measurement = measured(fine, effects, [0.15, 5e-8, -4e-8], seed=3)
    found = diagnose(
        Case(rotor, measurement),
        few("speed_dependent_stiffness", "runout", "channel_gain"),
        Search(np.random.default_rng(0), LESS),
    )
    alone = next(trial for trial in found.trials if trial.candidate == Candidate("runout", effects[1]))
    assert alone.p > found.level / 2
    assert found.verdict == "named" and [each.effect for each in found.applied] == effects
    for value, interval in zip([0.15, 5e-8, -4e-8], found.best_estimate.intervals[-3:]):
        # 95 %, widened to twice its half-width: 99.99 %
        assert abs(value - (interval.low + interval.high) / 2) < interval.high - interval.low


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "places", "values"),
    [
        ("runout", (0, 2), [1e-6, 0.0, 0.0, -1e-6]),
        ("channel_gain", (0, 5), [0.12, -0.1]),
        ("unbalance", (0, 1), [3e-5, 0.0, 0.0, 3e-5]),
    ],
)
def test_one_effect_at_two_places_is_named_twice(rotor, fine, name, places, values):
    effects = [located(fine, name, place) for place in places]
    measurement = measured(fine, effects, values, seed=1)
    found = diagnose(
        Case(rotor, measurement), few("runout", "channel_gain", "unbalance"), Search(np.random.default_rng(0), LESS)
    )
    assert found.verdict == "named" and found.named == (name, name)
    assert {str(each.effect) for each in found.applied} == {str(effect) for effect in effects}
    first, second = np.split(np.array(found.best.problem.parameters.names[-len(values) :]), 2)
    place = "_".join(str(found.applied[1].effect).replace(".", "_").split())
    assert list(first) == [item.name for item in effects[0].parameters(fine)]
    assert list(second) == [f"{item}_{place}" for item in first]


@pytest.mark.slow
def test_pairs_that_explain_the_data_alike_are_all_reported(rotor, fine):
    """Mass and Young's modulus do the same; so do they beside a gain."""
    effects = [located(fine, "mass"), located(fine, "channel_gain", 3)]
    measurement = measured(fine, effects, [0.01, 0.15], seed=2)
    library = few("mass", "youngs_modulus", "channel_gain")
    found = diagnose(
        Case(rotor, measurement), library, Search(np.random.default_rng(0), dataclasses.replace(LESS, split=True))
    )
    names = {each.names for each in found.explanations}
    assert found.verdict == "ambiguous" and names == {("channel_gain", "mass"), ("channel_gain", "youngs_modulus")}
    assert set(found.ambiguity_group) == {"mass", "youngs_modulus", "channel_gain"}
    assert found.split is None or all(" and " in pair.one for pair in found.split.pairs)
    assert {each.effect for each in found.applied if each.name == "channel_gain"} == {effects[1]}


def test_first_effects_that_predict_the_same_count_once(rotor, fine):
    measurement = measured(fine, [located(fine, "mass")], [0.004], seed=4)
    baseline = fit_baseline(Case(rotor, measurement), Search(np.random.default_rng(0), Effort()))
    found = candidates(rotor, few("mass", "youngs_modulus", "runout"))
    trials = fitted(baseline.best, found, SEARCH)
    names = [trial.name for trial in distinct_firsts(trials, 3)]
    assert len(names) == 2 and "runout" in names


def test_a_limit_leaves_out_what_stays_above_it_and_nothing_else(rotor, fine):
    """A gain beside a mass: with a limit that it comes below, and most others do not."""
    effects = [located(fine, "mass"), located(fine, "channel_gain", 3)]
    measurement = measured(fine, effects, [0.01, 0.15], seed=6)
    baseline = fit_baseline(Case(rotor, measurement), Search(np.random.default_rng(0), Effort())).best
    first = fitted(baseline, candidates(rotor, few("mass")), SEARCH)[0].fit
    found = candidates(first.problem, few("channel_gain", "runout", "timing_delay"))
    limit = first.deviance - np.log(first.likelihood.n_residual)
    every, below = (
        {(trial.name, trial.location): trial.fit.deviance for trial in trials}
        for trials in (
            fitted(first, found, SEARCH),
            fitted(first, found, SEARCH, limit=limit),
        )
    )
    assert below and len(below) < len(every)
    assert set(below) == {effect for effect, deviance in every.items() if deviance < limit}
    for effect, deviance in below.items():
        assert deviance == pytest.approx(every[effect], abs=0.01)  # fits end by what they promise


N_DATA = 100


def explanation(drop, *names, n_unknown=1):
    effect = registered_effects()
    applied = tuple(Candidate(name, effect[name]) for name in names)
    return Explanation(applied, None, drop, drop - n_unknown * np.log(N_DATA), n_unknown, 0.0)


def test_what_is_near_is_so_by_bic_or_by_the_deviance_whatever_bic_charges():
    best = explanation(100.0, "mass")
    assert explanation(95.0, "runout").is_near(best) and not explanation(93.0, "runout").is_near(best)
    assert explanation(99.0, "flexible_pedestal", n_unknown=3).is_near(best)
    assert explanation(99.0, "flexible_pedestal", n_unknown=3).delta_bic < best.delta_bic - 6


def test_the_order_of_a_pair_makes_no_other_explanation():
    one, other = explanation(50.0, "mass", "runout"), explanation(52.0, "runout", "mass")
    third = explanation(40.0, "mass", "channel_gain")
    assert ranked_explanations([one, third, other]) == [other, third]
    assert best_of_names([other, one, third]) == [other, third]


def test_p_of_a_second_effect_is_corrected_for_all_that_were_tried(rotor, fine):
    measurement = measured(fine, [], [], seed=5)
    baseline = fit_baseline(Case(rotor, measurement), Search(np.random.default_rng(0), Effort())).best
    [candidate] = candidates(rotor, few("mass"))
    fit: Fit = fit_nearby(candidate.effect.added_to(rotor), baseline)
    one, many = (trial_of(candidate, fit, baseline, n).p for n in (1, 66))
    assert many == min(1.0, 66 * one)


def test_an_effect_left_in_a_lower_maximum_is_lifted_by_the_pair_that_it_is_part_of(rotor, fine):
    """Its second effect is then no evidence: what it brought is the first one's own."""
    runout = located(fine, "runout").added_to(fine)
    x = np.array([{**TRUTH, "runout_x": 1e-5}.get(name, 0.0) for name in runout.parameters.names])
    values = observe(runout.dense_response(x[None])[0], "complex", NOISE, np.random.default_rng(5))
    measurement = Measurement(rotor.speed, rotor.channels, values, NOISE, "made")
    first = Candidate("runout", located(rotor, "runout"))
    other = registry.create("effect", "runout", {"position": 0.5})  # its unknowns come first, and take the plain names
    second = Candidate("runout", other)
    alone, both = (first.beside(rotor), first.beside(second.beside(rotor)))
    baseline = fit_from_values(
        Case(rotor, measurement), np.array([TRUTH.get(name, 0.0) for name in rotor.parameters.names])
    )
    at = np.array([TRUTH.get(name, 0.0) for name in rotor.parameters.names])
    pair = fit_from_values(Case(both, measurement), np.append(at, [0.0, 0.0, 1e-5, 0.0]))
    right = fit_from_values(Case(alone, measurement), np.append(at, [1e-5, 0.0]))
    best = Explanation((second, first), pair, 0.0, 0.0, 4, 0.0)
    low = Fit(right.likelihood, right.likelihood.at(np.full(len(right.point.theta), 0.3)))
    lifted = _from_pair(trial_of(first, low, baseline, 2), best, baseline, 2)
    assert lifted is not None and lifted.fit.deviance == pytest.approx(right.deviance, abs=0.1)
    assert _from_pair(lifted, best, baseline, 2) is None


@pytest.mark.parametrize(("name", "most"), [("clearance_rub", module.COSTLY), ("runout", None)])
def test_beside_what_is_not_linear_in_the_motion_only_few_are_fitted_and_none_is_scanned(
    rotor, fine, name, most, monkeypatch
):
    """A response with a rub takes a tenth of a second, a fit ten to a hundred of them, a scan thousands."""
    measurement = measured(fine, [], [], seed=1)
    located_first = located(fine, name) if name == "runout" else registry.create("effect", name, {}).locations(fine)[0]
    first = Candidate(name, located_first)
    problem = first.effect.added_to(rotor)
    likelihood = likelihood_of(Case(problem, measurement))
    fit = Fit(
        likelihood, Point(likelihood.start(np.full(len(problem.parameters), 0.5)), 0.0, np.empty(0), np.empty((0, 0)))
    )
    trial = Trial(first, fit, 100.0, 90.0, 1e-9)
    second = next(each for each in candidates(rotor, registered_effects()) if each.effect.is_scanned)
    asked, scanned = [], []
    monkeypatch.setattr(
        module, "fitted", lambda *_, most, **__: asked.append(most) or [Trial(second, fit, 1.0, 0.0, 1.0)]
    )
    monkeypatch.setattr(module, "_scans", lambda *words: scanned.append(words[1]) or [])
    monkeypatch.setattr(module, "shared", lambda *words: [])
    module.pairs_beside([trial], [trial], None, Search(np.random.default_rng(0), LESS), is_scanned=True)
    assert asked[0] == most
    assert len(scanned) == (1 if most is None else 0)

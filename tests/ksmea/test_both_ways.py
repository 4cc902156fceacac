"""Joint fit against the fit of differences: they agree where the model is right, and not where something alike is missing."""

import dataclasses
import json

import numpy as np
import pytest

import ksmea
from campaigns import NOISE, TRIAL, TRUTH, layout_of, measured
from ksmea.errors import SettingError
from ksmea.measurement.noise import Noise
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.records.campaign import BothWaysRecord, MovedRecord
from ksmea.records.identification import IdentificationRecord
from ksmea.show.text import hausman_lines
from ksmea.studies.hausman import both_ways
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.5]).build()
SPEED = np.linspace(200, 1500, 15)
LAYOUT = layout_of(PROBLEM, [SPEED, SPEED], [("bare", ()), ("trial", (TRIAL,))])
SEEN = aligned(PROBLEM, LAYOUT)
X = np.array([TRUTH[name] for name in SEEN.parameters.names])
RUNOUT = np.array([1e-6, 1e-6j, 5e-7, -5e-7j])  # of the readings of all runs


def _data(seed, runout=0.0, known=True):
    made = measured(PROBLEM, LAYOUT, seed=seed)
    return dataclasses.replace(made, values=made.values + runout, noise=NOISE if known else None)


def test_they_agree_where_the_model_is_right():
    """p < 0.1 in 10 % of draws: of 60, 6 ± 2.3; and p is spread evenly, 0.5 ± 0.037 in the mean."""
    p = np.array([both_ways(Case(SEEN, _data(seed)), X).p for seed in range(60)])
    assert 1 <= np.sum(p < 0.1) <= 14
    assert abs(np.mean(p) - 0.5) < 4 * 0.037


@pytest.mark.parametrize("known", [True, False])
def test_a_runout_moves_the_joint_fit_alone(known):
    found = both_ways(Case(SEEN, _data(1, RUNOUT, known)), X)
    assert found.p < 1e-6 and found.moved and all(abs(each.standard_errors) > 3 for each in found.moved)
    for each in found.moved:  # by differences they are what they are
        index = SEEN.parameters.names.index(each.name)
        assert each.value == pytest.approx(X[index] / SEEN.parameters.si_per_unit[index], rel=0.2)
    assert "u" not in [each.name for each in found.moved]  # it cancels
    [said] = hausman_lines(found)
    assert "do not agree" in said and "runout" in said and "+experiment=diagnose" in said


def test_a_value_at_a_search_limit_is_no_movement():
    """kxx is 50 and may be 45 at most: the fit of differences ends there, and whatever a runout does to the joint one is no estimate."""
    narrow = aligned(ThreeDisk(sensors=[0.1, 0.5], limits={"kxx": [30, 45]}).build(), LAYOUT)
    found = both_ways(Case(narrow, _data(1, RUNOUT)), np.minimum(X, narrow.parameters.upper))
    assert found.p < 1e-6 and found.moved and "kxx" not in [each.name for each in found.moved]


def test_runs_without_a_known_weight_show_the_sweep_and_nothing_else():
    """Two runs at speeds up to 0.1 % apart, whose readings differ as by a sweep: no advice to leave out what is alike in all runs."""
    runs = layout_of(PROBLEM, [SPEED, SPEED * 1.0009], [("up", ()), ("down", ())])
    data = dataclasses.replace(measured(PROBLEM, runs), noise=NOISE)
    data = dataclasses.replace(data, values=data.values * np.repeat([1.0, 0.7], len(SPEED))[:, None])
    found = both_ways(Case(aligned(PROBLEM, runs), data), X)
    lines = list(hausman_lines(found))
    assert found is None or (not found.shows_machine and "differences between runs do not agree" not in "".join(lines))
    [said] = hausman_lines(BothWaysRecord(1e-9, 2, (MovedRecord("cxx", "kN s/m", 1.0, 5.0),), shows_machine=False))
    assert "none carried a known weight" in said and "cxx" not in said and "reference" not in said
    assert list(hausman_lines(BothWaysRecord(0.3, 2, shows_machine=False))) == []


def test_differences_that_tell_nothing_are_not_compared():
    repeat = layout_of(PROBLEM, [SPEED, SPEED], [("one", ()), ("two", ())])
    elsewhere = layout_of(PROBLEM, [SPEED, SPEED + 20], [("bare", ()), ("trial", (TRIAL,))])
    amplitudes = dataclasses.replace(LAYOUT, kind="amplitude")
    for layout, noise in ((repeat, NOISE), (elsewhere, NOISE), (amplitudes, NOISE), (LAYOUT, Noise(0.0, 0.0))):
        data = dataclasses.replace(measured(PROBLEM, layout), noise=noise)
        seen = aligned(PROBLEM, data)
        assert both_ways(Case(seen, data), np.array([TRUTH[name] for name in seen.parameters.names])) is None


@pytest.fixture(scope="module")
def by_differences():
    """Identifications by differences from either run, with a runout that would spoil a joint fit; intervals for one of them."""
    found = {}
    for reference in ("bare", "trial"):
        data = _data(2, RUNOUT, known=False)
        data = dataclasses.replace(data, campaign=dataclasses.replace(data.campaign, reference=reference))
        intervals = "profile" if reference == "bare" else "none"
        found[reference] = ksmea.identify(PROBLEM, data, level=0.999, intervals=intervals)
    return found


@pytest.mark.slow
def test_identify_by_differences_says_what_it_cannot_know(by_differences):
    """Whatever run is the reference."""
    found = by_differences
    one, other = (each.record for each in found.values())
    text = str(found["bare"])
    assert "u: not known from differences" in text and "by differences from run bare" in text
    assert "search ended short" not in text and one.both_ways is None and one.weights.corrections == ()
    assert found["bare"]["kxx"].low < 50 < found["bare"]["kxx"].high  # 0.1 % of draws would not
    assert IdentificationRecord.from_data(json.loads(found["bare"].to_json())) == one
    known = [pair for pair in zip(one.parameters, other.parameters) if None not in (pair[0].low, pair[0].high)]
    assert len(known) >= 3
    # two searches end at the same maximum within what a search leaves, 0.1 % of an interval
    for mine, theirs in known:
        assert mine.value == pytest.approx(theirs.value, abs=1e-3 * (mine.high - mine.low))


@pytest.mark.parametrize("study", [ksmea.diagnose, ksmea.locate])
def test_a_cause_is_not_looked_for_in_differences(study):
    data = _data(1)
    data = dataclasses.replace(data, campaign=dataclasses.replace(data.campaign, reference="bare"))
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5])
    with pytest.raises(SettingError, match="reference: expected all that the runs show"):
        study(rotor, data)


def test_the_step_to_the_likelihood_of_differences_hides_no_search(by_differences):
    record = by_differences["trial"].record  # without intervals, which are no search
    *_, before, last = record.trace.stages
    assert last.name == record.stage == "likelihood of differences" and before.name == "final step"
    assert last.x == pytest.approx(record.x) and last.x != before.x
    assert (last.evaluations, last.jacobians) == (record.model_evaluations, record.model_jacobians)

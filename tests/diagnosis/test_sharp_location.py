"""A sharp location ends the search of pairs of effects elsewhere."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from ksmea.diagnosis import diagnosis as module
from ksmea.fits.search import Search
from ksmea.location.location import Location
from ksmea.location.unknown_force import Unmodelled
from ksmea.problem.case import Case
from ksmea.records.location import is_at_most_sites
from tests.diagnosis.conftest import LESS, registered_effects

PLACES = [0.1 * index for index in range(10)]


def location(force=(), moment=(), reading=()):
    """A location with sites accepted at these indices of ten places and three planes."""
    tried = [("force", force, PLACES), ("moment", moment, PLACES), ("reading", reading, PLACES[:3])]
    kinds = [(kind, at, index in accepted) for kind, accepted, places in tried for index, at in enumerate(places)]
    sites = tuple(
        SimpleNamespace(unmodelled=Unmodelled(kind, at), point=SimpleNamespace(excess=1.0)) for kind, at, _ in kinds
    )
    qualities = tuple(SimpleNamespace(p=0.5 if accepted else 0.0) for _, _, accepted in kinds)
    return Location(sites, qualities, None, None, None, 0.01)


@pytest.mark.parametrize(
    ("accepted", "is_sharp"),
    [
        ({}, False),
        ({"force": (4, 5)}, True),
        ({"force": (4,), "moment": (4, 5), "reading": (1,)}, True),
        ({"reading": (1,)}, True),
        ({"reading": (0, 1)}, False),  # of any plane
        ({"force": (1, 2), "moment": (6, 7)}, False),  # four of ten places
    ],
)
def test_a_location_is_sharp_at_few_places(accepted, is_sharp):
    assert location(**accepted).is_sharp is is_sharp


@pytest.mark.parametrize(
    ("n_accepted", "n_tried", "is_anywhere"), [(2, 3, False), (3, 3, True), (3, 6, False), (4, 6, True), (1, 1, False)]
)
def test_a_cause_is_anywhere_at_most_sites_and_three_or_more(n_accepted, n_tried, is_anywhere):
    """Two of three stated places, or the only one, are places; the search and its record judge alike."""
    tried = location(force=range(n_accepted))
    some = dataclasses.replace(tried, sites=tried.sites[:n_tried], qualities=tried.qualities[:n_tried])
    assert some.is_anywhere is is_anywhere
    assert is_at_most_sites(n_accepted, n_tried) is is_anywhere


def test_only_effects_at_the_place_are_left(rotor):
    trials = [
        SimpleNamespace(candidate=SimpleNamespace(effect=effect))
        for name in ("mass", "unbalance", "channel_gain", "added_mass")
        for effect in registered_effects()[name].locations(rotor)
    ]
    baseline = SimpleNamespace(problem=rotor)
    there = module.acting_where(location(force=(5,)), trials, baseline)
    assert {trial.candidate.effect.position for trial in there} == {0.5}
    spread = location(force=range(8))
    assert module.acting_where(spread, trials, baseline) is trials


@pytest.mark.slow
def test_what_is_located_is_no_pair_of_effects_elsewhere(rotor, hide, monkeypatch):
    """A further unbalance and a library without it: pairs are sought of effects at its place alone, and the location is found once."""
    measurement, effect, _ = hide("unbalance", 3)
    asked = []

    def beside(firsts, trials, *words, **more):
        asked.extend(trial.candidate.effect.position for trial in trials)
        return []

    monkeypatch.setattr(module, "pairs_beside", beside)
    calls = []
    real = location(force=(PLACES.index(0.2),)) if effect.position == 0.2 else None
    effects = {name: registered_effects()[name] for name in ("mass", "channel_gain", "added_mass", "runout")}
    found = module.diagnose(
        Case(rotor, measurement),
        effects,
        Search(np.random.default_rng(0), LESS),
        locate=lambda case: calls.append(case) or real,
    )
    assert found.verdict == "unknown" and len(calls) == 1
    assert set(asked) == {0.2}

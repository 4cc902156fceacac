"""Effects that are hidden in data of a finer mesh are named, or stand in the ambiguity group, beside those that look like them.

Other effects than in test_diagnosis.py, one draw each, against their aliases and two common causes to keep the time short."""

import numpy as np
import pytest

from ksmea.diagnosis.diagnosis import diagnose
from ksmea.diagnosis.trials import Candidate
from ksmea.fits.search import Search
from ksmea.plugins import registry
from ksmea.problem.case import Case
from tests.diagnosis.conftest import LESS
from tiers import mostly_slow

COMMON = ("runout", "unbalance")


def library(name):
    found = registry.create("effect", name, {})
    names = dict.fromkeys((name, *found.aliases, *COMMON))
    return {each: registry.create("effect", each, {}) for each in names if each != "run_up_acceleration"}


@pytest.mark.parametrize(
    ("name", "seed"),
    mostly_slow(
        [
            ("annular_seal", 2),
            ("coupling_misalignment", 1),
            ("foundation_resonance", 2),
            ("short_journal_bearing", 2),
            ("skewed_disk", 2),
            ("thermal_bow", 1),
            ("timing_delay", 1),
        ],
        but=["short_journal_bearing", "skewed_disk", "thermal_bow"],
    ),
)
def test_a_hidden_effect_is_found(rotor, hide, name, seed):
    measurement, located, _ = hide(name, seed)
    found = diagnose(Case(rotor, measurement), library(name), Search(np.random.default_rng(0), LESS))
    trial = next(trial for trial in found.trials if trial.candidate == Candidate(name, located))
    assert trial.deviance_drop >= 60, "the draw is too small to be asked for"
    assert found.verdict in ("named", "ambiguous") and name in found.ambiguity_group
    assert found.best_quality.p > found.level / 2

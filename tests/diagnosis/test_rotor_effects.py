"""Effects that change the shaft, hidden in data of a finer mesh: each is found beside what looks like it."""

import dataclasses

import numpy as np
import pytest

from ksmea.diagnosis.diagnosis import diagnose
from ksmea.fits.search import Search
from ksmea.plugins import registry
from ksmea.problem.case import Case
from tests.diagnosis.conftest import LESS
from tiers import mostly_slow

LEAST = 30  # of the deviance drop, of effects of one unknown: less may look like another effect


# Of large effects every second speed is enough: the shaft is reduced at each for each value of an effect.
@pytest.mark.parametrize(
    ("name", "seed", "step"),
    mostly_slow(
        [
            ("added_mass", 1, 2),
            ("axial_force", 1, 1),
            ("external_damping", 1, 2),
            ("hub_stiffening", 1, 2),
            ("shear_theory", 3, 1),
        ],
        but=["shear_theory"],
    ),
)
def test_it_is_named_or_among_those_that_explain_the_data_as_well(rotor, hide, name, seed, step):
    measurement, located, [size] = hide(name, seed)
    measurement = dataclasses.replace(measurement, speed=measurement.speed[::step], values=measurement.values[::step])
    rotor = rotor.at(measurement.speed, measurement.channels)
    effects = {
        each: registry.create("effect", each, {}) for each in (name, *registry.create("effect", name, {}).aliases)
    }
    found = diagnose(Case(rotor, measurement), effects, Search(np.random.default_rng(0), LESS))
    trial = next(trial for trial in found.trials if trial.name == name and trial.candidate.effect == located)
    assert trial.deviance_drop >= LEAST, "the draw is too small to be asked for"
    assert found.verdict in ("named", "ambiguous") and name in found.ambiguity_group
    assert found.best_quality.p > found.level / 2
    if found.named == (name,):
        assert found.applied[0].effect == located
        interval = found.best_estimate.intervals[-1]
        middle, half = (interval.low + interval.high) / 2, interval.high - interval.low
        assert abs(size - middle) < half  # 95 %, widened to twice the half-width: 99.99 %

"""With 2X in the data a crack, a misaligned coupling and a bow are told apart, which 1X alone hardly does."""

import numpy as np
import pytest

from ksmea.diagnosis.observability import collinearity
from ksmea.diagnosis.trials import Candidate, best_by_name, fitted
from ksmea.fits.fitting import fit_from_values
from ksmea.fits.search import Search
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk

TRUTH = np.array([50e6, 70e6, 5e3, 7e3, 2e-4])
CHANNELS = tuple(
    Channel(position, axis, harmonic) for harmonic in (1.0, 2.0) for position in (0.1, 0.5) for axis in "xy"
)
SEARCH = Search(np.random.default_rng(0))
NAMES = ("crack", "coupling_misalignment", "residual_bow")
PROBLEM = ThreeDisk().build().at(np.linspace(60.0, 500.0, 24), CHANNELS)


def place(name):
    return Candidate(name, registry.create("effect", name, {}).locations(PROBLEM)[0])


def measured(name, theta):
    response = place(name).effect.added_to(PROBLEM).response(np.append(TRUTH, theta)[None])[0]
    values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(5))
    return Measurement(PROBLEM.speed, CHANNELS, values, None, "test")


def candidates():
    """A crack at each disk, a force and a moment at each end, and a bow."""
    return [
        Candidate(name, place) for name in NAMES for place in registry.create("effect", name, {}).locations(PROBLEM)
    ]


@pytest.mark.parametrize(
    ("name", "theta"),
    [
        ("crack", [0.05, -0.03]),
        ("coupling_misalignment", [40.0, 20.0, -25.0, 30.0]),
        ("residual_bow", [3e-6, -2e-6]),
    ],
)
def test_what_makes_2x_is_told_from_what_does_not(name, theta):
    """One draw of the noise each, 5 % and 0.1 µm. ΔBIC above 6 is strong evidence."""
    measurement = measured(name, theta)
    baseline = fit_from_values(Case(PROBLEM, measurement), TRUTH)
    trials = fitted(baseline, candidates(), SEARCH)
    best, *others = best_by_name(trials).values()
    assert best.name == name
    assert best.delta_bic > 6 and all(best.delta_bic > other.delta_bic + 6 for other in others)


def test_what_cannot_act_together_is_no_second_effect():
    """A rub beside a crack is refused, and must not end a diagnosis that tries all pairs."""
    crack, rub, runout = map(place, ("crack", "clearance_rub", "runout"))
    measurement = measured("crack", [0.05, -0.03])
    baseline = fit_from_values(Case(PROBLEM, measurement), TRUTH)
    (first,) = fitted(baseline, [crack], SEARCH)
    seconds = fitted(first.fit, [rub, runout], SEARCH)
    assert [each.name for each in seconds] == ["runout"]
    assert collinearity(first, rub) == 0 < collinearity(first, runout)

"""An effect at two places: both act, and the second one has its place in the names of its unknowns."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.plugins import registry
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=14)
PLAIN = SETTINGS.build()
X = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])


def effect(name, **settings):
    return registry.create("effect", name, settings)


def unknowns(problem):
    return problem.parameters.names[len(X) :]


@pytest.mark.parametrize("name", ["runout", "unbalance", "channel_gain", "probe_rotation"])
def test_an_effect_at_two_places_is_the_sum_of_both(name):
    """Changes by each alone add up as long as they are small.

    They are 1e-5 of the drawn ones; products are of its square.
    """
    plain = PLAIN.response(X[None])
    both, x, alone = PLAIN, X, []
    for place, seed in zip(effect(name).locations(PLAIN)[:2], (1, 2)):
        size = 1e-5 * place.draw(PLAIN, np.random.default_rng(seed))
        alone.append(place.added_to(PLAIN).response(np.append(X, size)[None]) - plain)
        both, x = place.added_to(both), np.append(x, size)
    change = both.response(x[None]) - plain
    assert np.abs(change - sum(alone)).max() < 1e-3 * np.abs(change).max()
    assert np.abs(both.response(x[None]) - both.dense_response(x[None])).max() < 1e-8 * np.abs(plain).max()


def test_the_second_place_is_in_the_names_of_its_unknowns_and_the_first_ones_stay():
    problem = PLAIN
    for position in (0.1, 0.2, 0.5):
        problem = effect("runout", position=position).added_to(problem)
    gain = effect("channel_gain", position=0.1, direction="x").added_to(problem)
    gain = effect("channel_gain", position=0.5, direction="y").added_to(gain)
    assert unknowns(gain) == (
        "runout_x", "runout_y", "runout_x_at_0_2_m", "runout_y_at_0_2_m", "runout_x_at_0_5_m", "runout_y_at_0_5_m",
        "channel_gain", "channel_gain_y_at_0_5_m",
    )  # fmt: skip
    assert unknowns(problem) == unknowns(gain)[:-2]


@pytest.mark.parametrize(("name", "settings"), [("runout", {"position": 0.1}), ("mass", {})])
def test_the_same_effect_at_the_same_place_twice_is_refused(name, settings):
    with pytest.raises(SettingError, match=r"each unknown once, got (runout_x|mass_change) again"):
        effect(name, **settings).added_to(effect(name, **settings).added_to(PLAIN))

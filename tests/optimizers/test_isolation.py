"""Global generators and logging are as they were, however the block is left."""

import logging.config
import random

import numpy as np
import pytest

from ksmea.numerics.isolation import LARGEST_MISFIT, finite, global_generators, logging_unconfigured


def draws(seed):
    with global_generators(np.random.default_rng(seed)):
        return random.random(), np.random.random()


def test_the_generator_seeds_both_global_generators():
    assert draws(1) == draws(1)
    assert draws(1)[0] != draws(2)[0] and draws(1)[1] != draws(2)[1]


def test_states_are_restored_after_an_error():
    random.random(), np.random.normal()  # an odd number of normals leaves a second one cached in the state
    python_state, numpy_state = random.getstate(), np.random.get_state()
    with pytest.raises(KeyError), global_generators(np.random.default_rng(1)):
        random.random(), np.random.random()
        raise KeyError
    assert random.getstate() == python_state
    assert all(np.array_equal(was, now) for was, now in zip(numpy_state, np.random.get_state()))


def test_logging_cannot_be_configured_inside_and_can_afterwards():
    configure, level = logging.config.dictConfig, logging.getLogger().level
    with pytest.raises(KeyError), logging_unconfigured():
        logging.config.dictConfig({"version": 1, "root": {"level": "CRITICAL"}})
        raise KeyError
    assert logging.getLogger().level == level
    assert logging.config.dictConfig is configure


def test_variance_of_infinite_misfits_is_a_number():
    misfit = finite(np.array([np.inf] * 50 + [1.0] * 50))
    assert np.isfinite(np.var(misfit)) and misfit.max() == LARGEST_MISFIT

"""Isolation of optimisation libraries: their side effects are kept from everything around them.

pyswarms configures the root logger and opens a log file in the working directory, and most compute with misfits as though
all of them were finite. Others draw from generators that the whole process shares.
"""

from __future__ import annotations

import logging.config
import random
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ksmea.arrays import Array

LARGEST_MISFIT = 1e150  # the square still fits a float, so that a library may take variances of it


@contextmanager
def logging_unconfigured() -> Iterator[None]:
    """Nothing inside the block can configure logging by `logging.config.dictConfig`.

    pyswarms 1.3.0 calls it when it is imported and again whenever a swarm is made (`utils/reporter/reporter.py`);
    that replaces the handlers and the level of the root logger and creates report.log in the working directory.
    """
    configure = logging.config.dictConfig
    logging.config.dictConfig = lambda config: None
    try:
        yield
    finally:
        logging.config.dictConfig = configure


def finite(misfit: Array) -> Array:
    """Misfits (k,) with +inf replaced by a finite value worse than any other.

    +inf marks a point at which none can be computed.

    >>> finite(np.array([1.0, np.inf]))
    array([1.e+000, 1.e+150])
    """
    return np.minimum(misfit, LARGEST_MISFIT)


@contextmanager
def global_generators(rng: np.random.Generator) -> Iterator[None]:
    """Seed `random` and `numpy.random` from `rng` inside the block and restore both states at its end.

    >>> before = random.getstate()
    >>> with global_generators(np.random.default_rng(1)):
    ...     first = random.random(), np.random.random()
    >>> with global_generators(np.random.default_rng(1)):
    ...     again = random.random(), np.random.random()
    >>> first == again, random.getstate() == before
    (True, True)
    """
    python_state, numpy_state = random.getstate(), np.random.get_state()
    random.seed(int(rng.integers(2**63)))
    np.random.seed(int(rng.integers(2**32)))
    try:
        yield
    finally:
        random.setstate(python_state)
        np.random.set_state(numpy_state)

"""Generators that a whole process shares: seeded for as long as a block lasts, and as they were afterwards."""
# Shorter than 40 lines: the one place that touches shared generators.

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np


@contextmanager
def global_generators(rng: np.random.Generator) -> Iterator[None]:
    """Seed `random` and `numpy.random` from `rng` inside the block and restore both states when it is left.

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

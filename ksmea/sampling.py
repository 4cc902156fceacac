"""Initial designs of experiments in the unit cube."""

from __future__ import annotations

import numpy as np
import scipy

from ksmea.arrays import Array


def latin_hypercube(samples: int, d: int, rng: np.random.Generator) -> Array:
    """Latin hypercube (samples, d): every one of `samples` equal slices of every coordinate holds one point.

    M. D. McKay, R. J. Beckman and W. J. Conover, Technometrics 21 (1979) 239–245, doi 10.2307/1268522. The paper names
    the Latin hypercube and no more, so nothing is optimised on top of it.
    """
    return scipy.stats.qmc.LatinHypercube(d, rng=rng).random(samples)

"""Values of unknowns of which none is known: the middles of their limits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ksmea.parameters import Parameters


def middles(parameters: Parameters, names: Iterable[str]) -> dict[str, float]:
    """The middle of the limits of each named unknown, in its unit; the geometric one where they lie a decade or more apart."""
    middle = parameters.to_si(parameters.from_decades(np.full(len(parameters), 0.5)))
    values = dict(zip(parameters.names, parameters.in_units(middle).tolist()))
    return {name: values[name] for name in names}

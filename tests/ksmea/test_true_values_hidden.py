"""Nothing that an identification is given holds the true values: every number that can be reached is looked at."""

from collections.abc import Iterable, Mapping

import numpy as np
import pytest

from ksmea.identification.ksmea import KSMEA
from ksmea.plugins.identification import Streams
from ksmea.problem.case import Case
from ksmea.problem.counted import CountedProblem
from ksmea.studies.identify import IdentificationOptions, identification
from measurements.synthetic import Synthetic
from optimizers.de import DE
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging

REFERENCE = {"kxx": 50e6, "kyy": 70e6, "cxx": 500.0, "cyy": 700.0, "u": 2e-4}


NEAR_LIMITS = {"kxx": [30.0, 80.0], "kyy": [50.0, 100.0]}


def streams(seed=0):
    return Streams(*(np.random.default_rng([seed, part]) for part in range(3)))


def numbers_in(thing, seen=None):
    """Every number that can be reached from an object through attributes, entries and arrays.

    What was seen is kept, not its `id` alone: a list made here and freed would lend its `id` to the next one.
    """
    seen = {} if seen is None else seen
    if isinstance(thing, (bool, str, bytes, type)) or thing is None or callable(thing):
        return
    if isinstance(thing, (int, float, complex, np.number)):
        yield from (complex(thing).real, complex(thing).imag, abs(complex(thing)))
        return
    if id(thing) in seen:
        return
    seen[id(thing)] = thing
    if isinstance(thing, np.ndarray):
        for part in (thing.real, thing.imag, np.abs(thing)):
            yield from part.ravel().tolist()
    elif isinstance(thing, Mapping):
        yield from numbers_in([*thing.keys(), *thing.values()], seen)
    elif isinstance(thing, Iterable):
        for entry in list(thing):
            yield from numbers_in(entry, seen)
    for entry in getattr(thing, "__dict__", {}).values():
        yield from numbers_in(entry, seen)


def true_values_in(*things):
    numbers = np.array(list(numbers_in(things)))
    return {name for name, value in REFERENCE.items() if np.any(np.abs(np.abs(numbers) / value - 1) < 1e-6)}


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
def test_nothing_that_is_handed_to_an_identification_holds_the_true_values(kind):
    received = []

    class Method(KSMEA):
        def identify(self, *arguments):
            received.extend((*arguments, vars(self)))
            return super().identify(*arguments)

    settings = ThreeDisk(n_speed=50)  # 53 speeds would have 500 and 700 rad/s among them
    problem = settings.build()
    synthetic = Synthetic(kind=kind, relative=0.1)
    measurement = synthetic.measure(settings, settings.reference(), np.random.default_rng(0), np.random.default_rng(0))
    method = Method(Kriging(), DE(generations=2), 30, max_updates=1)
    identification(Case(problem, measurement), method, streams(), IdentificationOptions(intervals="none", crlb=False))
    assert isinstance(received[0], CountedProblem) and measurement in received
    assert true_values_in(*received, vars(problem)["reduction"]) == set()
    # it would be noticed
    assert true_values_in(received, {"hidden": [settings.reference()]}) == set(REFERENCE)

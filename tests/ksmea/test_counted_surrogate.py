"""A counted surrogate predicts as the one behind, and whatever else it is asked is that one's answer."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from counted_runs import measured, streams
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.identification.trace import CountedPredictor, CountedSurrogate, with_counted_surrogate
from ksmea.measurement.noise import Noise
from ksmea.numerics.meter import Meter
from ksmea.plugins.surrogate import Predictor, Surrogate, Unsuited
from optimizers.de import DE
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging
from surrogates.none import NoSurrogate

QUICK = DE(population=10, generations=3)


def test_the_method_finds_the_same_and_its_predictions_are_counted():
    rotor = ThreeDisk().build()
    measurement = measured(rotor, [50e6, 70e6, 500.0, 700.0, 2e-4], "amplitude", Noise(0.1, 0.0))
    method, count = KSMEA(Kriging(), QUICK, 30, max_updates=4, refit_every=2), Meter()
    plain = method.identify(rotor, measurement, streams())
    counted = with_counted_surrogate(method, count).identify(rotor, measurement, streams())
    assert np.array_equal(plain.x, counted.x) and plain.notes == counted.notes
    assert method.surrogate == Kriging()  # the method itself is as it was
    # the search counts its own points; after each of them the response at its optimum is predicted once
    assert count.evaluations == counted.surrogate_evaluations + counted.updates > counted.updates


def test_what_has_no_surrogate_of_its_own_stays_as_it_is():
    for method in (Direct(QUICK), KSMEA(NoSurrogate(), QUICK, 30), object()):
        assert with_counted_surrogate(method, Meter()) is method


class Constant(Predictor):
    best = 3.0

    def predict(self, u):
        return np.ones((len(u), 1))

    def variance(self, u):
        return 2.0 * np.ones((len(u), 1))

    def leave_one_out(self):
        return np.array([0.5])

    @property
    def notes(self):
        return {"nugget": 1e-6}


@dataclasses.dataclass(frozen=True)
class OneOfItsOwn(Surrogate):
    transform = "log"
    degree: int = 7

    def least_samples(self, d):
        return 2 * d

    def of_degree(self, degree):
        return dataclasses.replace(self, degree=degree)

    def fit(self, u, y, rng):
        return Constant()


def test_contract_and_what_a_plugin_has_of_its_own_are_those_behind():
    count = Meter()
    surrogate = CountedSurrogate(OneOfItsOwn(), count)
    assert (surrogate.transform, surrogate.degree, surrogate.least_samples(3)) == ("log", 7, 6)
    assert not surrogate.is_true_model
    other = surrogate.of_degree(8)
    assert isinstance(other, CountedSurrogate) and other.degree == 8 and other.count is count
    points = np.zeros((4, 2))
    predictor = surrogate.fit(points, np.zeros((4, 1)), np.random.default_rng(0))
    assert np.array_equal(predictor.variance(points), 2.0 * np.ones((4, 1))) and predictor.leave_one_out() == [0.5]
    assert predictor.notes == {"nugget": 1e-6} and predictor.best == 3.0 and predictor.append(points[0], 1.0) is None
    assert count.evaluations == 0
    predictor.predict(points)
    assert count.evaluations == 4
    with pytest.raises(AttributeError, match="of_nobody"):
        predictor.of_nobody  # noqa: B018


@dataclasses.dataclass(frozen=True)
class AtALoss(OneOfItsOwn):
    substitute: Surrogate | None = None

    def fit(self, u, y, rng):
        raise Unsuited("of no use here", self.substitute)


def test_what_takes_over_from_a_surrogate_is_counted_too():
    count, nothing = Meter(), (np.zeros((4, 2)), np.zeros((4, 1)), np.random.default_rng(0))
    for substitute in (OneOfItsOwn(), NoSurrogate(), None):
        with pytest.raises(Unsuited) as raised:
            CountedSurrogate(AtALoss(substitute=substitute), count).fit(*nothing)
        found = raised.value.substitute
        assert isinstance(found, CountedSurrogate) == isinstance(substitute, OneOfItsOwn)
        if not isinstance(found, CountedSurrogate):
            assert found is substitute


def test_every_member_of_the_contracts_is_counted_or_handed_on():
    """No default of the contract may answer in place of the one behind."""
    for counted, contract in ((CountedPredictor, Predictor), (CountedSurrogate, Surrogate)):
        assert issubclass(counted, contract) and contract not in counted.__mro__
        members = {name for name in dir(contract) if not name.startswith("_")} - set(vars(counted))
        behind = SimpleNamespace(**dict.fromkeys(members, "of the one behind"))
        assert {getattr(counted(behind, Meter()), name) for name in members} == {"of the one behind"}

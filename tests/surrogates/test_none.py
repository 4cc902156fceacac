"""Without a surrogate each prediction is an evaluation of the model."""

import numpy as np
import pytest

from ksmea.identification.true_model import TrueModel
from ksmea.plugins.transforms import make_transform
from surrogates.none import NoSurrogate


class CountingModel:
    def __init__(self):
        self.evaluations = 0

    def response(self, u):
        """At one speed through two channels."""
        self.evaluations += len(u)
        return np.column_stack([u.sum(axis=1), u.prod(axis=1)])[:, None]


def test_prediction_is_the_counted_model():
    model = CountingModel()
    settings = NoSurrogate()
    assert settings.least_samples(5) == 1 and settings.transform == "auto" and settings.is_true_model
    predictor = TrueModel(model, make_transform("none", "amplitude", n_speed=1, n_channel=2))
    assert model.evaluations == 0
    u = np.array([[0.1, 0.2], [0.3, 0.4], [0.0, 1.0]])
    np.testing.assert_array_equal(
        predictor.predict(u)[:, :2], [[0.1 + 0.2, 0.1 * 0.2], [0.3 + 0.4, 0.3 * 0.4], [1.0, 0.0]]
    )
    assert model.evaluations == 3
    assert predictor.leave_one_out() is None and predictor.append(u[0], u[0]) is None and predictor.notes == {}


def test_it_is_never_fitted_to_samples():
    with pytest.raises(TypeError, match="expected a method that evaluates the true model"):
        NoSurrogate().fit(np.array([[0.5, 0.5]]), np.array([[1.0, 0.25]]), np.random.default_rng(0))

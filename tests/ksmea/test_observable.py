"""Kinds of data: names, what is seen, and deviations as real numbers of unit variance."""

import json

import numpy as np
import pytest

from ksmea.measurement.observable import Observable, amplitude_sensitivity


def test_a_kind_is_its_name():
    assert Observable("complex") is Observable.COMPLEX and Observable.AMPLITUDE == "amplitude"
    assert (
        json.dumps({"kind": Observable.COMPLEX}) == '{"kind": "complex"}' and f"{Observable.AMPLITUDE}" == "amplitude"
    )
    with pytest.raises(ValueError):
        Observable("phase")


def test_what_is_seen():
    response = np.array([[3 + 4j, -2.0 + 0j]])
    assert Observable.AMPLITUDE.seen(response).tolist() == [[5.0, 2.0]]
    assert Observable.COMPLEX.seen(response) is response
    assert [observable.dimensions for observable in Observable] == [1, 2]


def test_the_sensitivity_of_an_amplitude_is_that_of_a_difference():
    rng = np.random.default_rng(0)
    response, sensitivity = (rng.standard_normal((2, *shape)) for shape in ((4, 2), (4, 2, 3)))
    response, sensitivity = response[0] + 1j * response[1], sensitivity[0] + 1j * sensitivity[1]
    h = 1e-6
    expected = [
        (abs(response + h * sensitivity[..., i]) - abs(response - h * sensitivity[..., i])) / (2 * h) for i in range(3)
    ]
    found = Observable.AMPLITUDE.seen_sensitivity(response, sensitivity)
    assert found == pytest.approx(np.stack(expected, axis=-1), abs=1e-9)
    assert np.array_equal(found, amplitude_sensitivity(response, sensitivity))
    assert Observable.COMPLEX.seen_sensitivity(response, sensitivity) is sensitivity


@pytest.mark.parametrize("observable", list(Observable))
def test_noise_in_units_of_itself_has_unit_variance_in_each_real_part(observable):
    rng = np.random.default_rng(1)
    first, second = rng.standard_normal((2, 100_000))
    unit = first if observable is Observable.AMPLITUDE else (first + 1j * second) / np.sqrt(2)
    parts = observable.real_parts(unit)
    assert parts.shape == (100_000 * observable.dimensions,)
    assert np.var(parts) == pytest.approx(1.0, abs=0.02)  # standard error √(2/100 000) = 0.5 %
    assert np.sum(parts**2) == pytest.approx(observable.dimensions * np.sum(np.abs(unit) ** 2))


def test_parts_are_set_side_by_side_along_an_axis():
    deviation = np.array([[1 + 2j, 3 + 4j]])
    assert Observable.COMPLEX.real_parts(deviation, axis=1) / np.sqrt(2) == pytest.approx(np.array([[1, 3, 2, 4]]))
    assert Observable.COMPLEX.real_parts(deviation) / np.sqrt(2) == pytest.approx(np.array([[1, 3], [2, 4]]))

"""Noise that is stated too small is no fault of the model, and an effect is found beside it; data of a finer mesh."""

import numpy as np
import pytest

from ksmea.diagnosis.diagnosis import diagnose
from ksmea.fits.lack_of_fit import CHI2, FitQuality, is_size_alone
from ksmea.fits.search import Search
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.studies.diagnose import diagnosis
from ksmea.studies.library import library
from problems.three_disk import ThreeDisk
from tests.diagnosis.conftest import LESS

PROBLEM = ThreeDisk(sensors=[0.1, 0.5], n_speed=40)
EFFECTS = library(["runout", "channel_gain", "speed_dependent_stiffness"], [])[0]
NOISE = {"kind": "complex", "relative": 0.06, "floor": 0.1, "mesh": 26, "route": "dense"}


def data(seed, **settings):
    source = registry.create("measurement", "synthetic", {**NOISE, **settings})
    truth = source.true_values(PROBLEM)
    noise, hidden = (np.random.default_rng([seed, place]) for place in (0, 1))
    return source.measure(PROBLEM, truth, noise, hidden)


def found(measurement, seed=0):
    return diagnose(Case(PROBLEM.build(), measurement), EFFECTS, Search(np.random.default_rng(seed), LESS))


@pytest.mark.parametrize("stated", [0.667, 1.5])
def test_a_right_model_is_adequate_whatever_noise_is_stated(stated):
    verdicts = [found(data(seed, stated=stated)).verdict for seed in range(4)]
    assert verdicts == ["adequate"] * 4


def test_noise_is_taken_as_large_as_it_is_where_it_is_stated_too_small():
    measurement = data(1, stated=0.5)
    taken = found(measurement).baseline.likelihood.measurement.noise
    # 2 within 6 %: three standard deviations of the scatter of 320 real residuals
    assert taken.relative / measurement.noise.relative == pytest.approx(2, rel=0.12)


def test_stated_noise_is_kept_where_an_effect_explains_what_is_more():
    measurement = data(2, hidden=["runout"], expected_drop=300.0)
    named = found(measurement)
    assert named.named == ("runout",)
    assert named.baseline.likelihood.measurement.noise == measurement.noise


def test_stated_noise_is_kept_where_two_effects_explain_what_is_more():
    """The first of them alone fails by its χ²: a second effect is looked for before the noise is doubted."""
    few = ThreeDisk(sensors=[0.1, 0.5], n_speed=12)
    source = registry.create(
        "measurement", "synthetic", {**NOISE, "hidden": ["unbalance", "channel_gain"], "expected_drop": 150.0}
    )
    noise, hidden = (np.random.default_rng([2, place]) for place in (0, 1))
    measurement = source.measure(few, source.true_values(few), noise, hidden)
    effects = library(["runout", "channel_gain", "unbalance", "probe_rotation"], [])[0]
    named = diagnose(Case(few.build(), measurement), effects, Search(np.random.default_rng(0), LESS))
    assert set(named.named) == {"unbalance", "channel_gain"}
    assert named.best.likelihood.measurement.noise == measurement.noise


def test_an_effect_is_named_beside_noise_that_is_stated_too_small():
    named = found(data(3, hidden=["runout"], expected_drop=300.0, stated=0.667))
    assert named.verdict == "named" and named.named == ("runout",)


@pytest.mark.parametrize("stated, said", [(0.667, "1.4|1.5|1.6"), (1.5, "0.6|0.7"), (1.0, None)])
def test_the_report_says_how_much_the_data_scatter(stated, said):
    record = diagnosis(Case(PROBLEM.build(), data(4, stated=stated)), EFFECTS, np.random.default_rng(0))
    remarks = [remark for remark in record.remarks if "their stated noise" in remark]
    assert bool(remarks) == (said is not None)
    assert said is None or any(f"scatter {start}" in remarks[0] for start in said.split("|"))


def test_a_misfit_with_a_shape_is_not_the_size_of_the_noise():
    quality = FitQuality(0.001, {"largest residual": 0.002, CHI2: 0.001}, np.zeros((2, 1)), 2.0, (0.0, 1.0), 0, 1.0)
    assert not is_size_alone(quality, 0.005)

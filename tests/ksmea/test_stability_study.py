"""The stability threshold of what a study found: its interval against draws, and what text and JSON say of it."""

import dataclasses
import json

import numpy as np
import pytest

from ksmea.inference.cramer_rao import identifiability
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.records.estimate import StabilityRecord
from ksmea.show.text import stability_text
from ksmea.studies.stability import stability_of
from rigid_rotor import DAMPING, NATURAL, STIFFNESS, problem_of, rigid_rotor

HIGHEST = 400.0  # rad/s
RPM = np.pi / 30


def falling(part):
    """Damping that falls with speed, cross-coupling κ = part · c ω_n, and values at which the bounce becomes unstable at
    Ω = Ω₁ (1 − part) / 0.8."""
    problem = problem_of(rigid_rotor(), np.linspace(150.0, HIGHEST, 26))
    problem = registry.create("effect", "speed_dependent_damping", {"full_speed": HIGHEST}).added_to(problem)
    problem = registry.create("effect", "cross_coupling_antisymmetric", {}).added_to(problem)
    return problem, np.array([STIFFNESS, -0.8, part * DAMPING * NATURAL])


@pytest.mark.slow
def test_the_interval_holds_as_many_draws_of_the_estimates_as_it_says():
    problem, x = falling(0.4)
    noise = Noise(0.01, 0.0)
    found = stability_of(problem, x, noise, "complex", level=0.9)
    assert found.threshold == pytest.approx(HIGHEST * 0.6 / 0.8, rel=2e-3) and found.is_violated
    covariance = np.linalg.inv(identifiability(problem, x, noise, "complex").information)
    draws = np.random.default_rng(0).multivariate_normal(x, covariance, size=200, method="cholesky")
    thresholds = np.array([problem.stability_threshold(draw, found.searched) for draw in draws])
    inside = np.mean((thresholds >= found.low) & (thresholds <= found.high))
    # 90 % ± 6 %: three standard deviations of 200 draws; the delta method is of first order
    assert inside == pytest.approx(0.9, abs=0.07)


def test_more_noise_makes_a_wider_interval_and_none_makes_a_point():
    problem, x = falling(0.4)
    none, little, much = (
        stability_of(problem, x, noise, "complex") for noise in (None, Noise(0.002, 0), Noise(0.02, 0))
    )
    assert none.low == none.high == none.threshold == little.threshold == much.threshold
    assert much.low < little.low < none.threshold < little.high < (much.high or np.inf)


def test_a_stable_rotor_that_may_be_unstable_has_an_open_interval():
    problem, x = falling(0.4)
    x[2] = 0.0
    assert stability_of(problem, x, Noise(1e-4, 0), "complex").threshold == pytest.approx(HIGHEST / 0.8, rel=2e-3)
    x[1:] = -0.6, 0.02 * DAMPING * NATURAL
    found = stability_of(problem, x, Noise(0.05, 0), "complex")
    assert found.threshold is None and found.high is None and found.low < found.searched


RECORD = StabilityRecord(300 * RPM, 200 * RPM, None, 0.95, 500 * RPM, 750 * RPM)


@pytest.mark.parametrize(
    "changes, said",
    [
        (
            {},
            [
                "stability: unstable from 300 rpm on, 95 % interval 200 rpm to above 750 rpm, the highest speed checked",
                "warning",
            ],
        ),
        (
            {"threshold": 600 * RPM, "low": 0.0, "high": 700 * RPM},
            ["stability: unstable from 600 rpm on, 95 % interval rest to 700 rpm"],
        ),
        ({"threshold": None, "low": None}, ["stability: no instability up to 750 rpm, the highest speed checked"]),
        (
            {"threshold": None},
            ["stability: no instability up to 750 rpm, the highest speed checked, but perhaps from 200 rpm on (95 %)"],
        ),
    ],
)
def test_what_is_said(changes, said):
    record = dataclasses.replace(RECORD, **changes)
    lines = list(stability_text(record))
    assert len(lines) == len(said) and all(line.startswith(start) for line, start in zip(lines, said))
    assert StabilityRecord.from_data(json.loads(json.dumps(record.to_data()))) == record


def test_nothing_is_said_where_the_problem_cannot_tell():
    assert list(stability_text(None)) == []

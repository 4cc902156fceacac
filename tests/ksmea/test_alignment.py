"""A problem and a measurement belong together, or an identification is refused in one line."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.identification.true_model import model_objective
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Streams
from ksmea.problem.alignment import aligned, require_aligned
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from optimizers.de import DE
from problems.three_disk import ThreeDisk
from surrogates.rsm import ResponseSurface

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
NOISE = Noise(0.05, 0.0)
PROBLEM = ThreeDisk(n_speed=9).build()


def measured_at(problem, kind="amplitude", phase_known=True):
    response = problem.response(TRUTH[None])[0]
    values = np.abs(response) if kind == "amplitude" else response
    return Measurement(problem.speed, problem.channels, values, NOISE, "test", phase_known)


SHIFTED = measured_at(PROBLEM.at(1.01 * PROBLEM.speed, PROBLEM.channels))
MISMATCHES = {
    "speed": (SHIFTED, "speed 1: expected 202 rad/s as measured, got a problem at 200 rad/s; make the problem with"),
    "one speed of many": (
        measured_at(PROBLEM.at(PROBLEM.speed + np.eye(9)[4], PROBLEM.channels)),
        "speed 5: expected 851 rad/s as measured, got a problem at 850 rad/s",
    ),
    "number of speeds": (
        measured_at(PROBLEM.at(PROBLEM.speed[:8], PROBLEM.channels)),
        "speeds: expected the 8 of the measurement, got a problem with 9",
    ),
    "direction": (
        measured_at(PROBLEM.at(PROBLEM.speed, PROBLEM.channels[::-1])),
        "channel 1: expected y at 0.1 m as measured, got a problem seen in x at 0.1 m",
    ),
    "position": (
        measured_at(PROBLEM.at(PROBLEM.speed, (PROBLEM.channels[0], Channel(0.5, "y")))),
        "channel 2: expected y at 0.5 m as measured, got a problem seen in y at 0.1 m",
    ),
    "number of channels": (
        measured_at(PROBLEM.at(PROBLEM.speed, PROBLEM.channels[:1])),
        "channels: expected the 1 of the measurement, got a problem with 2",
    ),
    "phases": (
        measured_at(PROBLEM, "complex", phase_known=False),
        "phases: expected a problem with an unknown phase origin, as the measurement has, got one without",
    ),
}


def streams():
    return Streams(*(np.random.default_rng(part) for part in range(3)))


USES = {
    "direct": lambda problem, data: Direct(DE(generations=1)).identify(problem, data, streams()),
    "ksmea": lambda problem, data: KSMEA(ResponseSurface(), DE(generations=1), 30).identify(problem, data, streams()),
    "likelihood": lambda problem, data: Likelihood(Model(problem), data),
    "objective": lambda problem, data: model_objective(Model(problem), Misfit(data, "log")),
    "asking": require_aligned,
}


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("name", MISMATCHES)
def test_what_does_not_belong_together_is_refused_before_anything_is_computed(name, use):
    class Untouched(Problem):
        parameters, speed, channels = PROBLEM.parameters, PROBLEM.speed, PROBLEM.channels

        def response(self, x):
            raise AssertionError("nothing was to be computed")

    data, text = MISMATCHES[name]
    with pytest.raises(SettingError) as caught:
        USES[use](Untouched(), data)
    assert str(caught.value).startswith(text) and "\n" not in str(caught.value)
    assert "ksmea.problem.alignment.aligned(problem, measurement)" in str(caught.value)


@pytest.mark.parametrize("name", MISMATCHES)
def test_the_aligned_problem_is_taken(name):
    data, _ = MISMATCHES[name]
    problem = aligned(PROBLEM, data)
    require_aligned(problem, data)
    x = np.append(TRUTH, np.zeros(len(problem.parameters) - 5))
    assert data.seen(problem.response(x[None])[0]) == pytest.approx(data.values, rel=1e-9)
    assert ("phase_origin" in problem.parameters.names) == (name == "phases")
    USES["direct"](problem, data)


def test_rounding_of_speeds_is_no_mismatch_and_what_fits_is_left_as_it_is():
    data = dataclasses.replace(measured_at(PROBLEM), speed=PROBLEM.speed * (1 + 1e-12))
    require_aligned(PROBLEM, data)
    assert aligned(PROBLEM, measured_at(PROBLEM)) is PROBLEM
    free = PROBLEM.with_phase_origin()
    assert aligned(free, measured_at(PROBLEM, "complex", phase_known=False)) is free
    assert aligned(PROBLEM, measured_at(PROBLEM, "complex")) is PROBLEM


class Fixed(Problem):
    """A problem that can do no more than it must."""

    parameters, speed, channels = PROBLEM.parameters, PROBLEM.speed, PROBLEM.channels

    def response(self, x):
        return PROBLEM.response(x)


def test_a_problem_that_cannot_be_seen_so_says_why():
    for data, text in (
        (SHIFTED, "test: expected a problem that can be seen at other speeds and channels, got Fixed"),
        (
            MISMATCHES["phases"][0],
            "test: phases were measured from an unknown origin, expected a problem that can leave",
        ),
    ):
        with pytest.raises(SettingError) as caught:
            aligned(Fixed(), data)
        assert str(caught.value).startswith(text) and "\n" not in str(caught.value)


def test_what_a_problem_may_leave_out_is_refused_where_it_is_asked_for():
    fixed = Fixed()
    assert not (fixed.has_sensitivity or fixed.can_leave_phase_open or fixed.takes_unbalance or fixed.has_dense_route)
    assert len(fixed.sites) == len(fixed.costly) == 0 and not fixed.has_free_phase
    for call in (
        lambda: fixed.sensitivity(TRUTH),
        lambda: fixed.with_phase_origin(),
        lambda: fixed.with_unbalance(0.1, 1e-6, 0.0),
        lambda: fixed.dense_response(TRUTH[None]),
        lambda: fixed.at(PROBLEM.speed, PROBLEM.channels),
        lambda: fixed.critical_speeds(TRUTH),
        lambda: fixed.modes(TRUTH, 100.0),
        lambda: fixed.campbell(TRUTH, PROBLEM.speed),
    ):
        with pytest.raises(SettingError, match=r"^expected a problem that .*, got Fixed; "):
            call()
    whole = PROBLEM
    assert whole.has_sensitivity and whole.can_leave_phase_open and whole.takes_unbalance and whole.has_dense_route

"""Method and measurement source that keep every property of their exams.

For each property there is one that breaks it.
"""

from dataclasses import dataclass, replace

import numpy as np

from ksmea.identification.direct import Direct
from ksmea.settings.settings import setting
from measurements.synthetic import Synthetic
from optimizers.lm import LM


def shipped(method_class=Direct):
    return method_class(LM(screening=200, starts=2))


@dataclass(frozen=True)
class Values(Direct):
    """It returns the values alone."""

    def identify(self, problem, measurement, streams):
        return super().identify(problem, measurement, streams).x


@dataclass(frozen=True)
class InMegas(Direct):
    """It returns stiffnesses in MN/m."""

    def identify(self, problem, measurement, streams):
        found = super().identify(problem, measurement, streams)
        return replace(found, x=found.x * np.array([1e-6, 1e-6, 1, 1, 1]))


@dataclass(frozen=True)
class Modest(Direct):
    """It forgets an evaluation."""

    def identify(self, problem, measurement, streams):
        found = super().identify(problem, measurement, streams)
        return replace(found, model_evaluations=found.model_evaluations - 1)


@dataclass(frozen=True)
class Greedy(Direct):
    """It looks around its optimum, whatever the budget."""

    def identify(self, problem, measurement, streams):
        found = super().identify(problem, measurement, streams)
        problem.response(np.repeat(found.x[None], 80, axis=0))
        return replace(found, model_evaluations=found.model_evaluations + 80)


@dataclass(frozen=True)
class Anywhere(Direct):
    """It takes the problem for the one that was measured."""

    def identify(self, problem, measurement, streams):
        return super().identify(problem.at(measurement.speed, measurement.channels), measurement, streams)


@dataclass(frozen=True)
class Centre(Direct):
    """It says what it said before it looked."""

    def identify(self, problem, measurement, streams):
        found = super().identify(problem, measurement, streams)
        return replace(found, x=problem.parameters.to_si(np.full(5, 0.2)), at_limit=(False,) * 5)


BROKEN_METHODS = [
    ("works_on_the_problem", shipped(Values), r"expected an Identification, got ndarray; return one"),
    (
        "values_are_within_bounds",
        shipped(InMegas),
        r"5 values within their limits, SI, got .*problem.parameters.to_si\(u\)",
    ),
    (
        "records_what_it_used",
        shipped(Modest),
        r"\d+ evaluations and \d+ Jacobians, as asked of the problem, got .*Model",
    ),
    ("keeps_its_budget", shipped(Greedy), r"at most 80 evaluations, got \d+; make the Model with its budget"),
    ("misaligned_problem_is_refused", shipped(Anywhere), r"at other speeds than measured, got an identification; call"),
    ("finds_the_true_values", shipped(Centre), r"values within 0.1 of the limits' width, got \w+ off by .*error=…"),
]


@dataclass(frozen=True)
class Fewer(Synthetic):
    """It leaves its last speed out."""

    def measure(self, settings, truth, noise, hidden):
        found = super().measure(settings, truth, noise, hidden)
        return found.part(np.arange(len(found.speed) - 1))


@dataclass(frozen=True)
class InMicrometres(Synthetic):
    """It measures in micrometres."""

    def measure(self, settings, truth, noise, hidden):
        found = super().measure(settings, truth, noise, hidden)
        return replace(found, values=found.values * 1e6)


@dataclass(frozen=True)
class Louder(Synthetic):
    """It draws three times the noise that it tells."""

    def measure(self, settings, truth, noise, hidden):
        louder = replace(self, relative=3 * self.relative)
        return replace(Synthetic.measure(louder, settings, truth, noise, hidden), noise=self.noise)


@dataclass(frozen=True)
class Forgetful(Synthetic):
    """It tells all true values but one."""

    def measure(self, settings, truth, noise, hidden):
        return super().measure(settings, super().true_values(settings), noise, hidden)

    def true_values(self, settings):
        return {name: value for name, value in super().true_values(settings).items() if name != "u"}


@dataclass(frozen=True)
class AnyPath(Synthetic):
    """It never looks whether its file is there."""

    path: str = setting("", "a file")


BROKEN_MEASUREMENTS = [
    ("measures_what_it_says", Fewer(), r"amplitude of 9 speeds and 2 channels, as stated, got amplitude of 8 and 2"),
    (
        "speeds_and_values_are_si",
        InMicrometres(),
        r"values up to 0.1 m, got .*; give them in m: 1e-6 times micrometres",
    ),
    (
        "problem_can_be_seen_so",
        Synthetic(kind="complex", phase_known=False),
        r"got SettingError: .* phases were measured from an unknown origin, expected a problem that can leave it open",
    ),
    ("noise_is_what_it_tells", Louder(relative=0.05), r"noise of 1 ± .* times its level, got .* times; draw it by"),
    ("true_values_are_of_its_unknowns", Forgetful(), r"true values of kxx, .*, or of none, got none of u; tell them"),
    (
        "bad_input_is_refused",
        AnyPath(),
        r"a SettingError of {'path': 'no_such_file'}, got a measurement; say in one line",
    ),
]

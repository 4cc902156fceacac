"""Old path of the contracts of plugins, for one release. Shorter than 40 lines: it only forwards."""

from ksmea.errors import warn_moved
from ksmea.plugins.effect import AnyEffect, Effect
from ksmea.plugins.identification import METHOD_PARTS, Method
from ksmea.plugins.optimizer import Optimizer
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.plugins.surrogate import Surrogate
from ksmea.problem.problem import Problem

__all__ = [
    "METHOD_PARTS",
    "AnyEffect",
    "Effect",
    "MeasurementSource",
    "Method",
    "Optimizer",
    "Problem",
    "ProblemSettings",
    "Surrogate",
]

warn_moved(__name__, "ksmea (from ksmea import Problem, Effect, …)")

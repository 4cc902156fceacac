"""Linearisation point of studies that look ahead: true values, or a measurement's most likely ones."""
# Shorter than 40 lines: two studies share it.

from __future__ import annotations

from bench.plan.plan import generator
from bench.plan.setup import Draw, Setup
from ksmea.plugins.source import MeasurementSource
from ksmea.problem.case import Case
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.enough_data import require_enough


def require_design_point(setup: Setup, who: str) -> None:
    """Raise `SettingError` if there are neither true values with noise nor a measurement of enough data."""
    source = setup.source
    if _is_measured(source):
        layout = source.layout(setup.settings)
        require_enough(layout, len(setup.problem.parameters), with_noise=source.noise is None)
    else:
        setup.require_truth(who)
        setup.require_noise(who)


def design_point(setup: Setup, draw: Draw, who: str) -> DesignPoint:
    """At the true values, or of a measurement at its most likely ones."""
    source = setup.source
    if _is_measured(source):
        return DesignPoint.of_measurement(Case(setup.problem, setup.measure(draw)), generator(draw.seeds["diagnosis"]))
    return DesignPoint(setup.problem, setup.true_x, setup.require_noise(who), source.kind, source.noise_known)


def _is_measured(source: MeasurementSource) -> bool:
    """Whether it holds a measurement whatever the problem is."""
    return type(source).read is not MeasurementSource.read

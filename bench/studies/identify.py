"""Study of an identification: `ksmea.studies.identify`, and its result compared with the true values."""

from __future__ import annotations

import dataclasses
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.plan.plan import generator
from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.identification.trace import comparable_misfit
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.numerics.meter import JACOBIAN_AS_EVALUATIONS
from ksmea.plugins import registry
from ksmea.plugins.identification import Streams
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.differences_problem import as_searched
from ksmea.problem.journal import Journal, JournaledProblem
from ksmea.records.curves import ResponseCurves, as_array
from ksmea.records.identification import IdentificationRecord
from ksmea.records.record import Record, finite
from ksmea.records.trace import TraceRecord
from ksmea.settings.settings import Settings, own_fields, setting
from ksmea.studies.curves import fine_responses
from ksmea.studies.enough_data import require_enough
from ksmea.studies.identify import INPUTS, INTERVALS, IdentificationOptions, identification

SAME_RESPONSE = 1e-5  # relative, of records
IN_DETAIL = "identify_in_detail"  # name of the study with details


@dataclass(frozen=True)
class Identify(Study):
    """The values of the unknowns, found by the method from the measurement, with an interval next to each.

    The intervals belong to the maximum of the true model's likelihood nearest to what the method found; if data are few
    they reach over all likely maxima. They take Jacobians of the true model, which are counted apart from the method's.
    """

    intervals: str = setting(
        "profile",
        "how intervals are made: profile (from the information, checked and where needed replaced by the profile"
        " likelihood: some ten Jacobians an unknown), information (unchecked: a few in all), none",
        choices=INTERVALS,
    )
    level: float = setting(0.95, "confidence level of the intervals", above=0, at_most=0.9999)
    basin: bool = setting(
        False, "compare the maximum of the likelihood nearest to what was found with the one nearest to the truth"
    )
    details: bool = setting(
        False,
        "keep what a report on one identification shows: data and fit over speed, CRLBs and correlations at the"
        " identified values",
    )
    unmodelled: str = setting(
        "",
        "also give the unknowns fitted with an unknown force, free at every speed, at this position (m), or auto: at"
        " all places and of all kinds that explain the data (docs/location.md)",
    )

    inputs: str = setting(
        "joint",
        "numbers of the model that are known to a tolerance: joint, fitted in the last step and part of the intervals; or stated,"
        " taken as exact",
        choices=INPUTS,
    )
    budget: int | None = setting(
        None,
        "true-model evaluations at most, of any method, its own settings apart; null: what the method asks for. A run that asks"
        " for more ends with the best point until then",
        at_least=1,
    )
    jacobian_cost: int = setting(
        JACOBIAN_AS_EVALUATIONS,
        "evaluations that one Jacobian counts as in this budget; 2: a response and one adjoint solution",
        at_least=0,
    )

    record: ClassVar[type[Record]] = IdentificationRecord
    report: ClassVar[str] = "summary"

    @property
    def parts(self) -> tuple[Settings, ...]:
        """The study with its details, if these are requested.

        It is another plugin (`bench.studies.identify_in_detail`), so that a plain identification neither loads nor
        depends on the code of details.
        """
        if not (self.details or self.unmodelled):
            return ()
        own = {field.name: getattr(self, field.name) for field in own_fields(Identify)}
        detailed: Settings = registry.create("study", IN_DETAIL, own)
        return (detailed, *detailed.parts)

    def validate(self, setup: Setup) -> None:
        for part in self.parts:
            if isinstance(part, Identify):
                return part.validate(setup)
        if self.basin and not setup.truth:
            raise SettingError(
                "expected true values to compare with, got a measurement without; leave it out", setting="study.basin"
            )
        with_noise = self.intervals != "none" and not setup.source.noise_known
        require_enough(setup.source.layout(setup.settings), len(setup.problem.parameters), with_noise=with_noise)
        setup.method.validate(setup.problem)
        return None

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        detailed = next((part for part in self.parts if isinstance(part, Identify)), self)
        problem = setup.problem if draw.journal is None else JournaledProblem(setup.problem, Journal(draw.journal))
        case = Case(problem, setup.measure(draw))
        record = detailed.identified(case, setup, draw)
        used = case.answered()  # the case that the record is of
        response = setup.true_response(draw) if draw.with_curves else None
        if response is not None:
            channels = case.measurement.channels
            response = response[:, [channels.index(channel) for channel in used.measurement.channels]]
        record = record.with_truth(problem.parameters, setup.truth, response)
        if draw.with_fine and record.curves is not None:
            record = dataclasses.replace(record, curves=_with_fine(record, record.curves, used, setup, draw))
        if setup.truth.keys() >= set(problem.parameters.names):
            near = _maximum_near(setup.true_x, used)
            if self.basin and near is not None and record.deviance is not None:
                record = dataclasses.replace(record, basin_excess=record.deviance - near.deviance)
            if record.trace is not None:
                record = dataclasses.replace(record, trace=_judged(record.trace, setup, near, used))
        return dataclasses.replace(record, hidden=setup.hidden(draw)).to_data()

    def identified(self, case: Case, setup: Setup, draw: Draw) -> IdentificationRecord:
        """The record of one identification, without a comparison with true values."""
        options = self.options(setup, draw)
        return identification(case, setup.method, streams_of(draw), options, generator(draw.seeds["diagnosis"]))

    def options(self, setup: Setup, draw: Draw) -> IdentificationOptions:
        crlb, within = self.details or not setup.truth, (self.budget, self.jacobian_cost)
        made = IdentificationOptions(self.intervals, self.level, crlb, draw.with_curves, self.details, *within)
        return dataclasses.replace(made, inputs=self.inputs)


def streams_of(draw: Draw) -> Streams:
    """Generators of a method's components in one run."""
    return Streams(*(generator(draw.seeds[component]) for component in ("design", "surrogate", "optimizer")))


def _maximum_near(x: Array, case: Case) -> Point | None:
    """The maximum of the likelihood nearest to x (d,) SI.

    None if the data have no noise, or the search fails.
    """
    if case.measurement.noise is not None and not case.measurement.has_noise:
        return None
    with suppress(np.linalg.LinAlgError):
        return nearest_maximum(likelihood_of(case), case.problem.parameters.to_cube(x))
    return None


def _with_fine(
    record: IdentificationRecord, curves: ResponseCurves, used: Case, setup: Setup, draw: Draw
) -> ResponseCurves:
    """Curves with the models at more speeds than were measured.

    The true response is among them if a problem of this setup makes it: data may come from another one."""
    models = {"identified": (used.problem, record.x)}
    if curves.modelled is not None and record.history:
        models["modelled"] = (used.problem, np.array(record.history[-1].x))
    if curves.true is not None and setup.truth.keys() >= set(setup.problem.parameters.names):
        problem, x = setup.with_hidden(draw) or (used.problem, setup.true_x)
        with suppress(SettingError):
            made = np.abs(aligned(problem, used.measurement).response(x[None])[0])
            if np.allclose(made, as_array(curves.true), rtol=SAME_RESPONSE):
                models["true"] = (problem, x)
    with suppress(SettingError):  # of a problem that has no response elsewhere
        return dataclasses.replace(curves, fine=fine_responses(used.measurement, models))
    return curves


def _judged(trace: TraceRecord, setup: Setup, near: Point | None, case: Case) -> TraceRecord:
    """A trace compared with the true values and the maximum near them.

    Data without noise are compared with the true values alone.
    """
    true, parameters = setup.true_x, case.problem.parameters
    best = true if near is None else parameters.to_si(near.theta[: len(true)])
    searched = as_searched(case)
    least = finite(comparable_misfit(searched.measurement)(searched.problem.response(best[None]))[0])
    return trace.judged(parameters, true, setup.crlb(case.problem), least)

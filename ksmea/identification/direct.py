"""The optimiser on the true model, without a surrogate."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass

from ksmea.errors import BudgetSpent
from ksmea.identification.true_model import FINAL_STEP, model_objective, most_likely
from ksmea.likelihood.misfit import FORMS, Misfit
from ksmea.measurement.measurement import Measurement
from ksmea.plugins.identification import Identification, Method, Stage, Streams, at_limit
from ksmea.plugins.optimizer import Optimizer
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from ksmea.settings.settings import part, setting


@dataclass(frozen=True)
class Direct(Method):
    """Minimise the misfit of the true model with the optimiser alone, as Table 6 does with DE, PSO and GA.

    If the noise level is not known, the optimiser searches with equal weights in relative terms. The result is then
    the maximum of the likelihood nearest to its optimum, with the noise also estimated, unless `final_step` says
    otherwise.
    """

    optimizer: Optimizer = part("what searches the true model")
    misfit: str = setting("likelihood", "form of the misfit", choices=FORMS)
    budget: int | None = setting(
        None, "largest number of true-model evaluations; null: no limit but the optimiser's", at_least=1
    )
    jacobian_cost: int = setting(
        0,
        "evaluations that one Jacobian counts as in the budget; 0: it is counted apart, and costs nothing",
        at_least=0,
    )
    final_step: bool | None = setting(
        None,
        "end at the maximum of the likelihood nearest to the optimiser's optimum; null: if the misfit is the likelihood"
        " and the noise level is not known",
    )

    def validate(self, problem: Problem) -> None:
        self.optimizer.check_dimension(len(problem.parameters))

    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        started = time.perf_counter()
        model = Model(problem, budget=self.budget, jacobian_cost=self.jacobian_cost)
        misfit = Misfit(measurement, self.misfit)
        objective = model_objective(model, misfit, model.left)
        with suppress(BudgetSpent):
            self.optimizer.minimize(objective, streams.optimizer)
        minimum = objective.found(model)  # not what the optimiser returned: the objective knows
        is_spent = objective.was_refused or model.was_refused
        u, value = minimum.u, minimum.value - misfit.offset
        objective.end_stage("search")  # or the optimiser has ended stages of its own
        stages = [
            Stage(name, problem.parameters.to_si(end.u), end.evaluations, end.jacobians)
            for name, end in objective.stages
        ]
        if self._ends_in_final_step(measurement) and (found := most_likely(model, measurement, u)) is not None:
            u, value = found
            stages.append(Stage(FINAL_STEP, problem.parameters.to_si(u), model.evaluations, model.jacobians))
        total = time.perf_counter() - started
        return Identification(
            x=problem.parameters.to_si(u),
            at_limit=at_limit(u),
            misfit=value,
            stop="budget" if is_spent else "optimizer",
            updates=0,
            model_evaluations=model.evaluations,
            model_jacobians=model.jacobians,
            surrogate_evaluations=0,
            seconds={"model": model.seconds, "surrogate": 0.0, "search": total - model.seconds, "total": total},
            stages=tuple(stages),
        )

    def _ends_in_final_step(self, measurement: Measurement) -> bool:
        if self.final_step is None:
            return self.misfit == "likelihood" and measurement.noise is None
        return self.final_step

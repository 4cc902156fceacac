"""KSMEA: a surrogate of the response, an optimiser on it, and the true model where the optimiser ends (Section 4).

Han, Guo & Gao, JSV 332 (2013) 2659–2671, doi 10.1016/j.jsv.2012.12.025, Fig. 1 and eqs. (23)–(25):

1. a Latin hypercube of samples, evaluated with the true model, and the surrogate fitted to the responses;
2. the optimiser minimises the misfit between the surrogate's response and the measured one;
3. the true model is evaluated there; SMC or SDF say whether the surrogate was accurate enough to stop;
4. if not, the point joins the samples, the surrogate is rebuilt and step 2 follows: one updating step.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ksmea.contracts import Optimizer, Predictor, Problem, Surrogate
from ksmea.descent import descend
from ksmea.errors import BudgetSpent, SettingError
from ksmea.identification import Identification, Streams, Update, at_bound, check_optimizer
from ksmea.measurement import Measurement
from ksmea.misfit import FORMS, Misfit
from ksmea.model import Model, model_objective
from ksmea.objective import Objective
from ksmea.parameters import Array
from ksmea.sampling import latin_hypercube
from ksmea.settings import Settings, setting
from ksmea.stopping import simple_difference, squared_multiple_correlation
from ksmea.transforms import make_transform


@dataclass(frozen=True)
class KSMEA(Settings):
    """The paper's method; whatever it leaves open is a setting."""

    misfit: str = setting("log", "form of the misfit that is minimised on the surrogate", choices=FORMS)
    surrogate_error: bool = setting(
        True, "add the surrogate's leave-one-out error to the noise, where the surrogate tells it"
    )
    smc: float = setting(0.999, "stop when the squared multiple correlation exceeds this", source="eq. (23)", at_most=1)
    sdf: float = setting(
        1e-11, "stop when the simple difference function falls below this", unit="m", source="eq. (24)", at_least=0
    )
    max_updates: int = setting(
        50, "updating steps at most; 50 is the most the paper reports", source="Table 8", at_least=1
    )
    budget: int | None = setting(None, "true-model evaluations at most, initial samples included", at_least=1)
    surrogate_budget: int | None = setting(
        None, "surrogate evaluations at most per updating step; null: what the optimiser asks for", at_least=1
    )
    polish: bool = setting(True, "end each search on the surrogate with bounded least squares from the optimum found")
    nearest: int | None = setting(
        None, "fit the surrogate to this many samples nearest to the best one; null: to all", at_least=1
    )
    refit_every: int = setting(
        1,
        "re-estimate the surrogate's own parameters at every n-th update and only append the sample in between,"
        " where the surrogate can",
        at_least=1,
    )
    least_distance: float = setting(
        1e-7,
        "a new sample nearer than this to an old one (unit cube) would make the surrogate singular: stop there",
        at_least=0,
    )
    final_step: bool = setting(
        False, "end with least squares on the true model (likelihood) from the best point; the paper has no such step"
    )

    ignores: ClassVar[tuple[str, ...]] = ()

    def validate(self, problem: Problem, surrogate: Surrogate, optimizer: Optimizer, samples: int) -> None:
        check_optimizer(optimizer, problem)
        d = len(problem.parameters)
        least = surrogate.least_samples(d)
        if samples < least:
            raise SettingError(
                f"samples: expected at least {least} for this surrogate with {d} unknowns, got {samples};"
                " take more samples, or a lower trend or degree"
            )
        if self.nearest is not None and self.nearest < least:
            raise SettingError(
                f"method.nearest: expected at least {least} for this surrogate with {d} unknowns, got {self.nearest}"
            )
        if self.budget is not None and samples >= self.budget:
            raise SettingError(
                f"method.budget: expected more than the {samples} initial samples, got {self.budget};"
                " raise it or take fewer samples"
            )

    def identify(
        self,
        problem: Problem,
        measurement: Measurement,
        surrogate: Surrogate,
        optimizer: Optimizer,
        samples: int,
        streams: Streams,
    ) -> Identification:
        d = len(problem.parameters)
        transform = make_transform(
            surrogate.transform,
            amplitude_data=measurement.is_amplitude,
            n_speed=len(measurement.speed),
            n_channel=len(measurement.channels),
        )
        model = Model(problem, transform)
        clock = _Clock(model)
        misfit = Misfit(measurement, self.misfit)

        points = latin_hypercube(samples, d, streams.design)  # (n, d)
        responses = model.response(points)  # (n, n_speed, n_channel)
        misfits = misfit.value(misfit.observed(responses))  # (n,) of the true model
        predictor = None
        history: list[Update] = []
        surrogate_evaluations = 0
        stop = ""
        while not stop:
            with clock.measures("surrogate"):
                chosen = self._training(points, misfits)
                outputs = transform.encode(responses[chosen])
                predictor = self._fit(surrogate, predictor, points[chosen], outputs, model, streams, len(history))
            with clock.measures("search"):
                searched = self._with_surrogate_error(misfit, predictor, model)
                objective = self._surrogate_objective(searched, predictor, model)
                u = self._search(objective, optimizer, streams.optimizer)
                surrogate_evaluations += objective.evaluations
                predicted = transform.decode(predictor.predict(u[None]))
            response = model.response(u[None])
            observed = misfit.observed(response)
            update = Update(
                x=problem.parameters.to_si(u),
                predicted_misfit=float(misfit.value(predicted)[0]),
                misfit=float(misfit.value(observed)[0]),
                smc=squared_multiple_correlation(predicted[0], observed[0], measurement.values),
                sdf=simple_difference(predicted[0], observed[0]),
            )
            history.append(update)
            repeated = np.min(np.linalg.norm(points - u, axis=1)) < self.least_distance
            points = np.vstack([points, u])
            responses = np.concatenate([responses, response])
            misfits = np.append(misfits, update.misfit)
            stop = self._stop(update, bool(repeated), len(history), model.evaluations)

        best = points[np.argmin(misfits)]
        final_misfit = float(np.min(misfits))
        if self.final_step and (self.budget is None or model.evaluations < self.budget):
            best, final_misfit = self._final_step(model, measurement, best)
        return Identification(
            x=problem.parameters.to_si(best),
            at_bound=at_bound(best),
            misfit=final_misfit,
            stop=stop,
            updates=len(history),
            model_evaluations=model.evaluations,
            model_jacobians=model.jacobians,
            surrogate_evaluations=surrogate_evaluations,
            seconds=clock.split(),
            history=tuple(history),
            notes=getattr(predictor, "notes", {}),
        )

    def _training(self, points: Array, misfits: Array) -> Array:
        """Indices of the samples that the surrogate is fitted to."""
        if self.nearest is None or len(points) <= self.nearest:
            return np.arange(len(points))
        distance = np.linalg.norm(points - points[np.argmin(misfits)], axis=1)
        return np.sort(np.argsort(distance, kind="stable")[: self.nearest])

    def _fit(
        self,
        surrogate: Surrogate,
        previous: Predictor | None,
        u: Array,
        y: Array,
        model: Model,
        streams: Streams,
        updates: int,
    ) -> Predictor:
        """The surrogate of samples u (n, d), whose last is new: a fit, a warm refit or one sample appended."""
        if previous is None:
            return surrogate.fit(u, y, model, streams.surrogate)
        if updates % self.refit_every and self.nearest is None and hasattr(previous, "append"):
            return previous.append(u[-1], y[-1])
        if hasattr(surrogate, "refit"):
            return surrogate.refit(previous, u, y, model, streams.surrogate)
        return surrogate.fit(u, y, model, streams.surrogate)

    def _with_surrogate_error(self, misfit: Misfit, predictor: Predictor, model: Model) -> Misfit:
        if not (self.surrogate_error and hasattr(predictor, "leave_one_out")):
            return misfit
        measured = misfit.measurement.values
        return replace(misfit, model_sd=model.transform.spread(predictor.leave_one_out(), measured[None])[0])

    def _surrogate_objective(self, misfit: Misfit, predictor: Predictor, model: Model) -> Objective:
        def predicted(u: Array) -> Array:
            return model.transform.decode(predictor.predict(u))

        return Objective(
            len(model.problem.parameters),
            lambda u: misfit.residuals(predicted(u)),
            screening_at=lambda u: misfit.screening(predicted(u)),
            budget=self.surrogate_budget,
        )

    def _search(self, objective: Objective, optimizer: Optimizer, rng: np.random.Generator) -> Array:
        """The optimum (d,) on the surrogate; a spent budget ends the search with the best point seen."""
        with suppress(BudgetSpent):
            optimizer.minimize(objective, rng)
            if self.polish:
                descend(objective, objective.result().u, max_iterations=50)
        best = objective.result()
        if not np.isfinite(best.value):
            raise ArithmeticError(f"none of the {objective.evaluations} points of the optimiser has a finite misfit")
        return best.u

    def _stop(self, update: Update, repeated: bool, updates: int, model_evaluations: int) -> str:
        """The reason to stop, or '' to go on."""
        if update.smc > self.smc:
            return "smc"
        if update.sdf < self.sdf:
            return "sdf"
        if repeated:
            return "repeated"
        if self.budget is not None and model_evaluations >= self.budget:
            return "budget"
        return "updates" if updates >= self.max_updates else ""

    def _final_step(self, model: Model, measurement: Measurement, start: Array) -> tuple[Array, float]:
        likelihood = Misfit(measurement, "likelihood")
        left = None if self.budget is None else self.budget - model.evaluations
        objective = model_objective(model, likelihood, left)
        with suppress(BudgetSpent):
            descend(objective, start, max_iterations=100)
        found = objective.result()
        return found.u, found.value - likelihood.offset


class _Clock:
    """Wall time of an identification by part; what a part spends in the true model is the model's alone."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._started = time.perf_counter()
        self._parts = {"surrogate": 0.0, "search": 0.0}

    @contextmanager
    def measures(self, part: str) -> Iterator[None]:
        started, in_model = time.perf_counter(), self._model.seconds
        yield
        self._parts[part] += time.perf_counter() - started - (self._model.seconds - in_model)

    def split(self) -> dict[str, float]:
        return {"model": self._model.seconds, **self._parts, "total": time.perf_counter() - self._started}

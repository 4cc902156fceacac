"""KSMEA: a surrogate of the response, an optimiser on it, and the true model at its end (Section 4).

Han, Guo & Gao, JSV 332 (2013) 2659–2671, doi 10.1016/j.jsv.2012.12.025, Fig. 1 and eqs. (23)–(25):

1. a Latin hypercube of samples, evaluated with the true model, and the surrogate fitted to the responses;
2. the optimiser minimises the misfit between the surrogate's response and the measured one;
3. the true model is evaluated there; SMC or SDF say whether the surrogate was accurate enough to stop;
4. if not, the point joins the samples, the surrogate is rebuilt and step 2 follows: one updating step.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import BudgetSpent, SettingError
from ksmea.identification.true_model import FINAL_STEP, TrueModel, most_likely
from ksmea.identification.updating import improvement_residual, simple_difference, squared_multiple_correlation
from ksmea.likelihood.misfit import FORMS, Misfit
from ksmea.measurement.measurement import Measurement
from ksmea.numerics.least_squares import polish
from ksmea.numerics.objective import Objective
from ksmea.numerics.screening import latin_hypercube
from ksmea.plugins.identification import POLISH, Identification, Method, SearchStage, Stage, Streams, Update, at_limit
from ksmea.plugins.optimizer import Optimizer
from ksmea.plugins.surrogate import Predictor, Surrogate, Unsuited
from ksmea.plugins.transforms import Transform, make_transform
from ksmea.problem.alignment import require_aligned
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from ksmea.problem.response_structure import ResponseStructure
from ksmea.settings.settings import part, setting

SEARCH = "search"  # the stage's name
INFILLS = ("optimum", "expected_improvement")


@dataclass(frozen=True)
class KSMEA(Method):
    """The paper's method; whatever it leaves open is a setting.

    `KSMEA(surrogate=Kriging(), optimizer=DE(), samples=40).identify(problem, measurement, streams)`
    """

    surrogate: Surrogate = part("what stands for the response of the true model")
    optimizer: Optimizer = part("what searches the surrogate")
    samples: int = part("points of the initial design, a Latin hypercube", at_least=1)
    misfit: str = setting("log", "form of the misfit that is minimised on the surrogate", choices=FORMS)
    infill: str = setting(
        "optimum",
        "location of the next true evaluation: at the surrogate's lowest misfit, as the paper does, or where the expected"
        " improvement of the misfit is largest (`ksmea/identification/updating.py`)",
        choices=INFILLS,
    )
    surrogate_error: bool = setting(
        True, "add the surrogate's leave-one-out error to the noise, if the surrogate estimates it"
    )
    smc: float = setting(0.999, "stop when the squared multiple correlation exceeds this", source="eq. (23)", at_most=1)
    sdf: float = setting(
        1e-11, "stop when the simple difference function falls below this", unit="m", source="eq. (24)", at_least=0
    )
    sdf_relative: float = setting(
        0.0,
        "stop when SDF falls below this part of the sum of amplitudes; 0: never. The paper gives one number in"
        " metres, whatever the size of the response",
        at_least=0,
    )
    max_updates: int = setting(
        50,
        "updating steps at most; 50 is the most the paper reports. 0: the first surrogate's optimum is the answer, and the true"
        " model is never evaluated there",
        source="Table 8",
        at_least=0,
    )
    budget: int | None = setting(None, "true-model evaluations at most, initial samples included", at_least=1)
    jacobian_cost: int = setting(
        0,
        "evaluations that one Jacobian counts as in the budget; 0: it is counted apart, and costs nothing",
        at_least=0,
    )
    surrogate_budget: int | None = setting(
        None,
        "largest number of surrogate evaluations per updating step; null: no limit but the optimiser's",
        at_least=1,
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
        False, "end at the maximum of the true model's likelihood nearest to the best point; the paper has no such step"
    )

    def validate(self, problem: Problem) -> None:
        d = len(problem.parameters)
        self.optimizer.check_dimension(d)
        least = self.surrogate.with_structure(structure_of(problem)).least_samples(d)
        if self.samples < least:
            raise SettingError(
                f"samples: expected at least {least} for this surrogate with {d} unknowns, got {self.samples};"
                " take more samples, or a lower trend or degree"
            )
        if self.infill == "expected_improvement" and self.misfit == "likelihood":
            raise SettingError(
                "method.infill: expected a misfit whose noise stays as it is for expected_improvement, got likelihood;"
                " write method.misfit=log"
            )
        if self.nearest is not None and self.nearest < least:
            raise SettingError(
                f"method.nearest: expected at least {least} for this surrogate with {d} unknowns, got {self.nearest}"
            )
        if self.budget is not None and self.samples + min(self.max_updates, 1) > self.budget:
            raise SettingError(
                f"method.budget: expected more than the {self.samples} initial samples, got {self.budget};"
                " raise it or take fewer samples"
            )

    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        require_aligned(problem, measurement)
        model, misfit = Model(problem, self.budget, self.jacobian_cost), Misfit(measurement, self.misfit)
        clock, to_si = _Clock(model), problem.parameters.to_si
        known = _Samples.at(latin_hypercube(self.samples, len(problem.parameters), streams.design), model, misfit)
        stages = [Stage("samples", to_si(known.best()[0]), model.evaluations, model.jacobians)]
        surrogate = self.surrogate.with_structure(structure_of(problem))
        predictor: Predictor | None = None
        predicted = None
        history: list[Update] = []
        remarks: tuple[str, ...] = ()
        optimum: tuple[Array, float] | None = None  # on the surrogate, where the true model is not evaluated there
        search: tuple[SearchStage, ...] = ()
        surrogate_evaluations = 0
        stop = ""
        while not stop:
            try:
                with clock.measures("surrogate"):
                    fitted = self._fitted(surrogate, predictor, known, streams.surrogate)
                    surrogate, predictor, remarks = fitted.surrogate, fitted.predictor, remarks + fitted.remarks
                with clock.measures("search"):
                    objective = self._objective(fitted, known)
                    u = self._search(objective, model, streams.optimizer)
                    search = tuple(SearchStage(name, to_si(end.u), end.value) for name, end in objective.stages)
                    surrogate_evaluations += objective.evaluations
                    prediction = fitted.response(u[None])
                if not self.max_updates:
                    optimum, stop, predicted = (u, float(misfit.value(prediction)[0])), "optimizer", prediction[0]
                    break
                known, distance = known.with_sample(u), known.distance_to(u)
            except BudgetSpent:
                stop = "budget"
                break
            predicted = prediction[0]  # not before the true model has been evaluated there: the two go together
            history.append(_update(prediction, known, search))
            stop = self._stop(history, distance, model)

        best, best_misfit = optimum or known.best()
        stages += [Stage(each.name, each.x, model.evaluations, model.jacobians, on_surrogate=True) for each in search]
        stages.append(Stage("updating steps", to_si(best), model.evaluations, model.jacobians))
        if self.final_step and (found := most_likely(model, measurement, best)) is not None:
            best, best_misfit = found
            stages.append(Stage(FINAL_STEP, to_si(best), model.evaluations, model.jacobians))
        return Identification(
            x=to_si(best),
            at_limit=at_limit(best),
            misfit=best_misfit,
            stop=stop,
            updates=len(history),
            model_evaluations=model.evaluations,
            model_jacobians=model.jacobians,
            surrogate_evaluations=surrogate_evaluations,
            seconds=clock.split(),
            history=tuple(history),
            predicted=predicted,
            modelled=None if not history else misfit.observed(known.responses[-1]),
            remarks=remarks,
            notes={} if predictor is None else predictor.notes,
            stages=tuple(stages),
        )

    def _fitted(
        self, surrogate: Surrogate, previous: Predictor | None, known: _Samples, rng: np.random.Generator
    ) -> _Fitted:
        """The surrogate of the samples, or its substitute if it is not suited.

        `previous` is the predictor without the last sample.
        """
        measurement = known.misfit.measurement
        size = {"n_speed": len(measurement.speed), "n_channel": len(measurement.channels)}
        transform = make_transform(surrogate.transform, measurement.kind, **size)
        try:
            predictor = self._predictor(surrogate, previous, transform, known, rng)
        except Unsuited as unsuited:
            if unsuited.substitute is None:
                raise
            other = self._fitted(unsuited.substitute, None, known, rng)
            return replace(other, remarks=(str(unsuited), *other.remarks))
        return _Fitted(surrogate, transform, predictor)

    def _predictor(
        self,
        surrogate: Surrogate,
        previous: Predictor | None,
        transform: Transform,
        known: _Samples,
        rng: np.random.Generator,
    ) -> Predictor:
        """A fit, a warm refit, or one sample appended."""
        if surrogate.is_true_model:
            return TrueModel(known.model, transform)
        chosen = known.nearest_to_best(self.nearest)
        u, y = known.points[chosen], transform.encode(known.responses[chosen])
        if previous is None:
            return surrogate.fit(u, y, rng)
        if (len(known.points) - self.samples) % self.refit_every and self.nearest is None:
            appended = previous.append(u[-1], y[-1])
            if appended is not None:
                return appended
        return surrogate.refit(previous, u, y, rng)

    def _objective(self, fitted: _Fitted, known: _Samples) -> Objective:
        """Objective of the search for the next point.

        The misfit of the surrogate's response, its own error added to the noise where it tells it, or what the true
        misfit, by the same noise, is expected to improve.
        """
        d, misfit = known.points.shape[1], known.misfit
        own_error = fitted.predictor.leave_one_out() if self.surrogate_error else None
        if own_error is not None:
            measured = misfit.measurement.values[None]
            misfit = replace(misfit, model_sd=fitted.transform.spread(own_error, measured)[0])
        if self.infill == "expected_improvement":
            lowest = float(np.min(misfit.value(misfit.observed(known.responses))))
            return Objective(
                d, lambda u: improvement_residual(*fitted.residuals(u, misfit), lowest), budget=self.surrogate_budget
            )
        return Objective(
            d,
            lambda u: misfit.residuals(fitted.response(u)),
            screening_at=lambda u: misfit.screening(fitted.response(u)),
            budget=self.surrogate_budget,
        )

    def _search(self, objective: Objective, model: Model, rng: np.random.Generator) -> Array:
        """Optimum (d,) on the surrogate, by the optimiser and then the polish.

        Each is a stage of the objective; a spent budget ends the search with the best point seen.
        """
        stage = SEARCH
        try:
            self.optimizer.minimize(objective, rng)
            if self.polish:
                objective.end_stage(SEARCH)
                stage = POLISH
                polish(objective)
        except BudgetSpent:
            if not objective.was_refused:  # the true model's budget, of a surrogate that evaluates it
                raise
        objective.end_stage(stage)
        return objective.found(model).u

    def _stop(self, history: list[Update], distance: float, model: Model) -> str:
        """Reason to stop, or '' to go on; `distance` is the distance of the new sample to the nearest old one."""
        update = history[-1]
        if update.smc > self.smc:
            return "smc"
        if update.sdf < self.sdf or update.sdf < self.sdf_relative * update.sum_of_amplitudes:
            return "sdf"
        if distance < self.least_distance:
            return "repeated"
        if model.is_spent:
            return "budget"
        return "updates" if len(history) >= self.max_updates else ""


def structure_of(problem: Problem) -> ResponseStructure:
    """Structure of a problem for surrogates: no evaluation of it, and no true value."""
    return ResponseStructure(
        problem.parameters, problem.speed, len(problem.channels), problem.unknown_impedances, problem.unbalance
    )


@dataclass(frozen=True)
class _Samples:
    """Points of the unit cube that the true model has been evaluated at, and the misfit there."""

    model: Model
    misfit: Misfit
    points: Array  # (n, d)
    responses: ComplexArray  # (n, n_speed, n_channel)
    misfits: Array  # (n,)

    @classmethod
    def at(cls, points: Array, model: Model, misfit: Misfit) -> _Samples:
        responses = model.response(points)
        return cls(model, misfit, points, responses, misfit.value(misfit.observed(responses)))

    def with_sample(self, u: Array) -> _Samples:
        """These, and behind them the point u (d,)."""
        added = self.at(u[None], self.model, self.misfit)
        return replace(
            self,
            points=np.vstack([self.points, added.points]),
            responses=np.concatenate([self.responses, added.responses]),
            misfits=np.append(self.misfits, added.misfits),
        )

    def best(self) -> tuple[Array, float]:
        index = int(np.argmin(self.misfits))
        return self.points[index], float(self.misfits[index])

    def nearest_to_best(self, count: int | None) -> Indices:
        """Indices of that many samples nearest to the best one, in their order; of all if there are no more."""
        if count is None or len(self.points) <= count:
            return np.arange(len(self.points))
        distance = np.linalg.norm(self.points - self.best()[0], axis=1)
        return np.sort(np.argsort(distance, kind="stable")[:count])

    def distance_to(self, u: Array) -> float:
        return float(np.min(np.linalg.norm(self.points - u, axis=1)))


@dataclass(frozen=True)
class _Fitted:
    """A surrogate fitted to the samples, and remarks on any that was not suited before it."""

    surrogate: Surrogate
    transform: Transform  # of the responses to its outputs
    predictor: Predictor
    remarks: tuple[str, ...] = ()

    def response(self, u: Array) -> Array | ComplexArray:
        """(k, d) → (k, n_speed, n_channel), m."""
        return self.transform.decode(self.predictor.predict(u))

    def residuals(self, u: Array, misfit: Misfit) -> tuple[Array, Array]:
        """Mean and variance (k, m) of the residuals of the true model at points (k, d), by the surrogate.

        A surrogate without a variance is as uncertain everywhere as its leave-one-out error, or exact.
        """
        outputs, variance = self.predictor.predict(u), self.predictor.variance(u)
        if variance is None:
            own_error = self.predictor.leave_one_out()
            variance = np.broadcast_to(0.0 if own_error is None else own_error**2, outputs.shape)
        predicted = self.transform.decode(outputs)
        sd = misfit.residual_sd(predicted, self.transform.spread(np.sqrt(variance), predicted))
        return misfit.residuals(predicted), sd**2


def _update(predicted: Array | ComplexArray, known: _Samples, search: tuple[SearchStage, ...]) -> Update:
    """Outcome of an updating step: prediction (1, n_speed, n_channel) and true model at the last sample."""
    misfit, modelled = known.misfit, known.misfit.observed(known.responses[-1])
    return Update(
        x=known.model.problem.parameters.to_si(known.points[-1]),
        predicted_misfit=float(misfit.value(predicted)[0]),
        misfit=float(known.misfits[-1]),
        smc=squared_multiple_correlation(predicted[0], modelled, misfit.measurement.values),
        sdf=simple_difference(predicted[0], modelled),
        sum_of_amplitudes=float(np.sum(np.abs(modelled))),
        search=search,
    )


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

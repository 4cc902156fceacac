"""Diagnosis: misfit of a model, the physical cause that explains it, and the evidence."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.plan import generator
from bench.plan.progress import progress_of
from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from ksmea.diagnosis.trials import candidates, candidates_and_left_out, none_located
from ksmea.errors import SettingError
from ksmea.fits.fitting import fit_from_values
from ksmea.numerics.parallel import Workers, cpu_seconds
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.case import Case
from ksmea.problem.problem import joint_values
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.record import Record
from ksmea.settings.settings import setting
from ksmea.studies.diagnose import DiagnosisOptions, Report, diagnosis
from ksmea.studies.library import library


@dataclass(frozen=True)
class Diagnose(DiagnosisOptions, Study):
    """Diagnosis: misfit of the model, its cause, and the prediction by an extended model."""

    effects: list[str] = setting(
        [], "names of the effects that are fitted; an empty list: all that are registered; [none]: none of them"
    )
    without: list[str] = setting([], "names of effects that are not fitted")

    record: ClassVar[type[Record]] = DiagnosisRecord
    report: ClassVar[str] = "diagnosis"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    @property
    def parts(self) -> list[AnyEffect]:
        return list(library(self.effects, self.without)[0].values())

    def validate(self, setup: Setup) -> None:
        setup.refuse_exact_data("study=diagnose")
        effects, _ = library(self.effects, self.without)
        found, left_out = candidates_and_left_out(setup.problem, effects)
        if not found and left_out:
            problem_class, reasons = (
                type(setup.problem).__name__,
                "; ".join(f"{name} {why}" for name, why in left_out.items()),
            )
            raise SettingError(
                f"study=diagnose: expected a problem that effects can be added to, got {problem_class}: {reasons}; take one that is"
                " made of a rotor, or other effects"
            )
        if effects and not found:
            raise SettingError(f"{none_located(effects)}", setting="study.effects")
        n_data = len(setup.problem.speed) * len(setup.problem.channels)
        least = 2 * len(setup.problem.parameters)
        if n_data < least:
            raise SettingError(
                f"study=diagnose: expected at least {least} data, twice the unknowns, got {n_data}; measure more speeds"
            )

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        started = cpu_seconds()
        case = Case(setup.problem, setup.measure(draw))
        effects, left_out = library(self.effects, self.without, case.measurement, case.problem)
        details = not setup.truth  # made data are not misread
        report = Report(left_out, tuple(setup.source.remarks), details=details, fine=draw.with_curves)
        n_candidate = len(candidates(setup.problem, effects))
        n_interval = 2 * len(setup.problem.parameters)  # before and after
        # candidates are fitted, refined, compared with the best one, and fitted as second effects
        n_step = 1 + 4 * n_candidate + n_interval + self.blocks
        with progress_of(draw, "diagnosis", n_step) as progress:
            found = diagnosis(
                case,
                effects,
                generator(draw.seeds["diagnosis"]),
                options=self,
                report=report,
                workers=Workers(draw.workers, progress),
            )
        found = dataclasses.replace(
            found,
            hidden=setup.hidden(draw),
            hidden_deviance_drop=_hidden_deviance_drop(setup, draw, case, found),
            seconds=cpu_seconds() - started,
        )
        return {"status": "done", **found.to_data()}


def _hidden_deviance_drop(setup: Setup, draw: Draw, case: Case, found: DiagnosisRecord) -> float | None:
    """Deviance drop from the baseline model's fit to the fit of the model that made the data.

    That fit starts from the true values: the drop shows how visible the hidden effects are. None if nothing is hidden.
    """
    truth, baseline = setup.with_hidden(draw), found.lack_of_fit.before.deviance
    if truth is None or baseline is None:
        return None
    problem, x = truth
    joint = problem.joint  # with numbers that were drawn, which it starts from as stated
    return baseline - fit_from_values(case.by(joint), joint_values(problem, joint, x)).deviance

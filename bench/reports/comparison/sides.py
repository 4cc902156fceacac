"""One side of a comparison: an identification or a diagnosis as what can be compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.jobs.lines import RunLine
from bench.jobs.records import read_records
from bench.plan.plan import Plan, Run, read_plan
from bench.reports.fleet.rows import diagnosed, identified
from bench.reports.identification.finding import finding
from bench.reports.pages.made_by import flattened
from ksmea.errors import SettingError
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import Shown
from ksmea.records.identification import IdentificationRecord
from ksmea.show import diagnosis_findings as findings
from ksmea.show.diagnosis_findings import verdict_line
from ksmea.show.text import two_digits
from ksmea.units import MICROMETRE

USUAL_LEVEL = 0.95  # of intervals in plans that say none
RECORD_TYPES: Mapping[str, type[IdentificationRecord | DiagnosisRecord]] = {
    "identify": IdentificationRecord,
    "identify_in_detail": IdentificationRecord,
    "diagnose": DiagnosisRecord,
}


@dataclass(frozen=True)
class Side:
    """One result as it is compared with another.

    `finding` is its short verdict, which another result of the same study can equal; `facts` are numbers and words by
    name; `level` is the confidence level of the intervals.
    """

    name: str
    plan: Plan
    study: str
    settings: Mapping[str, str]
    verdict: str
    finding: str
    facts: Mapping[str, str | float]
    unknowns: Mapping[str, Shown]
    level: float


def read_side(folder: Path) -> Side:
    """The first run that has a result in a folder.

    Raises `SettingError` if it is neither an identification nor a diagnosis.
    """
    plan = read_plan(folder)
    run, line = _first(plan, folder)
    cell = plan.cells[run.cell]
    study = str((cell.settings.get("study") or {}).get("name", "identify"))
    if study not in RECORD_TYPES:
        raise SettingError(f"compare: expected results of identify or diagnose, got {folder} with study={study}")
    settings = dict(flattened(cell.settings)) | {"seed": str(cell.seed), "repetition": str(run.repetition)}
    findings_of = _diagnosis_findings if study == "diagnose" else _identification_findings
    verdict, finding, facts, unknowns = findings_of(line)
    setting = "interval_level" if study == "diagnose" else "level"
    level = float((cell.settings.get("study") or {}).get(setting, USUAL_LEVEL))
    return Side(str(folder), plan, study, settings, verdict, finding, facts, unknowns, level)


def n_with_result(plan: Plan, folder: Path) -> int:
    """Runs of a plan that have a result."""
    found = read_records(folder, lambda line: line.has_result, plan)
    return sum(found.get(run.key, False) for run in plan.runs)


def _first(plan: Plan, folder: Path) -> tuple[Run, RunLine]:
    lines = read_records(folder, plan=plan)
    for run in plan.runs:
        if (line := lines.get(run.key)) is not None and line.has_result:
            return run, line
    raise SettingError(
        f"compare: expected a run with a result in {folder}, found none; python -m bench status {folder} tells more"
    )


Findings = tuple[str, str, Mapping[str, str | float], Mapping[str, Shown]]


def _identification_findings(line: RunLine) -> Findings:
    record = line.record(IdentificationRecord)
    row = identified(record)
    return finding(record), row.finding, dict(_facts(record)), row.values


def _facts(record: IdentificationRecord) -> Iterator[tuple[str, str | float]]:
    yield "misfit", np.nan if record.misfit is None else record.misfit
    if record.deviance is not None:
        yield "deviance", record.deviance
    if record.lack_of_fit is not None:
        yield "lack-of-fit p", record.lack_of_fit.p
    if record.intervals is not None:
        noise = record.intervals.noise
        yield from _noise(noise.relative, noise.floor)
    yield "model evaluations", record.model_evaluations
    yield "model Jacobians", record.model_jacobians


def _noise(relative: float, floor: float) -> Iterator[tuple[str, float]]:
    """The parts of the noise that there are, with the digits that texts tell of them.

    `floor` in m, rms where each datum has its own.
    """
    yield from (
        (name, float(two_digits(part)))
        for name, part in (("noise (%)", 100 * relative), ("noise (µm)", floor / MICROMETRE))
        if part
    )


def _diagnosis_findings(line: RunLine) -> Findings:
    record = line.record(DiagnosisRecord)
    row = diagnosed(record)
    before = record.lack_of_fit.before
    facts: dict[str, str | float] = {
        "verdict": record.verdict,
        "cause": str(row.facts["cause"]),
        "location": str(row.facts["location"]),
    }
    facts |= {"lack-of-fit p": before.p, "reduced χ²": before.reduced_chi2}
    facts |= {} if record.lack_of_fit.after is None else {"lack-of-fit p after": record.lack_of_fit.after.p}
    facts |= {} if record.lack_of_fit.after is None else {"reduced χ² after": record.lack_of_fit.after.reduced_chi2}
    facts |= {} if row.noise is None else dict(_noise(*row.noise))
    unknowns = {**row.values, **_of_extension(record)}
    headline = findings.title(record, record.notation)
    return headline, verdict_line(record).removeprefix("Verdict: "), facts, unknowns


def _of_extension(record: DiagnosisRecord) -> dict[str, Shown]:
    """Unknowns that an accepted extended model adds to the model as given; empty if none is accepted."""
    if record.verdict == "located" and record.location is not None and record.location.extension is not None:
        own, found = {row.name for row in record.coefficients}, record.location.extension
        return {
            name: Shown(value, np.nan, np.nan, found.units[name])
            for name, value in found.values.items()
            if name not in own
        }
    if not record.is_explained:
        return {}
    return {row.name: row.after.shown for row in record.coefficients if row.before is None and row.after}

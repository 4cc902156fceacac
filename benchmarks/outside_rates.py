"""Rates at which a diagnosis invents a name for a cause that its library lacks, on drawn machines.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.outside_rates 5 rows.csv [CAUSE …]
    python -m benchmarks.outside_rates rows.csv

The first makes draws that the file does not have yet, in two processes, and writes a row for each; both print a table of them. Draw n of
a cause (`benchmarks/outside_causes.py`) is on a machine of its own, of the kind n modulo 5 of `problems/drawn_kinds.py`, with complex data
of 3 to 7 % noise that the fit is not told. Effects that can express the cause are taken out of the library. Its size is scaled until it
changes the response by 20 to 80 % of it.

An explanation is *alike* if its deviance exceeds that of the true response by no more than a diagnosis takes for a tie: with the cause in
the library, both would be reported. Such data do not tell that the explanation is wrong.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from bench.reports.tables import rate
from benchmarks.outside_causes import CAUSES, WITHOUT, Cause, Machine, of_change
from benchmarks.resumed import rows_of
from ksmea.arrays import Array, ComplexArray
from ksmea.diagnosis.trials import NEAR as TIE
from ksmea.likelihood.misfit import deviance
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.studies.diagnose import DiagnosisOptions, diagnosis
from ksmea.studies.library import library
from problems.drawn_kinds import KINDS

FIRST_INSTANCE = 3000  # apart from those of the experiments
RELATIVES = (0.03, 0.05, 0.07)
FLOOR = 0.02  # of the median amplitude
CHANGE = 0.2, 0.8  # of the rms response
CLEAR = 60.0  # Δχ² of what is clearly visible


def row(cause: str, number: int) -> dict[str, Any]:
    """One draw: what was hidden, what was found."""
    rng = np.random.default_rng([number, *cause.encode()])
    family = list(KINDS)[number % len(KINDS)]
    machine = Machine.drawn(family, FIRST_INSTANCE + number * len(CAUSES) + list(CAUSES).index(cause))
    hidden = CAUSES[cause](machine, rng)
    response = of_change(machine, hidden, rng.uniform(*CHANGE))
    noise = Noise(RELATIVES[number % len(RELATIVES)], FLOOR * float(np.median(np.abs(response))))
    noisy = observe(response, "complex", noise, rng)
    problem = machine.problem
    measurement = Measurement(problem.speed, problem.channels, noisy, None, cause)
    case = Case(problem, measurement)
    effects, _ = library([], list(WITHOUT[CAUSES[cause]]), measurement, problem)
    options = DiagnosisOptions(average=False, split=False)
    started = time.process_time()
    record = diagnosis(case, effects, rng, options=options)
    seconds = time.process_time() - started
    return (
        {"cause": cause, "number": number, "family": family, "position": hidden.position}
        | _found(record, hidden, seconds)
        | _explained(record, measurement, response, noise)
        | _coefficients(record, machine)
    )


def _explained(
    record: DiagnosisRecord, measurement: Measurement, response: ComplexArray, noise: Noise
) -> dict[str, Any]:
    """How far the deviance of the explanation is above that of the true response."""
    if record.curves is None or record.curves.responses.after is None:
        return {"behind": np.nan}
    real, imaginary = np.moveaxis(np.array(record.curves.responses.after), -1, 0)
    explained = least_deviance(measurement, real + 1j * imaginary, noise)
    return {"behind": explained - least_deviance(measurement, response, noise)}


def least_deviance(measurement: Measurement, response: ComplexArray, noise: Noise) -> float:
    """Deviance of data from a response with the noise that makes it least, sought from a level near it."""
    squared, amplitude = np.abs(measurement.values - response) ** 2, np.abs(response)

    def of_noise(log_level: Array) -> float:
        variance = Noise(*np.exp(log_level)).variance(amplitude)
        return float(deviance(squared, variance, 1.0, measurement.kind))

    return float(minimize(of_noise, np.log([noise.relative, noise.floor]), method="Nelder-Mead").fun)


def _coefficients(record: DiagnosisRecord, machine: Machine) -> dict[str, Any]:
    """Numbers of intervals of an explained model's unknowns, and of those that hold the true value."""
    after = {each.name: each.after for each in record.coefficients if each.after is not None}
    true = dict(zip(machine.problem.parameters.names, machine.x, strict=True))
    scale = {each.name: each.si_per_unit for each in machine.problem.parameters}
    held = [after[name].holds(value / scale[name]) for name, value in true.items() if name in after]
    return {"compared": len(held), "held": sum(held)}


def _found(record: DiagnosisRecord, hidden: Cause, seconds: float) -> dict[str, Any]:
    """The verdict, the place and the misfit, compared with the hidden cause."""
    best, where = next(iter(record.ranking), None), record.location
    drop = best.deviance_drop if best is not None else 0.0
    if where is not None:
        drop = max(drop, where.plain.chi2 - where.plain.n_left)
    return {
        "verdict": record.verdict,
        "named": " ".join(record.named),
        "group": " ".join(record.ambiguity_group),
        "drop": drop,
        "is_located": where is not None,
        "place_accepted": np.nan if where is None else where.accepts(hidden.position),
        "share": np.nan if where is None else np.mean([site.accepted for site in where.candidates]),
        "sites": "" if where is None else "; ".join(map(str, where.sites)),
        "law": "" if where is None or where.law is None else where.law.key,
        "seconds": seconds,
    }


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """A line per cause and one for all: counts of clearly visible draws."""
    groups = [*rows.groupby("cause", sort=False), ("all", rows)]
    return pd.DataFrame([{"cause": name, **_counts(mine)} for name, mine in groups])


def _counts(mine: pd.DataFrame) -> dict[str, Any]:
    clear = mine[(mine["drop"] >= CLEAR) & ~mine["verdict"].isin(["adequate", "not observable"])]
    honest = int(clear["verdict"].isin(["located", "unknown"]).sum())
    alike = int((clear["behind"] <= TIE).sum())
    with_place = clear[clear["is_located"]]
    right = int(with_place["place_accepted"].astype(bool).sum())
    return {
        "draws": len(mine),
        "clear": len(clear),
        **{
            verdict: int((clear["verdict"] == verdict).sum())
            for verdict in ("located", "unknown", "ambiguous", "named")
        },
        "alike": alike,
        "honest": rate(honest, len(clear)),
        "honest of unlike": rate(honest, len(clear) - alike),
        "held": rate(int(clear["held"].sum()), int(clear["compared"].sum())),
        "right place": rate(right, len(with_place)),
        "share": with_place["share"].median(),
        "seconds": mine["seconds"].median(),
        "most": mine["seconds"].max(),
    }


def main(arguments: list[str]) -> None:
    rows = rows_of(arguments, COLUMNS, row, CAUSES)
    print(summary(rows.sort_values("number")).to_string(index=False, float_format="{:.3g}".format))


COLUMNS = [
    *("cause", "number", "family", "position", "verdict", "named", "group", "drop"),
    *("is_located", "place_accepted", "share", "sites", "law", "seconds"),
    *("behind", "compared", "held"),
]

if __name__ == "__main__":
    main(sys.argv[1:])

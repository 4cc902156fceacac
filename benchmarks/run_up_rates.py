"""Rates at which a diagnosis names a sweep of the speed, and takes steady data for one.

The rate must be in the interval.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.run_up_rates 30 50 rows.csv
    python -m benchmarks.run_up_rates rows.csv

The first makes the draws that the file lacks, 30 sweeps and 50 steady runs of each rotor in two processes; both print a table.
Rates are log-uniform over a decade around δ², δ the half-width of the first peak, at which a peak is shifted by about its width;
either direction, which the diagnosis is told. Complex data, 5 % noise and a floor of 0.1 µm, neither of which the fit is told.

- rk4_two_disk: four probes, 40 speeds; sweeps are integrated over time (6 modes), steady data are of 56 elements;
- three_disk: three planes in x and y, 109 speeds from 375 to 402 rad/s, through the first two critical speeds; data are of 26 elements
  by the closed form, as integration over the minutes of such a sweep takes hours.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.resumed import add_missing_rows
from ksmea.arrays import Array, ComplexArray
from ksmea.diagnosis.diagnosis import diagnose
from ksmea.fits.search import Search
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.speeds import DIRECTIONS, SpeedHistory
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.rk4_two_disk import RK4TwoDisk
from problems.rotor.response.problem import RotorProblem
from problems.three_disk import ThreeDisk
from tests.helpers.swept_rotor import swept_response

SWEEP = "run_up_acceleration"
EFFECTS = (SWEEP, "speed_dependent_damping", "speed_dependent_stiffness", "unbalance", "runout")
NOISE = Noise(0.05, 1e-7)
CLEAR = 60.0  # Δχ² of what is clearly visible
RK4 = {"sensors": [0.12, 0.44], "directions": ["x", "y"], "n_speed": 40}
THREE = {"sensors": [0.1, 0.5, 1.0], "speed_from": 375.0, "speed_to": 402.0, "n_speed": 109}
ROTORS = {  # fitted, making data, δ in rad/s
    "rk4_two_disk": (RK4TwoDisk(**RK4), RK4TwoDisk(mesh=56, **RK4), 6.9),
    "three_disk": (ThreeDisk(**THREE), ThreeDisk(mesh=26, **THREE), 0.175),
}
COLUMNS = ["rotor", "sweeps", "seed", "seconds", "verdict", "applied", "group", "rate", "found", "low", "high", "drop"]


def response(rotor: str, made: RotorProblem, x: Array, rate: float) -> ComplexArray:
    """Response of the rotor, steady at a rate of 0, (n_speed, n_channel) m."""
    if not rate:
        return made.dense_response(x[None])[0]
    if rotor == "rk4_two_disk":
        return np.asarray(swept_response(made, x, rate, n_mode=6))
    effect = registry.create("effect", SWEEP, {})
    return np.asarray(effect.added_to(made).response(np.append(x, rate)[None])[0])


def row(rotor: str, sweeps: bool, seed: int) -> dict[str, Any]:
    """One draw and its diagnosis."""
    settings, finer, width = ROTORS[rotor]
    rng = np.random.default_rng([seed, sweeps, rotor == "three_disk"])
    problem, made = settings.build(), finer.build()
    x = np.array([settings.reference()[name] for name in problem.parameters.names])
    sign, size = rng.choice([-1.0, 1.0]), width**2 * 10 ** rng.uniform(-0.5, 0.5)
    rate = sign * size if sweeps else 0.0
    values = observe(response(rotor, made, x, rate), "complex", NOISE, rng)
    history = SpeedHistory(DIRECTIONS[int(sign < 0)])
    measurement = Measurement(problem.speed, problem.channels, values, None, "", history=history)
    effects = {name: registry.create("effect", name, {}).seen_in(measurement) for name in EFFECTS}
    started = time.process_time()
    found = diagnose(Case(problem, measurement), effects, Search(rng))
    line = {"rotor": rotor, "sweeps": sweeps, "seed": seed, "seconds": time.process_time() - started, "rate": rate}
    line |= {"verdict": found.verdict, "applied": " ".join(each.name for each in found.applied)}
    line |= {
        "group": " ".join(found.ambiguity_group),
        "drop": max(t.deviance_drop for t in found.trials if t.name == SWEEP),
    }
    if found.best is not None and found.best_estimate is not None and SWEEP in line["applied"]:
        index = found.best.problem.parameters.names.index("acceleration")
        interval = found.best_estimate.intervals[index]
        line |= {"found": found.best.x[index], "low": interval.low, "high": interval.high}
    return line


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """Summary, a line per rotor, of draws and diagnoses.

    It has the draws, the ones with Δχ² of 60 and more, and of these the ones alone named, in the group, with the rate
    in its 95 % interval; and the verdicts on steady data.
    """
    lines = []
    for rotor, mine in rows.fillna({"applied": "", "group": ""}).groupby("rotor"):
        clear = mine[mine["sweeps"] & (mine["drop"] >= CLEAR)]
        steady = mine[~mine["sweeps"]]
        inside = (clear["low"] <= clear["rate"]) & (clear["rate"] <= clear["high"])
        lines.append(
            {
                "rotor": rotor,
                "sweeps": int(mine["sweeps"].sum()),
                "clear": len(clear),
                "named alone": int(((clear["verdict"] == "named") & (clear["applied"] == SWEEP)).sum()),
                "in the group": int(clear["group"].str.contains(SWEEP).sum()),
                "rate in interval": f"{inside.sum()} of {clear['found'].notna().sum()}",
                "steady": len(steady),
                "called a sweep": int(steady["group"].str.contains(SWEEP).sum()),
                "adequate": int((steady["verdict"] == "adequate").sum()),
                "seconds": mine["seconds"].median(),
            }
        )
    return pd.DataFrame(lines)


def main(arguments: list[str]) -> None:
    path = Path(arguments[-1])
    if len(arguments) > 1:
        counts = {True: int(arguments[0]), False: int(arguments[1])}
        tasks = [
            (rotor, sweeps, seed) for sweeps in (False, True) for seed in range(counts[sweeps]) for rotor in ROTORS
        ]
        add_missing_rows(path, COLUMNS, row, tasks)
    print(summary(pd.read_csv(path)).set_index("rotor").T.to_string(float_format="{:.3g}".format))


if __name__ == "__main__":
    main(sys.argv[1:])

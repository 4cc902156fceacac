"""How often the measurement that an ambiguous diagnosis recommends makes the cause known.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.closing_the_loop 20 rows.csv [CAUSE …]
    python -m benchmarks.closing_the_loop rows.csv [figure.png]

The first makes draws that the file does not have yet, in two processes, and writes a row for each; both print the rates and what
failed, the second draws expected against achieved separations too. Three-disk rotor, complex data or amplitudes of one plane, 24 speeds,
3 to 7 % noise and a floor of 0.1 µm, which the fit is not told, nor where phases begin. The data come from the dense route with
26 elements and hide one effect of the library; its location and its size are drawn. Where the diagnosis is ambiguous and recommends
a measurement, that is made of the same rotor with noise of its own, and all data are diagnosed together.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import binomtest

from benchmarks.resumed import rows_of
from ksmea.arrays import Array
from ksmea.diagnosis.diagnosis import NEAR, Criteria, Diagnosis, diagnose
from ksmea.diagnosis.further_measurement import Split
from ksmea.diagnosis.trials import best_by_name
from ksmea.fits.search import Effort, Search
from ksmea.measurement.measurement import Layout, Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.show.charts.locators import plain_ticks
from ksmea.studies.library import library
from measurements.hidden_size import drawn_size
from problems.three_disk import ThreeDisk

FLOOR, RELATIVES = 1e-7, (0.03, 0.05, 0.07)
PLANES = (0.1, 0.5, 1.0)
N_SPEED = 24
REFERENCE = ThreeDisk().reference()
# What one plane of probes often leaves open; docs/diagnosis.md says which effects look alike. Mass and Young's modulus have the
# sizes that these effects draw: a change that moves the response by its own size is too small for its scale to show.
WHOLE_SHAFT = ("mass", "youngs_modulus")
CAUSES = (*WHOLE_SHAFT, "probe_rotation", "cross_coupling_symmetric", "speed_dependent_stiffness", "flexible_pedestal")
OTHERS = ("residual_bow", "runout", "unbalance", "unequal_bearings")  # further effects that are tried
LIBRARY = library([*CAUSES, *OTHERS], [])[0]
EFFORT = Effort(screening=1024, starts=6, scan=64, scan_values=8, effect_starts=3)  # less than half of the default


@dataclass(frozen=True)
class Machine:
    """A rotor that hides an effect, at the true values x (d,) SI of all of its unknowns, and its noise."""

    problem: Problem
    x: Array
    noise: Noise

    @classmethod
    def drawn(cls, cause: str, settings: ThreeDisk, layout: Layout, noise: Noise, rng: np.random.Generator) -> Machine:
        plain = aligned(settings.build(), layout)
        x = np.array([REFERENCE.get(name, 0.0) for name in plain.parameters.names])
        locations = list(registry.create("effect", cause, {}).locations(plain))
        effect = locations[rng.integers(len(locations))]
        size = (
            effect.draw(plain, rng)
            if cause in WHOLE_SHAFT
            else drawn_size(effect, plain, x, Observable(layout.kind), rng)
        )
        return cls(effect.added_to(plain), np.append(x, size), noise)

    def measured(self, layout: Layout, rng: np.random.Generator) -> Measurement:
        response = aligned(self.problem, layout).dense_response(self.x[None])[0]
        values = observe(response, layout.kind, self.noise, rng)
        return Measurement(layout.speed, layout.channels, values, None, "made", layout.phase_known, layout.campaign)


def with_further(first: Measurement, both: Measurement) -> Measurement:
    """All data, those that were there already as they were."""
    values = both.values.copy()
    values[: first.values.shape[0], : first.values.shape[1]] = first.values
    return Measurement(both.speed, both.channels, values, None, "made", both.phase_known, both.campaign)


def row(cause: str, seed: int) -> dict[str, Any]:
    """One draw: what was hidden, what was found at first, what was recommended, and what was found then."""
    rng = np.random.default_rng([seed, *cause.encode()])
    kind, plane = str(rng.choice(["complex", "amplitude"])), float(rng.choice(PLANES))
    noise = Noise(float(rng.choice(RELATIVES)), FLOOR)
    settings = ThreeDisk(sensors=[plane], n_speed=N_SPEED)
    problem = settings.build()
    layout = Layout(problem.speed, problem.channels, kind, "made", phase_known=False)
    machine = Machine.drawn(cause, dataclasses.replace(settings, mesh=26), layout, noise, rng)
    started = time.process_time()
    first = machine.measured(layout, rng)
    before = diagnose(Case(aligned(problem, layout), first), LIBRARY, Search(rng, EFFORT), Criteria(n_block=2))
    found = {
        "cause": cause,
        "seed": seed,
        "kind": kind,
        "plane": plane,
        "relative": noise.relative,
    }
    found |= {
        "size": " ".join(f"{value:.4g}" for value in machine.x[len(machine.x) - n_unknown(cause, problem) :]),
        "deviance_drop": before.trials[0].deviance_drop,
        "first": before.verdict,
        "group": " ".join(before.ambiguity_group),
    }
    if before.split is not None:
        split = before.split
        all_data = with_further(first, machine.measured(split.layout, rng))
        after = diagnose(
            Case(aligned(problem, split.layout), all_data), LIBRARY, Search(rng, EFFORT), Criteria(n_block=2)
        )
        found |= _recommended(split, cause) | _closed(after, cause, before)
    return found | {"seconds": time.process_time() - started}


def n_unknown(cause: str, problem: Problem) -> int:
    return len(registry.create("effect", cause, {}).parameters(problem))


def _recommended(split: Split, cause: str) -> dict[str, Any]:
    """`expected` is the least separation of the truth from any other explanation."""
    of_truth = [pair for pair in split.pairs if cause in (pair.one, pair.other)]
    return {
        "recommended": split.measurement,
        "what": "weight" if split.weight else "planes" if "probes" in split.measurement else "speeds",
        "tells_all": not split.together,
        "together": "; ".join(f"{pair.one} {pair.other}" for pair in split.together),
        "now": min((pair.now for pair in of_truth), default=np.nan),
        "expected": min((pair.then for pair in of_truth), default=np.nan),
    }


def _closed(after: Diagnosis, cause: str, before: Diagnosis) -> dict[str, Any]:
    """Row on the second diagnosis of a draw.

    `achieved` is the deviance of the best other explanation of the first diagnosis above the true one's.
    """
    deviances = {name: trial.fit.deviance for name, trial in best_by_name(after.trials).items()}
    others = [deviances[name] for name in before.ambiguity_group if name != cause and name in deviances]
    return {
        "second": after.verdict,
        "second_named": " ".join(after.named),
        "second_group": " ".join(after.ambiguity_group),
        "achieved": min(others, default=np.nan) - deviances[cause],
        "lack_of_fit_p": np.nan if after.best_quality is None else after.best_quality.p,
        "closed": after.verdict == "named" and after.named == (cause,),
    }


def rates(rows: pd.DataFrame) -> str:
    """Outcome of the ambiguous draws, by recommendation and by cause.

    Each draw that did not end with the truth follows.
    """
    ambiguous = rows[rows["first"] == "ambiguous"]
    recommended = ambiguous[ambiguous["recommended"].notna()]
    of_all = recommended[recommended["tells_all"].eq(True)]
    apart = (of_all["achieved"] - of_all["expected"]) / (2 * np.sqrt(of_all["expected"]))
    failed = recommended[~recommended["closed"].eq(True)]
    return "\n".join(
        [
            f"{len(rows)} draws, {len(ambiguous)} ambiguous, {len(recommended)} with a recommended measurement",
            _line("said to tell all apart", of_all),
            *(_line(f"  {what}", mine) for what, mine in of_all.groupby("what")),
            *(_line(f"  {cause}", mine) for cause, mine in of_all.groupby("cause")),
            _line("said to tell some apart", recommended[recommended["tells_all"].eq(False)]),
            _line("all ambiguous", ambiguous),
            (
                f"achieved / expected: median {(of_all['achieved'] / of_all['expected']).median():.2f}; difference over the noise of"
                f" a draw: median {apart.median():.2f}, quartiles {apart.quantile(0.25):.2f} and {apart.quantile(0.75):.2f}"
            ),
            "",
            failed[["cause", "seed", "what", "together", "expected", "achieved", "second", "second_group"]].to_string(),
        ]
    )


def _line(name: str, rows: pd.DataFrame) -> str:
    if rows.empty:
        return f"{name}: none"
    closed = int(rows["closed"].eq(True).sum())
    low, high = binomtest(closed, len(rows)).proportion_ci(method="wilson")
    return f"{name}: named right {closed} of {len(rows)} ({100 * closed / len(rows):.0f} %, {100 * low:.0f} to {100 * high:.0f})"


def figure(rows: pd.DataFrame) -> Figure:
    """Achieved over expected separation of the truth from its nearest rival, with the noise of one draw."""
    made = Figure(figsize=(6, 5), layout="constrained")
    axes = made.subplots()
    told = rows[rows["expected"].gt(1) & rows["achieved"].gt(1)]
    line = np.geomspace(told["expected"].min(), told["expected"].max())
    axes.fill_between(line, np.maximum(line - 4 * np.sqrt(line), 1), line + 4 * np.sqrt(line), color="0.9", label="2 σ")
    axes.axline((100, 100), slope=1, color="0.6", lw=1)
    axes.axhline(NEAR, color="0.6", lw=1, ls=":", label="ambiguous below")
    for what, mine in told.groupby("what"):
        axes.scatter(mine["expected"], mine["achieved"], s=18, label=f"recommended: {what}")
    failed = told[~told["closed"].eq(True)]
    axes.scatter(failed["expected"], failed["achieved"], s=70, facecolors="none", edgecolors="k", label="not named")
    axes.set(xscale="log", yscale="log", xlabel="expected Δχ²", ylabel="achieved Δχ²")
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.legend(frameon=False)
    return made


def main(arguments: list[str]) -> None:
    rows = rows_of(arguments, COLUMNS, row, CAUSES)
    print(rates(rows))
    if not arguments[0].isdigit() and len(arguments) > 1:
        figure(rows).savefig(arguments[1], dpi=110)


COLUMNS = [
    *("cause", "seed", "kind", "plane", "relative", "size", "deviance_drop", "first", "group"),
    *("recommended", "what", "tells_all", "together", "now", "expected"),
    *("second", "second_named", "second_group", "achieved", "lack_of_fit_p", "closed", "seconds"),
]
if __name__ == "__main__":
    main(sys.argv[1:])

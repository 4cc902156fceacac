"""Scans that find better fits than nearby ones, and residuals of the nearby fits by then.

If these are noise already, a diagnosis leaves scans out.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.nearby_scans 40 > nearby_scans.csv

Each draw hides one effect in the three-disk rotor, complex data or amplitudes with known noise or none stated, such that a fit
without it leaves a deviance of 40 to 1000. All effects are fitted from nearby and refined twice, with first scans and without.
`explained` says whether the best effect then leaves noise behind without them. `gain` is how much lower scans get any effect that then lies within the margin of the best, `changed` says whether another set of effects
lies within it.
"""

from __future__ import annotations

import csv
import sys

import numpy as np

import ksmea
from ksmea.diagnosis.trials import NEAR, Trial, candidates, fitted, refined
from ksmea.fits.fitting import fit_baseline, polished
from ksmea.fits.lack_of_fit import fit_quality
from ksmea.fits.search import Effort, Search
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.studies.library import library

EFFECTS = (
    "residual_bow", "runout", "unbalance", "cross_coupling_antisymmetric", "cross_coupling_symmetric",
    "speed_dependent_stiffness", "speed_dependent_damping", "flexible_pedestal", "youngs_modulus", "mass", "channel_gain",
    "probe_rotation", "unequal_bearings", "internal_damping", "external_damping", "coupling_misalignment", "skewed_disk",
    "timing_delay", "foundation_resonance", "annular_seal", "added_mass", "axial_force", "shear_theory", "hub_stiffening",
)  # fmt: skip
DROPS = (40.0, 80.0, 150.0, 400.0, 1000.0)
LEVEL = 0.005  # of the test of lack of fit, as half of 1 %


Drops = dict[tuple[str, str], float]  # by effect and location


def drops(trials: list[Trial]) -> Drops:
    return {(trial.name, trial.location): trial.deviance_drop for trial in trials}


def near_best(drops: Drops) -> set[tuple[str, str]]:
    """The trials that come within the margin of the best."""
    return {place for place, drop in drops.items() if drop > max(drops.values()) - NEAR}


def compared(seed: int) -> list[object]:
    """One draw."""
    rng = np.random.default_rng([seed, 5])
    effect, drop, kind = str(rng.choice(EFFECTS)), float(rng.choice(DROPS)), str(rng.choice(["complex", "amplitude"]))
    loaded = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    is_known = bool(rng.integers(2))
    hiding = {"hidden": [effect], "expected_drop": drop, "noise_known": is_known}
    measurement = ksmea.synthetic_measurement(loaded, relative=0.05, kind=kind, rng=seed, **hiding).measurement
    problem, effort = aligned(loaded.problem, measurement), Effort()
    baseline = fit_baseline(Case(problem, measurement), Search(rng, effort))
    found = candidates(problem, library((), (), measurement)[0])
    trials = fitted(baseline.best, found, Search(rng, effort))

    def by(is_scanned: bool) -> list[Trial]:
        return refined(trials, baseline, Search(rng).with_effort(effort.of_first_scans, is_scanned=is_scanned))

    from_nearby = by(False)
    explained = fit_quality(polished(from_nearby[0].fit), rng).p >= LEVEL
    scanned, nearby = drops(by(True)), drops(from_nearby)
    gain = max(scanned[place] - nearby[place] for place in near_best(scanned))
    changed = near_best(scanned) != near_best(nearby)
    return [seed, effect, kind, drop, explained, f"{max(nearby.values()):.1f}", f"{gain:.2f}", changed]


def main() -> None:
    table = csv.writer(sys.stdout)
    table.writerow(["seed", "hidden", "kind", "expected_drop", "explained", "drop_of_best_nearby", "gain", "changed"])
    for seed in range(int(sys.argv[1])):
        table.writerow(compared(seed))
        sys.stdout.flush()


if __name__ == "__main__":
    main()

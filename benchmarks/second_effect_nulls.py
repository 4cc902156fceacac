"""How often a second effect is called significant beside the only one that the data hide.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.second_effect_nulls 40

Three-disk rotor, probes in x and y at three places, complex data with 5 % noise and a floor of 0.1 µm, both unknown, made with 26
elements by the dense solver. One runout of 1 µm is hidden at a plane that is drawn, its fit starts from the truth, and all other
candidates of the library are fitted beside it. Where the correction for their number is right, the smallest p is below 5 % in
5 % of draws at most.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.stats import binomtest

from ksmea.diagnosis.second_effects import pairs_beside
from ksmea.diagnosis.trials import candidates, trial_of
from ksmea.fits.fitting import BaselineFits, fit_from_values, fit_nearby
from ksmea.fits.search import Search
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import ranked
from ksmea.problem.case import Case
from ksmea.studies.library import library
from problems.three_disk import ThreeDisk

SENSORS, NOISE, SIZE = [0.1, 0.2, 0.5], Noise(0.05, 1e-7), 1e-6
LEVEL = 0.05  # of the smallest p: high enough for some tens of draws to say something


def smallest_p(seed: int) -> float:
    """Of all second effects beside a runout, corrected for their number."""
    rng, settings = np.random.default_rng(seed), ThreeDisk(sensors=SENSORS)
    fine, rotor = (ThreeDisk(sensors=SENSORS, mesh=mesh).build() for mesh in (26, settings.mesh))
    found = candidates(rotor, library((), ("run_up_acceleration",))[0])
    places = [candidate for candidate in found if candidate.name == "runout"]
    hidden, angle = places[rng.integers(len(places))], rng.uniform(0, 2 * np.pi)
    own = np.array([settings.reference()[name] for name in rotor.parameters.names])
    x = np.append(own, SIZE * np.array([np.cos(angle), np.sin(angle)]))
    values = observe(hidden.effect.added_to(fine).dense_response(x[None])[0], "complex", NOISE, rng)
    measurement = Measurement(rotor.speed, rotor.channels, values, None, "made")
    baseline = fit_from_values(Case(rotor, measurement), own)
    first = trial_of(hidden, fit_from_values(Case(hidden.effect.added_to(rotor), measurement), x), baseline, len(found))
    trials = [trial_of(each, fit_nearby(each.effect.added_to(rotor), baseline), baseline, len(found)) for each in found]
    fits = BaselineFits(baseline, (), ranked(baseline.u[None], np.zeros(1)))
    pairs = pairs_beside([first], trials, fits, Search(np.random.default_rng(seed)), is_scanned=False)
    return min(pair.p for pair in pairs)


if __name__ == "__main__":
    p = np.array([smallest_p(seed) for seed in range(int(sys.argv[1]))])
    below = int(np.sum(p < LEVEL))
    interval = binomtest(below, len(p)).proportion_ci(0.95, method="wilson")
    print(f"smallest p below {LEVEL:.0%}: {below} of {len(p)}, 95 % interval {interval.low:.1%} to {interval.high:.1%}")
    print(f"smallest of all: {np.min(p):.2g}")

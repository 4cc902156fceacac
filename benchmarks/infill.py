"""Cost of infills: true evaluations until the misfit is within a 95 % region of its minimum.

    python benchmarks/infill.py 40 20      # samples, repetitions

Three-disk rotor, 10 % noise on amplitudes, the misfit `log`, Kriging and DE. A region of 95 % in five unknowns reaches to where
the misfit is 11.07 above its minimum: errors as large as the CRLB. The minimum is that of least squares from the true values,
which only this count knows. All infills of a repetition have the same noise and initial samples; the paper's stopping rules
are off. A run that does not get there in 30 updating steps counts as slower than all that do.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.stats import chi2

from ksmea.identification.ksmea import KSMEA
from ksmea.identification.true_model import model_objective
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.numerics.least_squares import descend
from ksmea.numerics.screening import latin_hypercube
from ksmea.plugins.identification import Streams
from ksmea.problem.counted import Model
from optimizers.de import DE
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging

NOISE = Noise(0.1, 0.0)
UPDATES = 30
INFILLS = ("optimum", "expected_improvement")


def streams(seed: int) -> Streams:
    return Streams(*(np.random.default_rng([seed, part]) for part in range(3)))


def evaluations_needed(seed: int, samples: int, infill: str) -> float:
    """True evaluations until the misfit is within the region; inf where it was not reached."""
    rotor, truth = ThreeDisk().build(), np.array(list(ThreeDisk().reference().values()))
    values = observe(rotor.response(truth[None])[0], "amplitude", NOISE, np.random.default_rng([seed, 3]))
    measurement = Measurement(rotor.speed, rotor.channels, values, NOISE, "three_disk")
    misfit = Misfit(measurement, "log")
    objective = model_objective(Model(rotor, None, 0), misfit, None)
    descend(objective, rotor.parameters.to_cube(truth), max_iterations=100)
    reached = objective.result().value + chi2.ppf(0.95, len(truth))

    initial = latin_hypercube(samples, len(truth), streams(seed).design)
    if np.min(misfit.value(misfit.observed(rotor.response(rotor.parameters.to_si(initial))))) <= reached:
        return samples
    method = KSMEA(
        Kriging(), DE(population=60, generations=40), samples, smc=1.0, sdf=0.0, max_updates=UPDATES, infill=infill
    )
    history = method.identify(rotor, measurement, streams(seed)).history
    return next((samples + k for k, update in enumerate(history, start=1) if update.misfit <= reached), np.inf)


def main(samples: int, repetitions: int) -> None:
    for infill in INFILLS:
        needed = np.array([evaluations_needed(seed, samples, infill) for seed in range(repetitions)])
        lower, median, upper = np.quantile(needed, [0.25, 0.5, 0.75], method="inverted_cdf")
        print(
            f"{samples} samples, {infill}: median {median:g}, quartiles {lower:g} to {upper:g},"
            f" {np.sum(np.isfinite(needed))} of {repetitions} got there; {needed}",
            flush=True,
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

"""Remarks of a diagnosis on readings: slow roll that the accepted model does not predict, and a gain that is a unit."""

from __future__ import annotations

import numpy as np

from ksmea.diagnosis.diagnosis import Diagnosis
from ksmea.studies.misreadings import first_criticals, unit_of_gain
from ksmea.units import DEGREE, MICROMETRE, RPM

GAIN = "channel_gain"  # the effect whose size may be a unit
SLOW = 0.3  # of the first critical speed: below, a shaft follows its unbalance by less than 10 % of the eccentricity
FEWEST_SLOW = 3  # rows there that a slow-roll vector is read from
CHANCE = 0.0027  # beyond 3 σ, shared by all probes, of a vector that noise alone makes


def slow_roll_remarks(found: Diagnosis) -> tuple[str, ...]:
    """The mean vector of each probe at low speed that the accepted model does not predict, if it exceeds the noise; nothing of
    amplitudes, and without rows below SLOW times the first critical speed."""
    accepted = found.named and found.best is not None
    fit = found.best if accepted and found.best is not None else found.baseline
    measurement, plain = fit.measurement, found.baseline
    criticals = first_criticals(plain.problem, plain.x, float(np.max(measurement.speed)))
    if measurement.is_amplitude or measurement.is_by_differences or criticals is None or not len(criticals):
        return ()
    slow = measurement.speed < SLOW * criticals[0]
    if np.count_nonzero(slow) < FEWEST_SLOW:
        return ()
    response = fit.response()
    weight = fit.noise.sd(np.abs(response))[slow] ** -2  # (n_slow, n_channel), m⁻²
    mean = np.sum(weight * (measurement.values - response)[slow], axis=0) / np.sum(weight, axis=0)
    deviations = np.abs(mean) * np.sqrt(2 * np.sum(weight, axis=0))  # noise is that of both parts together
    exceeds = np.sqrt(2 * np.log(len(measurement.channels) / CHANCE))  # of a Rayleigh distribution
    rows = f"mean of {np.count_nonzero(slow)} rows up to {np.max(measurement.speed[slow]) / RPM:.0f} rpm"
    return tuple(
        f"slow roll of probe {channel}: {abs(vector) / MICROMETRE:.2g} µm at {np.angle(vector) / DEGREE:.0f}° that the model does not"
        f" predict ({rows}, {size:.0f} σ); subtract it, or diagnose with runout and bow among the effects"
        for channel, vector, size in zip(measurement.channels, mean, deviations)
        if channel.is_1x and size > exceeds
    )


def gain_remarks(found: Diagnosis) -> tuple[str, ...]:
    """The unit that a gain of the accepted model is the factor of."""
    if not found.named or found.best is None:
        return ()
    values = dict(zip(found.best.problem.parameters.names, found.best.x, strict=True))
    said = []
    for candidate in found.applied:
        sizes = [size for name, size in values.items() if candidate.name == GAIN and name.startswith(GAIN)]
        said += [
            f"a gain of {1 + size:.3g} ({candidate.effect}) is that of another unit: {unit}; check its scale, or the plane that it"
            " is compared with"
            for size in sizes
            if (unit := unit_of_gain(1 + size))
        ]
    return tuple(said)

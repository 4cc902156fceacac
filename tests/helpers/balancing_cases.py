"""Balancing jobs made by hand: a linear machine with two planes, several speeds and channels.

Runs carry any weights.
"""

import numpy as np

from ksmea.measurement.campaign import Campaign, Run, UnknownWeight, Weight
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.units import DEGREE, GRAM_MILLIMETRE, MICROMETRE, RPM

PLANES = (0.2, 0.4)  # m
UNKNOWN = None


def campaign(runs, speed, time=None, noise=None, repeats=1):
    """Measurement of runs with weights and responses.

    A run is (name, {plane: complex weight in g mm or UNKNOWN}, response (n_speed · repeats, n_channel) in µm).
    """
    n_channel = np.shape(runs[0][2])[1]
    channels = tuple(Channel(0.1 * (1 + index), "x") for index in range(n_channel))
    speed = np.tile(np.repeat(speed, repeats), len(runs)) * RPM
    counted = tuple(run(name, on, len(values)) for name, on, values in runs)
    values = np.concatenate([np.asarray(values, dtype=complex) for _, _, values in runs]) * MICROMETRE
    return Measurement(speed, channels, values, noise, "made", False, Campaign(counted), time=time)


def run(name, on, n_speed):
    known = [
        Weight(position, abs(value) * GRAM_MILLIMETRE, float(np.angle(value)))
        for position, value in on.items()
        if value is not UNKNOWN
    ]
    unknown = [UnknownWeight(position) for position, value in on.items() if value is UNKNOWN]
    return Run(name, n_speed, tuple(known), unknown_weights=tuple(unknown))


def machine(rng, n_entry=4):
    """Bare response (n_entry,) µm and influence coefficients (2, n_entry) µm/(g mm)."""
    bare, one, two = rng.standard_normal((3, n_entry, 2)) @ np.array([1, 1j])
    return 10 * bare, np.array([one, two]) * 0.2


def polar(text):
    """A complex number of 'size@degrees'; what stands behind a space is a remark."""
    size, angle = text.split()[0].split("@")
    return float(size) * np.exp(1j * float(angle) * DEGREE)


def corrections(found):
    return np.array([size * np.exp(1j * angle * DEGREE) for size, angle in found.correction.values()])

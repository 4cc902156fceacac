"""A measurement as a table with the columns of the file that `measurement=file` reads."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ksmea.measurement.measurement import Measurement
from ksmea.units import DEGREE, MICROMETRE, RPM


def measurement_frame(measurement: Measurement) -> pd.DataFrame:
    """A row for each speed and channel. Columns `run`, `phase_lead_deg`, `sigma_um`, `time_s` and `harmonic` only if the data have them."""
    shape = measurement.values.shape
    channels = measurement.channels
    columns = {
        "speed_rpm": measurement.speed[:, None] / RPM,
        "position_m": np.array([channel.position for channel in channels]),
        "direction": np.array([channel.direction for channel in channels], dtype=object),
        "amplitude_um_0pk": np.abs(measurement.values) / MICROMETRE,
    }
    if not measurement.is_amplitude:
        columns["phase_lead_deg"] = np.angle(measurement.values) / DEGREE
    if measurement.noise is not None and measurement.has_noise:
        columns["sigma_um"] = measurement.noise.sd(np.abs(measurement.values)) / MICROMETRE
    if measurement.time is not None:
        columns["time_s"] = measurement.time[:, None]
    if not all(channel.is_1x for channel in channels):
        columns["harmonic"] = np.array([channel.harmonic for channel in channels])
    if measurement.campaign is not None:
        runs = measurement.campaign.runs
        names = np.repeat(np.array([run.name for run in runs], dtype=object), [run.n_speed for run in runs])
        columns = {"run": names[:, None], **columns}
    return pd.DataFrame({name: np.broadcast_to(values, shape).ravel() for name, values in columns.items()})

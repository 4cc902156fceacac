"""A measurement written as the file that `measurement=file` reads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement import Measurement
from ksmea.units import DEGREE, MICROMETRE, RPM
from measurements.run_up_rows import REQUIRED


def as_csv(measurement: Measurement, remarks: Sequence[str] = (), time: Array | None = None) -> str:
    """A measurement as such a file, in the order of its speeds, or of `time` (n_speed,) s; the way back is exact to eight
    digits. Noise that is known becomes `sigma_um`."""
    noise = measurement.noise
    optional = {
        "phase_lead_deg": None if measurement.is_amplitude else np.angle(measurement.values) / DEGREE,
        "sigma_um": None if noise is None or noise.is_absent else noise.sd(np.abs(measurement.values)) / MICROMETRE,
        "time_s": None if time is None else np.broadcast_to(time[:, None], measurement.values.shape),
    }
    if not all(channel.is_1x for channel in measurement.channels):
        harmonics = np.array([channel.harmonic for channel in measurement.channels])
        optional["harmonic"] = np.broadcast_to(harmonics, measurement.values.shape)
    amplitude = np.abs(measurement.values) / MICROMETRE
    order = np.arange(len(measurement.speed)) if time is None else np.argsort(time, kind="stable")
    lines = [*(f"# {remark}" for remark in remarks), ",".join((*REQUIRED, *optional))]
    for speed in order:
        for index, channel in enumerate(measurement.channels):
            numbers = [
                amplitude[speed, index],
                *(None if part is None else part[speed, index] for part in optional.values()),
            ]
            cells = ["" if number is None else f"{number:.8g}" for number in numbers]
            where = [f"{measurement.speed[speed] / RPM:.10g}", f"{channel.position:.10g}", channel.direction]
            lines.append(",".join([*where, *cells]))
    return "\n".join(lines) + "\n"

"""A measurement, or rows that were read, written as the file that `measurement=file` reads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.measurement import Measurement
from ksmea.units import DEGREE, MICROMETRE, RPM
from measurements.run_up_rows import REQUIRED, Rows


def rows_as_csv(rows: Rows, remarks: Iterable[str] = ()) -> str:
    """The rows of one run as such a file, in their order; the way back is exact to the last bit."""
    optional = {
        "phase_lead_deg": rows.phase,
        "sigma_um": rows.sigma,
        "time_s": rows.time,
        "harmonic": None if all(harmonic == 1 for *_, harmonic in rows.channel) else [each[2] for each in rows.channel],
    }
    columns = [(name, values) for name, values in optional.items() if values is not None]
    lines = [*(f"# {remark}" for remark in remarks), ",".join((*REQUIRED, *(name for name, _ in columns)))]
    for index, (speed, (position, direction, _), amplitude) in enumerate(zip(rows.speed, rows.channel, rows.amplitude)):
        numbers = (_exact(values[index]) for _, values in columns)
        lines.append(",".join([_exact(speed), _exact(position), direction, _exact(amplitude), *numbers]))
    return "\n".join(lines) + "\n"


def _exact(number: float) -> str:
    """The shortest text that is read as the same number."""
    return repr(float(number)).removesuffix(".0")


def as_csv(measurement: Measurement, remarks: Sequence[str] = (), time: Array | None = None) -> str:
    """A measurement as such a file, in the order of its speeds, or of `time` (n_speed,) s.

    The way back is exact to eight digits. Noise that is known becomes `sigma_um`.
    """
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

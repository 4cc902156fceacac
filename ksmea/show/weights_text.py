"""Unknown weights, correction weights and influence coefficients as sentences and tables.

Correction weights cancel the unbalance.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ksmea.measurement.notation import LAG, Notation
from ksmea.records.curves import as_array
from ksmea.records.weights import VectorRecord, WeightsRecord
from ksmea.show.readings import PLAIN, deviation_unit, vibration_unit
from ksmea.show.text import fixed, number, rounded_alike
from ksmea.units import DEGREE, MICROMETRE, RPM, TURN

USUAL = "g mm"
ANGLES = "Angles of weights count in the direction of rotation; phases of vibrations are lags"
NO_WIDTH = 1e-6  # of the unit, or degrees: an interval of less is that of exact data, and is left out


def lines(record: WeightsRecord, notation: Notation = PLAIN) -> Iterator[str]:
    """Lines for each weight found, for the correction weights, and for the expected vibration with them."""
    for weight in record.weights:
        yield f"weight in run {weight.run} {_vector(weight)}"
    if record.corrections:
        yield f"weights that cancel the identified unbalance: {'; '.join(map(_vector, record.corrections))}"
        unit, name = vibration_unit(notation), deviation_unit(notation)
        parts = ", ".join(
            f"{notation.name(channel)} {number(before / unit, 3)} to {number(after / unit, 2)}"
            for channel, before, after in zip(record.channels, record.before, record.after)
        )
        yield f"with them the largest 1X at the measured speeds is expected to fall ({name}): {parts}"
    if notation.phase == LAG and (record.weights or record.corrections):
        yield f"{ANGLES[0].lower()}{ANGLES[1:]}"


def _vector(vector: VectorRecord) -> str:
    """For example 'at 1 m (disk 2): 150.2 g mm [148.1, 152.4] at 59.8° [59.0, 60.5]'."""
    at = f"at {vector.position:g} m" + (f" ({vector.plane})" if vector.plane else "")
    sizes = (vector.size, vector.size_low, vector.size_high)
    size, unit = _with_ends(*(each / vector.weight_unit_si for each in sizes)), f" {vector.weight_unit}"
    if vector.angle_low is None or vector.angle_high is None:
        return f"{at}: {_with_unit(size, unit)} at any angle"
    turn = TURN if vector.angle <= -TURN / 2 + 1e-6 else 0.0  # 180° rather than −180°
    angle = _with_ends(*((each + turn) / DEGREE for each in (vector.angle, vector.angle_low, vector.angle_high)))
    return f"{at}: {_with_unit(size, unit)} at {_with_unit(angle, '°')}"


def _with_ends(value: float, low: float, high: float) -> tuple[str, str]:
    if high - low <= NO_WIDTH:
        return fixed(value, 1), ""
    at, least, most = rounded_alike(value, low, high)
    return at, f" [{least}, {most}]"


def _with_unit(parts: tuple[str, str], unit: str) -> str:
    value, ends = parts
    return f"{value}{unit}{ends}"


def frame(record: WeightsRecord) -> pd.DataFrame:
    """Size and angle of each weight found and each correction weight, as rows of the table of unknowns."""
    rows = []
    for role, vectors in (("weight", record.weights), ("correction", record.corrections)):
        for vector in vectors:
            name = f"{role} at {vector.position:g} m" + (f"@{vector.run}" if vector.run else "")
            size = (vector.size, vector.size_low, vector.size_high)
            angle = (vector.angle, vector.angle_low, vector.angle_high)
            for what, unit, si, values in (
                ("size", vector.weight_unit, vector.weight_unit_si, size),
                ("angle", "deg", DEGREE, angle),
            ):
                value, low, high = (np.nan if each is None else each / si for each in values)
                rows.append((f"{name}, {what}", unit, value, low, high, "region"))
    return pd.DataFrame(rows, columns=["parameter", "unit", "value", "low", "high", "kind"])


def influence_frame(record: WeightsRecord) -> pd.DataFrame:
    """A row per plane, speed and channel.

    The influence coefficient per unit of weights with standard errors; 1 µm/(g mm) is 1 m/(kg m). Without weights in g
    mm, `unit` names the unit of each row.
    """
    units = {plane.weight_unit for plane in record.influence}
    name = "influence_um_per_g_mm" if units <= {USUAL} else "influence"
    size = {plane.position: plane.weight_unit_si / MICROMETRE for plane in record.influence}
    speed = as_array((record.speed,))[0] / RPM
    rows = [
        {
            "plane_m": plane.position,
            "plane": plane.plane,
            "speed_rpm": speed[line],
            "channel": channel,
            name: amplitude[line, column] * size[plane.position],
            "phase_lead_deg": phase[line, column] / DEGREE,
            "influence_se": amplitude_sd[line, column] * size[plane.position],
            "phase_se_deg": phase_sd[line, column] / DEGREE,
            **({} if units <= {USUAL} else {"unit": f"µm/({plane.weight_unit})"}),
        }
        for plane in record.influence
        for amplitude, phase, amplitude_sd, phase_sd in [
            [as_array(part) for part in (plane.amplitude, plane.phase, plane.amplitude_sd, plane.phase_sd)]
        ]
        for line in range(len(speed))
        for column, channel in enumerate(record.channels)
    ]
    return pd.DataFrame(rows)

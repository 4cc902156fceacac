"""Responses of a model as lines over speed: rpm, µm and degrees, broken where a further run begins or a phase jumps by a turn."""
# Shorter than 40 lines: two figures share it.

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ksmea.arrays import Array
from ksmea.records.curves import FineCurve, Matrix, as_array
from ksmea.show.figures.style import broken
from ksmea.units import DEGREE, MICROMETRE, RPM

JUMP = 1.9 * np.pi  # of a wrapped phase, where its line is broken
AMPLITUDE, PHASE = "amplitude (µm 0-peak)", "phase lead (°)"  # labels


def amplitude_line(curve: FineCurve, channel: int) -> tuple[Array, Array]:
    """rpm and µm."""
    amplitude = column(curve.amplitude, channel) / MICROMETRE
    return broken(as_array(curve.speed) / RPM, curve.breaks), broken(amplitude, curve.breaks)


def phase_line(curve: FineCurve, channel: int) -> tuple[Array, Array]:
    """rpm and degrees."""
    phase = column(curve.phase, channel)
    unwrapped = np.where(np.abs(np.diff(phase, append=phase[-1])) > JUMP, np.nan, phase)
    return broken(as_array(curve.speed) / RPM, curve.breaks), broken(unwrapped / DEGREE, curve.breaks)


def phase_axis(panel: Axes) -> None:
    """From -180° to 180°, with room for markers."""
    panel.set_ylim(-190, 190)
    panel.set_yticks([-180, -90, 0, 90, 180])


def column(values: Matrix | None, channel: int) -> Array:
    """One channel of a matrix (n_speed, n_channel)."""
    of_channel: Array = as_array(values)[:, channel]
    return of_channel

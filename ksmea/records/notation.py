"""Notation of a measurement's own file: units, detection, sign of phases and names of probes. Data and records stay SI, 0-peak and lead."""
# Shorter than 40 lines of code: files write it, records keep it and texts show it.

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ksmea.records.record import Record
from ksmea.units import HERTZ, INCH, MICROMETRE, MILLIMETRE, RPM

AMPLITUDES = {"µm": MICROMETRE, "mm": MILLIMETRE, "mil": 1e-3 * INCH, "in": INCH, "m": 1.0}  # m
DETECTIONS = {"0-peak": 1.0, "pp": 2.0, "rms": math.sqrt(0.5)}  # times the amplitude
SPEEDS = {"rpm": RPM, "Hz": HERTZ, "rad/s": 1.0}  # rad/s
LEAD, LAG = "lead", "lag"
TURN = 360.0  # degrees


@dataclass(frozen=True)
class NotationRecord(Record):
    """Units and names that a reader knows from the measurement's file.

    >>> NotationRecord("mil", "pp", "lag").unit, NotationRecord("mil", "pp", "lag").vibration(25.4e-6)
    ('mil pp', 2.0)
    """

    amplitude: str = "µm"  # one of AMPLITUDES
    detection: str = "0-peak"  # one of DETECTIONS
    phase: str = LEAD
    speed: str = "rpm"  # one of SPEEDS
    rotation: str = ""  # cw or ccw, as seen from the end that the file says; '' if it does not say
    names: Mapping[str, str] = field(default_factory=dict)  # of channels, such as 3X, by 'x at 0.1 m'

    @property
    def unit(self) -> str:
        return f"{self.amplitude} {self.detection}"

    def vibration(self, amplitude: float) -> float:
        """An amplitude (m, 0-peak) in `unit`."""
        return amplitude * DETECTIONS[self.detection] / AMPLITUDES[self.amplitude]

    def angle(self, lead: float) -> float:
        """A phase lead (degrees) as this notation counts it, from 0 to 360."""
        return (lead if self.phase == LEAD else -lead) % TURN

    def name(self, channel: str) -> str:
        """A channel's own name, or what it is called without one."""
        return self.names.get(channel, channel)

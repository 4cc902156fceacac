"""Notation of a measurement's own file: units, detection, sign of phases and names of probes.

Data stay SI, 0-peak and lead.

In words it is `mil_pp,lag,rpm`, and at the head of a file that `import` writes `shown as: mil_pp,lag,rpm; 3X = x at 0.1 m`.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ksmea.errors import SettingError, shortened
from ksmea.units import HERTZ, INCH, MICROMETRE, MILLIMETRE, RPM

AMPLITUDES = {"µm": MICROMETRE, "mm": MILLIMETRE, "mil": 1e-3 * INCH, "in": INCH, "m": 1.0}  # m
DETECTIONS = {"0-peak": 1.0, "pp": 2.0, "rms": math.sqrt(0.5)}  # times the amplitude
SPEEDS = {"rpm": RPM, "Hz": HERTZ, "rad/s": 1.0}  # rad/s
LEAD, LAG = "lead", "lag"
TURN = 360.0  # degrees
SPELT = {"um": "µm", "0pk": "0-peak", "thou": "mil"}  # other names of units
HEAD = "shown as: "  # of the line in a file
IN_FILE = re.compile(rf"^#\s*{HEAD}(.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Notation:
    """Units and names that a reader knows from the measurement's file.

    >>> Notation("mil", "pp", "lag").unit, Notation("mil", "pp", "lag").vibration(25.4e-6)
    ('mil pp', 2.0)
    """

    amplitude: str = "µm"  # one of AMPLITUDES
    detection: str = "0-peak"  # one of DETECTIONS
    phase: str = LEAD
    speed: str = "rpm"  # one of SPEEDS
    names: Mapping[str, str] = field(default_factory=dict)  # of channels, such as 3X, by 'x at 0.1 m'

    @property
    def unit(self) -> str:
        return f"{self.amplitude} {self.detection}"

    def vibration(self, amplitude: float) -> float:
        """An amplitude (m, 0-peak) in `unit`."""
        return float(amplitude * DETECTIONS[self.detection] / AMPLITUDES[self.amplitude])

    def angle(self, lead: float) -> float:
        """A phase lead (degrees) as this notation counts it, from 0 to 360."""
        return (lead if self.phase == LEAD else -lead) % TURN

    def name(self, channel: str) -> str:
        """A channel's own name, or what it is called without one."""
        return self.names.get(channel, channel)

    def with_words(self, words: str) -> Notation:
        """This notation with the units that words say, such as 'mil_pp,lag'; names stay.

        >>> Notation().with_words("mil_pp,lag").unit
        'mil pp'
        """
        found = self
        for word in filter(None, re.split(r"[,\s]+", words)):
            found = dataclasses.replace(found, **_fields_of(word))
        return found

    @property
    def words(self) -> str:
        return f"{self.amplitude}_{self.detection},{self.phase},{self.speed}"

    def line(self) -> str:
        """The line at the head of a file, without its sign of a remark."""
        return "; ".join([HEAD + self.words, *(f"{name} = {channel}" for channel, name in self.names.items())])


def of_text(text: str, otherwise: Notation = Notation()) -> Notation:
    """Notation stated at the head of a file; another one if the head has no such line."""
    found = IN_FILE.search(text)
    if found is None:
        return otherwise
    words, *names = found[1].split("; ")
    pairs = (each.partition(" = ") for each in names)
    return dataclasses.replace(
        Notation().with_words(words), names={channel.strip(): name for name, _, channel in pairs}
    )


def _fields_of(word: str) -> dict[str, Any]:
    """Fields that a word sets: 'mil_pp' sets two, 'lag' one."""
    parts = [SPELT.get(each, each) for each in re.split(r"[_ ]", word)]
    found: dict[str, str] = {}
    for part in parts:
        for name, choices in (("amplitude", AMPLITUDES), ("detection", DETECTIONS), ("speed", SPEEDS)):
            if part in choices:
                found[name] = part
        if part in (LEAD, LAG):
            found["phase"] = part
    if len(found) < len(parts):
        raise SettingError(
            f"units: expected words such as mil_pp,lag or um_0pk,lead,Hz, got {shortened(repr(word))}; units are"
            f" {_listed(AMPLITUDES)}, detections {_listed(DETECTIONS)}, phases lead and lag, speeds {_listed(SPEEDS)}"
        )
    return found


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)

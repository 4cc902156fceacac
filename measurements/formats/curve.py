"""Reading of one probe of a file at one harmonic, in the file's own units."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ksmea.arrays import Array, Indices

Flags = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass(frozen=True)
class Curve:
    """The rows of one probe in the order of the file, (n,) each.

    Texts are copied from the file, empty if it does not have them.
    """

    name: str
    where: str  # in the file, for messages
    line: list[int]
    speed: Array
    amplitude: Array  # or the size of what is complex
    phase: Array | None = None  # degrees, as a lag or a lead
    sigma: Array | None = None  # in the unit of the amplitude, total for complex data
    time: Array | None = None  # s from any origin
    speed_unit: str = ""
    unit: str = ""  # of amplitudes, with the detector: 'mil pp'
    sense: str = ""  # of phases, lag or lead
    stated_sense: str = ""  # of phases, if the file itself says it, and not the custom of its instrument
    angle: str = ""  # of the probe: '45° Right'
    position: float | None = None  # m
    direction: str = ""
    harmonic: float = 1.0
    is_compensated: bool = False  # slow roll is subtracted
    left_out: Mapping[str, int] = field(default_factory=dict)  # rows, by reason
    notes: tuple[str, ...] = ()  # remarks on the whole file

    def rows(self, kept: Flags, reason: str) -> Curve:
        """The curve at some of its rows (n,) bool; the others are counted under a reason."""
        if np.all(kept):
            return self
        left_out = {**self.left_out, reason: self.left_out.get(reason, 0) + int(np.count_nonzero(np.logical_not(kept)))}
        return dataclasses.replace(self.at(np.flatnonzero(kept)), left_out=left_out)

    def at(self, indices: Indices) -> Curve:
        """Some of its rows, in this order."""
        parts = {name: getattr(self, name) for name in ("speed", "amplitude", "phase", "sigma", "time")}
        changes: dict[str, Any] = {name: None if part is None else part[indices] for name, part in parts.items()}
        return dataclasses.replace(self, line=[self.line[index] for index in indices], **changes)

"""Record of a finding in words.

A sentence with sizes by name in braces, which are data, so that each reader's units show them.

>>> size = SizeRecord(3.2, 3.1, 3.3, "%")
>>> StatementRecord("youngs modulus", "The shaft is {change:stiffer|softer} than in the model", {"change": size}).place
''
"""
# Shorter than 40 lines of code: effects and texts share this record, and nothing else.

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ksmea.arrays import Array
from ksmea.records.estimate import EstimateRecord
from ksmea.records.record import Record

POLAR, ORBIT = "polar", "orbit"


@dataclass(frozen=True)
class SizeRecord(Record):
    """A size with the ends of its interval, None where open, in its unit.

    A vector has an angle, degrees: the phase lead of what it makes in direction x, with the half-width of its interval.
    """

    value: float
    low: float | None
    high: float | None
    unit: str
    angle: float | None = None
    angle_error: float | None = None

    def mapped(self, function: Callable[[float], float], unit: str) -> SizeRecord:
        """A monotone function of this size, with its interval."""
        low, high = (None if end is None else function(end) for end in (self.low, self.high))
        if function(self.value + 1e-6) < function(self.value - 1e-6):
            low, high = high, low
        return SizeRecord(function(self.value), low, high, unit)

    def holds(self, value: float) -> bool:
        return (self.low is None or self.low <= value) and (self.high is None or value <= self.high)


@dataclass(frozen=True)
class StatementRecord(Record):
    """Where something acts and how much of it there is.

    `sentence` ends without a full stop. In it `{name}` is a size with its unit and, of a vector, its angle; `{name:more|less}` its
    magnitude and the word of its sign; `{name:size}` a vector without its angle; `{name:reading}` what a probe reads, in the unit
    and detection of the data; `{place}` the location, `{place:probes}` the probes there.
    """

    words: str  # what it is, as a noun: 'residual bow'
    sentence: str
    sizes: Mapping[str, SizeRecord] = field(default_factory=dict)
    place: str = ""  # '' of what has none
    advice: str = ""  # what to check on the machine, a sentence
    picture: str = POLAR  # the picture that shows it best: polar or orbit
    is_of_measurement: bool = False  # it is an error of the measurement, not a property of the machine


def of_unknowns(estimates: Mapping[str, EstimateRecord], correlation: Array) -> dict[str, SizeRecord]:
    """Sizes of unknowns (e,) by name, and of each pair `name_x`, `name_y` the vector `name`.

    `correlation` (e, e) is of their errors. The interval of a vector's length and angle follows from the intervals of
    its components to first order.
    """
    sizes = {each.name: SizeRecord(each.value, each.low, each.high, each.unit) for each in estimates.values()}
    names = list(estimates)
    for one, name in enumerate(names):
        if name.endswith("_x") and (partner := f"{name[:-2]}_y") in estimates:
            both = (estimates[name], estimates[partner])
            sizes[name[:-2]] = _vector(*both, float(correlation[one, names.index(partner)]))
    return sizes


def _vector(x: EstimateRecord, y: EstimateRecord, correlation: float) -> SizeRecord:
    length, angle = float(np.hypot(x.value, y.value)), float(np.degrees(np.arctan2(y.value, x.value)))
    if None in (x.low, x.high, y.low, y.high) or not length:
        return SizeRecord(length, None, None, x.unit, angle)
    half = np.array([(each.shown.high - each.shown.low) / 2 for each in (x, y)])
    covariance = np.outer(half, half) * np.array([[1.0, correlation], [correlation, 1.0]])
    along = np.array([x.value, y.value]) / length
    across = np.array([-along[1], along[0]])
    error, turn = (float(np.sqrt(max(each @ covariance @ each, 0.0))) for each in (along, across))
    return SizeRecord(
        length, max(length - error, 0.0), length + error, x.unit, angle, float(np.degrees(min(turn / length, np.pi)))
    )

"""Speeds, vibrations and noise of a measurement in the units of a notation, for texts and charts.

A displacement, as in an orbit, has the unit of the amplitude and no detection: half its peak-to-peak width is its
amplitude.
"""

from __future__ import annotations

from ksmea.measurement.notation import AMPLITUDES, DETECTIONS, SPEEDS, Notation

PLAIN = Notation()
DECIMALS = {"rpm": 0, "Hz": 1, "rad/s": 1}  # of a speed: 0.1 Hz is 6 rpm


def vibration_unit(notation: Notation) -> float:
    """Size of the unit of vibrations, m 0-peak.

    >>> vibration_unit(Notation("mil", "pp"))
    1.27e-05
    """
    return AMPLITUDES[notation.amplitude] / DETECTIONS[notation.detection]


def speed_unit(notation: Notation) -> float:
    """Size of the unit of speeds, rad/s."""
    return SPEEDS[notation.speed]


def speed_form(notation: Notation) -> str:
    """Format of a speed in its unit: '.0f' of rpm."""
    return f".{DECIMALS[notation.speed]}f"


def speed_digits(value: float, notation: Notation) -> str:
    """A speed in the unit of a notation as it is written, without its unit.

    >>> speed_digits(3619.8, PLAIN), speed_digits(60.33, Notation(speed="Hz"))
    ('3620', '60.3')
    """
    return f"{value:{speed_form(notation)}}"


def speed_at_pointer(notation: Notation) -> str:
    """Speed at the pointer of a chart, to be filled in.

    >>> speed_at_pointer(PLAIN)
    '{x:.0f} rpm'
    """
    return f"{{x:{speed_form(notation)}}} {notation.speed}"


def speed_label(notation: Notation) -> str:
    """Label of an axis of speeds."""
    return f"speed ({notation.speed})"


def amplitude_label(notation: Notation) -> str:
    """Label of an axis of amplitudes."""
    return f"amplitude ({notation.unit})"


def deviation_unit(notation: Notation) -> str:
    """Unit of a standard deviation of vibrations; 0-peak goes without saying.

    >>> deviation_unit(PLAIN), deviation_unit(Notation("mil", "pp"))
    ('µm', 'mil pp')
    """
    return notation.amplitude if notation.detection == PLAIN.detection else notation.unit

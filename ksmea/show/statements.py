"""Statements as sentences in the units and names of a notation.

Sizes to the digits that their intervals support.
"""

from __future__ import annotations

import math
from string import Formatter

from ksmea.measurement.notation import Notation
from ksmea.records.estimate import Shown
from ksmea.records.statement import SizeRecord, StatementRecord
from ksmea.show.readings import PLAIN
from ksmea.show.text import capital, fixed, number
from ksmea.units import SI_PER_UNIT

READING, PROBES, LENGTH = "reading", "probes", "size"
FULL_TURN = "360"  # rounded; as an angle it is 0
WHOLE_DEGREES = 3.0  # of a half-width: an angle in a sentence has no decimals
ANGLE = "deg"  # unit of which a part is not stated: its zero is a convention
UNSAID = "whole rotor"  # a location that a sentence does not repeat
ALONE = 3  # digits of a size without an interval
LEAST_LEADING = 3  # leading digit from which on one digit of a half-width is enough
THIN_SPACE = "\u2009"
GROUPED = 10_000  # from where on digits are grouped
LENGTH_IN_SI = {"µm": 1e-6, "mm": 1e-3, "m": 1.0}


def sentence(statement: StatementRecord, notation: Notation = PLAIN) -> str:
    """Where something acts and how much of it there is, without a full stop."""
    parts = [
        text if name is None else text + _filled(statement, name, form or "", notation)
        for text, name, form, _ in Formatter().parse(statement.sentence)
    ]
    said = " ".join("".join(parts).split()).replace(" ,", ",").replace(" :", ":")
    return capital(said)


def intervals(statement: StatementRecord, notation: Notation = PLAIN) -> str:
    """The half-widths of the intervals of its sizes: '± 0.0025 mil pp, ± 0.6°'.

    Of an open interval it is the known end.
    """
    said = []
    for _, name, form, _ in Formatter().parse(statement.sentence):
        size = statement.sizes.get(name or "")
        if size is None:
            continue
        size = _in_notation(size, form or "", notation)
        said.append(_interval(size))
        if size.angle_error is not None and form != LENGTH:
            said.append(f"± {rounded(size.angle_error, size.angle_error)}°")
    return ", ".join(said)


def place(location: str, notation: Notation = PLAIN) -> str:
    """A location with the names of its probes; '' for the whole rotor."""
    return "" if location == UNSAID else notation.name(location)


def probes(location: str, notation: Notation = PLAIN) -> str:
    """The probes at a location: '3X and 3Y', or 'the probes at 0.1 m'.

    >>> probes("at 0.1 m", Notation(names={"x at 0.1 m": "3X", "y at 0.1 m": "3Y"})), probes("x at 0.1 m")
    ('3X and 3Y', 'the probe in x at 0.1 m')
    """
    named = [
        name for channel, name in notation.names.items() if channel == location or channel.endswith(f" {location}")
    ]
    if location in ("all planes", "all channels"):
        return "all probes"
    if named:
        return " and ".join([", ".join(named[:-1]), named[-1]] if len(named) > 2 else named)
    return f"the probes {location}" if location.startswith("at ") else f"the probe in {location}"


def half_width(of: SizeRecord | Shown) -> float | None:
    """Half the width of an interval, or the distance to its one end; None without an interval."""
    ends = [end for end in (of.low, of.high) if end is not None and math.isfinite(end)]
    if len(ends) == 2:
        return (ends[1] - ends[0]) / 2
    return abs(ends[0] - of.value) if ends else None


def value_columns(shown: Shown) -> tuple[str, str, str]:
    """Value, interval and relative half-width: ('50.05', '± 0.05', '0.1 %'), or ('0.9', 'above 0.66', '').

    An angle has no relative half-width: its zero is a convention.
    """
    half = half_width(shown)
    if half is None:
        return number(shown.value, 3), "not determined", ""
    if math.isfinite(shown.low) and math.isfinite(shown.high):
        share = f"{number(100 * half / abs(shown.value), 2)} %" if shown.value and shown.unit != ANGLE else ""
        return rounded(shown.value, half).replace("-", "−"), f"± {rounded(half, half)}", share
    word, end = ("above", shown.low) if math.isfinite(shown.low) else ("below", shown.high)
    return rounded(shown.value, half).replace("-", "−"), f"{word} {rounded(end, half)}".replace("-", "−"), ""


def with_unit(value: float, unit: str, half: float | None) -> str:
    """A value to the place that its half-width supports: 0.242 mil pp, 15 %."""
    digits = number(value, ALONE) if half is None else rounded(value, half)
    return f"{digits}{'' if unit in (ANGLE, '') else ' '}{'°' if unit == ANGLE else unit}"


def _filled(statement: StatementRecord, name: str, form: str, notation: Notation) -> str:
    if name == "place":
        return probes(statement.place, notation) if form == PROBES else place(statement.place, notation)
    if (size := statement.sizes.get(name)) is None:
        return "?"
    size = _in_notation(size, form, notation)
    word = ""
    if "|" in form:
        positive, negative = form.split("|")
        word = f" {positive if size.value >= 0 else negative}"
        size = _magnitude(size)
    bound, value = _known_end(size)
    half = _coarse(size)
    said = with_unit(value, size.unit, half if not bound or half is None else min(half, abs(value)))
    said = bound + (f"−{said[1:]}" if said.startswith("-") else said)
    if size.angle is None or form == LENGTH:
        return said + word
    angle = rounded(size.angle, max(size.angle_error or 0.0, WHOLE_DEGREES))
    return f"{said} at {'0' if angle == FULL_TURN else angle}° {notation.phase}"


def _known_end(size: SizeRecord) -> tuple[str, float]:
    """'at most ' or 'at least ' with the only known end of an interval; otherwise the value.

    An end of the other sign bounds nothing that the value's sign, or its word, speaks of.
    """
    if (size.low is None) == (size.high is None):
        return "", size.value
    word, end = ("at most ", size.high) if size.low is None else ("at least ", size.low)
    return ("", size.value) if end is None or end * size.value <= 0 else (word, end)


def _coarse(size: SizeRecord) -> float | None:
    """Its half-width, or as much as leaves `ALONE` digits: a sentence has no more."""
    half = half_width(size)
    least = 3 * 10.0 ** (math.floor(math.log10(abs(size.value))) - ALONE + 1) if size.value else 0.0
    return None if half is None else max(half, least)


def _in_notation(size: SizeRecord, form: str, notation: Notation) -> SizeRecord:
    """A size with its reading and its angle converted to a notation."""
    angle = None if size.angle is None else notation.angle(size.angle)
    if form != READING:
        return SizeRecord(size.value, size.low, size.high, size.unit, angle, size.angle_error)
    metre = LENGTH_IN_SI.get(size.unit) or SI_PER_UNIT["length"][size.unit]
    value, low, high = (
        None if each is None else notation.vibration(each * metre) for each in (size.value, size.low, size.high)
    )
    return SizeRecord(value or 0.0, low, high, notation.unit, angle, size.angle_error)


def _magnitude(size: SizeRecord) -> SizeRecord:
    if size.value >= 0:
        return size
    low, high = (None if end is None else -end for end in (size.high, size.low))
    return SizeRecord(-size.value, low, high, size.unit)


def _interval(size: SizeRecord) -> str:
    half = half_width(size)
    if half is None:
        return "interval open"
    if size.low is None or size.high is None:
        word, end = ("above", size.low) if size.low is not None else ("below", size.high)
        return f"{word} {with_unit(end or 0.0, size.unit, half)}"
    return f"± {with_unit(half, size.unit, half)}"


def rounded(value: float, half: float) -> str:
    """Value rounded to the first digit of its half-width, or to the second if that begins with 1 or 2.

    >>> rounded(0.5213, 0.062), rounded(200.13, 2.3), rounded(13970.0, 40)
    ('0.52', '200.1', '13 970')
    """
    if not (math.isfinite(half) and half > 0):
        return number(value, ALONE)
    power = math.floor(math.log10(half))
    leading = float(f"{half / 10.0**power:.1f}")
    text = fixed(value, -power + (leading < LEAST_LEADING))
    return f"{float(text):,.0f}".replace(",", THIN_SPACE) if abs(value) >= GROUPED and "." not in text else text

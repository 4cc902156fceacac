"""Units as files spell them: of amplitudes with their detector, of speeds, times and phases.

Detectors are peak to peak, zero to peak and rms.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from ksmea.errors import SettingError, shortened
from ksmea.units import DEGREE, HERTZ, INCH, MICROMETRE, RPM

MIL = 1e-3 * INCH  # m
STANDARD_GRAVITY = 9.80665  # m/s²: exact by definition
MILLIMETRE = 1e-3  # m

# Size in SI, and how often displacement is differentiated in time.
UNITS = {
    "um": (MICROMETRE, 0),
    "mil": (MIL, 0),
    "mm": (MILLIMETRE, 0),
    "in": (INCH, 0),
    "m": (1.0, 0),
    "mm/s": (MILLIMETRE, 1),
    "in/s": (INCH, 1),
    "m/s": (1.0, 1),
    "g": (STANDARD_GRAVITY, 2),
    "m/s2": (1.0, 2),
}
ZERO_TO_PEAK = {"pp": 0.5, "0pk": 1.0, "rms": 2**0.5}  # of an amplitude, of a sinusoid
DETECTORS = tuple(ZERO_TO_PEAK)
SPEED_UNITS = {"rpm": RPM, "Hz": HERTZ, "rad/s": 1.0}  # rad/s
TIMES = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}  # s
_RADIAN = 1 / DEGREE  # degrees
PHASES = {"deg": 1.0, "°": 1.0, "degree": 1.0, "degrees": 1.0, "rad": _RADIAN, "radian": _RADIAN, "radians": _RADIAN}

# What to do where a file is in none of them.
SCALED = "give a unit and what 1 of the file is in it, such as unit=mil scale=5 for volts of a probe of 200 mV/mil"

_SPELT = {
    "mils": "mil",
    "micron": "um",
    "microns": "um",
    "micrometer": "um",
    "micrometre": "um",
    "inch": "in",
    "inches": "in",
    "ips": "in/s",
    "mm s": "mm/s",  # of mm_s
    "m/s^2": "m/s2",
    "m/s**2": "m/s2",
    "g's": "g",
}
_VOLTAGES = ("v", "mv", "uv", "kv", "volt", "volts", "millivolt", "millivolts")
_DETECTOR = {
    "pp": r"p[-/ ]?p|pk[- ]?pk|peak[- ]?(?:to[- ])?peak|spitze[- ]spitze|crête à crête|c[àa-]c|pico a pico|picco-?picco",
    "rms": r"rms|eff",
    "0pk": r"0-?pk?|0-peak|zero[- ]to[- ]peak|pk|peak",
}
_SPEED = {
    "rpm": (
        *("rpm", "r.p.m.", "cpm", "1/min", "u/min", "min-1", "min^-1", "min⁻¹", "r/min", "rev/min"),
        *("tr/min", "giri/min", "obr/min", "omw/min", "varv/min", "об/мин", "转/分", "回/分"),
    ),
    "Hz": ("hz", "cps", "1/s", "s-1", "rev/s"),
    "rad/s": ("rad/s", "rad/sec"),
}
MOST_WORDS = 4  # of a unit with its detector
_MISTAKABLE = {"", "g", "m", "in", "v", "s", "h", "min"}  # which may be names, or the least of something
_LETTERS = re.compile(r"[^\W\d_]+")
# English, German, French, Spanish, Italian
_SENSES = {
    "lag": ("lag", "nacheil", "retard", "retraso", "ritardo"),
    "lead": ("lead", "voreil", "avance", "adelanto", "anticipo"),
}
_PARENTHESES = re.compile(r"[\[(]([^\[\]()]*)[\])]\s*$")


@dataclass(frozen=True)
class AmplitudeUnit:
    """Unit and detector of an amplitude as a text states them, each empty if it is not stated."""

    unit: str
    detector: str


def amplitude_unit(text: str) -> AmplitudeUnit | None:
    """The unit that a text names, or None if it names none of `UNITS`.

    >>> amplitude_unit("mil pp"), amplitude_unit("µm 0-pk")
    (AmplitudeUnit(unit='mil', detector='pp'), AmplitudeUnit(unit='um', detector='0pk'))
    """
    left, detector = _apart(text)
    unit = _SPELT.get(left, left)
    if unit and unit not in UNITS:
        return None
    return AmplitudeUnit(unit, detector)


def is_voltage(text: str) -> bool:
    """Whether a text names a voltage, which is a motion by the sensitivity of the probe alone.

    >>> is_voltage("mV pp"), is_voltage("mil")
    (True, False)
    """
    return _apart(text)[0] in _VOLTAGES


def detector_of(text: str) -> str:
    """The detector that a text ends in, whatever the unit before it; empty if it names none.

    >>> detector_of("V pk"), detector_of("V")
    ('0pk', '')
    """
    return _apart(text)[1]


def _apart(text: str) -> tuple[str, str]:
    """The text before the detector, in lower case, and the detector."""
    left = _plain(text).replace("²", "2").replace("_", " ")
    for name, pattern in _DETECTOR.items():
        left, found = re.subn(rf"(?:^|(?<=\s))(?:{pattern})$", "", left)
        if found:
            return left.strip(" ,-"), name
    return left.strip(" ,-"), ""


def speed_unit(text: str) -> str:
    """The unit of a speed that a text names; empty if it names none.

    >>> speed_unit("1/min"), speed_unit("furlongs")
    ('rpm', '')
    """
    spelt = text.strip().lower()
    return next((name for name, texts in _SPEED.items() if spelt in texts), "")


def seconds_per(unit: str, where: str) -> float:
    """Size of a unit of time, s; 1 if no unit is named.

    >>> seconds_per("ms", ""), seconds_per("", "")
    (0.001, 1.0)
    """
    spelt = _plain(unit).strip("-")
    if spelt not in TIMES:
        raise SettingError(f"{where}: expected a time in {', '.join(filter(None, TIMES))}, got {shortened(repr(unit))}")
    return TIMES[spelt]


def degrees_per(unit: str) -> float:
    """Size of a unit of phases in degrees; 1 for a text that is not such a unit, as in 'Phase (lag)'.

    >>> round(degrees_per("rad"), 3), degrees_per("lag")
    (57.296, 1.0)
    """
    return PHASES.get(_plain(unit), 1.0)


def _plain(unit: str) -> str:
    return unit.strip().lower().replace("µ", "u").replace("μ", "u")


def unit_in_heading(heading: str, *, in_brackets: bool = True) -> str:
    """The text in brackets at the end of a heading, or the last words if they are a unit.

    Empty if there is neither.

    >>> unit_in_heading("1X Amp (µm pp)"), unit_in_heading("X_um_pp"), unit_in_heading("Speed"), unit_in_heading("probe_g")
    ('µm pp', 'um pp', '', '')
    """
    found = _PARENTHESES.search(heading) if in_brackets else None
    if found:
        return found[1]
    words = heading.replace("_", " ").replace(".", " ").split()
    tails = (" ".join(words[-count:]) for count in range(min(MOST_WORDS, len(words)), 0, -1))
    return next(filter(_is_unmistakable, tails), "")


def _is_unmistakable(text: str) -> bool:
    """Whether words without brackets are a unit, and not the name of a probe: g and m alone may be one."""
    if _plain(text) in _MISTAKABLE:
        return False
    unit = amplitude_unit(text)
    is_amplitude = is_voltage(text) or (unit is not None and bool(unit.unit))
    return is_amplitude or bool(speed_unit(text)) or _plain(text) in (*PHASES, *TIMES)


def sense_in_heading(heading: str) -> str:
    """Whether a heading says that its phases are lags or leads; empty if it does not.

    >>> sense_in_heading("X Phase Lag [deg]"), sense_in_heading("phase_lead_deg"), sense_in_heading("Phase")
    ('lag', 'lead', '')
    """
    words = _LETTERS.findall(heading.lower())
    found = [sense for sense, known in _SENSES.items() if any(word.startswith(known) for word in words)]
    return found[0] if len(found) == 1 else ""

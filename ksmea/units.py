"""Units: inside everything is SI; input and output are converted here and nowhere else."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

TURN = 2 * math.pi  # rad
DEGREE = math.pi / 180  # rad
MILLIRADIAN = 1e-3  # rad
RPM = math.pi / 30  # rad/s
HERTZ = 2 * math.pi  # rad/s

INCH, POUND, OUNCE = 0.0254, 0.45359237, 0.028349523125  # m, kg, kg: exact by definition
MILLIMETRE = 1e-3  # m
MICROMETRE = 1e-6  # m
MICROSECOND = 1e-6  # s
GRAM_MILLIMETRE = 1e-6  # kg m
MEGANEWTON_PER_METRE = 1e6  # N/m
KILONEWTON_SECOND_PER_METRE = 1e3  # N s/m
MICROMETRE_PER_KILONEWTON = 1e-9  # m/N
GIGAPASCAL = 1e9  # Pa

POUND_FORCE = 4.4482216152605  # N, exact by definition
POUND_FORCE_PER_INCH = POUND_FORCE / INCH  # N/m

# Units that a file may use, by the quantity, with their size in SI.
SI_PER_UNIT = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": INCH, "ft": 12 * INCH, "mil": 1e-3 * INCH, "thou": 1e-3 * INCH},
    "modulus": {
        "Pa": 1.0, "MPa": 1e6, "GPa": GIGAPASCAL, "N/mm2": 1e6, "psi": POUND_FORCE / INCH**2, "ksi": 1e3 * POUND_FORCE / INCH**2,
    },
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "lb/in3": POUND / INCH**3, "lb/ft3": POUND / (12 * INCH) ** 3},
    "mass": {"kg": 1.0, "g": 1e-3, "lb": POUND, "oz": OUNCE, "lbf s2/in": POUND_FORCE_PER_INCH, "t": 1e3},
    "inertia": {
        "kg m2": 1.0, "kg mm2": 1e-6, "g mm2": 1e-9, "kg cm2": 1e-4, "lb in2": POUND * INCH**2, "lb ft2": POUND * (12 * INCH) ** 2,
        "lbf in s2": POUND_FORCE * INCH,
    },
    "stiffness": {
        "N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "kN/mm": 1e6, "N/um": 1e6, "lbf/in": POUND_FORCE_PER_INCH,
    },
    "damping": {
        "N s/m": 1.0, "kN s/m": 1e3, "N s/mm": 1e3, "kN s/mm": 1e6, "MN s/m": 1e6, "lbf s/in": POUND_FORCE_PER_INCH,
    },
    "force": {"N": 1.0, "kN": 1e3, "lbf": POUND_FORCE},
    "angular_stiffness": {"N m/rad": 1.0, "kN m/rad": 1e3, "MN m/rad": 1e6, "lbf in/rad": POUND_FORCE * INCH},
    "angular_damping": {"N m s/rad": 1.0, "kN m s/rad": 1e3, "lbf in s/rad": POUND_FORCE * INCH},
    "unbalance": {
        "kg m": 1.0, "g m": 1e-3, "kg mm": 1e-3, "g mm": GRAM_MILLIMETRE, "g cm": 1e-5, "oz in": OUNCE * INCH, "lb in": POUND * INCH,
        "g in": 1e-3 * INCH,
    },
    "angle": {"rad": 1.0, "deg": DEGREE},
    "speed": {"rad/s": 1.0, "rpm": RPM, "Hz": HERTZ},
}  # fmt: skip


@dataclass(frozen=True)
class Unit:
    """The name people read, and the unit's size in SI."""

    name: str
    si: float


@dataclass(frozen=True)
class Quantity:
    """The unit of a number of a result, and the unit in which texts show it.

    `shown` is the end of a name in this unit (`um` in `floor_um`), `size` the unit's size in `unit`. A quantity stands
    in the type of a field, of one number or of many; if it depends on other fields, a function of the result gives it
    (`ksmea.show.json_units`).
    """

    unit: str
    shown: str = ""
    size: float = 1.0


LENGTH, TIME = Quantity("m"), Quantity("s")
SPEED = Quantity("rad/s", "rpm", RPM)
VIBRATION = Quantity("m", "um", MICROMETRE)
ANGLE = Quantity("rad", "deg", DEGREE)
UNBALANCE = Quantity("kg m", "g_mm", GRAM_MILLIMETRE)
PART = Quantity("1", "pct", 0.01)
MICROMETRES, GRAM_MILLIMETRES, DEGREES = Quantity("µm"), Quantity("g mm"), Quantity("deg")

Length = Annotated[float, LENGTH]
Time = Annotated[float, TIME]
Speed = Annotated[float, SPEED]
Vibration = Annotated[float, VIBRATION]
Angle = Annotated[float, ANGLE]
Unbalance = Annotated[float, UNBALANCE]
Part = Annotated[float, PART]
OfUnknown = Annotated[
    float, Quantity("SI")
]  # one of a number for each unknown: divided by its `si_per_unit` it is in its `unit`

"""Units that a rotor file may use, by the kind of quantity, with their size in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass

INCH, POUND, OUNCE = 0.0254, 0.45359237, 0.028349523125  # m, kg, kg: exact by definition

SI_PER_UNIT = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": INCH},
    "modulus": {"Pa": 1.0, "MPa": 1e6, "GPa": 1e9},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3},
    "mass": {"kg": 1.0, "g": 1e-3, "lb": POUND},
    "inertia": {"kg m2": 1.0, "kg mm2": 1e-6, "g mm2": 1e-9},
    "stiffness": {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "kN/mm": 1e6, "N/um": 1e6},
    "damping": {"N s/m": 1.0, "kN s/m": 1e3, "N s/mm": 1e3, "kN s/mm": 1e6},
    "unbalance": {"kg m": 1.0, "g m": 1e-3, "kg mm": 1e-3, "g mm": 1e-6, "oz in": OUNCE * INCH},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "speed": {"rad/s": 1.0, "rpm": math.pi / 30, "Hz": 2 * math.pi},
}


@dataclass(frozen=True)
class Unit:
    """The name people read, and the unit's size in SI."""

    name: str
    si: float

"""Bearings that soften as the frequency rises, K − M Ω².

Springs with mass, alike under all bearings, in x and in y.

A housing that moves with the journal, a heavy squirrel cage or mount and the liquid of a long film add M to each bearing
(Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 5.5; Childs, Turbomachinery Rotordynamics, 1993,
section 4.2, for films). It resists acceleration of any motion, whatever the spin speed. At one bearing alone it is an added mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, rotor_mass
from problems.rotor.extension.sizes import Size

LARGEST = 0.3  # of the rotor's mass at each bearing
NOTICED = (0.01, 0.15)  # of the rotor's mass, are drawn


@dataclass(frozen=True)
class BearingMass(RotorEffect):
    """All bearings carry a mass."""

    says = "Each bearing moves a mass of {bearing_mass_x} in x and {bearing_mass_y} in y"
    check_next = (
        "Tap the bearing housings at standstill: a moving mass of this size in the frequency response confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_stiffness": "both change the bearings' stiffness with speed; a wider band, an impact test at standstill",
        "flexible_pedestal": "a pedestal softens with frequency too; a sensor on the casing",
        "added_mass": "at one bearing both are alike; look at each bearing",
        "mass": "both lower natural frequencies; several critical speeds",
    }

    extent = ALL_BEARINGS
    for_drawings_only: ClassVar[bool] = True
    sizes = (
        Size("bearing_mass_x", "kg", (0.0, LARGEST), drawn=NOTICED, of=rotor_mass),
        Size("bearing_mass_y", "kg", (0.0, LARGEST), drawn=NOTICED, of=rotor_mass),
    )

    def bearing_inertia(self, theta: Array) -> Array:
        return theta.T

"""Antisymmetric cross-coupling of the bearings, kxy = −kyx = κ.

The tangential force of an oil film, a seal, steam.

It feeds the forward whirl for κ > 0 and damps it for κ < 0 (Friswell, Penny, Garvey & Lees, Dynamics of Rotating
Machines, 2010, section 7.4).
"""
# Shorter than 40 lines: one effect a file, by which it is registered.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array, ComplexArray
from ksmea.plugins.effect import ORBIT
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, column, stiffness_scale
from problems.rotor.extension.sizes import Size

LARGEST = 0.2  # of the largest stiffness
NOTICED = (0.002, 0.05)  # of the largest stiffness, of either sign, are drawn


@dataclass(frozen=True)
class CrossCouplingAntisymmetric(RotorEffect):
    """All bearings push at right angles to the deflection, kxy = −kyx."""

    extent = ALL_BEARINGS
    words = "cross-coupling"
    says = "Bearings push across the deflection with {kxy_antisymmetric} (kxy = −kyx)"
    picture = ORBIT
    check_next = (
        "Change oil temperature or inlet swirl:"
        " forward whirl that changes with it confirms it; watch the margin to instability."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "internal_damping": "both act on the damping of the forward whirl; the onset of instability, reverse rotation",
        "annular_seal": "both drive forward whirl; a seal's grows with speed: measure over a wide band, or without pressure",
        "short_journal_bearing": "both drive forward whirl; warm and cold oil differ, what else couples does not",
    }
    couples_axes: ClassVar[bool] = True

    sizes = (Size("kxy_antisymmetric", "MN/m", LARGEST, drawn=NOTICED, of=stiffness_scale),)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        changed = impedance.copy()
        changed[:, 0, 1] += column(theta[:, 0])
        changed[:, 1, 0] -= column(theta[:, 0])
        return changed

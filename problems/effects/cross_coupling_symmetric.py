"""Symmetric cross-coupling of the bearings, kxy = kyx = κ.

The principal axes of their stiffness are not x and y.

A bearing with stiffnesses k₁, k₂ along axes that are turned by α has kxy = kyx = ½(k₁ − k₂) sin 2α. It turns the orbit's
ellipse, and does no work (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 5; J. W. Lund,
Review of the concept of dynamic coefficients for fluid film journal bearings, J. Tribology 109 (1987) 37–41).
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
NOTICED = (0.003, 0.1)  # of the largest stiffness, of either sign, are drawn


@dataclass(frozen=True)
class CrossCouplingSymmetric(RotorEffect):
    """The bearings' principal axes are turned, kxy = kyx."""

    extent = ALL_BEARINGS
    words = "turned bearing axes"
    says = "Bearings couple x and y with {kxy_symmetric} (kxy = kyx)"
    picture = ORBIT
    check_next = "Survey the angles of the probes: if they are right, a bearing load between x and y confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "probe_rotation": "both turn the ellipse; survey the angles of the probes, or look at how it changes with speed",
    }
    couples_axes: ClassVar[bool] = True

    sizes = (Size("kxy_symmetric", "MN/m", LARGEST, drawn=NOTICED, of=stiffness_scale),)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        changed = impedance.copy()
        changed[:, 0, 1] += column(theta[:, 0])
        changed[:, 1, 0] += column(theta[:, 0])
        return changed

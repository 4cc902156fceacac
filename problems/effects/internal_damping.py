"""Internal damping: the turning shaft itself damps, in proportion to its stiffness, C_i = β K_s.

It resists motion as the shaft sees it, q̇ − Ω × q, and so brings a circulatory force along that drives the forward whirl
above a critical speed (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 7.3; A. Muszynska,
Rotordynamics, 2005). A circular forward orbit at the speed of rotation does not bend the shaft to and fro: only
the ellipse of anisotropic bearings shows it, by its backward part.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.problem.parameters import Parameter
from ksmea.units import MICROSECOND
from problems.rotor.extension.effect import RotorEffect, drawn
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem

LARGEST = 100 * MICROSECOND  # a loss factor βω of 0.1 at 160 Hz: shrink fits and couplings, more than steel itself
NOTICED = (3 * MICROSECOND, 60 * MICROSECOND)  # are drawn


@dataclass(frozen=True)
class InternalDamping(RotorEffect):
    """The shaft itself damps, as it turns."""

    aliases: ClassVar[Mapping[str, str]] = {
        "cross_coupling_antisymmetric": "both act on the damping of the forward whirl; the onset of instability,"
        " reverse rotation",
    }
    changes_rotor: ClassVar[bool] = True

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return (Parameter("internal_damping", "µs", MICROSECOND, 0.0, LARGEST),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return np.array([drawn(rng, *NOTICED)])

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        return dataclasses.replace(rotor, internal_damping=rotor.internal_damping + float(theta[0]))

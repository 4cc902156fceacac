"""Internal damping: the turning shaft itself damps, in proportion to its stiffness, C_i = β K_s.

It resists motion as the shaft sees it, q̇ − Ω × q, and so brings a circulatory force along that drives the forward whirl
above a critical speed (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 7.3; A. Muszynska,
Rotordynamics, 2005). A circular forward orbit at the speed of rotation does not bend the shaft to and fro: only
the ellipse of anisotropic bearings shows it, by its backward part.
"""
# Shorter than 40 lines: one effect a file, by which it is registered.

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.units import MICROSECOND
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.places import Place

LARGEST = 100 * MICROSECOND  # a loss factor βω of 0.1 at 160 Hz: shrink fits and couplings, more than steel itself
NOTICED = (3 * MICROSECOND, 60 * MICROSECOND)  # are drawn


@dataclass(frozen=True)
class InternalDamping(NumberEffect):
    """The shaft itself damps, as it turns."""

    says = "The shaft damps itself as it turns: {internal_damping} times its stiffness"
    check_next = (
        "Check shrink fits, splines and couplings for looseness:"
        " subsynchronous whirl above a critical speed confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "cross_coupling_antisymmetric": "both act on the damping of the forward whirl; the onset of instability,"
        " reverse rotation",
        "standing_damping": "damping of the turning shaft drives forward whirl above a critical speed; the onset of instability",
    }

    is_linear = True
    sizes = (Size("internal_damping", "µs", (0.0, LARGEST), drawn=NOTICED),)

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        yield Place(("internal_damping",))

"""Standing damping: the shaft damps in proportion to its stiffness, C = β K_s, without turning.

It acts along the whole length.

As many programs have it for the sum of all that nobody models: joints, sleeves, windings (Rayleigh's proportional damping). It damps
mode n of a shaft on stiff bearings by ζ_n = β ω_n/2, high modes most, where `external_damping` damps low ones. Other than
`internal_damping`, C_i (q̇ − Ω × q), it damps at any speed and drives nothing. Tried on machines of a drawing.

Lord Rayleigh, The Theory of Sound, vol. 1, 1877, section 97; Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010,
section 2.6.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.units import MICROSECOND
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import CouplingSegment
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.places import Place

LARGEST = 500 * MICROSECOND  # a damping ratio of 5 % at 32 Hz
NOTICED = (3 * MICROSECOND, 200 * MICROSECOND)  # are drawn


@dataclass(frozen=True)
class StandingDamping(NumberEffect):
    """Standing damping of the shaft along its whole length, in proportion to its stiffness."""

    says = "The shaft damps itself, and the damping stands still: {standing_damping} times its stiffness"
    check_next = (
        "Tap the rotor at rest, hanging free:"
        " its damping confirms joints, sleeves or windings that the rotor file lacks."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "external_damping": "both damp the whole shaft, the one low modes most, the other high ones; several critical speeds",
        "internal_damping": "damping of the turning shaft drives forward whirl above a critical speed; the onset of instability",
    }

    is_linear = True
    for_drawings_only: ClassVar[bool] = True
    sizes = (Size("standing_damping", "µs", (0.0, LARGEST), drawn=NOTICED),)

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        for index, segment in enumerate(rotor.segments):
            if not isinstance(segment, CouplingSegment):
                yield Place(("segments", index, "standing_damping", 1))  # per stiffness

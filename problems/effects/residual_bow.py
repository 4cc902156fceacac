"""Residual bow: the shaft is bent at rest, and turns with its bend.

Shorter than 40 lines: every bow has these shapes, load and sources (`problems/rotor/extension/bow.py`).

D(Ω) q = f + K_s q_b, with q_b of one or two shapes, the load being the same at all speeds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from problems.rotor.extension.bow import Bow
from problems.rotor.finite_elements.data import Rotor


@dataclass(frozen=True)
class ResidualBow(Bow):
    """The shaft is bent at rest."""

    bends = "The shaft is bent"
    check_next = "Measure runout along the shaft on rollers by dial gauge: a bow of this size confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "runout": "a bow is amplified at a critical speed, runout is not: measure through one, or a second plane",
        "thermal_bow": "a bow of heat is gone when the machine is cold, and run-up and run-down differ by it",
        "coupling_misalignment": "both turn with the shaft at any speed; run uncoupled, or measure the bow on slow roll",
    }

    vector = "bow"

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        return self.bow_loads(rotor, np.ones(len(speed)))

"""Residual bow: the shaft is bent at rest, and turns with its bend.

The shaft's elastic force is K_s (q − q_b), so that its own stiffness times the bow acts as a load that is the same at
all speeds: D(Ω) q = f + K_s q_b, with q_b = w(z) (1, −i) forward. Its shape is half a sine over the whole shaft,
w = sin(πz/L); a straight line may be added to it, K_s does not feel that. Probes read the bow along with the vibration,
less the line through the bearings, as they do of a real shaft.

J. C. Nicholas, E. J. Gunter & P. E. Allaire, Effect of residual shaft bow on unbalance response and balancing of a
single mass flexible rotor, J. Eng. Power 98 (1976) 171–189; Friswell, Penny, Garvey & Lees, Dynamics of Rotating
Machines, 2010, chapter 6.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.units import MICROMETRE
from problems.rotor.extension.effect import RotorEffect
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor.finite_elements.data import Rotor

LARGEST = 100 * MICROMETRE  # a rotor bent more than this is straightened before it is run
NOTICED = (0.3 * MICROMETRE, 30 * MICROMETRE)  # vectors as long as these are drawn


@dataclass(frozen=True)
class ResidualBow(RotorEffect):
    """The shaft is bent at rest, most in its middle."""

    says = "The shaft is bent by {bow} in its middle"
    check_next = "Dial gauge along the shaft on rollers; slow-roll run-out at mid-span; straighten or balance for the bow."
    aliases: ClassVar[Mapping[str, str]] = {
        "runout": "a bow is amplified at a critical speed, runout is not: measure through one, or a second plane",
        "thermal_bow": "a bow of heat is gone when the machine is cold, and run-up and run-down differ by it",
        "coupling_misalignment": "both turn with the shaft at any speed; run uncoupled, or measure the bow on slow roll",
    }

    sizes = (VectorSize("bow", "µm", LARGEST, drawn=NOTICED),)

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        return bow_load(rotor, np.ones(len(speed)))


def bow_load(rotor: Rotor, part: Array) -> ComplexArray:
    """The nodal forces of parts (n_speed,) of a unit bow, (n_speed, n_dof, 1)."""
    elastic = assemble_free(dataclasses.replace(rotor, axial_force=0.0)).stiffness  # an axial force has no memory
    return part[:, None, None] * (elastic @ bow_shape(rotor))[:, None]


def bow_shape(rotor: Rotor) -> ComplexArray:
    """The forward bow of unit size in the rotor's degrees of freedom (x, y, φ_x, φ_y), (n_dof,)."""
    argument = np.pi * rotor.node_positions / rotor.length
    deflection, slope = np.sin(argument), np.pi / rotor.length * np.cos(argument)
    # φ_y = dw_x/dz and φ_x = −dw_y/dz with w_y = −i w_x
    return np.stack([deflection, -1j * deflection, 1j * slope, slope], axis=-1).ravel()

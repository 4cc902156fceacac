"""Young's modulus of the shaft other than assumed: E (1 + e), shear modulus along with it.

All bending modes move alike. Every shaft is a little stiffer or softer than its drawing: shrunk-on disks, temperature
(steel loses 4 % from 20 to 120 °C), the modulus itself (200 to 215 GPa).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.places import Place, material_paths

LARGEST = 0.2
NOTICED = (0.003, 0.1)  # of either sign, are drawn


@dataclass(frozen=True)
class YoungsModulus(NumberEffect):
    """The shaft is stiffer or softer throughout."""

    words = "shaft stiffness"
    says = "The shaft is {youngs_modulus_change:stiffer|softer} in bending than in the model"
    check_next = (
        "Tap the rotor hanging free:"
        " shifted natural frequencies confirm it; then check diameters and material in the rotor file."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "axial_force": "both move all modes; a force moves the lowest most: several critical speeds, or tap the rotor"
        " hanging free",
        "hub_stiffening": "both stiffen the shaft; several critical speeds, whose modes bend that place differently",
        "shear_theory": "both move all modes; shear moves the highest most: several critical speeds, or tap the shaft alone",
        "mass": "both move all modes; weigh the rotor, or tap it hanging free",
        "speed_dependent_stiffness": "both move the peaks; several critical speeds, or tap the rotor hanging free",
        "unbalance": "both change the mix of modes; a trial weight on each disk, a second mode in the band",
    }

    is_linear = True
    sizes = (Size("youngs_modulus_change", "%", LARGEST, drawn=NOTICED),)

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        for path, material in material_paths(rotor):
            yield Place((*path, "young_modulus"), material.young_modulus)

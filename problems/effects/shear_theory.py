"""Shear theory: flexibility between none (Euler–Bernoulli) and more than Timoshenko's.

It is the other beam theory, of the shaft.

Φ = 12EI/(κGAl²) of each element (`problems/rotor/finite_elements/shaft.py`) is multiplied by 1 + s: s = −1 leaves no shear, s = 0 is the
model as it is, s > 0 a shear coefficient κ that is lower than Cowper's by 1/(1 + s), as of slotted, laminated and built-up
shafts. If the model has no shear, s refers to Timoshenko's. Short waves feel shear most: it lowers ω_n² of a beam on
two pins by about 1 + (nπ/L)² EI/(κGA). Rotary inertia stays: it follows from the density, not from the theory.

S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic bars,
Phil. Mag. 41 (1921) 744–746, doi 10.1080/14786442108636264; G. R. Cowper, J. Appl. Mech. 33 (1966) 335–340,
doi 10.1115/1.3625046.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.problem.parameters import Parameter
from problems.rotor.extension.effect import drawn
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import ShaftSegment
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.places import Place, material_paths
from problems.rotor.response.problem import RotorProblem

HIGHEST = 1.0  # twice Timoshenko's: κ of thin tubes is half of that of solid shafts
NOTICED = (0.05, 1.0)  # parts of either limit are drawn


@dataclass(frozen=True)
class ShearTheory(NumberEffect):
    """The shaft is softer or stiffer in shear than the model's beam theory has it."""

    words = "shear stiffness"
    says = "The shaft is {shear_flexibility_change:softer|stiffer} in shear than in the model"
    check_next = (
        "Check bore and wall thickness of hollow and stepped sections: a difference from the rotor file confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "youngs_modulus": "both move all modes; shear moves the highest most: several critical speeds, or tap the shaft alone",
    }

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        shaft = [each for each in problem.rotor.segments if isinstance(each, ShaftSegment)]
        layers = [layer.shear_flexibility for each in shaft for layer in each.layers]
        least = min([*(each.shear_flexibility for each in shaft), *layers])
        return (Parameter("shear_flexibility_change", "%", 0.01, -least, HIGHEST),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        [limits] = self.parameters(problem)
        limit = rng.choice([end for end in (limits.lower, limits.upper) if end])
        return np.array([limit * drawn(rng, *NOTICED)])

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        for path, _ in material_paths(rotor):
            yield Place((*path[:-1], "shear_flexibility"))

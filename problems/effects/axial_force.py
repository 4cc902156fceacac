"""A constant axial force in the whole shaft: tension stiffens it in bending, compression softens it.

Thrust, the pull of a magnet, a tie rod, or a shaft that is hindered from growing as it warms up. It does the work
½ N ∫ (dw/dz)² dz, a geometric stiffness N K_g in addition to the elastic one: of a uniform beam on two pins
ω_n² = (nπ/L)⁴ EI/μ + (nπ/L)² N/μ with μ its mass per length, so that low modes move most (H. D. Nelson, A finite
rotating shaft element using Timoshenko beam theory, J. Mech. Design 102 (1980) 793–803, doi 10.1115/1.3254824). The
shape functions are the element's own, with its shear, and N acts along the bent axis. Internal damping and the load of
a residual bow follow from the elastic stiffness alone.

Its limits are a quarter of the shaft's buckling load on pins at its bearings (`problems/rotor/free_motion/static_load.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.errors import SettingError
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.free_motion.static_load import buckling_load, is_held
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.places import Place
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.25  # of the buckling load: ω₁ falls to √0.75 of its value; a shaft that is nearer buckles under its weight
NOTICED = (0.005, 0.15)  # of the buckling load, of either sign, are drawn


def _buckling_load(problem: RotorProblem) -> float:
    return buckling_load(problem.rotor)


@dataclass(frozen=True)
class AxialForce(NumberEffect):
    """The shaft is in tension or compression."""

    is_linear = True
    if_nowhere: ClassVar[str] = "leave it out: its limits need bearings at two places"
    says = "The shaft is in {axial_force:tension|compression}"
    check_next = (
        "Measure thrust and coupling preload, cold and hot: a natural frequency that shifts with them confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "youngs_modulus": "both move all modes; a force moves the lowest most: several critical speeds, or tap the rotor"
        " hanging free",
        "mass": "both move all modes; a force moves the lowest most: several critical speeds, or tap the rotor"
        " hanging free",
    }

    sizes = (Size("axial_force", "kN", LARGEST, drawn=NOTICED, of=_buckling_load),)

    def locations(self, problem: RotorProblem) -> Sequence[AxialForce]:
        return [self] if is_held(problem.rotor) else []

    def placed_on(self, problem: RotorProblem) -> AxialForce:
        if not self.locations(problem):
            raise SettingError("axial force: expected bearings at two places or more, got one; leave this effect out")
        return self

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        yield Place(("axial_force",))

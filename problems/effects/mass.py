"""Mass of the rotor other than assumed: M (1 + m), gyroscopic matrix along with it.

The density of the shaft, and mass and moments of inertia of all disks, change in one proportion. All modes move alike:
blades, couplings and winding that a drawing leaves out (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines,
2010, chapter 5, for the matrices).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array
from problems.rotor.extension.effect import RotorEffect
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, Material, Segment
from problems.rotor.inputs.numbers import are_known_to_tolerance
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.2
NOTICED = (0.003, 0.1)  # of either sign, are drawn


@dataclass(frozen=True)
class Mass(RotorEffect):
    """The rotor is heavier or lighter throughout."""

    words = "rotor mass"
    says = "The rotor is {mass_change:heavier|lighter} throughout than in the model"
    check_next = "Weigh the rotor: a difference of this size from the rotor file confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "disk_mass": "both lower natural frequencies; several critical speeds, whose modes move that disk differently",
        "added_mass": "both lower natural frequencies; several critical speeds, whose modes move that place differently",
        "axial_force": "both move all modes; a force moves the lowest most: several critical speeds, or tap the rotor"
        " hanging free",
        "hub_stiffening": "both move all modes; several critical speeds, whose modes bend that place differently",
        "youngs_modulus": "both move all modes; weigh the rotor, or tap it hanging free",
        "speed_dependent_stiffness": "both move the peaks; several critical speeds, or weigh the rotor",
        "unbalance": "both change the mix of modes; a trial weight on each disk, a second mode in the band",
        "bearing_mass": "both lower natural frequencies; several critical speeds",
    }

    def locations(self, problem: RotorProblem) -> Sequence[Mass]:
        """Whole rotor as the only location.

        Empty if each mass and the density are known by themselves: one of these is then wrong, not all alike.
        """
        each_by_itself = all(are_known_to_tolerance(problem, field) for field in ("density", "mass"))
        return [] if each_by_itself else [self]

    sizes = (Size("mass_change", "%", LARGEST, drawn=NOTICED),)

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        factor = 1 + float(theta[0])

        def heavier(material: Material) -> Material:
            return dataclasses.replace(material, density=factor * material.density)

        def heavier_segment(segment: Segment) -> Segment:
            if isinstance(segment, CouplingSegment):
                return segment.heavier(factor)
            return segment.with_materials(heavier)

        def heavier_disk(disk: Disk) -> Disk:
            mass, polar, diametral = (
                factor * value for value in (disk.mass, disk.polar_inertia, disk.diametral_inertia)
            )
            return dataclasses.replace(disk, mass=mass, polar_inertia=polar, diametral_inertia=diametral)

        segments = map(heavier_segment, rotor.segments)
        disks, masses = (tuple(map(heavier_disk, parts)) for parts in (rotor.disks, rotor.masses))
        return dataclasses.replace(rotor, segments=tuple(segments), disks=disks, masses=masses)

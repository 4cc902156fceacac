"""Mass of the rotor other than assumed: M (1 + m), gyroscopic matrix along with it.

The density of the shaft, and mass and moments of inertia of all disks, change in one proportion. All modes move alike:
blades, couplings and winding that a drawing leaves out (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines,
2010, chapter 5, for the matrices).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import CouplingSegment
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.numbers import are_known_to_tolerance
from problems.rotor.inputs.places import Place, material_paths
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.2
NOTICED = (0.003, 0.1)  # of either sign, are drawn
OF_DISK = ("mass", "polar_inertia", "diametral_inertia")
OF_COUPLING = ("masses", "polar_inertias", "diametral_inertias")


@dataclass(frozen=True)
class Mass(NumberEffect):
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

    is_linear = True
    sizes = (Size("mass_change", "%", LARGEST, drawn=NOTICED),)

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        for path, material in material_paths(rotor):
            yield Place((*path, "density"), material.density)
        for thing, parts in (("disks", rotor.disks), ("masses", rotor.masses)):
            for index, part in enumerate(parts):
                yield from (Place((thing, index, field), getattr(part, field)) for field in OF_DISK)
        for index, segment in enumerate(rotor.segments):
            if isinstance(segment, CouplingSegment):
                for field in OF_COUPLING:
                    for side, value in enumerate(getattr(segment, field)):
                        yield Place(("segments", index, field, side), value)

"""External damping: the standing surroundings of the shaft damp it along its whole length.

A liquid is an example.

A force −c q̇ per length of shaft, with q̇ as it is seen from the ground. In a viscous liquid c grows as the gap around the
shaft narrows; the mass that the liquid adds is another effect (M. W. Wambsganss, S. S. Chen & J. A. Jendrzejczyk, Added mass
and damping of a vibrating rod in confined viscous fluids, Argonne National Laboratory, ANL-CT-75-08, 1974; for what it does to rotors: Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010,
chapter 7). Of a uniform shaft it damps mode n with a ratio c/(2 μ ω_n), with μ the mass per length: low modes most. Disks
have none of their own here. Whatever turns along with the shaft is `internal_damping`.

Its limit is a damping ratio of 5 % of the rotor as a rigid mass on its stiffest bearing, c L = 2 ζ √(k m).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from problems.rotor.extension.effect import rotor_mass, stiffness_scale
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.inputs.number_effect import NumberEffect
from problems.rotor.inputs.places import Place
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.05  # damping ratio: pumps with liquid around the whole shaft
NOTICED = (0.0005, 0.03)  # damping ratios are drawn


def _per_damping_ratio(problem: RotorProblem) -> float:
    """c of a damping ratio of 1, N s/m²."""
    return float(2 * np.sqrt(stiffness_scale(problem) * rotor_mass(problem)) / problem.rotor.length)


@dataclass(frozen=True)
class ExternalDamping(NumberEffect):
    """The surroundings of the shaft damp it."""

    says = "The surroundings damp the shaft with {external_damping}"
    check_next = "Drain or vent the casing and repeat the run: sharper peaks confirm liquid or gas around the rotor."
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_damping": "both change peak heights; several critical speeds, of which some hardly move the bearings",
        "standing_damping": "both damp the whole shaft, the one low modes most, the other high ones; several critical speeds",
    }

    is_linear = True
    sizes = (Size("external_damping", "N s/m²", (0.0, LARGEST), drawn=NOTICED, of=_per_damping_ratio),)

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        yield Place(("external_damping",))

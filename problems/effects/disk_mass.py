"""One disk heavier or lighter than assumed, its mass and both moments of inertia in one proportion.

Another material, blades, a filled bore.

Unlike `added_mass` as a point, it brings the moments of inertia of the disk along: an impeller that is heavier tilts more slowly
too (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 5, for the matrices of a disk).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.settings.settings import setting
from problems.rotor.extension.sizes import Size
from problems.rotor.inputs.number_effect import PartEffect

LARGEST = 0.3
NOTICED = (0.01, 0.15)  # of either sign, are drawn


@dataclass(frozen=True)
class DiskMass(PartEffect):
    """A disk is heavier or lighter."""

    position: float | None = setting(None, "of the disk; null: the first", unit="m", at_least=0)

    says = "The disk {place} is {disk_mass_change:heavier|lighter} than in the model"
    check_next = "Weigh this disk with all its parts: a difference of this size from the rotor file confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "added_mass": "a disk has moments of inertia too; modes that tilt it, or weigh the disk",
        "disk_inertia": "both change modes that tilt the disk; weigh it, or swing it on wires",
        "mass": "both lower natural frequencies; several critical speeds, whose modes move that disk differently",
    }
    of_rotor = "disks"
    fields = ("mass", "polar_inertia", "diametral_inertia")
    is_linear = True
    is_relative = True
    what, default_place, needs = "disk", "the first disk", "a rotor with a disk"
    sizes = (Size("disk_mass_change", "%", LARGEST, drawn=NOTICED),)

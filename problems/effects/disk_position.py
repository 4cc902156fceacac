"""A disk that sits elsewhere along the shaft than assumed: its inertia acts off the node of the model.

The centre of mass of an impeller lies millimetres off the middle of its hub, and drawings give the hub. The disk moves and turns as the
shaft does there (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 5.4, for the shapes of the element).
"""
# Shorter than 40 lines: one effect a file, by which it is registered.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.settings.settings import setting
from problems.rotor.extension.effect import shaft_length
from problems.rotor.extension.sizes import Size
from problems.rotor.inputs.number_effect import PartEffect

LARGEST = 0.02  # of the shaft's length, to either side
NOTICED = (0.002, 0.015)  # of the shaft's length, to either side, are drawn


@dataclass(frozen=True)
class DiskPosition(PartEffect):
    """A disk sits elsewhere along the shaft."""

    position: float | None = setting(None, "position in the model; null: the first disk", unit="m", at_least=0)

    says = "The disk {place} sits {disk_position_change:further from|nearer to} the shaft's start"
    check_next = "Measure the distance from the disk's centre of mass to a bearing: this offset confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "added_mass": "both change what the disk does to each mode; measure its distance from a bearing, or weigh it",
    }
    of_rotor = "disks"
    fields = ("offset",)
    is_relative = False
    what, default_place, needs = "disk", "the first disk", "a rotor with a disk"
    sizes = (Size("disk_position_change", "mm", LARGEST, drawn=NOTICED, of=shaft_length),)

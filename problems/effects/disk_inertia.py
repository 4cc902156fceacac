"""Moments of inertia of one disk other than assumed, polar and diametral ones in one proportion.

Its mass is as assumed.

A drawing gives the mass of an impeller and leaves its moments of inertia to a formula for a ring. They tilt modes: an overhung disk splits
forward and backward whirl by its polar moment (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 3).
"""
# Shorter than 40 lines: one effect a file, by which it is registered.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.settings.settings import setting
from problems.rotor.extension.sizes import Size
from problems.rotor.inputs.number_effect import PartEffect

LARGEST = 0.3
NOTICED = (0.03, 0.25)  # of either sign, are drawn


@dataclass(frozen=True)
class DiskInertia(PartEffect):
    """A disk has other moments of inertia."""

    position: float | None = setting(None, "of the disk; null: the first", unit="m", at_least=0)

    says = "The disk {place} has {disk_inertia_change:more|less} moment of inertia than in the model"
    check_next = "Compare the disk with its drawing, or swing it on wires: another moment of inertia confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "disk_mass": "both change modes that tilt the disk; weigh it, or swing it on wires",
        "hub_stiffening": "both raise modes that tilt the disk; tap the rotor hanging free, or swing the disk on wires",
    }
    of_rotor = "disks"
    fields = ("polar_inertia", "diametral_inertia")
    is_linear = True
    is_relative = True
    what, default_place, needs = "disk", "the first disk", "a rotor with a disk that has moments of inertia"
    sizes = (Size("disk_inertia_change", "%", LARGEST, drawn=NOTICED),)

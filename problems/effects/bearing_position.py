"""A bearing that holds the shaft elsewhere than assumed: its forces act off the node of the model.

The centre of pressure of a journal bearing lies in its middle only where it is aligned; one that bears at an edge holds the shaft by
half its width nearer to that edge.
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
class BearingPosition(PartEffect):
    """A bearing holds the shaft elsewhere."""

    position: float | None = setting(None, "position in the model; null: the first bearing", unit="m", at_least=0)

    says = "The bearing {place} acts {bearing_position_change:further from|nearer to} the shaft's start"
    check_next = "Measure where the bearing carries: edge wear or a shifted contact pattern confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "unequal_bearings": "both change the share of each bearing; measure the width over which it carries",
    }
    of_rotor = "bearings"
    fields = ("offset",)
    is_relative = False
    what, default_place, needs = "bearing", "the first bearing", "a rotor with a bearing"
    sizes = (Size("bearing_position_change", "mm", LARGEST, drawn=NOTICED, of=shaft_length),)

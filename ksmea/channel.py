"""One probe: where it looks, in which direction, and at which multiple of the speed of rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ksmea.errors import SettingError

DIRECTIONS = ("x", "y")


@dataclass(frozen=True)
class Channel:
    """One probe: where along the shaft it looks (m) and in which direction. Its response q is that at `harmonic` times the
    speed of rotation, Re(q e^{ihΩt}): 1 is 1X, 2 is 2X, 0.5 is ½X.

    >>> print(Channel(0.1, "x"), Channel(0.1, "x", 2.0), sep=", ")
    x at 0.1 m, 2X x at 0.1 m
    """

    position: float
    direction: str
    harmonic: float = 1.0

    def __post_init__(self) -> None:
        if self.direction not in DIRECTIONS:
            raise SettingError(f"direction of a channel: expected x or y, got {self.direction!r}")
        if not 0 < self.harmonic < math.inf:
            raise SettingError(
                f"harmonic of a channel: expected a number above 0, such as 2 for 2X, got {self.harmonic}"
            )

    @property
    def is_1x(self) -> bool:
        return self.harmonic == 1

    def __str__(self) -> str:
        return f"{'' if self.is_1x else f'{self.harmonic:g}X '}{self.direction} at {self.position:g} m"

"""Probe channel: position, direction, and the multiple of the speed of rotation that it measures.

A direction is x, y, or an angle in degrees from x towards y, the sense in which the shaft turns: a probe at θ reads the motion
cos θ x + sin θ y. It is a text, so that x and y stay what files and records call them; every other direction has one name, its
degrees in (−180, 180], such as 45 or -45.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ksmea.errors import SettingError, shortened
from ksmea.units import DEGREE, TURN

DIRECTIONS = ("x", "y")
ANGLES = {"x": 0.0, "y": 90.0}  # degrees
HALF_TURN, FULL_TURN = 180.0, 360.0  # degrees
SAME_POSITION = 1e-9  # m: positions closer than this are one, but for rounding
RESOLUTION = 9  # decimals of an angle in degrees; further ones are rounding
COSINES = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), -90.0: (0.0, -1.0)}  # exact where they are


def direction_at(degrees: float) -> str:
    """The direction at an angle from x towards y, degrees.

    >>> direction_at(0), direction_at(90), direction_at(405), direction_at(-180)
    ('x', 'y', '45', '180')
    """
    if not math.isfinite(degrees):
        raise SettingError(f"direction: expected an angle in degrees, got {degrees}")
    angle = round(HALF_TURN - (HALF_TURN - degrees) % FULL_TURN, RESOLUTION) + 0.0
    return next((name for name, other in ANGLES.items() if other == angle), f"{angle:.12g}")


def require_direction(direction: str, setting: str = "direction") -> None:
    """Raise `SettingError` if a text is not a direction, or is one under another name than its own."""
    try:
        own = direction if direction in DIRECTIONS else direction_at(float(direction))
    except ValueError:  # a `SettingError` too: an angle that is not finite
        raise SettingError(
            f"expected x, y or degrees from x towards y, got {shortened(repr(direction))}", setting=setting
        ) from None
    if own != direction:
        raise SettingError(f"expected {own}, got {shortened(repr(direction))}, another name of it", setting=setting)


def degrees_of(direction: str) -> float:
    """The angle of a direction, degrees from x towards y."""
    return ANGLES[direction] if direction in ANGLES else float(direction)


def named(direction: str) -> str:
    """A direction in words: x, y or 45°."""
    return direction if direction in DIRECTIONS else f"{direction}°"


def cosines(direction: str) -> tuple[float, float]:
    """cos θ and sin θ, the parts of the motion in x and y that a probe in this direction reads.

    >>> cosines("y"), cosines("180")
    ((0.0, 1.0), (-1.0, 0.0))
    """
    degrees = degrees_of(direction)
    return COSINES.get(degrees) or (math.cos(degrees * DEGREE), math.sin(degrees * DEGREE))


@dataclass(frozen=True)
class Channel:
    """Probe at a position of the shaft, with its direction and harmonic.

    Its response q is that at `harmonic` times the speed of rotation, Re(q e^{ihΩt}).

    Args:
        position: position along the shaft, m.
        direction: "x", "y", or degrees from x towards y as a text, such as "45".
        harmonic: multiple h of the speed of rotation; 1 is 1X, 2 is 2X, 0.5 is ½X.

    Raises:
        SettingError: the direction is not one, or the harmonic is not above 0.

    >>> print(Channel(0.1, "x"), Channel(0.1, "x", 2.0), Channel(0.1, "-45"), sep=", ")
    x at 0.1 m, 2X x at 0.1 m, -45° at 0.1 m
    """

    position: float
    direction: str
    harmonic: float = 1.0

    def __post_init__(self) -> None:
        require_direction(self.direction)
        if not 0 < self.harmonic < math.inf:
            raise SettingError(
                f"harmonic of a channel: expected a number above 0, such as 2 for 2X, got {self.harmonic}"
            )

    @property
    def is_1x(self) -> bool:
        """Whether it measures at the speed of rotation."""
        return self.harmonic == 1

    @property
    def angle(self) -> float:
        """Direction, degrees from x towards y."""
        return degrees_of(self.direction)

    @property
    def cosines(self) -> tuple[float, float]:
        """The parts of the motion in x and in y that it reads."""
        return cosines(self.direction)

    @property
    def forward_factor(self) -> complex:
        """Reading of a forward circular motion that x reads as 1: e^{−iθ}."""
        along_x, along_y = self.cosines
        return complex(along_x, -along_y)

    def is_at(self, position: float | None, direction: str | None = None) -> bool:
        """Whether the probe stands at a position and looks in a direction.

        Args:
            position: m, equal but for rounding; None is any.
            direction: as of a channel; None is any.
        """
        stands_there = position is None or abs(self.position - position) <= SAME_POSITION
        return stands_there and direction in (None, self.direction)

    def is_parallel_to(self, other: Channel) -> bool:
        """Whether both read the same motion, or one the negative of the other.

        Args:
            other: another channel.
        """
        across = (self.angle - other.angle) % HALF_TURN
        return min(across, HALF_TURN - across) * DEGREE < 1e-6 * TURN

    def __str__(self) -> str:
        return f"{'' if self.is_1x else f'{self.harmonic:g}X '}{named(self.direction)} at {self.position:g} m"


def further_directions(channels: Sequence[Channel]) -> tuple[str, str]:
    """Two perpendicular directions for further probes.

    They are x and y if there are no probes or if one measures in x or y; otherwise the first direction of the probes
    and a direction at right angles to it, one of the probes if possible.

    >>> further_directions([Channel(0.1, "y")]), further_directions([Channel(0.1, "45"), Channel(0.1, "-45")])
    (('x', 'y'), ('45', '-45'))
    """
    present = list(dict.fromkeys(channel.direction for channel in channels))
    if not present or any(direction in DIRECTIONS for direction in present):
        return ("x", "y")
    across = [direction_at(degrees_of(present[0]) + turn) for turn in (ANGLES["y"], -ANGLES["y"])]
    return present[0], next((each for each in across if each in present), across[0])

"""One probe: where it looks, and in which direction."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.errors import SettingError

DIRECTIONS = ("x", "y")


@dataclass(frozen=True)
class Channel:
    """One probe: where along the shaft it looks (m) and in which direction."""

    position: float
    direction: str

    def __post_init__(self) -> None:
        if self.direction not in DIRECTIONS:
            raise SettingError(f"direction of a channel: expected x or y, got {self.direction!r}")

    def __str__(self) -> str:
        return f"{self.direction} at {self.position:g} m"

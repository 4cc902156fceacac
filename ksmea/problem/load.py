"""One load on the shaft: its position (m), its direction, and its kind, a force or a moment."""
# Shorter than 40 lines: one datum, which floors above and below share.

from __future__ import annotations

from dataclasses import dataclass

from ksmea.errors import SettingError
from ksmea.measurement.channel import DIRECTIONS

FORCE, MOMENT = "force", "moment"
LOADS = (FORCE, MOMENT)


@dataclass(frozen=True)
class Load:
    """Unit force (N) along x or y, or unit moment (N m) about x or y, at a position of the shaft (m).

    Under Re(f e^{iΩt}) it has the frequency of rotation.
    """

    position: float
    direction: str
    quantity: str = FORCE

    def __post_init__(self) -> None:
        if self.direction not in DIRECTIONS:
            raise SettingError(f"direction of a load: expected x or y, got {self.direction!r}")
        if self.quantity not in LOADS:
            raise SettingError(f"kind of a load: expected {' or '.join(LOADS)}, got {self.quantity!r}")

    @property
    def kind(self) -> str:
        """Name of `quantity` in plugins, for one release."""
        return self.quantity

    @property
    def unit(self) -> str:
        return "N" if self.quantity == FORCE else "N m"

"""What a problem that is made of a rotor can tell of how it looks and how it whirls: the contract that drawings ask for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from ksmea.arrays import Array
from ksmea.rotordynamics.layout import RotorLayout
from ksmea.rotordynamics.whirl import Motions


class FreeRotor(ABC):
    """A rotor on its bearings with all numbers given: its layout and its free motions."""

    @abstractmethod
    def layout(self, speed: float) -> RotorLayout:
        """What it is made of; coefficients of bearings are those at a spin speed (rad/s)."""

    @abstractmethod
    def motions(self, speed: Array, *, damping: float = 1.0) -> list[Motions]:
        """The oscillating free motions at spin speeds (n_speed,) rad/s, with a part of all damping and of the part of stiffness that is not
        symmetric; 0: undamped."""

    @abstractmethod
    def frequencies(self, speed: Array, *, damped: bool = True) -> Array:
        """Damped natural frequencies (n_speed, n) rad/s at spin speeds (n_speed,), rising, 0 in place of motions that do not
        oscillate, damped or undamped as above: each column is a continuous function of the speed."""

    @abstractmethod
    def shapes(self, speed: float, places: Sequence[float]) -> Motions:
        """The oscillating free motions at a spin speed (rad/s), read at places (m) of the shaft."""

    @abstractmethod
    def undamped_critical_speeds(self, stiffness: float) -> tuple[Array, Array]:
        """Forward and backward undamped critical speeds (rad/s), rising, on bearings of one stiffness (N/m) in x and y."""

    @property
    @abstractmethod
    def remarks(self) -> tuple[str, ...]:
        """What of the rotor its free motions leave out, in sentences."""


class Rotordynamic(ABC):
    """A problem that can tell all that at values of its unknowns."""

    @abstractmethod
    def free_rotor(self, x: Array, highest: float) -> FreeRotor:
        """The rotor at values x (d,) SI, its free motions true up to a frequency and spin speed (rad/s)."""

"""Free whirling motions of a rotor, as rotordynamics describes them.

A free motion is Re(q e^{λt}), λ = σ + iω_d; forward whirl turns with the shaft. The contract of what tells them, for
drawings, is `FreeRotor`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.rotordynamics.layout import RotorLayout
from ksmea.rotordynamics.margins import SeparationMargin

FORWARD, BACKWARD, MIXED = "forward", "backward", "mixed"
STILL = 1e-3  # of the largest amplitude: places that move less do not vote on the direction of whirl
NO_PEAK = np.sqrt(0.5)  # damping ratio from which on a response has no peak, so that a motion has no critical speed
PREVAILING = 0.9  # of the squared amplitudes of one direction, less those of the other, from which it is called so
STRAIGHT = 1e-6  # an orbit's minor axis relative to its major one below which it is a line, not an ellipse


@dataclass(frozen=True, eq=False)
class Motions:
    """The oscillating free motions at one spin speed (rad/s), by rising frequency.

    Shapes are deflections in x and y at places along the shaft, the largest of each motion 1.
    """

    speed: float
    eigenvalue: ComplexArray  # (n_motion,) rad/s
    shape: ComplexArray  # (n_motion, n_place, 2)

    def first(self, n: int) -> Motions:
        """The n slowest motions that can resonate."""
        kept = np.flatnonzero(damping_ratio(self.eigenvalue) < NO_PEAK)[:n]
        return Motions(self.speed, self.eigenvalue[kept], self.shape[kept])


@dataclass(frozen=True, eq=False)
class Branches:
    """Modes followed over spin speed; NaN if a mode does not oscillate there or could not be followed."""

    speed: Array  # (n_speed,) rad/s
    eigenvalue: ComplexArray  # (n_speed, n_branch) rad/s
    direction: Array  # (n_speed, n_branch) 1 forward, −1 backward, 0 mixed

    @property
    def frequency(self) -> Array:  # damped, rad/s
        return np.asarray(self.eigenvalue.imag)

    @property
    def log_decrement(self) -> Array:  # (n_speed, n_branch)
        return log_decrement(self.eigenvalue)

    @property
    def damping_ratio(self) -> Array:  # (n_speed, n_branch)
        return damping_ratio(self.eigenvalue)


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed (rad/s) at which a damped natural frequency is `harmonic` times the speed."""

    speed: float
    harmonic: float
    eigenvalue: complex  # rad/s
    direction: str
    undamped: float | None = None  # rad/s, the critical speed that it is without any damping

    @property
    def damping_ratio(self) -> float:
        return float(damping_ratio(np.array(self.eigenvalue)))

    @property
    def log_decrement(self) -> float:
        return float(log_decrement(np.array(self.eigenvalue)))

    @property
    def amplification_factor(self) -> float | None:
        """1/(2ζ), what a response to unbalance is multiplied by there.

        None for a motion that grows or is not damped.
        """
        ratio = self.damping_ratio
        return 1 / (2 * ratio) if ratio > 0 else None


@dataclass(frozen=True, eq=False)
class CriticalSpeedMap:
    """Undamped critical speeds over the stiffness of bearings that are all alike and equal in x and y."""

    stiffness: Array  # (n,) N/m
    forward: Array  # (n, n_curve) rad/s, rising; NaN where there are fewer
    backward: Array  # (n, n_curve) rad/s
    of_model: tuple[
        tuple[str, float], ...
    ]  # name and value (N/m) of the stiffnesses that the rotor's own bearings have


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """Modes at one spin speed, at places (n_place,) m that lie close enough to be joined by a line."""

    places: Array
    motions: Motions
    directions: tuple[str, ...]  # of each mode


@dataclass(frozen=True, eq=False)
class Rotordynamics:
    """Geometry and whirl of a rotor at given values of its unknowns."""

    title: str
    values: tuple[tuple[str, str, float], ...]  # name, unit, value in it
    layout: RotorLayout
    highest: float  # rad/s, up to which critical speeds were looked for
    branches: Branches
    harmonics: tuple[float, ...]
    critical_speeds: tuple[CriticalSpeed, ...]
    threshold: float  # rad/s, lowest speed at which a free motion grows; infinite: none up to the highest
    speed_map: CriticalSpeedMap | None  # None: the rotor is not stably held without its bearings' own stiffness
    shapes: ModeShapes
    remarks: tuple[str, ...] = ()
    operating: tuple[float, float] | None = None  # rad/s
    margins: tuple[SeparationMargin, ...] = ()  # of peaks of the response beside it


def damping_ratio(eigenvalue: ComplexArray) -> Array:
    """ζ = −Re λ / |λ|."""
    return np.asarray(-eigenvalue.real / np.abs(eigenvalue)) + 0.0  # no -0


def log_decrement(eigenvalue: ComplexArray) -> Array:
    """δ = −2π Re λ / |Im λ|, the logarithm by which an amplitude shrinks in one turn of the motion."""
    return np.asarray(-2 * np.pi * eigenvalue.real / np.abs(eigenvalue.imag)) + 0.0


def direction_of_whirl(x: ComplexArray, y: ComplexArray) -> str:
    """Direction in which almost all of a shape (n_place,) whirls.

    Orbits are Re(x e^{iωt}), Re(y e^{iωt}); mixed if places differ or move along lines. Squared amplitudes vote, so
    that places that hardly move, as next to a node, make no motion mixed.

    An orbit is a forward circle of radius |x + iy|/2 and a backward one of radius |x − iy|/2; the difference of
    their squares is Im(x ȳ), which is ±(|x|² + |y|²)/2 for a circle and 0 for a line.
    """
    power = np.abs(x) ** 2 + np.abs(y) ** 2
    round_by = np.nan_to_num(roundness(x, y))
    votes = np.where(np.abs(round_by) > STRAIGHT, np.sign(round_by), 0.0)
    share = float(np.sum(power * votes) / np.sum(power))
    return FORWARD if share > PREVAILING else BACKWARD if share < -PREVAILING else MIXED


def roundness(x: ComplexArray, y: ComplexArray) -> Array:
    """Roundness of the orbit at each place (n_place,): 1 a forward circle, −1 a backward one, 0 a line.

    NaN if it hardly moves.
    """
    power = np.abs(x) ** 2 + np.abs(y) ** 2
    moving = power > STILL**2 * power.max()
    return np.where(moving, 2 * np.imag(x * y.conj()) / np.where(moving, power, 1.0), np.nan)


@dataclass(frozen=True, eq=False)
class Mode:
    """One damped mode at one speed."""

    frequency: float  # damped, rad/s
    damping_ratio: float
    whirl: str  # forward, backward, or mixed where nodes differ or move along lines
    shape: ComplexArray  # (n_node, 4): x, y, φ_x, φ_y, scaled to a largest deflection of 1


@dataclass(frozen=True, eq=False)
class Campbell:
    """Natural frequencies over spin speed, each row rising; NaN if a speed has fewer oscillating modes."""

    speed: Array  # (n_speed,) rad/s
    frequency: Array  # (n_speed, n_mode) damped, rad/s
    damping_ratio: Array  # (n_speed, n_mode); below 0: unstable


class FreeRotor(ABC):
    """A rotor on its bearings with all numbers given: its layout and its free motions."""

    @abstractmethod
    def layout(self, speed: float) -> RotorLayout:
        """Parts of the rotor; coefficients of bearings are evaluated at a spin speed (rad/s)."""

    @abstractmethod
    def motions(self, speed: Array, *, damping: float = 1.0) -> list[Motions]:
        """Oscillating free vibrations at spin speeds (n_speed,) rad/s, with a part of all damping.

        The part also applies to the part of stiffness that is not symmetric; 0: undamped.
        """

    @abstractmethod
    def frequencies(self, speed: Array, *, damped: bool = True) -> Array:
        """Natural frequencies (n_speed, n) rad/s at spin speeds (n_speed,), rising, 0 if not oscillating.

        They are damped, or undamped as in `motions`: each column is a continuous function of the speed.
        """

    @abstractmethod
    def shapes(self, speed: float, places: Sequence[float]) -> Motions:
        """The oscillating free motions at a spin speed (rad/s), read at places (m) of the shaft."""

    @abstractmethod
    def undamped_critical_speeds(self, stiffness: float) -> tuple[Array, Array]:
        """Forward and backward undamped critical speeds (rad/s), rising, on equal bearings.

        Their stiffness (N/m) is equal in x and y.
        """

    @property
    @abstractmethod
    def remarks(self) -> tuple[str, ...]:
        """Parts of the rotor that its free motions leave out, in sentences."""


class Rotordynamic(ABC):
    """A problem that can tell all that at values of its unknowns."""

    @abstractmethod
    def free_rotor(self, x: Array, highest: float) -> FreeRotor:
        """The rotor at values x (d,) SI, its free motions true up to a frequency and spin speed (rad/s)."""

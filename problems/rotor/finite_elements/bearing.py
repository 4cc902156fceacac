"""Bearings and seals: linear forces at a node, constant or as tables over the speed of rotation, on the ground or on a pedestal.

The force on the shaft is −(K q + C q̇ + M q̈) with full 2 × 2 matrices, q the motion of the shaft against the ground or, on a pedestal,
against the housing. K, C and M are functions of the speed of rotation Ω, a pedestal's stiffness a function of the frequency of the motion.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from scipy.interpolate import PchipInterpolator

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError

STIFFNESSES = ("kxx", "kxy", "kyx", "kyy")  # the 2 × 2 matrix of a bearing, row by row
DAMPINGS = ("cxx", "cxy", "cyx", "cyy")
MASSES = ("mxx", "mxy", "myx", "myy")
COEFFICIENTS = STIFFNESSES + DAMPINGS + MASSES
GROUP_FACTORS = ("stiffness_factor", "damping_factor", "mass_factor")  # on all four entries of K, C, M in a table

MAX_KEPT = 8  # interpolations of a table
LARGEST = (
    1e30  # SI, of any number of a rotor, and its reciprocal the smallest: fourth powers neither overflow nor vanish
)


@dataclass(frozen=True)
class SpeedTable:
    """Rows of numbers over rising speeds (rad/s), interpolated by PCHIP through its points; the row at an end holds beyond it."""

    speed: tuple[float, ...]
    rows: tuple[tuple[float, ...], ...]  # (n_speed, n_column)

    def __post_init__(self) -> None:
        if not self.speed or any(after <= before for before, after in pairwise(self.speed)):
            raise SettingError(f"speeds of a table: expected a list that rises, got {list(self.speed)}")
        if len(self.rows) != len(self.speed):
            raise SettingError(f"rows of a table: expected {len(self.speed)}, one for each speed, got {len(self.rows)}")
        if not np.all(np.abs(np.array(self.rows)) <= LARGEST):
            raise SettingError("rows of a table: expected numbers, got one that is none")

    def at(self, speed: Array) -> Array:
        """(n_speed, n_column) at speeds (n_speed,) rad/s."""
        if len(self.speed) == 1:
            return np.tile(np.array(self.rows[0]), (len(speed), 1))
        if (kept := self._kept.get(speed.tobytes())) is None:
            kept = np.asarray(self._interpolator(np.clip(speed, self.speed[0], self.speed[-1])))
            kept.setflags(write=False)
            if len(self._kept) >= MAX_KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[speed.tobytes()] = kept
        return kept

    @cached_property
    def _interpolator(self) -> PchipInterpolator:
        return PchipInterpolator(np.array(self.speed), np.array(self.rows), axis=0)

    @cached_property
    def _kept(self) -> dict[bytes, Array]:
        """Rows at the speeds that were asked for last: fits ask for the same ones again and again."""
        return {}

    def beyond(self, speed: Array) -> tuple[float, float] | None:
        """The first and the last of these speeds (rad/s) if any lies beyond the table."""
        low, high = float(np.min(speed)), float(np.max(speed))
        slack = 1e-9 * self.speed[-1]
        return (low, high) if low < self.speed[0] - slack or high > self.speed[-1] + slack else None


@dataclass(frozen=True)
class Pedestal:
    """The support of one bearing, between its housing and the ground: z = K (1 + iη sgn ω) + iωC − ω²M at a frequency ω of the motion, and
    `dynamic_stiffness` beside it, if it was measured: eight columns, Re and Im of zxx zxy zyx zyy (N/m) over the frequency (rad/s)."""

    kxx: float = 0.0
    kxy: float = 0.0
    kyx: float = 0.0
    kyy: float = 0.0
    cxx: float = 0.0
    cxy: float = 0.0
    cyx: float = 0.0
    cyy: float = 0.0
    mxx: float = 0.0
    mxy: float = 0.0
    myx: float = 0.0
    myy: float = 0.0
    loss_factor: float = 0.0
    dynamic_stiffness: SpeedTable | None = None

    def __post_init__(self) -> None:
        _require_numbers(self, "support")

    def impedance(self, frequency: Array) -> ComplexArray:
        """z at frequencies (n,) rad/s, (n, 2, 2) N/m."""
        stiffness, damping, mass = _matrices(self)
        sign, omega = np.sign(frequency)[:, None, None], np.asarray(frequency)[:, None, None]
        measured = np.moveaxis(self.measured(frequency), -1, 0)
        elastic = stiffness * (1 + 1j * self.loss_factor * sign)
        return np.asarray(elastic + 1j * omega * damping - omega**2 * mass + measured, dtype=complex)

    def matrices(self, speed: float = 0.0) -> tuple[ComplexArray, Array, Array]:
        """K (1 + iη), C and M, (2, 2) each; `dynamic_stiffness` as spring and damper at a frequency (rad/s), at 0 without damper."""
        stiffness, damping, mass = _matrices(self)
        measured = self.measured(np.array([speed]))[..., 0]
        elastic = stiffness * complex(1, self.loss_factor) + measured.real
        return np.asarray(elastic), damping + (measured.imag / speed if speed else 0.0), mass

    def measured(self, frequency: Array) -> ComplexArray:
        """`dynamic_stiffness` at frequencies (n,) rad/s, (2, 2, n) N/m."""
        if self.dynamic_stiffness is None:
            return np.zeros((2, 2, len(frequency)), dtype=complex)
        parts = self.dynamic_stiffness.at(np.abs(frequency)).T.reshape(4, 2, len(frequency))
        return (parts[:, 0] + 1j * np.sign(frequency) * parts[:, 1]).reshape(2, 2, -1)


@dataclass(frozen=True)
class Bearing:
    """A linear bearing or seal at a node. With a table, K = K₀ + factors · table, entry by entry, and C and M likewise."""

    position: float  # m
    kxx: float = 0.0  # N/m
    kxy: float = 0.0
    kyx: float = 0.0
    kyy: float = 0.0
    cxx: float = 0.0  # N s/m
    cxy: float = 0.0
    cyx: float = 0.0
    cyy: float = 0.0
    mxx: float = 0.0  # kg
    mxy: float = 0.0
    myx: float = 0.0
    myy: float = 0.0
    table: SpeedTable | None = None  # twelve columns in the order of COEFFICIENTS
    factors: tuple[float, ...] = field(default=(1.0,) * len(COEFFICIENTS))  # of the table's columns
    pedestal: Pedestal | None = None  # None: rigid ground

    def __post_init__(self) -> None:
        _require_numbers(self, f"bearing at {self.position:g} m")
        if self.table is not None and len(self.table.rows[0]) != len(COEFFICIENTS):
            raise SettingError(
                f"table of the bearing at {self.position:g} m: expected {len(COEFFICIENTS)} columns, got"
                f" {len(self.table.rows[0])}"
            )

    @property
    def stiffness(self) -> Array:  # (2, 2) N/m, without its table
        return _matrices(self)[0]

    @property
    def damping(self) -> Array:  # (2, 2) N s/m
        return _matrices(self)[1]

    @property
    def mass(self) -> Array:  # (2, 2) kg
        return _matrices(self)[2]

    def matrices_at(self, speed: Array) -> tuple[Array, Array, Array]:
        """K (N/m), C (N s/m) and M (kg) at speeds of rotation (n_speed,) rad/s, (n_speed, 2, 2) each."""
        speed = np.asarray(speed, dtype=float)
        whole = np.tile(numbers_of(self), (len(speed), 1))
        if self.table is not None:
            whole = whole + np.array(self.factors) * self.table.at(speed)
        stiffness, damping, mass = whole.reshape(len(speed), 3, 2, 2).transpose(1, 0, 2, 3)
        return stiffness, damping, mass

    def impedance(self, speed: Array, harmonic: float = 1.0) -> ComplexArray:
        """K + iωC − ω²M of a motion at ω = hΩ, h the harmonic, at speeds (n_speed,) rad/s, (n_speed, 2, 2) N/m."""
        stiffness, damping, mass = self.matrices_at(speed)
        omega = (harmonic * np.asarray(speed))[:, None, None]
        return np.asarray(stiffness + 1j * omega * damping - omega**2 * mass, dtype=complex)


Coefficients = TypeVar("Coefficients", Bearing, Pedestal)


def numbers_of(bearing: Bearing | Pedestal) -> list[float]:
    """Its coefficients in the order of COEFFICIENTS."""
    return [getattr(bearing, name) for name in COEFFICIENTS]


def with_numbers(bearing: Bearing, own: Array, factors: Array, of_pedestal: Array) -> Bearing:
    """The bearing with other coefficients (12,), factors of its table (12,), and coefficients of its pedestal (12,)."""
    changed = with_coefficients(bearing, own)
    if bearing.table is not None:
        changed = dataclasses.replace(changed, factors=tuple(map(float, factors)))
    if bearing.pedestal is not None:
        changed = dataclasses.replace(changed, pedestal=with_coefficients(bearing.pedestal, of_pedestal))
    return changed


def with_coefficients(of: Coefficients, values: Array) -> Coefficients:
    """A bearing or pedestal with other coefficients (12,), in the order of COEFFICIENTS."""
    numbers: dict[str, Any] = dict(zip(COEFFICIENTS, map(float, values), strict=True))
    return dataclasses.replace(of, **numbers)


def _matrices(bearing: Bearing | Pedestal) -> tuple[Array, Array, Array]:
    stiffness, damping, mass = np.array(numbers_of(bearing)).reshape(3, 2, 2)
    return stiffness, damping, mass


def _require_numbers(bearing: Bearing | Pedestal, what: str) -> None:
    for name in COEFFICIENTS:
        if not abs(getattr(bearing, name)) <= LARGEST:
            raise SettingError(f"{name} of the {what}: expected a number, got {getattr(bearing, name)}")

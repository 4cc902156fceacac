"""Bearings and seals: linear forces at a node, on the ground or on a pedestal.

They are constant or tables over the speed of rotation.

The force on the shaft is −(K q + C q̇ + M q̈) with full 2 × 2 matrices, q the motion of the shaft against the ground or, on a pedestal,
against the housing. K, C and M are functions of the speed of rotation Ω, a pedestal's stiffness a function of the frequency of the motion.

A support that an effect adds is in series with a bearing, or with all of them: a spring with a loss factor and a mass in each axis.

With z_b the bearing's impedance and a the support's dynamic compliance, the shaft feels z = (1 + z_b a)⁻¹ z_b; a = 0 is
a bearing on rigid ground. The compliance is a function of the frequency of the motion, whatever the spin
speed is: a = s / (1 + iη sgn ω − s ω² m), s the compliance of the spring. Bearings that stand on a common support feel each
other: it moves by v = a Σ z_b (q_b − v), so that bearing b pushes with z_b (q_b − v), v = (1 + a Σ z_b)⁻¹ a Σ z_b q_b.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.numerics.differences import recent

STIFFNESSES = ("kxx", "kxy", "kyx", "kyy")  # the 2 × 2 matrix of a bearing, row by row
DAMPINGS = ("cxx", "cxy", "cyx", "cyy")
MASSES = ("mxx", "mxy", "myx", "myy")
COEFFICIENTS = STIFFNESSES + DAMPINGS + MASSES
IS_CROSSED = np.array([name[1:] in ("xy", "yx") for name in COEFFICIENTS])
GROUP_FACTORS = ("stiffness_factor", "damping_factor", "mass_factor")  # on all four entries of K, C, M in a table

MAX_KEPT = 8  # interpolations of a table
# SI, of any number of a rotor, and its reciprocal the smallest: fourth powers neither overflow nor vanish
LARGEST = 1e30


@dataclass(frozen=True)
class SpeedTable:
    """Rows of numbers over rising speeds (rad/s), interpolated by PCHIP through its points.

    The row at an end holds beyond it.
    """

    speed: tuple[float, ...]
    rows: tuple[tuple[float, ...], ...]  # (n_speed, n_column)

    def __post_init__(self) -> None:
        if not self.speed or any(after <= before for before, after in pairwise(self.speed)):
            raise SettingError(f"speeds of a table: expected a list that rises, got {list(self.speed)}")
        if len(self.rows) != len(self.speed):
            raise SettingError(f"rows of a table: expected {len(self.speed)}, one for each speed, got {len(self.rows)}")
        if not np.all(np.abs(np.array(self.rows)) <= LARGEST):
            raise SettingError("rows of a table: expected numbers, got a value that is not a number")

    def at(self, speed: Array) -> Array:
        """(n_speed, n_column) at speeds (n_speed,) rad/s."""
        if len(self.speed) == 1:
            return np.tile(np.array(self.rows[0]), (len(speed), 1))
        return recent(self._kept, speed.tobytes(), lambda: self._interpolated(speed), MAX_KEPT)

    def _interpolated(self, speed: Array) -> Array:
        rows = np.asarray(self._interpolator(np.clip(speed, self.speed[0], self.speed[-1])))
        rows.setflags(write=False)
        return rows

    @cached_property
    def _interpolator(self) -> scipy.interpolate.PchipInterpolator:
        return scipy.interpolate.PchipInterpolator(np.array(self.speed), np.array(self.rows), axis=0)

    @cached_property
    def _kept(self) -> OrderedDict[bytes, Array]:
        """Rows at the speeds used last, which a fit requests at each step."""
        return OrderedDict()

    def beyond(self, speed: Array) -> tuple[float, float] | None:
        """The first and the last of these speeds (rad/s) if any lies beyond the table."""
        low, high = float(np.min(speed)), float(np.max(speed))
        slack = 1e-9 * self.speed[-1]
        return (low, high) if low < self.speed[0] - slack or high > self.speed[-1] + slack else None


@dataclass(frozen=True)
class Pedestal:
    """The support of one bearing, between its housing and the ground.

    Z = K (1 + iη sgn ω) + iωC − ω²M at a frequency ω of the motion, plus the `dynamic_stiffness`, if it was measured:
    eight columns, Re and Im of zxx zxy zyx zyy (N/m) over the frequency (rad/s).
    """

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
        """K (1 + iη), C and M, (2, 2) each.

        `dynamic_stiffness` as spring and damper at a frequency (rad/s), at 0 without damper.
        """
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
    """A linear bearing or seal at a node, or off it by an `offset`.

    With a table, K = K₀ + factors · table, entry by entry, and C and M likewise.
    """

    position: float  # m, of its node
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
    offset: float = 0.0  # m

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

    @property
    def largest_stiffness(self) -> float:
        """The largest entry of K in size, at any speed of its table, N/m."""
        speeds = np.zeros(1) if self.table is None else np.array(self.table.speed)
        return float(np.abs(self.matrices_at(speeds)[0]).max())

    def matrices_at(self, speed: Array) -> tuple[Array, Array, Array]:
        """K (N/m), C (N s/m) and M (kg) at speeds of rotation (n_speed,) rad/s, (n_speed, 2, 2) each."""
        speed = np.asarray(speed, dtype=float)
        whole = np.tile(numbers_of(self), (len(speed), 1))
        if self.table is not None:
            whole = whole + np.array(self.factors) * self.table.at(speed)
        stiffness, damping, mass = whole.reshape(len(speed), 3, 2, 2).transpose(1, 0, 2, 3)
        return stiffness, damping, mass

    def impedance(self, speed: Array, harmonic: float = 1.0) -> ComplexArray:
        """Impedance K + iωC − ω²M of a motion at ω = hΩ, (n_speed, 2, 2) N/m.

        h is the harmonic, at speeds (n_speed,) rad/s.
        """
        stiffness, damping, mass = self.matrices_at(speed)
        omega = (harmonic * np.asarray(speed))[:, None, None]
        return np.asarray(stiffness + 1j * omega * damping - omega**2 * mass, dtype=complex)


Coefficients = TypeVar("Coefficients", Bearing, Pedestal)


def numbers_of(bearing: Bearing | Pedestal) -> list[float]:
    """Its coefficients in the order of COEFFICIENTS."""
    return [getattr(bearing, name) for name in COEFFICIENTS]


def with_numbers(bearing: Bearing, own: Array, factors: Array, of_pedestal: Array) -> Bearing:
    """Bearing with other coefficients (12,), table factors (12,) and pedestal coefficients (12,)."""
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


def mirrored_bearing(bearing: Bearing) -> Bearing:
    """The bearing with y reversed: cross-coupled coefficients change sign."""
    signs = np.where(IS_CROSSED, -1.0, 1.0)
    changed = with_coefficients(bearing, signs * numbers_of(bearing))
    if bearing.table is not None:
        changed = dataclasses.replace(changed, table=_times(bearing.table, signs))
    if (pedestal := bearing.pedestal) is not None:
        own = with_coefficients(pedestal, signs * numbers_of(pedestal))
        if pedestal.dynamic_stiffness is not None:
            of_measured = np.array([1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0])
            own = dataclasses.replace(own, dynamic_stiffness=_times(pedestal.dynamic_stiffness, of_measured))
        changed = dataclasses.replace(changed, pedestal=own)
    return changed


def _times(table: SpeedTable, signs: Array) -> SpeedTable:
    return SpeedTable(table.speed, tuple(tuple(map(float, signs * row)) for row in table.rows))


def _matrices(bearing: Bearing | Pedestal) -> tuple[Array, Array, Array]:
    stiffness, damping, mass = np.array(numbers_of(bearing)).reshape(3, 2, 2)
    return stiffness, damping, mass


def _require_numbers(bearing: Bearing | Pedestal, what: str) -> None:
    for name in COEFFICIENTS:
        if not abs(getattr(bearing, name)) <= LARGEST:
            raise SettingError(f"{name} of the {what}: expected a number, got {getattr(bearing, name)}")


@dataclass(frozen=True, eq=False)
class Support:
    """Supports of all bearings, which are alike, or their common support, for n parameter sets."""

    spring: Array  # (2 axes, n) m/N, compliance
    mass: Array  # (n,) kg
    loss_factor: float | Array  # η of the springs, of all sets or (n,)
    is_common: bool = False

    def compliance(self, frequency: Array) -> ComplexArray:
        """Dynamic compliance (2 axes, n, n_frequency) m/N at frequencies (n_frequency,) rad/s."""
        spring, mass = self.spring[:, :, None], self.mass[:, None]
        loss = np.reshape(self.loss_factor, (-1, 1)) * np.sign(frequency)
        return np.asarray(spring / (1 + 1j * loss - spring * mass * frequency**2))


def in_series(impedance: ComplexArray, compliance: ComplexArray) -> ComplexArray:
    """Impedance (1 + z a)⁻¹ z of 2 × 2 impedances and compliances in series.

    Impedances are (n_bearing, 2, 2, n, n_frequency), compliances (2, n, n_frequency).
    """
    (xx, xy), (yx, yy) = np.moveaxis(impedance, 0, 2)
    a_x, a_y = compliance[:, None]
    own_x, own_y = 1 + xx * a_x, 1 + yy * a_y
    determinant = own_x * own_y - xy * a_y * yx * a_x
    changed = np.empty_like(impedance)
    changed[:, 0, 0] = (own_y * xx - xy * a_y * yx) / determinant
    changed[:, 0, 1] = (own_y * xy - xy * a_y * yy) / determinant
    changed[:, 1, 0] = (own_x * yx - yx * a_x * xx) / determinant
    changed[:, 1, 1] = (own_x * yy - yx * a_x * xy) / determinant
    return changed


def in_series_with(supports: Sequence[Support], impedance: ComplexArray, frequency: Array) -> ComplexArray:
    """Impedances of bearings (n_bearing, 2, 2, n, n_frequency) on supports of their own."""
    for support in supports:
        if not support.is_common:
            impedance = in_series(impedance, support.compliance(frequency))
    return impedance


def ports_on(supports: Sequence[Support], impedance: ComplexArray, frequency: Array) -> ComplexArray:
    """Impedances (n_port, n_port, n, n_frequency) from the motion of any port to the force on any other.

    They are of bearings (n_bearing, 2, 2, n, n_frequency) on all supports.
    """
    impedance = in_series_with(supports, impedance, frequency)
    n_port, shape = 2 * len(impedance), impedance.shape[-2:]
    common = np.zeros((2, *shape), dtype=complex)
    for support in supports:
        if support.is_common:
            common += support.compliance(frequency)
    return on_common(impedance, common).reshape(n_port, n_port, *shape)


def on_common(impedance: ComplexArray, compliance: ComplexArray) -> ComplexArray:
    """Impedances of bearings that stand together on a compliance (2, n, n_frequency).

    They are (n_bearing, 2, 2, n, n_frequency) alone; together, from the motion of one bearing (second n_bearing) to the
    force on another, (n_bearing, 2, n_bearing, 2, n, n_frequency) N/m.
    """
    unit = np.eye(2)[..., None, None]
    carried = inverse(unit + compliance[:, None] * impedance.sum(axis=0))
    moved = [product(carried, compliance[:, None] * each) for each in impedance]  # v per motion of each bearing
    coupled = np.empty((len(impedance), 2, *impedance.shape[:2], *compliance.shape[1:]), dtype=complex)
    for bearing, own in enumerate(impedance):
        for other, motion in enumerate(moved):
            coupled[bearing, :, other] = product(own, unit - motion if other == bearing else -motion)
    return coupled


def product(one: ComplexArray | Array, other: ComplexArray | Array) -> ComplexArray:
    """Matrix products (2, 2, …)."""
    return np.asarray(one[:, 0, None] * other[None, 0] + one[:, 1, None] * other[None, 1])


def inverse(matrices: ComplexArray | Array) -> ComplexArray:
    """Inverse matrices (2, 2, …)."""
    (a, b), (c, d) = matrices
    return np.array([[d, -b], [-c, a]]) / (a * d - b * c)

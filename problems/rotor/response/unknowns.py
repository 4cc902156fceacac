"""Unknowns of a rotor: each sets one or more of its numbers; their impedances, for surrogates.

An unknown with several targets ties them: two equal bearings have one kxx that sets both.
"""

from __future__ import annotations

import dataclasses
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import unknown
from ksmea.problem.parameters import Parameter
from ksmea.problem.response_structure import UnknownImpedance
from problems.rotor.finite_elements.bearing import (
    COEFFICIENTS,
    GROUP_FACTORS,
    MASSES,
    STIFFNESSES,
    Bearing,
    Pedestal,
    numbers_of,
    with_coefficients,
    with_numbers,
)
from problems.rotor.finite_elements.data import Rotor

UNBALANCE_PARTS = ("magnitude", "phase")
PEDESTAL_PARTS = (*COEFFICIENTS, "mass")
FACTORS = (*GROUP_FACTORS, *(f"{name}_factor" for name in COEFFICIENTS))
COLUMNS_OF: dict[str, tuple[int, ...]] = {
    **{name: (index,) for index, name in enumerate(COEFFICIENTS)},
    **{f"{name}_factor": (index,) for index, name in enumerate(COEFFICIENTS)},
    **{name: tuple(range(4 * group, 4 * group + 4)) for group, name in enumerate(GROUP_FACTORS)},
    "mass": (COEFFICIENTS.index("mxx"), COEFFICIENTS.index("myy")),
}
CARTESIAN_PARTS = ("x", "y")  # in their place: the components at 0° and at 90°, of either sign


@dataclass(frozen=True)
class BearingTarget:
    """Coefficient of one bearing or seal, or a factor on its table, by its index in `Rotor.supported`.

    `kxx_factor` acts on one column, `stiffness_factor` on all four of K.
    """

    bearing: int
    coefficient: str

    def __post_init__(self) -> None:
        if self.coefficient not in (*COEFFICIENTS, *FACTORS):
            raise unknown("bearing coefficient", self.coefficient, (*COEFFICIENTS, *FACTORS))

    @property
    def is_factor(self) -> bool:
        return self.coefficient in FACTORS

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices in COEFFICIENTS of the coefficients it sets."""
        return COLUMNS_OF[self.coefficient]


@dataclass(frozen=True)
class PedestalTarget:
    """Coefficient of the pedestal of a bearing, or its `mass` in x and y.

    The bearing has an index in `Rotor.supported`.
    """

    bearing: int
    coefficient: str

    def __post_init__(self) -> None:
        if self.coefficient not in PEDESTAL_PARTS:
            raise unknown("support coefficient", self.coefficient, PEDESTAL_PARTS)

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices in COEFFICIENTS of the coefficients it sets."""
        return COLUMNS_OF[self.coefficient]


@dataclass(frozen=True)
class UnbalanceTarget:
    """Magnitude (kg m), phase (rad) or Cartesian component (kg m) of the unbalance in one plane.

    The plane has an index in `Rotor.unbalance`.
    """

    plane: int
    part: str = "magnitude"

    def __post_init__(self) -> None:
        known = (*UNBALANCE_PARTS, *CARTESIAN_PARTS)
        if self.part not in known:
            raise unknown("part of an unbalance", self.part, known)

    @property
    def turns(self) -> bool:
        """Whether it frees the angle of its plane, alone or with the other component."""
        return self.part != "magnitude"


@dataclass(frozen=True)
class OriginTarget:
    """An angle (rad) added to the phases of all unbalance: the origin of the measured phases."""


Target = BearingTarget | PedestalTarget | UnbalanceTarget | OriginTarget


def changes_sign(target: Target) -> bool:
    """Whether what it sets has the other sign with y reversed."""
    if isinstance(target, (BearingTarget, PedestalTarget)):
        return target.coefficient[1:] in ("xy", "yx")
    return isinstance(target, OriginTarget) or target.part in ("phase", "y")


@dataclass(frozen=True)
class Unknown:
    """A parameter and all that it sets."""

    parameter: Parameter
    targets: tuple[Target, ...]


@dataclass(frozen=True, eq=False)
class Inputs:
    """The numbers of a rotor that unknowns may set, for a batch of parameter sets."""

    own: RotorNumbers  # for all that they do not set
    coefficients: Array  # (n, n_supported, 12) in the order of COEFFICIENTS, N/m, N s/m, kg
    factors: Array  # (n, n_supported, 12) on the columns of tables
    pedestals: Array  # (n, n_supported, 12) as of `coefficients`
    unbalance: Array  # (n, n_plane, 2): magnitude in kg m, phase in rad
    origin: Array  # (n,) rad, by which all phases are turned

    @property
    def complex_unbalance(self) -> ComplexArray:  # (n, n_plane) kg m
        return _complex(self.unbalance)

    @property
    def rotor(self) -> Rotor:
        return self.own.rotor

    def bearings_at(self, speed: Array) -> tuple[Array, Array, Array]:
        """Stiffness N/m, damping N s/m and mass kg of bearings and seals at spin speeds (n_speed,) rad/s.

        They are (n_supported, 2, 2, n, n_speed) each; the last axis is 1 if they are equal at all speeds. Responses,
        loads and free motion take bearings from here; the dense route and modes take them from `rotor_at`.
        """
        n, n_supported = self.coefficients.shape[:2]
        parts = self.coefficients.transpose(1, 2, 0)[..., None]
        if self.own.has_tables:
            tables = np.stack([columns_at(bearing, speed) for bearing in self.rotor.supported])
            parts = parts + self.factors.transpose(1, 2, 0)[..., None] * tables[:, :, None]
        parts = parts.reshape(n_supported, len(COEFFICIENTS) // len(STIFFNESSES), 2, 2, n, parts.shape[-1])
        return parts[:, 0], parts[:, 1], parts[:, 2]

    def pedestals_of(self, index: int) -> tuple[tuple[int, Pedestal], ...]:
        """Pedestals of one parameter set, each with the index of its bearing."""
        found = []
        for bearing, each in enumerate(self.rotor.supported):
            if each.pedestal is not None:
                found.append((bearing, with_coefficients(each.pedestal, self.pedestals[index, bearing])))
        return tuple(found)

    def pedestal_impedance(self, bearing: int, frequency: Array) -> ComplexArray:
        """Impedance of the support of one bearing at frequencies (n_speed,) rad/s, (2, 2, n, n_speed) N/m."""
        pedestal = self.rotor.supported[bearing].pedestal
        assert pedestal is not None, "a bearing without a support"
        stiffness, damping, mass = self.pedestals[:, bearing].T.reshape(3, 2, 2, -1, 1)
        return np.asarray(
            stiffness * (1 + 1j * pedestal.loss_factor * np.sign(frequency))
            + 1j * frequency * damping
            - frequency**2 * mass
            + pedestal.measured(frequency)[:, :, None]
        )

    def pedestal_impedances(self, bearings: Iterable[int], frequency: Array) -> dict[int, ComplexArray]:
        """`pedestal_impedance` of bearings, once for each, however many of its entries are requested."""
        return {bearing: self.pedestal_impedance(bearing, frequency) for bearing in set(bearings)}


def columns_at(bearing: Bearing, speed: Array) -> Array:
    """The table of a bearing at speeds (n_speed,) rad/s, (12, n_speed); zeros without one."""
    if bearing.table is None:
        return np.zeros((len(COEFFICIENTS), len(speed)))
    return bearing.table.at(speed).T


@dataclass(frozen=True, eq=False)
class RotorNumbers:
    """Numbers of a rotor that unknowns may set, as arrays, and which unknown sets which.

    Shapes as in `Inputs`, without the first axis.
    """

    rotor: Rotor
    coefficients: Array
    factors: Array
    pedestals: Array
    unbalance: Array
    # Column of x, bearing or plane, and column of the array, for each number that an unknown sets, (3, n) each
    set_coefficients: Indices
    set_factors: Indices
    set_pedestals: Indices
    set_unbalance: Indices
    components: tuple[tuple[int, int, complex], ...]  # column of x, plane, direction of a Cartesian part
    origin: int | None  # column of x
    n_unknown: int

    @classmethod
    def of(cls, rotor: Rotor, unknowns: Sequence[Unknown]) -> RotorNumbers:
        supported, width = rotor.supported, len(COEFFICIENTS)
        pedestals = [numbers_of(bearing.pedestal or Pedestal()) for bearing in supported]
        unbalance = [[getattr(plane, part) for part in UNBALANCE_PARTS] for plane in rotor.unbalance]
        targets = [(column, target) for column, item in enumerate(unknowns) for target in item.targets]
        of_bearings = [(column, each) for column, each in targets if isinstance(each, BearingTarget)]
        of_planes = [(column, each) for column, each in targets if isinstance(each, UnbalanceTarget)]
        return cls(
            rotor,
            np.reshape([numbers_of(bearing) for bearing in supported], (-1, width)).astype(float),
            np.reshape([bearing.factors for bearing in supported], (-1, width)).astype(float),
            np.reshape(pedestals, (-1, width)).astype(float),
            np.reshape(unbalance, (-1, len(UNBALANCE_PARTS))).astype(float),
            _settings([(column, each) for column, each in of_bearings if not each.is_factor]),
            _settings([(column, each) for column, each in of_bearings if each.is_factor]),
            _settings([(column, each) for column, each in targets if isinstance(each, PedestalTarget)]),
            _indices(
                (column, each.plane, UNBALANCE_PARTS.index(each.part))
                for column, each in of_planes
                if each.part in UNBALANCE_PARTS
            ),
            tuple(
                (column, each.plane, 1 if each.part == "x" else 1j)
                for column, each in of_planes
                if each.part in CARTESIAN_PARTS
            ),
            next((column for column, each in targets if isinstance(each, OriginTarget)), None),
            len(unknowns),
        )

    @cached_property
    def linear_unbalance(self) -> tuple[Array, Array]:
        """Unbalance at fixed angles: a constant (2 · n_plane,) kg m, and its slopes (d, 2 · n_plane).

        Re and Im of each plane lie side by side. All but one of a plane's summands are zero, so that sums are exact.
        """
        directions = np.exp(1j * self.unbalance[:, UNBALANCE_PARTS.index("phase")])
        constant = self.unbalance[:, UNBALANCE_PARTS.index("magnitude")] * directions
        slopes = np.zeros((self.n_unknown, len(constant)), dtype=complex)
        columns, planes, _ = self.set_unbalance
        slopes[columns, planes] = directions[planes]
        constant[planes] = 0
        return constant.view(float), slopes.view(float)

    @cached_property
    def has_fixed_angles(self) -> bool:
        """Whether unknowns set magnitudes of unbalance alone."""
        is_angle = self.set_unbalance[2] == UNBALANCE_PARTS.index("phase")
        return not is_angle.any() and not self.components and self.origin is None

    @cached_property
    def has_tables(self) -> bool:
        return any(bearing.table is not None for bearing in self.rotor.supported)

    @cached_property
    def has_mass(self) -> bool:
        """Whether bearings or seals have mass terms, or may have."""
        masses = slice(COEFFICIENTS.index(MASSES[0]), None)
        tables = [np.array(each.table.rows)[:, masses] for each in self.rotor.supported if each.table is not None]
        are_set = self.set_coefficients[2] >= masses.start
        return bool(np.any(self.coefficients[:, masses]) or np.any(are_set) or any(map(np.any, tables)))


def _settings(targets: Iterable[tuple[int, BearingTarget | PedestalTarget]]) -> Indices:
    return _indices((column, each.bearing, entry) for column, each in targets for entry in each.columns)


def _indices(rows: Iterable[tuple[int, int, int]]) -> Indices:
    return np.array(list(rows), dtype=int).reshape(-1, 3).T


def inputs_at(own: RotorNumbers, x: Array) -> Inputs:
    """The rotor's own numbers with the unknowns' values (n, d) put in."""
    return Inputs(
        own,
        _with_values(own.coefficients, own.set_coefficients, x),
        _with_values(own.factors, own.set_factors, x),
        _with_values(own.pedestals, own.set_pedestals, x),
        _unbalance_at(own, x),
        _origin_at(own, x),
    )


def complex_unbalance_at(own: RotorNumbers, x: Array) -> ComplexArray:
    """`Inputs.complex_unbalance` at values (n, d), without the other numbers: (n, n_plane) kg m."""
    if not own.has_fixed_angles:
        return _complex(_unbalance_at(own, x))
    constant, slopes = own.linear_unbalance
    return np.asarray((x.dot(slopes) + constant).view(complex))


def unbalance_and_slopes(own: RotorNumbers, x: Array) -> tuple[ComplexArray, ComplexArray]:
    """Unbalance (n_plane,) kg m at values (d,), and its derivatives by the unknowns, (n_plane, d)."""
    unbalance = _unbalance_at(own, x[None])[0]
    whole = _complex(unbalance)
    slopes = np.zeros((len(whole), len(x)), dtype=complex)
    for column, plane, entry in own.set_unbalance.T:
        is_phase = UNBALANCE_PARTS[entry] == "phase"
        slopes[plane, column] += 1j * whole[plane] if is_phase else np.exp(1j * unbalance[plane, 1])
    for column, plane, direction in own.components:
        slopes[plane, column] += direction * np.exp(1j * _origin_at(own, x[None])[0])
    if own.origin is not None:
        slopes[:, own.origin] += 1j * whole
    return whole, slopes


def _unbalance_at(own: RotorNumbers, x: Array) -> Array:
    """Magnitude and phase of each plane, (n, n_plane, 2)."""
    unbalance = _with_values(own.unbalance, own.set_unbalance, x, is_written=True)
    if own.components:
        vectors: dict[int, ComplexArray] = defaultdict(lambda: np.zeros(len(x), dtype=complex))
        for column, plane, direction in own.components:
            vectors[plane] += direction * x[:, column]
        for plane, vector in vectors.items():
            unbalance[:, plane] = np.stack([np.abs(vector), np.angle(vector)], axis=-1)
    if own.origin is not None:
        unbalance[:, :, 1] += x[:, own.origin, None]  # after all phases are set
    return unbalance


def _origin_at(own: RotorNumbers, x: Array) -> Array:
    return np.zeros(len(x)) if own.origin is None else x[:, own.origin].copy()


def _complex(unbalance: Array) -> ComplexArray:
    return np.asarray(unbalance[..., 0] * np.exp(1j * unbalance[..., 1]))


def _with_values(rows: Array, settings: Indices, x: Array, *, is_written: bool = False) -> Array:
    """(n, n_row, width) of rows (n_row, width), with values (n, d) where they are set."""
    columns, places, entries = settings
    if not len(columns) and not is_written:
        return np.broadcast_to(rows, (len(x), *rows.shape))
    whole = np.empty((len(x), *rows.shape))
    whole[:] = rows
    whole[:, places, entries] = x[:, columns]
    return whole


def rotor_at(rotor: Rotor, unknowns: Sequence[Unknown], x: Array) -> Rotor:
    """The rotor with one set of values (d,) put in."""
    inputs = inputs_at(RotorNumbers.of(rotor, unknowns), np.asarray(x, dtype=float)[None])
    supported = [
        with_numbers(bearing, inputs.coefficients[0, index], inputs.factors[0, index], inputs.pedestals[0, index])
        for index, bearing in enumerate(rotor.supported)
    ]
    n_bearing = len(rotor.bearings)
    unbalance = tuple(
        dataclasses.replace(plane, **dict(zip(UNBALANCE_PARTS, map(float, values), strict=True)))
        for plane, values in zip(rotor.unbalance, inputs.unbalance[0], strict=True)
    )
    return dataclasses.replace(
        rotor, bearings=tuple(supported[:n_bearing]), seals=tuple(supported[n_bearing:]), unbalance=unbalance
    )


def unknown_impedances(unknowns: Sequence[Unknown]) -> tuple[UnknownImpedance, ...]:
    """Parts of the dynamic stiffness that unknowns set, linear in them.

    There is one for entries of bearings that share their unknown stiffness, damping and mass, and one for each factor
    of a table and each number of a pedestal, with the rank of its part.
    """
    entries: dict[tuple[int, int], list[str]] = defaultdict(
        lambda: ["", "", ""]
    )  # by bearing and place in its matrices
    apart: Counter[tuple[str, str, str]] = Counter()
    for item in unknowns:
        for target in item.targets:
            if isinstance(target, BearingTarget) and not target.is_factor:
                [column] = target.columns
                entries[target.bearing, column % 4][column // 4] = item.parameter.name
            elif isinstance(target, (BearingTarget, PedestalTarget)):
                part = target.columns[0] // 4
                names = ["", "", ""]
                names[part] = item.parameter.name
                apart[names[0], names[1], names[2]] += min(len(target.columns), 2)
    together = Counter((names[0], names[1], names[2]) for names in entries.values())
    return tuple(UnknownImpedance(k, c, n_port, m) for (k, c, m), n_port in (*together.items(), *apart.items()))

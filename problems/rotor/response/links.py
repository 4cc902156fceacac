"""Links of a rotor to the ground: its bearings, seals and pedestals as impedances between ports.

A bearing on a pedestal is two links in series, z_f between the shaft and the housing and z_p between the housing and the ground. With
S = (z_f + z_p)⁻¹ and shaft motion q at the bearing, the housing moves by v = S z_f q, and the shaft feels z_f − z_f S z_f. A force f on the
housing moves it by S f more and pushes the shaft with z_f S f; a pair of forces f on the shaft and −f on the housing moves it by −S f.
The port of the first link is the motion q − v, the port of the second is v, so that a change of either impedance is a change at its ports
alone, as it is for a bearing on the ground.

Numbers that are known are part of the rotor: they cost no port. Sign convention: real quantities are Re(· e^{iωt}); a link pushes the
shaft with −z q.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.bearing import Bearing, numbers_of
from problems.rotor.finite_elements.beside_node import bearing_rows
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.banded import DIAGONAL

PORTS_PER_LINK = 2  # x and y

# Phase of the nominal impedances. It makes them dissipate at every speed, so that the nominal rotor has no sharp
# resonance where the factorisation would lose digits, and so that each update starts from a damped rotor.
NOMINAL_PHASE = np.exp(0.25j * np.pi)


@dataclass(frozen=True)
class Impedance:
    """Impedance of a bearing or its pedestal from motion in direction `column` to force in `row`.

    Directions are 0 for x and 1 for y. Its ports belong to its `link`; −1: links are numbered as bearings are. `moved`
    is the link that moves, if another one, by way of a common support.
    """

    bearing: int  # index in `Rotor.supported`
    row: int
    column: int
    moved: int | None = None
    link: int = -1
    of_pedestal: bool = False

    def __post_init__(self) -> None:
        if self.link < 0:
            object.__setattr__(self, "link", self.bearing)

    @property
    def row_port(self) -> int:
        return PORTS_PER_LINK * self.link + self.row

    @property
    def column_port(self) -> int:
        return PORTS_PER_LINK * (self.link if self.moved is None else self.moved) + self.column

    @property
    def is_direct(self) -> bool:
        """Whether it answers motion with a force in line with it."""
        return self.row_port == self.column_port


def links_of(impedances: Sequence[Impedance]) -> tuple[tuple[int, bool], ...]:
    """The bearing of each link, and whether it is the pedestal of that bearing."""
    found = {item.link: (item.bearing, item.of_pedestal) for item in impedances}
    return tuple(found[link] for link in sorted(found))


@dataclass(frozen=True, eq=False)
class LinkedBearing:
    """A bearing or seal with all numbers given at n_speed speeds, as the shaft feels it."""

    dof: Indices  # (n,) of the shaft, that move it
    rows: Array  # (2, n), which read x and y from these
    felt: ComplexArray  # (n_speed, 2, 2) N/m, by the shaft
    # Of a bearing on a pedestal, (n_speed, 2, 2) each; None on the ground: motion of the housing per motion of the shaft, force on the
    # shaft per force on the housing, and motion of the housing per force on it where the shaft is held
    carried: ComplexArray | None = None
    pushed: ComplexArray | None = None
    yielding: ComplexArray | None = None

    def motion(self, *, of_pedestal: bool) -> ComplexArray:
        """Motion of the ports of a link per motion of the shaft."""
        assert self.carried is not None, "a bearing on the ground"
        return self.carried if of_pedestal else np.eye(2) - self.carried

    def force(self, *, of_pedestal: bool) -> ComplexArray:
        """Force on the shaft per force at the ports of a link."""
        assert self.pushed is not None, "a bearing on the ground"
        return self.pushed if of_pedestal else np.eye(2) - self.pushed


@dataclass(frozen=True)
class HousingReading:
    """A channel that reads the shaft against the housing of a bearing."""

    channel: int
    bearing: int
    cosines: tuple[float, float]


def on_their_pedestals(
    rotor: Rotor, impedances: Sequence[Impedance], values: ComplexArray, speed: Array, harmonic: float = 1.0
) -> list[LinkedBearing]:
    """Each bearing and seal of a rotor, `Rotor.supported`, with values of some impedances.

    The values (n_impedance, n_speed) N/m are of the impedances that have ports; all others have the rotor's own
    numbers.
    """
    linked = {part: np.zeros((len(speed), 2, 2), dtype=complex) for part in links_of(impedances)}
    for item, each in zip(impedances, values, strict=True):
        if item.moved is None:
            linked[item.bearing, item.of_pedestal][:, item.row, item.column] = each
    return [
        _linked(rotor, bearing, linked.get((index, False)), linked.get((index, True)), speed, harmonic)
        for index, bearing in enumerate(rotor.supported)
    ]


def _linked(
    rotor: Rotor,
    bearing: Bearing,
    film: ComplexArray | None,
    pedestal: ComplexArray | None,
    speed: Array,
    harmonic: float,
) -> LinkedBearing:
    dof, rows = bearing_rows(rotor, bearing)
    film = bearing.impedance(speed, harmonic) if film is None else film
    if bearing.pedestal is None:
        return LinkedBearing(dof, rows, film)
    pedestal = bearing.pedestal.impedance(harmonic * speed) if pedestal is None else pedestal
    try:
        yielding: ComplexArray = np.asarray(np.linalg.inv(film + pedestal), dtype=complex)
    except np.linalg.LinAlgError:
        raise SettingError(
            f"bearing at {bearing.position:g} m: expected a bearing or a support that holds its housing, got neither; give one of"
            " them a stiffness"
        ) from None
    carried, pushed = yielding @ film, film @ yielding
    return LinkedBearing(dof, rows, film - film @ carried, carried, pushed, yielding)


def condensed(
    impedance: ComplexArray, pedestals: Sequence[tuple[int, ComplexArray]]
) -> tuple[ComplexArray, ComplexArray]:
    """Impedances (n_port, n_port, …) N/m between all ports of bearings on pedestals.

    Each bearing has its index and its impedance (2, 2, …), as the shaft feels them. Also returns the motion of housings
    per motion of the ports, (n_pedestal, 2, n_port, …).
    """
    if not pedestals:
        return impedance, np.zeros((0, 2, *impedance.shape[1:]), dtype=complex)
    whole = np.moveaxis(impedance, (0, 1), (-2, -1))
    n_port, ports = len(impedance), np.concatenate([2 * index + np.arange(2) for index, _ in pedestals])
    below = np.zeros((*whole.shape[:-2], len(ports), len(ports)), dtype=complex)
    for place, (_, own) in enumerate(pedestals):
        here = slice(2 * place, 2 * place + 2)
        below[..., here, here] = np.moveaxis(own, (0, 1), (-2, -1))
    below += whole[..., ports[:, None], ports]
    moved = np.linalg.solve(below, whole[..., ports, :])
    felt = whole - whole[..., :, ports] @ moved
    housings = np.moveaxis(moved, (-2, -1), (0, 1)).reshape(len(pedestals), 2, n_port, *impedance.shape[2:])
    return np.asarray(np.moveaxis(felt, (-2, -1), (0, 1))), np.asarray(housings)


def add_to_band(band: ComplexArray, bearings: Sequence[LinkedBearing]) -> None:
    """Add bearings to a dynamic stiffness (n_speed, n_dof, WIDTH).

    It is stored as in `problems.rotor.response.banded`.
    """
    for bearing in bearings:
        felt = bearing.rows.T @ bearing.felt @ bearing.rows
        for row, row_dof in enumerate(bearing.dof):
            for column, column_dof in enumerate(bearing.dof):
                band[:, column_dof, DIAGONAL + row_dof - column_dof] += felt[:, row, column]


def read_housings(rotor: Rotor, channels: Sequence[Channel], harmonic: float = 1.0) -> list[HousingReading]:
    """Channels of a harmonic that read against a housing."""
    found = ((index, channel, rotor.housing_of(channel)) for index, channel in enumerate(channels))
    return [
        HousingReading(index, bearing, channel.cosines)
        for index, channel, bearing in found
        if bearing is not None and channel.harmonic == harmonic
    ]


@dataclass(frozen=True, eq=False)
class LinksOfShaft:
    """The ports of links and the readings of channels, as rows that read the shaft and as forces on it.

    Arrays are (n_dof, …) or (…, n_dof) where all bearings are on the ground, and have n_speed before them where some
    are not.
    """

    bearings: Sequence[LinkedBearing]
    links: Sequence[tuple[int, bool]]
    readings: Sequence[HousingReading]
    n_dof: int
    n_speed: int

    @property
    def is_on_ground(self) -> bool:
        return all(self.bearings[bearing].carried is None for bearing, _ in self.links)

    def port_rows(self) -> Array | ComplexArray:
        """Rows that read the ports, ([n_speed,] n_port, n_dof)."""
        if self.is_on_ground:
            return np.concatenate([np.empty((0, self.n_dof)), *(self._unit(bearing) for bearing, _ in self.links)])
        return np.concatenate([self._spread(*link, of_force=False) for link in self.links], axis=1)

    def port_forces(self) -> Array | ComplexArray:
        """Nodal forces of unit forces at the ports, ([n_speed,] n_dof, n_port)."""
        if self.is_on_ground:
            return self.port_rows().T
        return np.concatenate([self._spread(*link, of_force=True) for link in self.links], axis=2)

    def _unit(self, bearing: int) -> Array:
        """Rows (2, n_dof) that read the shaft at a bearing."""
        unit = np.zeros((2, self.n_dof))
        unit[:, self.bearings[bearing].dof] = self.bearings[bearing].rows
        return unit

    def _spread(self, bearing: int, of_pedestal: bool, *, of_force: bool) -> ComplexArray:
        own, unit = self.bearings[bearing], self._unit(bearing)
        if own.carried is None:
            both = np.broadcast_to(unit.astype(complex), (self.n_speed, *unit.shape))
            return np.swapaxes(both, 1, 2) if of_force else both
        if of_force:
            return np.asarray(unit.T @ own.force(of_pedestal=of_pedestal))
        return np.asarray(own.motion(of_pedestal=of_pedestal) @ unit)

    def reading_rows(self, of_shaft: Array) -> Array | ComplexArray:
        """Rows that read the channels, ([n_speed,] n_channel, n_dof).

        `of_shaft` (n_channel, n_dof) reads the shaft against the ground.
        """
        if not self.readings:
            return of_shaft
        rows = np.tile(of_shaft.astype(complex), (self.n_speed, 1, 1))
        for reading in self.readings:
            bearing = self.bearings[reading.bearing]
            rows[:, reading.channel, bearing.dof] -= _along(reading, bearing.carried) @ bearing.rows
        return rows

    def beside_shaft(self, n_channel: int) -> ComplexArray:
        """Motion of ports and channels per unit force at the ports while the shaft is held.

        It is (n_speed, n_port + n_channel, n_port): a force on a housing moves it, one between housing and shaft pushes
        it back.
        """
        n_port = PORTS_PER_LINK * len(self.links)
        found = np.zeros((self.n_speed, n_port + n_channel, n_port), dtype=complex)
        for place, (bearing, of_pedestal) in enumerate(self.links):
            yielding = self.bearings[bearing].yielding
            if yielding is None:
                continue
            here = slice(PORTS_PER_LINK * place, PORTS_PER_LINK * (place + 1))
            for row, (other, of_other) in enumerate(self.links):
                if other == bearing:
                    there = slice(PORTS_PER_LINK * row, PORTS_PER_LINK * (row + 1))
                    found[:, there, here] = yielding if of_other == of_pedestal else -yielding
            for reading in self.readings:
                if reading.bearing == bearing:
                    moved = _along(reading, yielding)
                    found[:, n_port + reading.channel, here] = -moved if of_pedestal else moved
        return found


def _along(reading: HousingReading, matrices: ComplexArray | None) -> ComplexArray:
    """Rows (n_speed, 2) of a reading through matrices (n_speed, 2, 2) of the housing."""
    assert matrices is not None, "a bearing on the ground"
    return np.asarray(np.array(reading.cosines) @ matrices)


def nominal_impedances(
    rotor: Rotor, impedances: Sequence[Impedance], speed: Array, harmonic: float = 1.0
) -> ComplexArray:
    """Nominal value of each impedance, (n_impedance, n_speed) N/m at a harmonic of each speed."""
    found = [_nominal_impedance(rotor.supported[item.bearing], item, speed, harmonic) for item in impedances]
    return np.array(found, dtype=complex).reshape(len(impedances), len(speed))


def _nominal_impedance(bearing: Bearing, impedance: Impedance, speed: Array, harmonic: float) -> ComplexArray:
    """Nominal impedance (n_speed,) N/m at a harmonic of each speed.

    It has the size of the given impedance with the nominal phase. None off the diagonal. Inertia counts as a spring, so
    that none cancels another.
    """
    if not impedance.is_direct:
        return np.zeros(len(speed), dtype=complex)
    entry, frequency = (slice(None), impedance.row, impedance.column), harmonic * speed
    if impedance.of_pedestal:
        pedestal = bearing.pedestal
        assert pedestal is not None, "a bearing without a support"
        numbers = np.array(numbers_of(pedestal)).reshape(3, 1, 2, 2)
        stiffness, damping, mass = (part[entry] for part in numbers)
        stiffness = stiffness + np.abs(pedestal.measured(frequency)[impedance.row, impedance.column])
    else:
        stiffness, damping, mass = (part[entry] for part in bearing.matrices_at(speed))
    return NOMINAL_PHASE * (np.abs(stiffness + 1j * frequency * damping) + frequency**2 * np.abs(mass))

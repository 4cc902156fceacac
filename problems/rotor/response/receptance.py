"""Receptance reduction: a rotor seen only from its ports.

A new bearing then costs a few small operations.

Bearings touch the rotor at few degrees of freedom, its ports. With the dynamic stiffness factored once per speed
about nominal bearings, all that a response needs is the receptance H between ports, unbalance planes and channels.
An impedance z_rc = k_rc + iΩ c_rc that differs from its nominal by Δz changes D by e_r Δz e_cᵀ, and H by the
rank-one update of Sherman and Morrison (Ann. Math. Stat. 21 (1950) 124–127, doi 10.1214/aoms/1177729893),

    H ← H − H[:, r] Δz / (1 + Δz H[c, r]) H[c, :],

one impedance after the other: exact, and the same few array operations for a whole batch of bearings.

Sign convention: real quantities are Re(· e^{iΩt}); a bearing pushes the shaft with −z q. A motion at a harmonic h is
Re(· e^{ihΩt}), with impedances at that frequency; unbalance does nothing there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import force_per_unbalance
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.response.banded import (
    BLOCK,
    Array32,
    blocks,
    dynamic_stiffness_band,
    factorised,
    side_by_side,
    solve,
    solve_factorised,
)
from problems.rotor.response.dense import channel_rows
from problems.rotor.response.links import (
    PORTS_PER_LINK,
    Impedance,
    LinksOfShaft,
    add_to_band,
    links_of,
    nominal_impedances,
    on_their_pedestals,
    read_housings,
)

MOST_KEPT = 2 * BLOCK  # n_speed n_dof of a rotor whose factors and motion are kept, some 350 MB


@dataclass(frozen=True, eq=False)
class Reduction:
    """A rotor about nominal bearings, seen from its ports."""

    speed: Array  # (n_speed,) rad/s
    impedances: tuple[Impedance, ...]  # those that may differ from nominal, bearing by bearing
    nominal: ComplexArray  # (n_impedance, n_speed) N/m
    # (n_port + n_channel, n_port + n_plane + n_load, n_speed): m/N, m per kg m of unbalance, m per unit of a load
    receptance: ComplexArray
    harmonic: float = 1.0  # h of the motion

    @cached_property
    def n_port(self) -> int:
        return PORTS_PER_LINK * len(links_of(self.impedances))

    @cached_property
    def entries(self) -> tuple[Indices, ...]:
        """Bearing, row and column of each impedance of a bearing, (n,) each."""
        found = [(item.bearing, item.row, item.column) for item in self.impedances if not item.of_pedestal]
        return tuple(np.array(found, dtype=int).reshape(-1, 3).T)

    @cached_property
    def of_pedestals(self) -> tuple[Impedance, ...]:
        """Impedances of pedestals, listed after the bearings."""
        return tuple(item for item in self.impedances if item.of_pedestal)

    def response_per_load(self, impedance: ComplexArray) -> ComplexArray:
        """Response of each channel to a unit unbalance in each plane, then to each further load.

        It is (n_channel, n_plane + n_load, n, n_speed), m per kg m and m per unit, for n sets of impedances
        (n_impedance, n, n_speed) N/m.
        """
        return updated_receptance(self.receptance, self.impedances, impedance - self.nominal[:, None], self.n_port)

    def motion_on(self, impedance: ComplexArray, sizes: ComplexArray) -> ComplexArray:
        """Motion and responses to further loads on impedances (n_impedance, n, n_speed) N/m.

        They are (n, n_speed, n_channel, 1 + n_load), m and m per unit, with unbalances and first loads of `sizes` (n,
        n_plane + …). The ports' motion q = (1 + H Δ)⁻¹ H f is solved for, and the effect of the bearings' forces Δ q on
        the channels taken off. If sizes are known this costs a fraction of the rank-one updates, which serve any.
        """
        change = impedance - self.nominal[:, None]
        n_port, n_own, (_, n, n_speed) = self.n_port, sizes.shape[1], change.shape
        pairs = list(zip(self.impedances, change, strict=True))
        per_own, per_load = np.split(self.receptance[:, n_port:], [n_own], axis=1)
        free = np.empty((len(self.receptance), 1 + per_load.shape[1], n, n_speed), dtype=complex)  # on nominal bearings
        np.matmul(sizes, per_own, out=free[:, 0])
        free[:, 1:] = per_load[:, :, None]
        system = np.empty((n_port, n_port + free.shape[1], n, n_speed), dtype=complex)
        system[:, n_port:] = free[:n_port]
        for port in range(n_port):
            felt = [(item.row_port, values) for item, values in pairs if item.column_port == port]
            system[:, port] = sum(self.receptance[:n_port, row, None] * values for row, values in felt)
            system[port, port] += 1
        motion, forces = eliminated(system), np.zeros((n_port, *free.shape[1:]), dtype=complex)
        for item, values in pairs:
            forces[item.row_port] += values * motion[item.column_port]
        per_port = self.receptance[n_port:, :n_port].transpose(2, 0, 1)
        taken_off = per_port @ forces.transpose(3, 0, 1, 2).reshape(n_speed, n_port, -1)
        taken_off = taken_off.reshape(n_speed, *free[n_port:].shape[:3])  # (n_speed, n_channel, 1 + n_load, n)
        return np.subtract(free[n_port:].transpose(2, 3, 0, 1), taken_off.transpose(3, 0, 1, 2), order="C")

    def receptance_on(self, impedance: ComplexArray) -> ComplexArray:
        """Receptance on other impedances (n_impedance, n_speed) N/m than the nominal ones.

        As `receptance`, ports included: (n_port + n_channel, n_port + n_plane + n_load, n_speed).
        """
        change = (impedance - self.nominal)[:, None]
        ports = np.arange(self.n_port)
        # The update consumes the ports that it works on, so those to be kept are entered twice.
        rows, columns = (np.concatenate([ports, np.arange(size)]) for size in self.receptance.shape[:2])
        return updated_receptance(self.receptance[np.ix_(rows, columns)], self.impedances, change, self.n_port)[:, :, 0]


@dataclass(frozen=True, eq=False)
class ShaftMotion:
    """Motion of the whole shaft about nominal bearings, from which probes are read wherever they stand."""

    speed: Array  # (n_speed,) rad/s
    impedances: tuple[Impedance, ...]
    nominal: ComplexArray  # (n_impedance, n_speed) N/m
    motion: (
        ComplexArray  # (n_speed, n_dof, n_port + n_plane + n_load): m/N, m per kg m of unbalance, m per unit of a load
    )
    harmonic: float = 1.0

    def read_by(self, rotor: Rotor, channels: Sequence[Channel], rows: Array | None = None) -> Reduction:
        """The rotor seen from its ports and by channels, and by rows (n_row, n_dof).

        `rotor` is the one that moves so; the probes on its housings may be others.
        """
        links = _links(rotor, self.impedances, self.nominal, self.speed, channels, self.harmonic)
        receptance = _receptance(rotor, links, self.motion, channels, rows, self.harmonic)
        return Reduction(self.speed, self.impedances, self.nominal, receptance, self.harmonic)


@dataclass(frozen=True, eq=False)
class FactoredShaft:
    """A rotor about nominal bearings, factored at each speed: further loads then cost a substitution each."""

    own: ShaftMotion  # without further loads
    factors: ComplexArray
    pivots: Array32

    @classmethod
    def of(cls, rotor: Rotor, impedances: tuple[Impedance, ...], speed: Array) -> FactoredShaft | None:
        """A rotor at the spin frequency; None of one too large for its factors to be kept."""
        if len(speed) * DOF_PER_NODE * len(rotor.node_positions) > MOST_KEPT:
            return None
        nominal = nominal_impedances(rotor, impedances, speed)
        links = _links(rotor, impedances, nominal, speed, (), 1.0)
        factors, pivots = factorised(stiffness_band(rotor, links, speed, 1.0))
        forces = side_by_side(_own_forces(rotor, links, speed, 1.0), len(speed))
        motion = solve_factorised(factors, pivots, forces)
        return cls(ShaftMotion(speed, impedances, nominal, motion), factors, pivots)

    def under(self, loads: ComplexArray | None) -> ShaftMotion:
        """Its motion, also under nodal forces (n_speed, n_dof, n_load), N per unit."""
        if loads is None:
            return self.own
        moved = solve_factorised(self.factors, self.pivots, loads)
        return replace(self.own, motion=np.concatenate([self.own.motion, moved], axis=2))


def shaft_motion(
    rotor: Rotor,
    impedances: tuple[Impedance, ...],
    speed: Array,
    loads: ComplexArray | None = None,
    *,
    harmonic: float = 1.0,
) -> ShaftMotion:
    """Motion of the whole shaft; arguments and nominal impedances as of `reduce_rotor`."""
    nominal = nominal_impedances(rotor, impedances, speed, harmonic)
    motion = [
        _motion(
            rotor,
            _links(rotor, impedances, nominal[:, part], speed[part], (), harmonic),
            speed[part],
            _of(loads, part),
            harmonic,
        )
        for part in _blocks(rotor, speed)
    ]
    return ShaftMotion(speed, impedances, nominal, np.concatenate(motion), harmonic)


def reduce_rotor(
    rotor: Rotor,
    impedances: tuple[Impedance, ...],
    speed: Array,
    channels: Sequence[Channel],
    loads: ComplexArray | None = None,
    *,
    rows: Array | None = None,
    harmonic: float = 1.0,
) -> Reduction:
    """Receptances of a rotor about nominal impedances: as large as its bearings', but well damped.

    `loads` (n_speed, n_dof, n_load) are nodal forces, N per unit, next to the unbalance planes; `rows` (n_row, n_dof)
    read the motion next to the channels. At a `harmonic` only its own channels read anything. The rotor is solved as
    the chain that it is (`problems.rotor.response.banded`), block by block of the speeds.
    """
    nominal = nominal_impedances(rotor, impedances, speed, harmonic)
    found = []
    for part in _blocks(rotor, speed):
        links = _links(rotor, impedances, nominal[:, part], speed[part], channels, harmonic)
        motion = _motion(rotor, links, speed[part], _of(loads, part), harmonic)
        found.append(_receptance(rotor, links, motion, channels, rows, harmonic))
    return Reduction(speed, impedances, nominal, np.concatenate(found, axis=2), harmonic)


def _blocks(rotor: Rotor, speed: Array) -> Iterator[slice]:
    return blocks(len(speed), DOF_PER_NODE * len(rotor.node_positions))


def _of(values: ComplexArray | None, part: slice) -> ComplexArray | None:
    """The part of values over speed."""
    return values if values is None else values[part]


def _links(
    rotor: Rotor,
    impedances: tuple[Impedance, ...],
    nominal: ComplexArray,
    speed: Array,
    channels: Sequence[Channel],
    harmonic: float,
) -> LinksOfShaft:
    bearings = on_their_pedestals(rotor, impedances, nominal, speed, harmonic)
    n_dof = DOF_PER_NODE * len(rotor.node_positions)
    return LinksOfShaft(bearings, links_of(impedances), read_housings(rotor, channels, harmonic), n_dof, len(speed))


def _motion(
    rotor: Rotor, links: LinksOfShaft, speed: Array, loads: ComplexArray | None, harmonic: float
) -> ComplexArray:
    """`ShaftMotion.motion` at these speeds."""
    forces = [*_own_forces(rotor, links, speed, harmonic), *([] if loads is None else [loads])]
    return solve(stiffness_band(rotor, links, speed, harmonic), side_by_side(forces, len(speed)))


def stiffness_band(rotor: Rotor, links: LinksOfShaft, speed: Array, harmonic: float = 1.0) -> ComplexArray:
    """The dynamic stiffness on these links as a band."""
    stiffness = dynamic_stiffness_band(assemble_free(rotor), speed, harmonic)
    add_to_band(stiffness, links.bearings)
    return stiffness


def _own_forces(
    rotor: Rotor, links: LinksOfShaft, speed: Array, harmonic: float
) -> tuple[Array | ComplexArray, Array | ComplexArray]:
    """Nodal forces of units at the ports, and of unbalance, ([n_speed,] n_dof, n_port) and (…, n_plane)."""
    if harmonic != 1:
        return links.port_forces(), np.zeros((links.n_dof, len(rotor.unbalance)))
    return links.port_forces(), force_per_unbalance(rotor, speed)


def _receptance(
    rotor: Rotor,
    links: LinksOfShaft,
    motion: ComplexArray,
    channels: Sequence[Channel],
    rows: Array | None,
    harmonic: float,
) -> ComplexArray:
    """`Reduction.receptance` at these speeds."""
    read = [links.port_rows(), links.reading_rows(channel_rows(rotor, channels, harmonic))]
    read += [] if rows is None else [rows]
    whole = _stacked(read, len(motion))
    used = np.flatnonzero(np.any(whole.reshape(-1, whole.shape[-1]), axis=0))  # probes and ports touch few
    receptance = whole[..., used] @ motion[:, used]  # (n_speed, row, column)
    if not links.is_on_ground:
        beside = links.beside_shaft(len(channels))
        receptance[:, : beside.shape[1], : beside.shape[2]] += beside
    return np.ascontiguousarray(np.moveaxis(receptance, 0, 2))


def _stacked(rows: Sequence[Array | ComplexArray], n_speed: int) -> Array | ComplexArray:
    """Rows ([n_speed,] n_row, n_dof) one below the other."""
    if all(each.ndim == 2 for each in rows):
        return np.concatenate([each.real for each in rows])
    spread = [np.broadcast_to(each, (n_speed, *each.shape[-2:])).astype(complex) for each in rows]
    return np.concatenate(spread, axis=1)


def at_harmonic(impedance: ComplexArray, harmonic: float) -> ComplexArray:
    """Impedances that a motion at a harmonic h of the spin speed feels, from impedances z at h = 1.

    They are Re z + i h Im z: coefficients of bearings are functions of the spin speed.
    """
    changed = impedance.copy()
    changed.imag *= harmonic
    return changed


def updated_receptance(
    receptance: ComplexArray, impedances: Sequence[Impedance], change: ComplexArray, n_port: int
) -> ComplexArray:
    """Receptance (row, column, n_speed) after changes (n_impedance, n, n_speed) of the impedances.

    The changes are made one by one.

    The first rows and columns are the ports. A port is dropped once no later impedance touches it, so that what
    remains are the rows and columns beyond the ports, (…, …, n, n_speed).
    """
    current = receptance[:, :, None]
    dropped = 0
    for index, impedance in enumerate(impedances):
        row, column = impedance.row_port - dropped, impedance.column_port - dropped
        still_needed = _first_port(impedances[index + 1 :], n_port) - dropped
        gain = change[index] / (1 + change[index] * current[column, row])
        update = current[still_needed:, row, None] * (gain * current[column, still_needed:])
        current = np.subtract(current[still_needed:, still_needed:], update, out=update)
        dropped += still_needed
    return current


def eliminated(system: ComplexArray) -> ComplexArray:
    """X (n_row, m, …) of A X = B from [A B] (n_row, n_row + m, …), which is overwritten.

    Gauss's elimination of many at once. It does not pivot, like one rank-one update after the other.
    """
    n = len(system)
    for index in range(n - 1):
        factor = system[index + 1 :, index] / system[index, index]
        system[index + 1 :, index + 1 :] -= factor[:, None] * system[index, index + 1 :]
    found = system[:, n:]
    for index in reversed(range(n)):
        found[index] /= system[index, index]
        found[:index] -= system[:index, index, None] * found[index]
    return found


def _first_port(impedances: Sequence[Impedance], n_port: int) -> int:
    """The lowest port that these impedances touch."""
    return min((min(impedance.row_port, impedance.column_port) for impedance in impedances), default=n_port)

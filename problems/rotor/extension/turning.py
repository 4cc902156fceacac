"""Stiffness that turns with the shaft, and perhaps opens and closes as it does.

Motion at several harmonics, by Hill's method.

    M q̈ + (C + ΩG) q̇ + (K + ΩN + Bᵀ κ(φ) B) q = f(φ),    φ = Ωt,    κ(φ) = Σ κ_m e^{imφ},    q(φ) = Σ q_h e^{ihφ},

both sums over negative and positive integers, κ_{−m} and q_{−h} being conjugates. Order by order, with D_h the dynamic
stiffness at hΩ, D_h q_h + Bᵀ Σ κ_{h−k} B q_k = f_h: one linear system for all orders together, cut off above `HIGHEST`,
in which the ports B q alone are coupled. Unbalance and other loads make the 1X force, f_0 is the rotor's weight; loads
may act at further orders. As q_1 and its conjugate are coupled, the response is linear in real and imaginary part of an
unbalance, each by itself.

A shaft with two second moments of area has κ_±2 alone: on isotropic bearings forward 1X, and weight and 2X, are two closed sets, in
which nothing is cut off.

G. Genta, Dynamics of Rotating Systems, 2005, chapters 5 and 6; M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating
Machines, 2010, chapter 7; T. Yamamoto & Y. Ishida, Linear and Nonlinear Rotordynamics, 2nd ed., 2012, chapter 5.

`turning_effects` collects from the effects of a rotor the stiffness that turns with the shaft and the loads at other orders than 1X.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import DIRECTIONS, Channel
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.extension.site_law import Force, SiteLaw, attached
from problems.rotor.finite_elements.assembly import Matrices, assemble_free
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.free_motion.static_load import GRAVITY
from problems.rotor.response import dense
from problems.rotor.response.links import Impedance
from problems.rotor.response.receptance import Reduction, reduce_rotor

HIGHEST = 3  # order of the motion that is kept: 3X is the highest that is measured as a rule
CHUNK_BYTES = 2**20  # of the largest temporary array of a batch: about what a core's own cache holds
OF_CONJUGATE = np.array([[1, -1j], [-1j, -1]])  # S: Re(S e^{2iθ}) is [[cos 2θ, sin 2θ], [sin 2θ, −cos 2θ]]


@dataclass(frozen=True, eq=False)
class Acting:
    """Loads and turning stiffness that act on n parameter sets in addition to bearings.

    `sizes` (n, n_load) are the sizes of loads by order; at 1X they follow the loads of the unbalance. `local` are
    forces by linear laws. `turning` has κ_m, m = 0, 1, 2 …, of the turning stiffness, (n, n_order, n_port, n_port) N/m.
    """

    sizes: Mapping[int, ComplexArray]
    local: Sequence[Force]
    turning: ComplexArray


@dataclass(frozen=True, eq=False)
class TurningShaft:
    """Rotor with a turning stiffness between its `rows` B (n_port, n_dof).

    Loads (n_speed, n_dof, n_load), N per unit by order, act in addition to its unbalance, at order 0 its weight. Local
    forces act at `sites`, two rows (2, n_dof) each.
    """

    rotor: Rotor
    impedances: tuple[Impedance, ...]
    speed: Array
    channels: tuple[Channel, ...]
    rows: Array
    loads: Mapping[int, ComplexArray]
    sites: tuple[Array, ...] = ()

    @cached_property
    def reductions(self) -> tuple[Reduction, ...]:
        """Rotor seen from its ports at each order from 0 on.

        It has columns for the loads and for unit forces at the ports.
        """
        ports = np.concatenate([*self.sites, self.rows])
        found = []
        for order in range(HIGHEST + 1):
            unit = np.broadcast_to(ports.T.astype(complex), (len(self.speed), *ports.T.shape))
            together = np.concatenate([self.loads[order], unit], axis=2) if order in self.loads else unit
            found.append(
                reduce_rotor(
                    self.rotor,
                    self.impedances,
                    self.speed,
                    self.channels,
                    together,
                    rows=ports,
                    harmonic=float(order),
                )
            )
        return tuple(found)

    def motion(self, entries: Sequence[ComplexArray], acting: Acting) -> ComplexArray:
        """Motion at the channels, each at its harmonic, (n, n_speed, n_channel) m.

        The impedances (n_impedance, n, n_speed) are of each reduction.
        """
        n_seen = len(self.channels)
        without, per_force, springs = [], [], []
        for order, (reduction, impedance) in enumerate(zip(self.reductions, entries, strict=True)):
            columns = reduction.response_per_load(impedance).transpose(2, 3, 0, 1)  # (n, n_speed, row, column)
            n_force = 2 * len(self.sites) + len(self.rows)
            own, forces = np.split(columns, [columns.shape[-1] - n_force], axis=-1)
            sizes = acting.sizes.get(order, np.zeros((len(columns), 0)))
            # half of it: the other half is its conjugate, of the negative order
            moved = np.einsum("nsrl,nl->nsr", own[..., own.shape[-1] - sizes.shape[1] :], sizes) / (2 if order else 1)
            if order == 1:
                for index, (site, coefficients) in enumerate(acting.local):
                    at_rest = np.stack([site.at_rest(each[None], self.speed) for each in coefficients])
                    moved = moved + (forces[..., 2 * index : 2 * index + 2] @ at_rest[..., None])[..., 0] / 2
            without.append(moved)
            per_force.append(forces)
            springs.append(local_stiffness(acting, self.speed, order, forces.shape[-1]))
        added = port_forces(
            [each[:, :, n_seen:] for each in per_force],
            [each[:, :, n_seen:] for each in without],
            springs,
            _behind(2 * len(self.sites), acting.turning),
        )
        parts = zip(without[1:], per_force[1:], added[1:])
        return np.asarray(
            sum(2 * (moved + (forces @ by[..., None])[..., 0])[..., :n_seen] for moved, forces, by in parts)
        )

    def dense_motion(self, impedances: Sequence[ComplexArray], acting: Acting, force: ComplexArray) -> ComplexArray:
        """Motion (n_speed, n_channel) of one set by the dense route: all orders in one system.

        `impedances` lie between all ports (n_port, n_port, n_speed) at each order; `force` (n_speed, n_dof) is the 1X
        force.
        """
        free, n_speed = assemble_free(self.rotor), len(self.speed)
        n_dof = len(free.mass)
        orders = range(-HIGHEST, HIGHEST + 1)
        whole = np.zeros((n_speed, len(orders), n_dof, len(orders), n_dof), dtype=complex)
        forces = np.zeros((n_speed, len(orders), n_dof), dtype=complex)
        for order in acting.sizes.keys() & self.loads.keys() - {1}:
            own = self.loads[order] @ acting.sizes[order][0] / (2 if order else 1)
            forces[:, HIGHEST + order], forces[:, HIGHEST - order] = own, np.conj(own)
        for site, coefficients in acting.local:
            at_site = self.sites[[each[0] for each in acting.local].index(site)]
            force = force + site.at_rest(coefficients, self.speed) @ at_site
        forces[:, HIGHEST + 1], forces[:, HIGHEST - 1] = force / 2, np.conj(force) / 2
        ports = np.concatenate([*self.sites, self.rows])
        turning = _behind(2 * len(self.sites), acting.turning)
        for row, order in enumerate(orders):
            stiffness = self._stiffness(free, impedances[abs(order)], abs(order))
            local = local_stiffness(acting, self.speed, abs(order), len(ports))[0]
            stiffness = stiffness + ports.T @ local @ ports
            whole[:, row, :, row] += stiffness if order >= 0 else np.conj(stiffness)
            for column, other in enumerate(orders):
                whole[:, row, :, column] += ports.T @ _of_order(turning, order - other)[0] @ ports
        size = len(orders) * n_dof
        motion = np.linalg.solve(whole.reshape(n_speed, size, size), forces.reshape(n_speed, size, 1))
        motion = motion.reshape(forces.shape)
        found = np.zeros((n_speed, len(self.channels)), dtype=complex)
        for h in range(1, HIGHEST + 1):
            _, rows = dense.bearings_and_readings(self.rotor, self.speed, self.channels, impedances[h], h)
            found += 2 * (rows @ motion[:, HIGHEST + h, :, None])[..., 0]
        return found

    def _stiffness(self, free: Matrices, impedance: ComplexArray, order: int) -> ComplexArray:
        of_bearings, _ = dense.bearings_and_readings(self.rotor, self.speed, (), impedance, float(order))
        return dense.dynamic_stiffness(free, self.speed, float(order)) + of_bearings


def weight_of(rotor: Rotor, angle: float) -> Array:
    """The nodal forces (n_dof,) N of the rotor's weight, which points an angle (rad) past +x towards +y."""
    shift = np.zeros((len(rotor.node_positions), DOF_PER_NODE))
    shift[:, : len(DIRECTIONS)] = np.cos(angle), np.sin(angle)
    return np.asarray(GRAVITY * assemble_free(rotor).mass @ shift.ravel())


def local_stiffness(acting: Acting, speed: Array, order: int, n_port: int) -> ComplexArray:
    """Stiffness K_h (n, n_speed, n_port, n_port), N/m, of local forces by linear laws.

    Without any it is (n, 1, n_port, n_port) zeros. Their sites are the first ports: a part that grows with Ω² is a
    mass, at the frequency of the motion; all else is a function of the spin speed, as coefficients of bearings are.
    """
    found = np.zeros((len(acting.turning), len(speed) if acting.local else 1, n_port, n_port), dtype=complex)
    omega = (order * speed)[:, None, None]
    for index, (site, coefficients) in enumerate(acting.local):
        if site.law.follows_motion:
            here = slice(2 * index, 2 * index + 2)
            for row, each in enumerate(coefficients):
                mass, damping, stiffness = attached((site, each[None]), speed)
                found[row, :, here, here] = stiffness + 1j * omega * damping - omega**2 * mass
    return found


def port_forces(
    receptance: Sequence[ComplexArray],
    motion: Sequence[ComplexArray],
    local: Sequence[ComplexArray],
    turning: ComplexArray,
) -> list[ComplexArray]:
    """Forces at the ports (n, n_speed, n_port), N, of orders 0, 1, 2 …

    With the receptances P_h (n, n_speed, n_port, n_port) and the motion w_h (n, n_speed, n_port) under these forces,
    w_h + P_h (K_h w_h + Σ κ_{h−k} w_k) is the given motion without them. κ_m is (n, n_order, n_port, n_port). If all m
    are even, even and odd orders are not coupled, and are solved apart.
    """
    n_order = len(receptance)
    step = 1 if np.any(turning[:, 1::2]) else 2
    n, n_speed, n_port = motion[0].shape
    found = [np.empty((n, n_speed, n_port), dtype=complex) for _ in range(n_order)]
    if not n_port:
        return found
    n_chunk = max(1, CHUNK_BYTES // (16 * n_speed * (n_order // step * n_port) ** 2))
    for part in (slice(start, start + n_chunk) for start in range(0, n, n_chunk)):
        for orders in (range(first, n_order, step) for first in range(step)):
            per_force, without, springs = (
                [each[order][part] for order in orders] for each in (receptance, motion, local)
            )
            for order, force in zip(orders, _coupled_forces(orders, per_force, without, springs, turning[part])):
                found[order][part] = force
    return found


def _coupled_forces(
    orders: Sequence[int],
    receptance: Sequence[ComplexArray],
    motion: Sequence[ComplexArray],
    local: Sequence[ComplexArray],
    turning: ComplexArray,
) -> ComplexArray:
    """Forces at the ports (n_coupled, n, n_speed, n_port), N, of orders coupled only with each other.

    They are −(A w + B conj w) with A of κ_{h−k} and B of κ_{h+k}, if w + P (A w + B conj w) is the motion without them.
    The real and the imaginary part are solved for.
    """
    n, n_speed, n_port = motion[0].shape
    blocks = np.zeros((2, n, local[0].shape[1], len(orders), n_port, len(orders), n_port), dtype=complex)
    for row, order in enumerate(orders):
        blocks[0, :, :, row, :, row] += local[row]
        for column, other in enumerate(orders):
            blocks[0, :, :, row, :, column] += _of_order(turning, order - other)[:, None]
            if other:
                blocks[1, :, :, row, :, column] += _of_order(turning, order + other)[:, None]
    size = len(orders) * n_port
    direct, conjugate = blocks.reshape(2, n, -1, size, size)
    total, difference = direct + conjugate, direct - conjugate
    moving = np.empty((2, n, n_speed, size, size), dtype=complex)  # P (A + B) and P (A − B)
    for row, each in enumerate(receptance):
        here = slice(row * n_port, (row + 1) * n_port)
        moving[:, :, :, here] = each @ np.stack([total[:, :, here], difference[:, :, here]])
    system = np.empty((n, n_speed, 2, size, 2, size))
    system[:, :, 0, :, 0], system[:, :, 0, :, 1] = moving[0].real, -moving[1].imag
    system[:, :, 1, :, 0], system[:, :, 1, :, 1] = moving[0].imag, moving[1].real
    system = system.reshape(n, n_speed, 2 * size, 2 * size) + np.eye(2 * size)
    without = np.concatenate(motion, axis=-1)
    parts = np.linalg.solve(system, np.concatenate([without.real, without.imag], axis=-1)[..., None])[..., 0]
    moved = (parts[..., :size] + 1j * parts[..., size:])[..., None]
    forces = -(direct @ moved + conjugate @ np.conj(moved))
    return np.moveaxis(forces.reshape(n, n_speed, len(orders), n_port), 2, 0)


def _of_order(turning: ComplexArray, order: int) -> ComplexArray:
    """κ_m (n, n_port, n_port)."""
    if abs(order) >= turning.shape[1]:
        return np.zeros_like(turning[:, 0])
    return turning[:, order] if order >= 0 else np.conj(turning[:, -order])


def _behind(n_before: int, turning: ComplexArray) -> ComplexArray:
    """κ_m with ports before its own that it does not touch."""
    return np.pad(turning, [(0, 0), (0, 0), (n_before, 0), (n_before, 0)])


@dataclass(frozen=True)
class TurningEffects:
    """Turning stiffness and further loads of some effects, in their order.

    The weight is taken from the first effect that turns; without one it does nothing.
    """

    effects: tuple[RotorHooks, ...]

    @property
    def are_there(self) -> bool:
        return any(effect.turns or effect.further_orders for effect in self.effects)

    def shaft(
        self,
        rotor: Rotor,
        impedances: tuple[Impedance, ...],
        speed: Array,
        channels: tuple[Channel, ...],
        loads: ComplexArray | None,
        sites: Sequence[SiteLaw],
    ) -> TurningShaft:
        """Rotor with these effects, as other effects have changed it.

        It has 1X loads (n_speed, n_dof, n_load) and sites of local forces.
        """
        turning = [effect for effect in self.effects if effect.turns]
        none = np.empty((0, DOF_PER_NODE * len(rotor.node_positions)))
        rows = np.concatenate([none, *(effect.turning_rows(rotor) for effect in turning)])
        by_order = {} if loads is None else {1: loads}
        if turning:
            weight = turning[0].weight(rotor).astype(complex)
            by_order[0] = np.broadcast_to(weight[:, None], (len(speed), len(weight), 1))
        for order, effects in self._by_order.items():
            by_order[order] = np.concatenate([effect.loads_at(rotor, speed, order) for effect in effects], axis=2)
        at_sites = tuple(site.rows(rotor) for site in sites)
        return TurningShaft(rotor, impedances, speed, channels, rows, by_order, at_sites)

    def acting(self, rotor: Rotor, of_effects: Sequence[Array], sizes: ComplexArray, local: Sequence[Force]) -> Acting:
        """Loads and stiffness on a rotor at the values (n, e) of each effect.

        They act in addition to 1X loads of sizes (n, n_load) and local forces.
        """
        by_order = {0: np.ones((len(sizes), 1), dtype=complex), 1: sizes}
        for order in self._by_order:
            both = (
                (effect, theta) for effect, theta in zip(self.effects, of_effects) if order in effect.further_orders
            )
            by_order[order] = np.concatenate([effect.load_sizes_at(theta, order) for effect, theta in both], axis=1)
        return Acting(by_order, local, self.stiffness(rotor, of_effects))

    @property
    def _by_order(self) -> dict[int, list[RotorHooks]]:
        """The effects with loads at each order but the first."""
        orders = dict.fromkeys(order for effect in self.effects for order in effect.further_orders)
        return {order: [effect for effect in self.effects if order in effect.further_orders] for order in orders}

    def stiffness(self, rotor: Rotor, of_effects: Sequence[Array]) -> ComplexArray:
        """κ_m (n, n_order, n_port, n_port) of a rotor at the values (n, e) of each effect."""
        none = np.zeros((len(of_effects[0]), 1, 0, 0), dtype=complex)
        both = zip(self.effects, of_effects)
        turning = (effect.turning_stiffness(rotor, theta) for effect, theta in both if effect.turns)
        return beside_each_other([none, *turning])


def beside_each_other(parts: Sequence[ComplexArray]) -> ComplexArray:
    """κ_m (n, n_order, n_port, n_port) of several turning stiffnesses, each with ports of its own."""
    n, n_order = len(parts[0]), max(part.shape[1] for part in parts)
    n_port = sum(part.shape[-1] for part in parts)
    found, start = np.zeros((n, n_order, n_port, n_port), dtype=complex), 0
    for part in parts:
        here = slice(start, start + part.shape[-1])
        found[:, : part.shape[1], here, here] = part
        start = here.stop
    return found

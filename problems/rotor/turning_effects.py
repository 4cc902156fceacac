"""The effects of a rotor that move it at several multiples of its speed, as what `problems.rotor.turning` asks for: a stiffness
that turns with the shaft, and loads at other orders than 1X."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import Channel
from problems.rotor.data import Rotor
from problems.rotor.hooks import RotorHooks
from problems.rotor.mesh import DOF_PER_NODE
from problems.rotor.receptance import Impedance
from problems.rotor.site_law import Force, SiteLaw
from problems.rotor.turning import Acting, TurningShaft


@dataclass(frozen=True)
class TurningEffects:
    """Those of some effects, in their order; the weight is that of the first one that turns, and does nothing without."""

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
        """A rotor with them, as other effects have changed it, with 1X loads (n_speed, n_dof, n_load) and sites of local forces."""
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
        """What acts on a rotor at the values (n, e) of each effect, besides 1X loads of sizes (n, n_load) and local forces."""
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

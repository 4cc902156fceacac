"""The effects of a rotor that are a stiffness that turns with its shaft, as what `problems.rotor.turning` asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import Channel
from problems.rotor.data import Rotor
from problems.rotor.hooks import RotorHooks
from problems.rotor.receptance import Impedance
from problems.rotor.site_law import SiteLaw
from problems.rotor.turning import TurningShaft


@dataclass(frozen=True)
class TurningEffects:
    """Those of some effects that turn, in their order; the weight is that of the first one."""

    effects: tuple[RotorHooks, ...]

    @property
    def are_there(self) -> bool:
        return any(effect.turns for effect in self.effects)

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
        rows = np.concatenate([effect.turning_rows(rotor) for effect in turning])
        at_sites = tuple(site.rows(rotor) for site in sites)
        return TurningShaft(rotor, impedances, speed, channels, rows, loads, turning[0].weight(rotor), at_sites)

    def stiffness(self, of_effects: Sequence[Array]) -> ComplexArray:
        """κ_m (n, n_order, n_port, n_port) at the values (n, e) of each effect."""
        return beside_each_other(
            [effect.turning_stiffness(theta) for effect, theta in zip(self.effects, of_effects) if effect.turns]
        )


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

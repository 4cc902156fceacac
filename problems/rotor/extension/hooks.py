"""Hooks of an effect into a rotor; each changes nothing unless an effect overrides it.

Names of effects' unknowns.

Values of an effect's unknowns are rows of θ (n, e), SI, in the order of its `parameters`. The first runout of a model has
`runout_x`; a second one at 0.5 m has `runout_x_at_0_5_m`. Names do not change when an effect is added. A name is one word, so that
settings can be given by it.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.errors import SettingError
from ksmea.measurement.campaign import Run
from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter, name_at
from ksmea.problem.problem import Given
from problems.rotor.extension.run_up import Sweep
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.finite_elements.bearing import Support
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem


class RotorHooks(ABC):
    """The hooks that an extended rotor calls, from the shaft to the probes."""

    couples_axes: ClassVar[bool] = False  # its `impedance` has entries beside the diagonal
    couples_bearings: ClassVar[bool] = False  # its `support` is common to all bearings
    changes_rotor = Given("rotor")
    moves_probes = Given("moved")
    has_loads = Given("loads")  # with `load_sizes`
    turns = Given("turning_rows")  # with `turning_stiffness` and `weight`
    # Effects act from the lowest stage to the highest, in whatever order they were added: what a probe sees (0) before its
    # angle (1), and that before its gain (2). Supports carry the bearings as all other effects leave them.
    stage: ClassVar[int] = 0

    @abstractmethod
    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        """Unknowns of the effect, with limits that contain 0. At 0 the model is as without the effect."""

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        """The rotor as changed by one set of values (e,)."""
        return rotor

    def moved(self, looking: Sequence[Channel], channels: Sequence[Channel], theta: Array) -> tuple[Channel, ...]:
        """Positions and directions of the probes at one set of values (e,).

        `looking` are the channels without this effect.
        """
        return tuple(looking)

    def costly(self, n_unknown: int) -> Indices:
        """Indices of the unknowns that change the rotor or move probes.

        Each new value of them requires another reduction.
        """
        return np.arange(n_unknown if self.changes_rotor or self.moves_probes else 0)

    def of_probes(self, n_unknown: int) -> Mask:
        """Which of its unknowns move probes, and change nothing of the rotor."""
        return np.full(n_unknown, self.moves_probes and not self.changes_rotor)

    def linear(self, n_unknown: int) -> Mask:
        """Mask of the unknowns on which the rotor's matrices depend linearly, at any values of the others."""
        return np.zeros(n_unknown, dtype=bool)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        """Impedances of the bearings, (n_bearing, 2, 2, n, n_speed) N/m, at spin speeds (rad/s).

        They are from motion (second 2) to force (first 2). A whirl at another frequency ω feels Re z + iω Im z / Ω:
        coefficients of bearings are functions of the spin speed. A function of the frequency itself is a `support`.
        """
        return impedance

    def bearing_inertia(self, theta: Array) -> Array | None:
        """Mass (2, n), kg, that each bearing carries in x and y; None for none.

        It is felt by the frequency of the motion.
        """
        return None

    def support(self, theta: Array) -> Support | None:
        """Support of the bearings, in series with each; None for rigid ground."""
        return None

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        """Nodal forces per unit of each load, (n_speed, n_dof, n_load)."""
        raise NotImplementedError

    def going(self, run: Run) -> Self:
        """This effect as the speed goes in one run of a campaign. Default: unchanged."""
        return self

    def load_sizes(self, theta: Array) -> ComplexArray:
        """Size of each load, (n, n_load)."""
        raise NotImplementedError

    @property
    def further_orders(self) -> Sequence[int]:
        """Multiples of the speed of rotation, other than 1X, at which it has loads.

        They go up to `problems.rotor.extension.turning.HIGHEST`.
        """
        return ()

    def loads_at(self, rotor: Rotor, speed: Array, order: int) -> ComplexArray:
        """Nodal forces per unit of each load at one of `further_orders`, shaped as in `loads`."""
        raise NotImplementedError

    def load_sizes_at(self, theta: Array, order: int) -> ComplexArray:
        """Size of each load of `loads_at`, shaped as in `load_sizes`."""
        raise NotImplementedError

    def unbalance(self, theta: Array) -> Mapping[float, complex]:
        """Unbalance among its loads at one set of values (e,), by position (m).

        It is in kg m in the direction of the force.
        """
        return {}

    def site_law(self) -> SiteLaw | None:
        """Site and law of a force whose coefficients are the unknowns; None if no such force acts."""
        return None

    def turning_rows(self, rotor: Rotor) -> Array:
        """B (n_port, n_dof) of a stiffness Bᵀ κ(φ) B that turns with the shaft, by its angle φ = Ωt."""
        raise NotImplementedError

    def turning_stiffness(self, rotor: Rotor, theta: Array) -> ComplexArray:
        """κ_m (n, n_order, n_port, n_port) of κ(φ) = Re κ_0 + 2 Re Σ κ_m e^{imφ} for m = 0, 1, 2 …"""
        raise NotImplementedError

    def weight(self, rotor: Rotor) -> Array:
        """The nodal forces (n_dof,) N under which what turns with the shaft stands still in space."""
        raise NotImplementedError

    def sweep(self, theta: Array) -> Sweep | None:
        """How the speed sweeps while the motion is measured; None: it does not."""
        return None

    def needed_channels(self, channels: Sequence[Channel]) -> Sequence[Channel]:
        """Further channels whose motion its `observed` makes these channels of."""
        return ()

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        """Readings of the probes for a motion, (n, n_speed, n_channel) m."""
        return response


def effect_unknowns(problem: RotorProblem, effects: Sequence[RotorHooks]) -> tuple[tuple[Parameter, ...], ...]:
    """The unknowns of each effect on a problem.

    Raises `SettingError` where an unknown of the problem has the name of one, or two effects are the same at the same
    place.
    """
    found: list[tuple[Parameter, ...]] = []
    own = set(problem.parameters.names)
    taken, there = set(own), set[tuple[type, str]]()
    for effect in effects:
        items, at = effect.parameters(problem), (type(effect), str(effect))
        for item in items:
            if item.name in own or at in there:
                raise SettingError(
                    f"effects: expected each unknown once, got {item.name} again; take one of the two effects, or another"
                    " place for one"
                )
        if any(item.name in taken for item in items):
            items = tuple(dataclasses.replace(item, name=name_at(item.name, str(effect))) for item in items)
        taken.update(item.name for item in items)
        there.add(at)
        found.append(items)
    return tuple(found)

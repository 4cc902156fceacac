"""Hooks of an effect into a rotor; each changes nothing unless an effect overrides it.

Values of an effect's unknowns are rows of θ (n, e), SI, in the order of its `parameters`.

Names of effects' unknowns: the first runout of a model has `runout_x`; a second one at 0.5 m has `runout_x_at_0_5_m`. Names do
not change when an effect is added. A name is one word, so that settings can be given by it.
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
    """Hooks that an extended rotor calls, from the shaft to the probes."""

    couples_axes: ClassVar[bool] = False  # its `impedance` has entries beside the diagonal
    couples_bearings: ClassVar[bool] = False  # its `support` is common to all bearings
    changes_rotor = Given("rotor")
    moves_probes = Given("moved")
    has_loads = Given("loads")  # with `load_sizes`
    multiplies: ClassVar[bool] = False  # its changes are in parts of what other effects change
    turns = Given("turning_rows")  # with `turning_stiffness` and `weight`
    # Effects act from the lowest stage to the highest, in whatever order they were added: what a probe sees (0) before its
    # gain (2). Supports carry the bearings as all other effects leave them.
    stage: ClassVar[int] = 0

    @abstractmethod
    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        """Unknowns of the effect; at 0 of all of them the model is as without it.

        Args:
            problem: rotor without the effect.

        Returns:
            Unknowns (e,), with limits (SI) that contain 0.
        """

    @property
    def is_held(self) -> bool:
        """Whether it changes the rotor and its probes without unknowns."""
        return False

    def holding_inputs(self, theta: Array) -> Self:
        """This effect with numbers that are known to a tolerance held; default: itself, it has none.

        Args:
            theta: one set of values (e,), SI.
        """
        return self

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        """Rotor changed by the effect.

        Args:
            rotor: rotor without it.
            theta: one set of values (e,), SI.
        """
        return rotor

    def moved(self, looking: Sequence[Channel], channels: Sequence[Channel], theta: Array) -> tuple[Channel, ...]:
        """Positions and directions of the probes.

        Args:
            looking: channels without this effect.
            channels: channels as the measurement states them.
            theta: one set of values (e,), SI.
        """
        return tuple(looking)

    def costly(self, n_unknown: int) -> Indices:
        """Indices of the unknowns that change the rotor or move probes.

        Each new value of them requires another reduction.

        Args:
            n_unknown: number e of its unknowns.
        """
        return np.arange(n_unknown if self.changes_rotor or self.moves_probes else 0)

    def of_probes(self, n_unknown: int) -> Mask:
        """Mask (e,) of the unknowns that move probes, and change nothing of the rotor.

        Args:
            n_unknown: number e of its unknowns.
        """
        return np.full(n_unknown, self.moves_probes and not self.changes_rotor)

    def linear(self, n_unknown: int) -> Mask:
        """Mask (e,) of the unknowns on which the rotor's matrices depend linearly.

        They do so jointly, and nothing else of the rotor depends on them: neither loads nor what probes read.

        Args:
            n_unknown: number e of its unknowns.
        """
        return np.zeros(n_unknown, dtype=bool)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        """Impedances of the bearings with the effect.

        They are from motion (second 2) to force (first 2). A whirl at another frequency ω feels Re z + iω Im z / Ω: coefficients of
        bearings are functions of the spin speed. A function of the frequency itself is a `support`.

        Args:
            impedance: impedances without it, (n_bearing, 2, 2, n, n_speed), N/m.
            speed: spin speeds (n_speed,), rad/s.
            theta: values (n, e), SI.

        Returns:
            Impedances (n_bearing, 2, 2, n, n_speed), N/m.
        """
        return impedance

    def bearing_inertia(self, theta: Array) -> Array | None:
        """Mass that each bearing carries in x and y, which the frequency of the motion determines.

        Args:
            theta: values (n, e), SI.

        Returns:
            Masses (2, n), kg; None for none.
        """
        return None

    def support(self, theta: Array) -> Support | None:
        """Support of the bearings, in series with each.

        Args:
            theta: values (n, e), SI.

        Returns:
            Support; None for rigid ground.
        """
        return None

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        """Nodal forces per unit of each load at 1X.

        Args:
            rotor: rotor that they act on.
            speed: spin speeds (n_speed,), rad/s.

        Returns:
            Forces (n_speed, n_dof, n_load), N per unit.
        """
        raise NotImplementedError

    def going(self, run: Run) -> Self:
        """This effect with the speed history of one run of a campaign.

        Default: unchanged.

        Args:
            run: run of a campaign.
        """
        return self

    def load_sizes(self, theta: Array) -> ComplexArray:
        """Size of each load.

        Args:
            theta: values (n, e), SI.

        Returns:
            Complex sizes (n, n_load), in the units of `loads`.
        """
        raise NotImplementedError

    @property
    def further_orders(self) -> Sequence[int]:
        """Multiples of the speed of rotation, other than 1X, at which it has loads.

        They go up to `problems.rotor.extension.turning.HIGHEST`.
        """
        return ()

    def loads_at(self, rotor: Rotor, speed: Array, order: int) -> ComplexArray:
        """Nodal forces per unit of each load at a further order.

        Args:
            rotor: rotor that they act on.
            speed: spin speeds (n_speed,), rad/s.
            order: one of `further_orders`.

        Returns:
            Forces (n_speed, n_dof, n_load), N per unit.
        """
        raise NotImplementedError

    def load_sizes_at(self, theta: Array, order: int) -> ComplexArray:
        """Size of each load of `loads_at`.

        Args:
            theta: values (n, e), SI.
            order: one of `further_orders`.

        Returns:
            Complex sizes (n, n_load).
        """
        raise NotImplementedError

    def unbalance(self, theta: Array) -> Mapping[float, complex]:
        """Unbalance among its loads.

        Args:
            theta: one set of values (e,), SI.

        Returns:
            Complex unbalance, kg m in the direction of the force, by position, m.
        """
        return {}

    def site_law(self) -> SiteLaw | None:
        """Site and law of a force whose coefficients are the unknowns; None if no such force acts."""
        return None

    def turning_rows(self, rotor: Rotor) -> Array:
        """Rows B of a stiffness Bᵀ κ(φ) B that turns with the shaft, by its angle φ = Ωt.

        Args:
            rotor: rotor that it belongs to.

        Returns:
            Rows (n_port, n_dof).
        """
        raise NotImplementedError

    def turning_stiffness(self, rotor: Rotor, theta: Array) -> ComplexArray:
        """Harmonics κ_m of the turning stiffness κ(φ) = Re κ_0 + 2 Re Σ κ_m e^{imφ}, m = 0, 1, 2 …

        Args:
            rotor: rotor that it belongs to.
            theta: values (n, e), SI.

        Returns:
            Factors (n, n_order, n_port, n_port), with which Bᵀ κ B is a stiffness in SI units.
        """
        raise NotImplementedError

    def weight(self, rotor: Rotor) -> Array:
        """Nodal forces under which the turning stiffness stands still in space: the weight.

        Args:
            rotor: rotor that it belongs to.

        Returns:
            Forces (n_dof,), N.
        """
        raise NotImplementedError

    def sweep(self, theta: Array) -> Sweep | None:
        """Sweep of the speed while the motion is measured; None: it does not sweep.

        Args:
            theta: values (n, e), SI.
        """
        return None

    def needed_channels(self, channels: Sequence[Channel]) -> Sequence[Channel]:
        """Further channels whose motion its `observed` needs for some channels.

        Args:
            channels: these channels.
        """
        return ()

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        """Readings of the probes for a motion.

        Args:
            response: motion at the channels, (n, n_speed, n_channel), m.
            channels: probes.
            speed: spin speeds (n_speed,), rad/s.
            theta: values (n, e), SI.

        Returns:
            Readings (n, n_speed, n_channel), m.
        """
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

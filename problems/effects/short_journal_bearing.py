"""Short journal bearing: an oil film between journal and bush.

It is in series with the model's bearings.

The film has stiffness and damping that change with speed, are coupled across, and differ along and across the load
(`problems/rotor/extension/short_bearing.py`). The model's coefficients describe the support of the bush; without
clearance the film is rigid and the shaft feels them alone, z = (1 + z_b A)⁻¹ z_b with A = (K + iΩC)⁻¹ of the film. Each
bearing carries its share of the rotor's weight; all else is alike.

The unknown is the compliance s that the film would have without any load at the highest speed Ω₁, by which the clearance is

    c = (π η D L³ Ω₁ s / 8)^{1/3},

since what a film does begins with c³. Diameter, length and viscosity enter as η D L³ alone; with these known s is the clearance.
Short-bearing theory holds for L/D up to about 0.5 and eccentricity ratios up to about 0.7, for laminar films of one viscosity. The
growth of free motions takes the stiffness and the damping that film and bush have together at the spin speed for those at all
frequencies of whirl, which is exact where the film is far softer than what holds it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.settings.settings import setting
from ksmea.units import DEGREE
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, stiffness_scale
from problems.rotor.extension.short_bearing import eccentricity_ratio, film_coefficients
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.bearing import inverse, product
from problems.rotor.finite_elements.mesh import element_at, locate
from problems.rotor.free_motion.static_load import weight_shares
from problems.rotor.response.problem import RotorProblem

SOFTEST = 2.0  # times the compliance of the stiffest bearing, as of a pedestal
NOTICED = (0.002, 0.5)  # of that compliance, are drawn
LEAST_SHARE = 1e-3  # of the whole load: a bearing that carries less counts as carrying this
N_DIGIT = 3  # of loads, mN: they come out of a mesh with its rounding
SMALLEST_CLEARANCE = 1e-12  # m, below which ε no longer changes: its compliance is none


@dataclass(frozen=True)
class ShortJournalBearing(RotorEffect):
    """The shaft floats on oil in its bearings."""

    extent = ALL_BEARINGS
    diameter: float | None = setting(
        None, "D of the journals; null: the shaft's diameter at the first bearing", unit="m", above=0
    )
    length: float | None = setting(None, "L of the bearings; null: a quarter of the diameter", unit="m", above=0)
    viscosity: float = setting(0.02, "η of the oil; ISO VG 32 has 0.02 at 55 °C", unit="Pa s", above=0)
    load_angle: float = setting(-90.0, "direction of the static load, from x towards y", unit="deg")
    loads_n: list[float] = setting(
        [], "static load of each bearing; empty: its share of the rotor's weight", unit="N", above=0
    )
    full_speed: float | None = setting(
        None, "the speed Ω₁ of the unknown; null: the highest of the problem", unit="rad/s", above=0
    )

    words = "journal bearing film"
    says = "Oil films yield by {film_compliance} at the highest speed"
    check_next = (
        "Repeat the run with warm and cold oil:"
        " a response that follows the viscosity confirms it; then check bearing clearances."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "annular_seal": "a film of liquid too, but at the bearings; probes near the seal, a run without pressure",
        "cross_coupling_antisymmetric": "both drive forward whirl; warm and cold oil differ, what else couples does not",
        "flexible_pedestal": "both are soft and in series with the bearings; a sensor on the casing, warm and cold oil",
    }
    couples_axes: ClassVar[bool] = True
    stage: ClassVar[int] = 1  # in series with the bearings as all else leaves them

    sizes = (Size("film_compliance", "µm/kN", (0.0, SOFTEST), drawn=NOTICED, per=stiffness_scale),)

    def locations(self, problem: RotorProblem) -> Sequence[ShortJournalBearing]:
        return [self.placed_on(problem)] if self.loads_n or len(problem.rotor.bearings) > 1 else []

    def placed_on(self, problem: RotorProblem) -> ShortJournalBearing:
        rotor, bearings = problem.rotor, problem.rotor.bearings
        if len(self.loads_n or bearings) != len(bearings) or (not self.loads_n and len(bearings) < 2):
            raise SettingError(
                f"loads_n: expected one of each of {len(bearings)} bearings, got {self.loads_n}; give them"
            )
        shares = np.array(self.loads_n) if self.loads_n else np.abs(weight_shares(rotor))
        shares = np.maximum(shares, LEAST_SHARE * np.sum(shares))
        segment = element_at(rotor, locate(rotor, bearings[0].position)[0]).segment
        diameter = self.diameter or 2 * segment.outer_radius
        return dataclasses.replace(
            self,
            diameter=diameter,
            length=self.length or diameter / 4,
            loads_n=np.round(shares, N_DIGIT).tolist(),
            full_speed=self.full_speed or float(np.max(problem.speed)),
        )

    def clearance(self, compliance: Array) -> Array:
        """Radial clearance, m, of the unknown, m/N, of any shape."""
        return np.cbrt(np.pi / 8 * self._oil * (self.full_speed or 0.0) * compliance)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        film = self.film_compliance(speed, theta[:, 0])
        unit = np.eye(2)[..., None, None, None]
        own = np.moveaxis(impedance, 0, 2)
        return np.moveaxis(product(inverse(unit + product(own, film)), own), 2, 0)

    def film_compliance(self, speed: Array, compliance: Array) -> ComplexArray:
        """A in (x, y), (2, 2, n_bearing, n, n_speed) m/N, for values (n,) of the unknown."""
        if self.full_speed is None:
            raise SettingError("full_speed: expected the highest speed, got none; add the effect to a problem")
        clearance = self.clearance(compliance)[:, None]
        load = np.array(self.loads_n)[:, None, None]
        sommerfeld = self._oil * speed / (8 * load * np.maximum(clearance, SMALLEST_CLEARANCE) ** 2)
        eccentricity = eccentricity_ratio(sommerfeld)
        stiffness, damping = film_coefficients(eccentricity)
        in_load_axes = clearance * eccentricity / load * inverse(eccentricity * (stiffness + 1j * damping))
        turn = self.load_angle * DEGREE + np.pi / 2  # of (u, v), with v against the load, from (x, y)
        axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])  # u and v as columns
        return np.asarray(np.einsum("iu,uv...,jv->ij...", axes, in_load_axes, axes))

    @property
    def _oil(self) -> float:
        """η D L³, N m² s."""
        return self.viscosity * (self.diameter or 0.0) * (self.length or 0.0) ** 3

"""Annular seal: the liquid in a narrow gap carries the shaft, damps it, and drags it as it swirls.

The liquid turns at λ times the speed of the shaft, on average, and what resists motion is motion against the liquid:

    f = −K q − D (q̇ − λ Ω × q),    so that K_xx = K_yy = K,  K_xy = −K_yx = λ Ω D,  C_xx = C_yy = D.

K comes from the pressure drop (the Lomakin effect), D from viscous and turbulent friction. The cross term drives forward whirl, and
makes a rotor unstable above about 1/λ times its lowest natural frequency where nothing else damps it. λ is 1/2 for smooth walls,
more where the liquid enters swirling, and 0.2 or less behind swirl brakes. The seal is short: moments, and the mass of the liquid, are
left out, as is the growth of K with speed in pumps whose pressure grows so.

A. Muszynska, Rotordynamics, 2005, chapter 4; H. F. Black, Effects of hydraulic forces in annular pressure seals on the vibrations of
centrifugal pump rotors, J. Mech. Eng. Sci. 11 (1969) 206–213; D. W. Childs, Turbomachinery
Rotordynamics, 1993, chapter 4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.nonlinear.laws import CROSS, LinearLaw
from ksmea.settings.settings import setting
from ksmea.units import KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE
from problems.rotor.extension.effect import SeatedEffect, places_of, rotor_mass, stiffness_scale
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor
from problems.rotor.response.problem import RotorProblem

STIFFEST = 0.5  # of the stiffest bearing k
MOST_DAMPING = 0.1  # of √(k m), m the mass of the rotor
NOTICED_STIFFNESS = (0.01, 0.3)  # of k, are drawn
NOTICED_DAMPING = (3e-5, 3e-3)  # of √(k m), are drawn: more drives a rotor unstable that is hardly damped otherwise


def _damping_scale(problem: RotorProblem) -> float:
    """√(k m), N s/m."""
    return float(np.sqrt(stiffness_scale(problem) * rotor_mass(problem)))


@dataclass(frozen=True)
class AnnularSeal(SeatedEffect):
    """A seal around the shaft holds, damps and drags it."""

    position: float | None = setting(
        None, "position of the seal; null: first seal of the rotor, or disk away from bearings", unit="m", at_least=0
    )
    swirl_ratio: float = setting(
        0.5, "λ, mean speed of the liquid around the shaft over the speed of the shaft's surface", at_least=0, at_most=1
    )

    says = "A seal {place} holds the shaft with {seal_stiffness} and damps it with {seal_damping}"
    check_next = "Repeat the run without flow or at another pressure drop: a change in the response confirms the seal."
    aliases: ClassVar[Mapping[str, str]] = {
        "cross_coupling_antisymmetric": "both drive forward whirl; a seal's grows with speed: measure over a wide band, or without pressure",
        "short_journal_bearing": "a film of liquid too, but at the bearings; probes near the seal, a run without pressure",
    }

    what, default_place = "seal", "the first disk"
    sizes = (
        Size("seal_stiffness", "MN/m", (0.0, STIFFEST), drawn=NOTICED_STIFFNESS, of=stiffness_scale),
        Size("seal_damping", "kN s/m", (0.0, MOST_DAMPING), drawn=NOTICED_DAMPING, of=_damping_scale),
    )

    def is_offered(self, problem: RotorProblem) -> bool:
        """Machines as drawn need a seal in the drawing, whose position is then tried."""
        return bool(problem.rotor.seals) or not problem.is_as_drawn

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        """Each seal that the rotor states.

        Without seals it is each disk that is at no bearing, as impellers and pistons have seals; without any, the point
        half way between the outer bearings.
        """
        return _gaps(problem.rotor)

    def site_law(self) -> SiteLaw:
        coefficients = (("k", "MN/m", MEGANEWTON_PER_METRE), ("d", "kN s/m", KILONEWTON_SECOND_PER_METRE))
        return SiteLaw(self.place, LinearLaw("annular_seal", "annular seal", coefficients, self._stiffness))

    def _stiffness(self, speed: Array) -> ComplexArray:
        """Dynamic stiffness of unit K and of unit D, (2, n_speed, 2, 2)."""
        still = np.broadcast_to(np.eye(2, dtype=complex), (len(speed), 2, 2))
        return np.stack([still, speed[:, None, None] * (1j * np.eye(2) + self.swirl_ratio * CROSS[0])])


def _gaps(rotor: Rotor) -> list[float]:
    """Positions that a seal may have, m."""
    if stated := places_of(rotor.seals, rotor):
        return stated
    bearings = [bearing.position for bearing in rotor.bearings]

    def is_free(position: float) -> bool:
        return all(abs(bearing - position) > SAME_PLACE * rotor.length for bearing in bearings)

    disks = [position for position in places_of(rotor.disks, rotor) if is_free(position)]
    return disks or [(min(bearings) + max(bearings)) / 2]

"""Bilinear support: beyond an amplitude the bearings are stiffer, or softer, than below.

Play that is taken up, a bump stop, a preload that is lost: to k belongs a force −Δk (1 − δ/|r|) r outside of |r| = δ, the motion of the
journal (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations, 1979, section 4.1, for piecewise linear springs). Peaks keep their place
up to δ and lean beyond it: to higher speeds for Δk > 0, to lower ones for Δk < 0. As with a cubic spring, more unbalance and the
direction of the run show it.

What acts is found by harmonic balance, and of several steady motions the one that the direction of the run leads to
(`ksmea/nonlinear/steady_motion.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ksmea.nonlinear.laws import LAWS, Law
from problems.effects.cubic_stiffness import BearingSprings
from problems.rotor.extension.effect import stiffness_scale
from problems.rotor.extension.nonlinear_effect import eccentricity
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

WIDEST = 30.0  # amplitude, times the eccentricity of the largest unbalance: motions beside resonances are far smaller
SOFTEST, STIFFEST = -0.5, 1.0  # change of stiffness, of the largest that a bearing may have
NOTICED, WIDE = (0.01, 0.3), (0.03, 0.3)  # of the limits, are drawn


def _widest(problem: RotorProblem) -> float:
    return WIDEST * eccentricity(problem)


@dataclass(frozen=True)
class BilinearStiffness(BearingSprings):
    """The bearings change their stiffness beyond an amplitude."""

    law: ClassVar[Law] = LAWS["spring_above_an_amplitude"]

    says = "Beyond {knee} of motion the bearings are {stiffness_beyond:stiffer|softer}, {place}"
    check_next = (
        "Repeat the run with more unbalance:"
        " peaks that lean further confirm it; then check play and stops of the bearings."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "cubic_stiffness": "both lean peaks; a run with far more unbalance, which shows the amplitude where it begins",
        "clearance_rub": "both lean peaks; friction and the place tell them apart: probes at the bearings",
    }

    sizes = (
        Size("stiffness_beyond", "MN/m", (SOFTEST, STIFFEST), drawn=NOTICED, of=stiffness_scale, makes_jumps=True),
        Size("knee", "µm", (0.0, 1.0), drawn=WIDE, of=_widest, rises=True, makes_jumps=True),
    )

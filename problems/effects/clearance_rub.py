"""Rub: if its motion exceeds a clearance, the shaft touches a stop around it and rubs.

With r the motion at the place, the stop pushes with −k (1 − δ/|r|) r outside of |r| = δ, and drags against the turning
shaft with μ times as much, at right angles (the Jeffcott rotor of A. Muszynska, Rotordynamics, 2005, ch. 5, and
J. Jiang and H. Ulbrich, Nonlinear Dyn. 24 (2001) 269–283). Contact stiffens: peaks are cut off at about the clearance
and lean to higher speeds, where run-up and run-down differ; a non-circular orbit has 3X. The clearance is around the
shaft as it is without unbalance: one that the shaft leans into, with contact on one side and motions at 2X and ½X, is
not described, nor is dry whip, a backward whirl at another frequency.

Without contact stiffness the other unknowns do nothing. What acts is found by harmonic balance, and of several steady motions the one
that the direction of the run leads to (`ksmea/nonlinear/steady_motion.py`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.nonlinear.laws import LAWS
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import SeatedEffect, places_of, stiffness_scale
from problems.rotor.extension.nonlinear_effect import UP, NonlinearEffect, eccentricity
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

WIDEST = 30.0  # clearance, times the eccentricity of the largest unbalance: motions beside resonances are far smaller
ROUGHEST = 0.5  # friction coefficient: dry steel on steel
STIFF, WIDE, ROUGH = (0.01, 0.3), (0.03, 0.3), (0.05, 0.6)  # of the limits, are drawn
LAW = LAWS["rub"]


def _widest(problem: RotorProblem) -> float:
    return WIDEST * eccentricity(problem)


def _roughest(problem: RotorProblem) -> float:  # so that what is drawn is a part of it
    return ROUGHEST


@dataclass(frozen=True)
class ClearanceRub(NonlinearEffect, SeatedEffect):
    """The shaft touches a stop where it moves farther than a clearance."""

    if_nowhere: ClassVar[str] = "this rotor has no disks; give its position, which takes a file"

    position: float | None = setting(None, "position of the contact; null: at a disk", unit="m", at_least=0)

    words = "rub"
    says = "The shaft touches a stop {place} beyond a clearance of {clearance}"
    check_next = (
        "Look for rub marks and measure clearances there: different peaks in run-up and coast-down confirm it too."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "cubic_stiffness": "both lean peaks; a run with more unbalance",
        "speed_dependent_damping": "both lower a peak; a run with more unbalance",
        "bilinear_stiffness": "both lean peaks; friction and the place tell them apart: probes at the bearings",
    }

    what, default_place, needs = "rub", "at a disk", "the position of the rub"
    sizes = (
        Size("contact_stiffness", "MN/m", (0.0, 1.0), drawn=STIFF, of=stiffness_scale, makes_jumps=True),
        Size("clearance", "µm", (0.0, 1.0), drawn=WIDE, of=_widest, makes_jumps=True),
        Size("friction", "%", (0.0, 1.0), drawn=ROUGH, of=_roughest, makes_jumps=True),
    )

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        if self.position is not None:
            return [self.position]
        return places_of(problem.rotor.disks, problem.rotor)

    def site_law(self) -> SiteLaw:
        return SiteLaw(self.place, LAW, orders=self.orders, goes_up=self.direction == UP)

"""Base of effects whose force depends on the motion otherwise than linearly.

It depends on the direction of the speed, and on harmonics.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

from ksmea.measurement.campaign import Run
from ksmea.measurement.measurement import Measurement
from ksmea.nonlinear.laws import Law
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import RotorEffect, rotor_mass, unbalance_scale
from problems.rotor.response.problem import RotorProblem

UP, DOWN = "up", "down"
OF_HISTORY = {"run-up": UP, "coast-down": DOWN}


@dataclass(frozen=True)
class NonlinearEffect(RotorEffect):
    """Base of nonlinear effects; if a resonance folds over, `direction` selects the steady motion."""

    direction: str = setting(
        UP, "direction of the slow change of speed, if the run does not state it", choices=(UP, DOWN)
    )
    harmonics: int = setting(
        5,
        "the highest harmonic of the rotation that motions have; of forces alike in opposite directions odd ones. With 5 a contact"
        " on a nearly flat orbit leaves out harmonics of a tenth of the force at 1X, which hardly move the shaft far above all"
        " criticals",
        at_least=1,
        at_most=15,
    )

    @property
    def orders(self) -> tuple[int, ...]:
        return tuple(range(1, self.harmonics + 1, 2))

    def going(self, run: Run) -> Self:
        return self._towards(run.direction)

    def _towards(self, direction: str) -> Self:
        return dataclasses.replace(self, direction=direction) if direction in (UP, DOWN) else self

    def force_at(self) -> tuple[float, Law] | None:
        site = self.site_law()
        return None if site is None or site.further else (site.position, site.law)

    def seen_in(self, measurement: Measurement) -> Self | None:
        """Effect with the direction of the run, if more than one run at 1X was measured.

        Nonlinear forces show at other harmonics, with other unbalance, and in the other direction of the speed. In a
        single run linear effects do as much, and balancing harmonics costs a hundred times as much as they do.
        """
        campaign, history = measurement.campaign, measurement.history
        if all(channel.is_1x for channel in measurement.channels) and (campaign is None or len(campaign.runs) < 2):
            return None
        return self._towards(OF_HISTORY.get(history.direction, "")) if history else self


def eccentricity(problem: RotorProblem) -> float:
    """Displacement of the rotor's mass by the largest unbalance, m.

    It is the scale of motions next to resonances.
    """
    return unbalance_scale(problem) / rotor_mass(problem)

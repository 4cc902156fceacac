"""Compass search: Kolda, Lewis & Torczon, SIAM Rev. 45 (2003) 385–482, doi 10.1137/S003614450242889."""

from dataclasses import dataclass

import numpy as np

from ksmea import Minimum, Objective, Optimizer, setting


@dataclass(frozen=True)
class CompassSearch(Optimizer):
    """Compass search: from a random point to the best of its neighbours along the axes.

    If none is better, the step is halved.
    """

    first_step: float = setting(0.25, "first step, of the range of each unknown", above=0, at_most=1)
    last_step: float = setting(1e-5, "the search ends below this step", above=0, at_most=1)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        directions = np.vstack([np.eye(objective.dim), -np.eye(objective.dim)])
        centre, step = rng.random(objective.dim), self.first_step
        lowest = objective(centre[None])[0]
        while step > self.last_step:
            around = np.clip(centre + step * directions, 0.0, 1.0)
            misfits = objective(around)
            best = int(np.argmin(misfits))
            if misfits[best] < lowest:
                centre, lowest = around[best], misfits[best]
            else:
                step /= 2
        return objective.result()

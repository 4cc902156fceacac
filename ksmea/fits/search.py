"""A search and all that travels with it.

How hard it looks, its random numbers, who shares its work and follows its steps.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.numerics.parallel import ALONE, Workers


@dataclass(frozen=True)
class Effort:
    """Numbers of screened points and fits, and further effort if several explanations are near."""

    screening: int = 4000  # points of the baseline model that are screened
    starts: int = 12  # fits of the baseline model
    scan: int = 200  # of the screened points, those that are screened again at each value of an effect
    scan_values: int = 16  # values of an effect with one unknown; twice as many for each more
    scan_clouds: int = 48  # best points of a scan that clouds of points are laid around
    effect_starts: int = 5  # fits of an extended one from a scan of its effect
    first_iterations: int = 8  # after which only the best of them go on
    survivors: int = 2
    firsts: int = 3  # effects that second ones are fitted beside, where the best one does not leave noise behind
    pairs: int = 18  # pairs of effects that are fitted to the end, and at most as many that are scanned
    average: bool = True  # unknowns and responses over several explanations
    split: bool = True  # several explanations by a further measurement, which is sought
    is_scanned: bool = True  # effects that need it are scanned over their whole range
    from_force: bool = True  # effects start from their force as that is recovered from the data

    @property
    def of_first_scans(self) -> Effort:
        """A quarter of it for first scans of effects, which mostly find what there is."""
        return dataclasses.replace(self, scan=max(1, self.scan // 4), scan_clouds=max(1, self.scan_clouds // 4))


@dataclass(frozen=True)
class Search:
    """Effort of a search, the generator of its random numbers, and the workers that share it.

    The result does not depend on the number of workers.
    """

    rng: np.random.Generator
    effort: Effort = Effort()
    workers: Workers = ALONE

    def with_effort(self, effort: Effort, **changes: Any) -> Search:
        """With another effort, some fields of it changed."""
        return dataclasses.replace(self, effort=dataclasses.replace(effort, **changes))

"""An axis that is linear about 0 and logarithmic to both sides, as figures have it and plotly lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.scale import SymmetricalLogTransform

from bench.reports.plots.traces import Layout
from ksmea.arrays import Array
from ksmea.show.figures.ticks import MOST_POWERS, symlog_ticks


@dataclass(frozen=True)
class SymlogAxis:
    """Positions of values on an axis that is linear up to `linear` to both sides."""

    linear: float

    def positions(self, values: Array | list[float]) -> Array:
        """Where values (n,) stand."""
        found: Array = self._transform(np.asarray(values, dtype=float))
        return found

    def ticks(self, low: float, high: float, most: int = MOST_POWERS) -> Layout:
        """What an axis shows between two values: plain numbers at 0 and, to each side, at `most` powers of ten."""
        at = symlog_ticks(low, high, self.linear, most)
        return {"tickvals": self.positions(at), "ticktext": [f"{each:.12g}".replace("-", "−") for each in at]}

    @cached_property
    def _transform(self) -> Callable[[Array], Array]:
        transform: Callable[[Array], Array] = SymmetricalLogTransform(
            base=10, linthresh=self.linear, linscale=1
        ).transform
        return transform

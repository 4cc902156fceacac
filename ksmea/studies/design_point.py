"""Where the studies that look ahead linearise the model, and the data that they add to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.diagnosis.fitting import Effort, fit_baseline
from ksmea.measurement import Measurement, Noise
from ksmea.studies.enough_data import require_enough


@dataclass(frozen=True)
class DesignPoint:
    """Values x (d,) SI of the unknowns of a problem that is seen as the data are, their kind, and their noise."""

    problem: Problem
    x: Array
    noise: Noise
    kind: str
    noise_known: bool = True

    @classmethod
    def of_measurement(cls, problem: Problem, measurement: Measurement, rng: np.random.Generator) -> DesignPoint:
        """What a measurement makes most likely, by a search of the whole box; the problem is aligned with it.

        Raises `SettingError` for fewer data than unknowns."""
        require_enough(measurement.layout, len(problem.parameters), with_noise=measurement.noise is None)
        fit = fit_baseline(problem, measurement, rng, Effort()).best
        return cls(problem, fit.x, fit.noise, measurement.kind, measurement.noise is not None)

"""Linearisation point of the studies that look ahead, and the data that they add to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import nnls

from ksmea.arrays import Array
from ksmea.fits.fitting import fit_baseline
from ksmea.fits.joint_fit import joint_baseline
from ksmea.fits.lack_of_fit import lack_of_fit
from ksmea.fits.search import Search
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem, joint_values
from ksmea.records.identification import LackOfFit
from ksmea.studies.enough_data import can_be_tested, require_enough
from ksmea.units import MICROMETRE

NEGLIGIBLE = 1e-6  # of s² at every datum: what rounding leaves of a part of the noise that is not there


@dataclass(frozen=True)
class DesignPoint:
    """Values x (d,) SI of the unknowns of an aligned problem, with observable and noise.

    `lack_of_fit` is the test of the model at values that were fitted to a measurement, as `identify` makes it; None where
    nothing was fitted or the data are too few to test. `remarks` say what was assumed of the noise. `numbers` are values (SI) of
    numbers known to a tolerance that are not as stated, by their names, and those in `exact` are known exactly.
    """

    problem: Problem
    x: Array
    noise: Noise
    kind: str
    noise_known: bool = True
    lack_of_fit: LackOfFit | None = None
    remarks: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    exact: tuple[str, ...] = ()

    @property
    def joint_x(self) -> Array:
        """Values (d,) SI of all unknowns of the joint problem."""
        return joint_values(self.problem, self.problem.joint, self.x, self.numbers)

    @classmethod
    def of_measurement(cls, case: Case, rng: np.random.Generator) -> DesignPoint:
        """Most likely values of a measurement by a search of the whole box.

        Numbers known to a tolerance are fitted jointly.

        Raises `SettingError` for fewer data than unknowns.
        """
        problem, measurement = case.problem, case.measurement
        with_noise = measurement.noise is None
        require_enough(measurement.layout, len(problem.parameters), with_noise=with_noise)
        fit = joint_baseline(fit_baseline(case, Search(rng))).best
        is_testable = can_be_tested(measurement.layout, len(problem.parameters), with_noise=with_noise)
        noise = fit.noise
        remarks: tuple[str, ...] = ()
        if np.ndim(noise.relative) or np.ndim(noise.floor):
            amplitude = np.abs(fit.response() if with_noise else measurement.values)
            noise = common_noise(noise, amplitude)
            remarks = (_said(noise, with_noise=with_noise),)
        values = dict(zip(fit.problem.parameters.names, fit.x.tolist()))
        return cls(
            problem,
            np.array([values.pop(name) for name in problem.parameters.names]),
            noise,
            measurement.kind,
            not with_noise,
            lack_of_fit(fit, rng) if is_testable else None,
            remarks,
            values,
        )


def common_noise(noise: Noise, amplitude: Array) -> Noise:
    """One relative part and one floor that describe noise that varies by datum or run.

    With them it is known at other speeds and probes too.

    Both squared are not below 0 and minimise Σ (s² / s²ᵢ − 1)² over the data, which have the amplitudes (n_speed, n_channel), m.
    Amplitudes that are all 0 say nothing of a relative part: it is 0.

    >>> amplitude = np.array([[1.0], [2.0], [4.0]])
    >>> found = common_noise(Noise(0.0, np.hypot(0.1 * amplitude, 0.3)), amplitude)
    >>> round(float(found.relative), 9), round(float(found.floor), 9)
    (0.1, 0.3)
    """
    variance = np.broadcast_to(noise.variance(amplitude), amplitude.shape)
    is_known = np.isfinite(amplitude) & np.isfinite(variance) & (variance > 0)
    squared, variance = amplitude[is_known] ** 2, variance[is_known]
    is_read = squared > 0
    scale = (
        np.median(squared[is_read]) if is_read.any() else 1.0,
        np.median(variance),
    )  # µm² beside 1: both columns near 1
    columns = np.stack([squared / scale[0], np.ones_like(squared)], axis=1) * (scale[1] / variance)[:, None]
    parts = nnls(columns, np.ones(len(columns)))[0]
    relative, floor = np.where(np.max(columns * parts, axis=0) > NEGLIGIBLE, parts, 0.0)
    return Noise(float(np.sqrt(relative * scale[1] / scale[0])), float(np.sqrt(floor * scale[1])))


def _said(noise: Noise, *, with_noise: bool) -> str:
    where = "differs from run to run" if with_noise else "is stated datum by datum"
    parts = [f"{100 * noise.relative:.2g} % of each value"] if noise.relative else []
    parts += [f"{noise.floor / MICROMETRE:.2g} µm"] if noise.floor else []
    return f"the noise {where}: here it is {' and '.join(parts)} everywhere, which describes it best"

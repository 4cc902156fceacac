"""Balancing in one plane without phases.

The bare run and three or more runs with a weight at different angles.

A run with the weight w has the amplitude |y0 + c w| at an entry. The phase of y0 is not measured and not needed; with y0 > 0

    |y0 + c w|² = y0² + |c|² |w|² + 2 Re(y0 c w)

is linear in y0², |c|² and y0 c. Four runs solve it: the circles of radii |y0 + c w| about the ends of −c w meet in y0, which
is the drawing of Siemens' and Fox' four-run method (Fox, *Practical field balancing*, 1980; Everett, J. Eng. Ind. 109 (1987) 165,
10.1115/1.3187107). From there least squares of the amplitudes are found, weighted by their noise.

With a weight of size W at 0, 120 and 240°, and its effect T = |c| W / y0, noise σ of the amplitudes gives the correction the
relative error (rms) 2 (σ / y0) √(4/3 + 1/(3 T²)) by the linear equation, to first order, and less by least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from ksmea.arrays import Array, ComplexArray
from ksmea.balancing.fit import COMMON, REPEATS, STATED, Fit, Terms
from ksmea.balancing.influence import Influence
from ksmea.balancing.readings import Readings
from ksmea.balancing.variance import Components
from ksmea.errors import SettingError

N_UNKNOWN = 3  # of an entry: bare amplitude, both parts of the influence coefficient
N_LINEAR = 4  # of its linear equation
TO_COMPLEX = np.array([[1, 0, 0], [0, 1, 1j]])  # from these three real numbers to both complex ones
SMALLEST = 1e-6  # relative singular value below which weights do not differ enough


@dataclass(frozen=True)
class AmplitudeFit(Fit):
    """Influence coefficients, phases relative to the bare response.

    `dof` is half of the real degrees of freedom.
    """

    covariance_found: ComplexArray = field(default_factory=lambda: np.empty((0, 0), np.complex128))  # E[δ δᴴ], flat
    relation_found: ComplexArray = field(default_factory=lambda: np.empty((0, 0), np.complex128))  # E[δ δᵀ]

    @property
    def coefficient_covariance(self) -> ComplexArray:
        return self.covariance_found

    @property
    def coefficient_relation(self) -> ComplexArray:
        """E[δ δᵀ]: the bare response is real, so that errors are not circular."""
        return self.relation_found


def fitted_amplitudes(readings: Readings) -> AmplitudeFit:
    """The fit to all runs of readings in one plane.

    Raises `SettingError` if weights are unknown, or known ones do not determine the coefficients.
    """
    if len(readings.is_known) < len(readings.names):
        raise SettingError(
            "balance: expected runs with known weights where amplitudes alone are measured, got an unknown one; add"
            " phase_lead_deg, or leave its run out"
        )
    scale = float(np.max(np.abs(readings.weights)))
    weights = readings.weights[:, 0] / scale
    linear = np.column_stack([np.ones(len(weights)), np.abs(weights) ** 2, 2 * weights.real, -2 * weights.imag])
    if np.linalg.matrix_rank(linear, tol=SMALLEST * np.linalg.norm(linear)) < N_LINEAR:
        raise SettingError(
            "balance: expected the bare run and three runs or more with the weight at different angles, such as 0, 120 and"
            f" 240°, since amplitudes alone are measured, got {len(weights)} runs that leave the angle of the correction"
            " open; add one, or phase_lead_deg"
        )
    amplitude = np.abs(readings.response)  # (n_run, n_entry)
    variance, method, dof = _noise(readings, amplitude)
    found = [_entry(linear, weights, each, own) for each, own in zip(amplitude.T, variance.T)]
    coefficients = np.array([each for each, _, _ in found]).T
    factor = sum(chi2 for *_, chi2 in found) / (2 * dof) if method == COMMON else 1.0
    n = len(found)
    covariance, relation = np.zeros((2, 2 * n, 2 * n), dtype=np.complex128)
    for index, (_, parts, _) in enumerate(found):
        at = np.ix_([index, n + index], [index, n + index])
        covariance[at], relation[at] = (
            factor * TO_COMPLEX @ parts @ other.T for other in (TO_COMPLEX.conj(), TO_COMPLEX)
        )
    unit = np.repeat([1.0, scale], n)
    influence = Influence(
        coefficients / np.array([[1.0], [scale]]),
        np.zeros(len(readings.speed), dtype=complex),
        0j,
        scale,
        readings.speed_of_entry,
    )
    components = Components(None, np.diag(factor * variance.mean(axis=0)).astype(complex), 1.0, 0.0)
    return AmplitudeFit(
        readings,
        np.arange(len(weights)),
        influence,
        Terms(),
        components,
        method,
        dof,
        covariance_found=np.asarray(covariance / np.outer(unit, unit)),
        relation_found=np.asarray(relation / np.outer(unit, unit)),
    )


def _noise(readings: Readings, amplitude: Array) -> tuple[Array, str, float]:
    """Variance (n_run, n_entry) of the amplitudes, its origin and its complex degrees of freedom.

    It is known up to a factor if neither sigma_um nor repeats determine it.
    """
    n_run, n_entry = amplitude.shape
    if readings.variance is not None:
        return readings.variance, STATED, float("inf")
    if readings.repeat_variance is not None:
        return np.tile(readings.repeat_variance, (n_run, 1)), REPEATS, readings.repeat_dof * n_entry / 2
    return np.tile(np.mean(amplitude**2, axis=0), (n_run, 1)), COMMON, (n_run - N_UNKNOWN) * n_entry / 2


def closed_form(linear: Array, amplitude: Array) -> ComplexArray:
    """Bare amplitude and influence coefficient by the linear equation, of amplitudes (n_run,).

    >>> turned = np.exp(2j * np.pi * np.arange(3) / 3)
    >>> linear = np.column_stack([np.ones(4), [0, 1, 1, 1], 2 * np.r_[0, turned.real], -2 * np.r_[0, turned.imag]])
    >>> np.round(closed_form(linear, np.abs([5, *(5 + (3 - 1j) * turned)])), 9)
    array([5.+0.j, 3.-1.j])
    """
    square, _, real, imaginary = np.linalg.lstsq(linear, amplitude**2, rcond=None)[0]
    bare = np.sqrt(max(square, np.finfo(float).tiny))
    return np.array([bare, complex(real, imaginary) / bare])


def _entry(
    linear: Array, weights: ComplexArray, amplitude: Array, variance: Array
) -> tuple[ComplexArray, Array, float]:
    """Bare amplitude and influence coefficient of an entry, with their covariance and χ².

    The covariance is of the amplitude and of both parts of the coefficient.
    """
    sd = np.sqrt(np.maximum(variance, 1e-12 * np.mean(amplitude**2)))  # digits of a file
    start, size = closed_form(linear, amplitude), float(np.max(amplitude))

    def residual(values: Array) -> Array:
        return np.asarray((np.abs(values[0] + complex(values[1], values[2]) * weights) - amplitude / size) * size / sd)

    first = np.array([start[0].real, start[1].real, start[1].imag]) / size
    found = least_squares(residual, first, method="lm", xtol=1e-14, ftol=1e-14)
    bare, coefficient = found.x[0] * size, complex(found.x[1], found.x[2]) * size
    turn = 1.0 if bare >= 0 else -1.0
    jacobian = np.asarray(found.jac, dtype=float)
    solved = turn * np.array([bare, coefficient], dtype=np.complex128)
    return solved, np.linalg.inv(jacobian.T @ jacobian) * size**2, float(2 * found.cost)

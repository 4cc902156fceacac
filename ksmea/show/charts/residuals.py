"""Residuals of the models of a diagnosis, in units of one law of noise, each at the response of its model; and
the two components of a complex residual, as texts, pages and figures name them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.records.diagnosis import CurvesRecord, DiagnosisRecord, Values
from ksmea.records.estimate import NoiseLevelRecord


def residuals(record: DiagnosisRecord) -> dict[str, Array | ComplexArray]:
    """Measured minus modelled (n_speed, n_channel) in units of the noise, 'before' and, with an extended model, 'after'.

    An estimated noise takes up what a model does not explain: in units of its own, a wrong model leaves about as much as a
    right one. Both are therefore in units of the noise that the extended model leaves, s² = (relative · |response|)² + floor²
    at the response of each. A noise that is known has one law already.
    """
    curves = record.curves
    if curves is None:
        return {}
    before, after = as_complex(curves.residuals.before), curves.residuals.after
    if after is None:
        return {"before": before}
    if not record.noise.known and record.noise.after is not None:
        size = np.abs(as_complex(curves.responses.before))
        before = before * (_sd(record.noise.before, size, curves) / _sd(record.noise.after, size, curves))
    return {"before": before, "after": as_complex(after)}


def as_complex(values: Values) -> Array | ComplexArray:
    """Numbers of a record (n_speed, n_channel): complex of pairs, real ones as they are."""
    parts = np.array(values, dtype=float)
    return parts[..., 0] + 1j * parts[..., 1] if parts.ndim == 3 else parts


def _sd(level: NoiseLevelRecord, size: Array, curves: CurvesRecord) -> Array:
    """Standard deviations of responses of this size (n_speed, n_channel), m."""
    found = np.hypot(level.relative * size, level.floor)
    if level.by_run:
        for rows, (_, relative, floor) in zip(_rows(curves), level.by_run):
            found[rows] = np.hypot(relative * size[rows], floor)
    return found


def _rows(curves: CurvesRecord) -> Iterator[slice]:
    """The speeds of each run."""
    starts = [0, *curves.breaks, len(curves.speed)]
    yield from map(slice, starts, starts[1:])


COMPONENTS = ("in phase", "in quadrature")  # with the fitted response


def components(residual: Array | ComplexArray, fitted: Array | ComplexArray) -> tuple[Array, Array]:
    """Components, each of unit variance, of residuals (measured − fitted) in units of the noise, whose variance is 1 in all.

    >>> along, across = components(np.array([1.0j]), np.array([2.0j]))  # longer by the noise's σ, √2 of a component's
    >>> along.round(3).tolist(), across.round(3).tolist()
    ([1.414], [0.0])
    """
    turned = np.sqrt(2) * residual * np.exp(-1j * np.angle(fitted))
    return turned.real, turned.imag

"""Curves of a diagnosis over speed: responses and residuals, before and after what it found."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.diagnosis.diagnosis import Diagnosis
from ksmea.diagnosis.model_averaging import Averaged
from ksmea.fits.fitting import Fit
from ksmea.records.curves import FineCurve
from ksmea.records.diagnosis import CurvesRecord, ResidualsRecord, ResponsesRecord, Values
from ksmea.records.extension import BandRecord
from ksmea.records.record import rounded, series
from ksmea.studies.curves import fine_curve


def diagnosis_curves(found: Diagnosis, *, fine: bool) -> CurvesRecord:
    """The curves of a diagnosis; `fine` adds both models at as many speeds as show their peaks."""
    measurement = found.baseline.measurement
    return CurvesRecord(
        speed=tuple(measurement.speed.tolist()),
        channels=tuple(str(channel) for channel in measurement.channels),
        responses=ResponsesRecord(
            measured=_parts(measurement.values),
            before=_parts(measurement.seen(found.baseline.response())),
            after=None if found.best is None else _parts(measurement.seen(found.best.response())),
        ),
        residuals=ResidualsRecord(
            before=_parts(found.baseline_quality.residuals),
            after=None if found.best_quality is None else _parts(found.best_quality.residuals),
        ),
        breaks=measurement.breaks,
        averaged=None if found.averaged is None else _band(found.averaged),
        fine_before=_fine(found.baseline) if fine else None,
        fine_after=_fine(found.best) if fine and found.best is not None else None,
    )


def _fine(fit: Fit) -> FineCurve | None:
    """Fine curve of a fit; None if only differences between runs count.

    The part common to runs is then known at the measured speeds alone.
    """
    return None if fit.measurement.is_by_differences else fine_curve(fit.case, fit.x)


def _band(averaged: Averaged) -> BandRecord:
    parts = (averaged.amplitude, averaged.amplitude_low, averaged.amplitude_high)
    return BandRecord(*(tuple(map(series, part)) for part in parts))


def _parts(values: Array | ComplexArray) -> Values:
    """Complex values as pairs of real and imaginary parts, real ones as they are, to five digits."""
    if np.iscomplexobj(values):
        return tuple(tuple((rounded(value.real), rounded(value.imag)) for value in row) for row in values)
    return tuple(map(series, values))

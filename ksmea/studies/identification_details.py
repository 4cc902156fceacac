"""Details of an identification for a report on it.

Data in words, fit over speed, tests of the fit, an unmodelled force.

They are added to the record of `ksmea.studies.identify.identified`, in which the fit has no part of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from ksmea.errors import LONGEST_NAME, SettingError, shortened
from ksmea.fits.lack_of_fit import lack_of_fit
from ksmea.plugins.identification import Method, Streams
from ksmea.problem.case import Case
from ksmea.problem.load import FORCE
from ksmea.records.identification import DataDescription, IdentificationRecord
from ksmea.studies.curves import fit_curves
from ksmea.studies.hausman import both_ways, repeats_of
from ksmea.studies.identify import IdentificationOptions, Identified, identified
from ksmea.studies.locate import LocationOptions, location
from ksmea.studies.misreadings import misreadings, slips
from ksmea.studies.remarks import campaign_remarks
from ksmea.studies.stability import stability_of
from ksmea.studies.weights import weights_found

AUTO = "auto"


def detailed_identification(
    case: Case,
    method: Method,
    streams: Streams,
    rng: np.random.Generator,
    options: IdentificationOptions,
    *,
    beside: LocationOptions | None = None,
    remarks: Sequence[str] = (),
) -> IdentificationRecord:
    """Record of an identification (`ksmea.studies.identify.identified`), with details if options set them.

    Details are the data in words with `remarks`, data and fit over speed, and a test of the fit by simulations.

    Args:
        rng: for the simulations of intervals and tests.
        beside: also estimate the unknowns with a force that the model lacks (`location_options`, `ksmea.studies.locate`): they
            hold although the model is wrong.

    Raises:
        SettingError: fewer data than unknowns.
        ArithmeticError: an identified value is not finite.
    """
    found = identified(case, method, streams, options, rng)
    record = found.record
    if options.details:
        kept = found.case.measurement.channels
        if left_out := [str(channel) for channel in case.measurement.channels if channel not in kept]:
            remarks = (*remarks, f"left out, since the model has no response there: {', '.join(left_out)}")
        record = _with_details(found, options.level, remarks, rng)
    if beside is not None:
        record = dataclasses.replace(record, location=location(found.case, rng, options=beside))
    return record


def location_options(unmodelled: str, level: float) -> LocationOptions | None:
    """Sites and kinds of the unmodelled force next to which the unknowns are estimated.

    FORCE at a position (m), all kinds at all sites for `AUTO`, None for an empty text. `level` is the confidence of
    intervals.
    """
    if not unmodelled:
        return None
    if unmodelled == AUTO:
        return LocationOptions(interval_level=level)
    try:
        position = float(unmodelled)
    except ValueError:
        raise SettingError(
            f"unmodelled: expected {AUTO} or the position of a site in m, got {shortened(unmodelled, LONGEST_NAME)!r}"
        ) from None
    return LocationOptions(interval_level=level, positions=[position], kinds=[FORCE])


def _with_details(
    found: Identified, level: float, remarks: Sequence[str], rng: np.random.Generator
) -> IdentificationRecord:
    case, x, noise = found.case, found.record.values, found.noise
    measurement = case.measurement
    tested = None if found.fit is None or not found.can_be_tested else lack_of_fit(found.fit, rng)
    rejected = tested is not None and tested.rejected
    misread = misreadings(case, x, noise, rejected=rejected)
    remarks = (*remarks, *(misread or slips(case, x)))
    return dataclasses.replace(
        found.record,
        lack_of_fit=tested,
        weights=None if found.fit is None else weights_found(found.fit, level),
        both_ways=both_ways(case, x),
        data=_description(case, remarks, testable=found.can_be_tested),
        repeats=repeats_of(measurement),
        fit=fit_curves(case, x, noise),
        stability=stability_of(
            case.problem,
            x,
            None if measurement.is_by_differences else noise,
            measurement.kind,
            noise_known=measurement.noise is not None,
            level=level,
            information=found.information,
        ),
    )


def _description(case: Case, remarks: Sequence[str], *, testable: bool) -> DataDescription:
    measurement = case.measurement
    return DataDescription(
        source=measurement.source,
        kind=measurement.kind,
        n_speed=len(measurement.speed),
        speed_from=float(np.min(measurement.speed)),
        speed_to=float(np.max(measurement.speed)),
        channels=tuple(str(channel) for channel in measurement.channels),
        remarks=(*campaign_remarks(case), *remarks),
        reference=measurement.campaign.reference if measurement.campaign else "",
        too_few_to_test=not testable,
    )

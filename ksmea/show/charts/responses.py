"""Measured and modelled response over speed of any record, as charts use it.

Residuals of both models of a diagnosis are in units of one law of noise.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import cosines
from ksmea.measurement.notation import DETECTIONS, Notation
from ksmea.records.curves import FineCurve, FitCurves, Polar, as_array
from ksmea.records.diagnosis import CurvesRecord, DiagnosisRecord, Values
from ksmea.records.estimate import NoiseLevelRecord
from ksmea.show.readings import PLAIN, speed_unit, vibration_unit

AS_GIVEN, WITH_CAUSE = "as given", "with the cause"  # models of a diagnosis, in words
ACCEPTED = "model"  # the model as given if it is not rejected
LEAST_SHOWN = 1e-6  # of the largest amplitude: where a band on a logarithmic axis ends that reaches to 0
OF_A_PLANE = re.compile(
    r"(?P<harmonic>.*?)(?P<direction>[xy]|[-+.e0-9]+(?=°))°? at (?P<place>.+)"
)  # `ksmea.measurement.channel.Channel` in words
LEAST_ACROSS = (
    0.1  # sine of the angle between two probes from which their motion is drawn as an orbit: noise grows as 1/sine
)


@dataclass(frozen=True)
class ModelCurve:
    """A model's response (n, n_channel) at its own speeds (n,); further runs begin at `breaks`."""

    speed: Array
    values: ComplexArray
    breaks: tuple[int, ...] = ()


@dataclass(frozen=True)
class Response:
    """Data (n_speed, n_channel) over speed (n_speed,); amplitudes alone where `has_phase` is False.

    Speeds and vibrations are in the units of `notation`, µm 0-peak and rpm by default; complex values are always leads.
    Channels have their own names, such as 'x at 0.1 m'; `shown_channels` are the names in the notation.

    By the name of each model it has its curve, its response at the measured speeds, and residuals in units of the noise
    by their part. `breaks` are the starts of the measured speeds of a further run. `sd` is along the amplitude,
    `averaged` are both ends (n_speed, n_channel) of the prediction of averaged models.
    """

    speed: Array
    channels: tuple[str, ...]
    measured: ComplexArray
    has_phase: bool
    sd: Array | None
    curves: Mapping[str, ModelCurve]
    at_speeds: Mapping[str, ComplexArray]
    residuals: Mapping[str, Mapping[str, Array]] = field(default_factory=dict)
    averaged: tuple[Array, Array] | None = None
    breaks: tuple[int, ...] = ()
    notation: Notation = PLAIN

    @property
    def shown_channels(self) -> tuple[str, ...]:
        """The channels by the names that the reader knows: '3X'."""
        return tuple(map(self.notation.name, self.channels))

    def plane_name(self, place: str) -> str:
        """A plane with the names of its two probes, if they have any: '0.1 m (3X, 3Y)'."""
        own = [self.channels[column] for column in self.planes()[place][0]]
        named = [self.notation.names[channel] for channel in own if channel in self.notation.names]
        return f"{place} ({', '.join(named)})" if named else place

    def planes(self) -> dict[str, tuple[tuple[int, int], Array]]:
        """Two columns of each plane with two directions, and the matrix (2, 2) from them to displacements.

        Displacements have no detection: a vibration of 2 mil pp moves the shaft from −1 to 1 mil.
        """
        detection = DETECTIONS[self.notation.detection]
        found: dict[str, dict[str, int]] = {}
        for column, channel in enumerate(self.channels):
            if said := OF_A_PLANE.fullmatch(channel):
                found.setdefault(said["harmonic"] + said["place"], {})[said["direction"]] = column
        pairs = ((place, of, pair) for place, of in found.items() if (pair := _across(sorted(of))) is not None)
        return {
            place: ((of[pair[0]], of[pair[1]]), np.asarray(np.linalg.inv(_read_by(pair)), dtype=float) / detection)
            for place, of, pair in pairs
        }


def _across(directions: Sequence[str]) -> tuple[str, str] | None:
    """The two that are nearest to a right angle; None if all are parallel."""
    pairs = list(combinations(directions, 2))
    best = max(pairs, key=lambda pair: abs(np.linalg.det(_read_by(pair))), default=None)
    return best if best is not None and abs(np.linalg.det(_read_by(best))) > LEAST_ACROSS else None


def _read_by(pair: tuple[str, str]) -> Array:
    """Readings of x and y by each of two probes, (2, 2)."""
    return np.array([cosines(direction) for direction in pair])


def of_fit(fit: FitCurves, name: str = "fitted", notation: Notation = PLAIN) -> Response:
    """The response of an identification in a notation."""
    unit = vibration_unit(notation)
    sd = None if fit.sd is None else as_array(fit.sd) / unit / (np.sqrt(2) if fit.has_phase else 1)
    parts: dict[str, Array] = {}
    if fit.sd is not None:
        of_channels = [residuals_of_fit(fit, column) for column in range(len(fit.channels))]
        names = COMPONENTS if fit.has_phase else ("amplitude",)
        parts = {part: np.stack(columns, axis=1) for part, columns in zip(names, zip(*of_channels))}
    return Response(
        speed=as_array(fit.speed) / speed_unit(notation),
        channels=fit.channels,
        measured=_complex(fit.measured, unit),
        has_phase=fit.has_phase,
        sd=sd,
        curves={name: _curve(fit.fine, notation)},
        at_speeds={name: _complex(fit.fitted, unit)},
        residuals={name: parts} if parts else {},
        notation=notation,
    )


def of_diagnosis(record: DiagnosisRecord, notation: Notation = PLAIN) -> Response | None:
    """Response of a diagnosis in a notation, by the model as given and with the cause, with residuals.

    Residuals are in units of one law of noise (`residuals.py`). None for a record without curves. A model's curve is
    the fine one of the record; for records without it, the one at the measured speeds.
    """
    curves = record.curves
    if curves is None:
        return None
    unit = vibration_unit(notation)
    speed = np.array(curves.speed) / speed_unit(notation)
    measured = as_complex(curves.responses.measured)
    given = AS_GIVEN if record.is_rejected else ACCEPTED
    values = {given: curves.responses.before, WITH_CAUSE: curves.responses.after}
    fine = {given: curves.fine_before, WITH_CAUSE: curves.fine_after}
    names = {"before": given, "after": WITH_CAUSE}
    at_speeds = {name: _with_phase(as_complex(found)) / unit for name, found in values.items() if found is not None}
    coarse = {name: ModelCurve(speed, found, curves.breaks) for name, found in at_speeds.items()}
    drawn = {name: _curve(found, notation) for name, found in fine.items() if found is not None}
    return Response(
        speed=speed,
        channels=curves.channels,
        measured=_with_phase(measured) / unit,
        has_phase=np.iscomplexobj(measured),
        sd=None,
        curves=coarse | drawn,
        at_speeds=at_speeds,
        residuals={names[when]: _parts(found, at_speeds[names[when]]) for when, found in residuals(record).items()},
        averaged=_averaged(curves, unit),
        breaks=curves.breaks,
        notation=notation,
    )


def _curve(fine: FineCurve, notation: Notation) -> ModelCurve:
    values = _complex(fine, vibration_unit(notation))
    return ModelCurve(as_array(fine.speed) / speed_unit(notation), values, fine.breaks)


def _complex(polar: Polar | FineCurve, unit: float) -> ComplexArray:
    """(n, n_channel) in a unit (m)."""
    amplitude = as_array(polar.amplitude) / unit
    phase = np.zeros_like(amplitude) if polar.phase is None else as_array(polar.phase)
    found: ComplexArray = amplitude * np.exp(1j * phase)
    return found


def _with_phase(values: Array | ComplexArray) -> ComplexArray:
    """Amplitudes with a phase of 0, complex values as they are."""
    return np.asarray(values if np.iscomplexobj(values) else np.abs(values), dtype=complex)


def _parts(residuals: Array | ComplexArray, fitted: ComplexArray) -> dict[str, Array]:
    """Residuals in units of the noise, of a complex one its components next to the fitted response."""
    if np.iscomplexobj(residuals):
        return dict(zip(COMPONENTS, components(residuals, fitted)))
    return {"amplitude": residuals.real}


def _averaged(curves: CurvesRecord, unit: float) -> tuple[Array, Array] | None:
    """Where averaged models reach, in a unit (m), to a positive end, as a logarithmic axis shows it."""
    if curves.averaged is None or curves.responses.after is None:
        return None
    least = LEAST_SHOWN * np.max(np.abs(as_complex(curves.responses.measured)))
    low, high = (np.maximum(np.array(end), least) / unit for end in (curves.averaged.low, curves.averaged.high))
    return low, high


def residuals_of_fit(fit: FitCurves, index: int) -> list[Array]:
    """Measured minus fitted in units of the noise, (n_speed,): of amplitudes one.

    Complex data have the components along the fitted response and at right angles to it, whose standard deviations are
    both 1.
    """
    sd, measured, fitted = (as_array(each)[:, index] for each in (fit.sd, fit.measured.amplitude, fit.fitted.amplitude))
    if fit.measured.phase is None or fit.fitted.phase is None:
        return [(measured - fitted) / sd]
    turn = as_array(fit.measured.phase)[:, index] - as_array(fit.fitted.phase)[:, index]
    scaled = np.sqrt(2) * (measured * np.exp(1j * turn) - fitted) / sd
    return [scaled.real, scaled.imag]


def residuals(record: DiagnosisRecord) -> dict[str, Array | ComplexArray]:
    """Measured minus modelled (n_speed, n_channel) in units of the noise, 'before' and 'after'.

    The latter only with an extended model.

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
    """Components, each of unit variance, of residuals in units of the noise.

    Residuals are measured − fitted, with a total variance of 1.

    >>> along, across = components(np.array([1.0j]), np.array([2.0j]))  # longer by the noise's σ, √2 of a component's
    >>> along.round(3).tolist(), across.round(3).tolist()
    ([1.414], [0.0])
    """
    turned = np.sqrt(2) * residual * np.exp(-1j * np.angle(fitted))
    return turned.real, turned.imag

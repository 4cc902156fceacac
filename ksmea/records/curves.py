"""Response curves of a record: numbers over speed and channel, rounded to what a figure can show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.records.record import DRAWN_DIGITS, rounded
from ksmea.units import ANGLE, SPEED, VIBRATION

DIGITS = 8  # a figure of differences needs no more, and records stay small
FINE_DIGITS = 6  # of responses whose difference is drawn
SPEED_DIGITS = DRAWN_DIGITS + 2  # which part those of a sharp peak

Row = tuple[float | None, ...]  # None: not finite
Matrix = tuple[Row, ...]  # (n_speed, n_channel)


@dataclass(frozen=True)
class Polar:
    """Response (n_speed, n_channel) as amplitude (m, 0-peak) and, for complex data, phase lead (rad)."""

    amplitude: Annotated[Matrix, VIBRATION]
    phase: Annotated[Matrix | None, ANGLE] = None

    @classmethod
    def of(cls, values: Array | ComplexArray, *, with_phase: bool) -> Self:
        return cls(matrix(np.abs(values)), matrix(np.angle(values)) if with_phase else None)


@dataclass(frozen=True)
class FineCurve:
    """The fitted response at more speeds (rad/s) than were measured, to be drawn as a line.

    `breaks` are the indices at which the speeds of a further run begin.
    """

    speed: Annotated[Row, SPEED]
    amplitude: Annotated[Matrix, VIBRATION]
    phase: Annotated[Matrix | None, ANGLE] = None
    breaks: tuple[int, ...] = ()

    @classmethod
    def of(cls, speed: Array, response: Array | ComplexArray, breaks: tuple[int, ...], *, with_phase: bool) -> Self:
        """A response (n_speed, n_channel), m, as it is drawn."""
        phase = matrix(np.angle(response), DRAWN_DIGITS) if with_phase else None
        return cls(row(speed, SPEED_DIGITS), matrix(np.abs(response), DRAWN_DIGITS), phase, breaks)


def check_shape(name: str, matrix: Matrix | None, n_row: int, n_column: int) -> None:
    """Raise `SettingError` if a matrix of a record has another shape; one without any number may have any."""
    if matrix is None or not any(value is not None and np.isfinite(value) for line in matrix for value in line):
        return
    if len(matrix) != n_row or any(len(line) != n_column for line in matrix):
        raise SettingError(f"{name}: expected {n_row} rows of {n_column} numbers, got another shape")


@dataclass(frozen=True)
class FitCurves:
    """Data and fitted response over speed (rad/s).

    `sd` (m) is the standard deviation of the noise at the fit, (n_speed, n_channel), None if it is neither known nor
    estimated.
    """

    speed: Annotated[Row, SPEED]
    channels: tuple[str, ...]
    measured: Polar
    fitted: Polar
    sd: Annotated[Matrix | None, VIBRATION]
    fine: FineCurve

    @property
    def has_phase(self) -> bool:
        return self.measured.phase is not None

    def check(self) -> None:
        """Raise `SettingError` if curves are not as long as their speeds, or not of each channel."""
        n_speed, n_channel = len(self.speed), len(self.channels)
        for polar in (self.measured, self.fitted):
            check_shape("fit.amplitude", polar.amplitude, n_speed, n_channel)
            check_shape("fit.phase", polar.phase, n_speed, n_channel)
        check_shape("fit.sd", self.sd, n_speed, n_channel)
        check_shape("fit.fine.amplitude", self.fine.amplitude, len(self.fine.speed), n_channel)
        check_shape("fit.fine.phase", self.fine.phase, len(self.fine.speed), n_channel)
        if not n_speed * n_channel or (self.fitted.phase is None) != (self.measured.phase is None):
            raise SettingError("fit: expected curves of data and fit alike, got none or phases of one alone")


@dataclass(frozen=True)
class FineResponses:
    """Amplitudes (m, 0-peak) of models at common speeds (rad/s), more than were measured.

    Each is (n_speed, n_channel), None for a missing curve. Names and `breaks` are as in `ResponseCurves`."""

    speed: Annotated[Row, SPEED]
    identified: Annotated[Matrix | None, VIBRATION] = None
    modelled: Annotated[Matrix | None, VIBRATION] = None
    true: Annotated[Matrix | None, VIBRATION] = None
    breaks: tuple[int, ...] = ()


@dataclass(frozen=True)
class ResponseCurves:
    """Amplitudes (m, 0-peak) over speed (rad/s), (n_speed, n_channel) each; None for a missing curve.

    They are the measurement, the identified model, the surrogate (`predicted`) and the true model (`modelled`) at the
    surrogate's last optimum, and the response without noise (`true`) if it is known. `breaks` are the indices at which
    the speeds of a further run begin.
    """

    speed: Annotated[Row, SPEED]
    channels: tuple[str, ...]
    measured: Annotated[Matrix | None, VIBRATION] = None
    identified: Annotated[Matrix | None, VIBRATION] = None
    predicted: Annotated[Matrix | None, VIBRATION] = None
    modelled: Annotated[Matrix | None, VIBRATION] = None
    true: Annotated[Matrix | None, VIBRATION] = None
    breaks: tuple[int, ...] = ()
    fine: FineResponses | None = None  # None in older records

    def check(self) -> None:
        """Raise `SettingError` if curves are not as long as their speeds, or not of each channel."""
        for name in ("measured", "identified", "predicted", "modelled", "true"):
            check_shape(f"curves.{name}", getattr(self, name), len(self.speed), len(self.channels))
        if self.fine is not None:
            for name in ("identified", "modelled", "true"):
                check_shape(f"curves.fine.{name}", getattr(self.fine, name), len(self.fine.speed), len(self.channels))


def row(values: Array, digits: int = DIGITS) -> Row:
    """(n,) as a record has it."""
    return tuple(rounded(value, digits) if np.isfinite(value) else None for value in values.tolist())


def matrix(values: Array, digits: int = DIGITS) -> Matrix:
    """(n_speed, n_channel) as a record has it."""
    return tuple(row(line, digits) for line in values)


def as_array(values: Any) -> Array:
    """Numbers of a record as an array; not a number where the record has None.

    >>> as_array(((1.0, None), (2.0, 3.0)))
    array([[ 1., nan],
           [ 2.,  3.]])
    """
    return np.array(values, dtype=float)

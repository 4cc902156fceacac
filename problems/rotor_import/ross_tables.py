"""Coefficients of a bearing element of ROSS, constant or over speed.

What its lists stand over has changed: `w` and `frequency` are the speed of rotation in versions 0 to 2, but of magnetic bearings and squeeze films,
where they are the frequency of whirl; version 3 has `speed`, `frequency` (of whirl), or both, and lists of lists then. A rotor file has tables over the
speed of rotation: those over whirl are taken where whirl is rotation, at 1X, which is exact for unbalance.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator, UnivariateSpline

from ksmea.arrays import Array
from ksmea.errors import described
from problems.rotor.finite_elements.bearing import COEFFICIENTS
from problems.rotor_import.ross_sections import Section

ROUNDING = 1e-12  # of the largest number of its kind: smaller ones are 0
AXES = ("speed", "frequency", "w")
OF_CONTROLLERS = ("g0", "kp_pid")  # keys of magnetic bearings, which are saved as other bearings are
AT_1X = "equal at 1X, not for modes at other frequencies"


@dataclass(frozen=True, eq=False)
class Coefficients:
    """kxx … myy, each (n,) over `speed` or of one number."""

    speed: Array | None  # (n,) rad/s; None: constant
    columns: dict[str, Array]
    remarks: tuple[str, ...] = ()
    gap: tuple[float, str, str] = (
        0.0,
        "",
        "",
    )  # to ROSS's interpolation, of the column's largest number; its name, the column


def coefficients(section: Section, major: int) -> Coefficients:
    """Coefficients of a section; `major` is the version of the file."""
    columns = _without_noise({name: _numbers(section, name) for name in COEFFICIENTS})
    axes = {key: _axis(section, key) for key in AXES if section.values.get(key) not in (None, [])}
    if all(values.size == 1 for values in columns.values()):
        return Coefficients(None, {name: values.ravel() for name, values in columns.items()})
    if not axes:
        raise section.error("frequency", "expected the speeds of its table, got none")
    if any(values.ndim == 2 for values in columns.values()):
        return _at_rotation(section, axes, columns)
    axis = next(key for key in AXES if key in axes)
    remarks = []
    if any(key in section.values for key in OF_CONTROLLERS):
        remarks.append(f"a magnetic bearing, read as its table over frequency; its controller is left out: {AT_1X}")
    elif axis == "frequency" and (major >= 3 or section.path.startswith("SqueezeFilm")):
        remarks.append(f"a table over the frequency of whirl: {AT_1X}")
    speed = axes[axis]
    full = {name: _as_long(section, name, values, len(speed)) for name, values in columns.items()}
    order = np.argsort(speed, kind="stable")
    speed, full = speed[order], {name: values[order] for name, values in full.items()}
    return Coefficients(speed, full, tuple(remarks), _gap(section, major, speed, full))


def _numbers(section: Section, name: str) -> Array:
    """(1,), (n,) or (n_speed, n_frequency)."""
    value = section.values.get(name)
    if value is None:
        return np.zeros(1)
    try:
        found = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError, OverflowError):
        found = np.full(1, np.nan)
    if not found.size or found.ndim > 2 or not np.all(np.isfinite(found)):
        raise section.error(name, f"expected numbers, got {described(value)}")
    return found


def _axis(section: Section, key: str) -> Array:
    found = _numbers(section, key).ravel()
    if np.any(found < 0):
        raise section.error(key, f"expected speeds from 0 on, got {found.min():g}")
    return found


def _without_noise(columns: dict[str, Array]) -> dict[str, Array]:
    """Replace by 0 what is only rounding, relative to the largest number of its kind."""
    largest = {kind: max(np.abs(columns[name]).max() for name in columns if name[0] == kind) for kind in "kcm"}
    return {
        name: np.where(np.abs(values) <= ROUNDING * largest[name[0]], 0.0, values) for name, values in columns.items()
    }


def _as_long(section: Section, name: str, values: Array, n_speed: int) -> Array:
    if values.size == 1:
        return np.full(n_speed, values.ravel()[0])
    if len(values) != n_speed:
        raise section.error(name, f"expected {n_speed} numbers, one for each speed, got {len(values)}")
    return values


def _at_rotation(section: Section, axes: dict[str, Array], columns: dict[str, Array]) -> Coefficients:
    """Tables [speed][frequency] along the line on which both are alike, at all points of both.

    Linear between them.
    """
    missing = [key for key in ("speed", "frequency") if key not in axes]
    if missing:
        raise section.error(missing[0], "expected the points of a table over speed and frequency, got none")
    speed, frequency = axes["speed"], axes["frequency"]
    for key, values in (("speed", speed), ("frequency", frequency)):
        if np.any(np.diff(values) <= 0):
            raise section.error(key, "expected a list that rises, got another one")
    points = np.union1d(speed, frequency)
    points = points[(points >= max(speed[0], frequency[0])) & (points <= min(speed[-1], frequency[-1]))]
    if not points.size:
        raise section.error("frequency", "expected a table that reaches the speeds, got frequencies apart from them")
    found = {}
    for name, values in columns.items():
        if values.ndim < 2:
            found[name] = _as_long(section, name, values, 1).repeat(len(points))
        elif values.shape != (len(speed), len(frequency)):
            shape = " × ".join(map(str, values.shape))
            raise section.error(name, f"expected {len(speed)} × {len(frequency)} numbers, got {shape}")
        else:
            found[name] = _on_diagonal(speed, frequency, values, points)
    return Coefficients(
        points, found, (f"a table over speed and frequency of whirl, taken where both are alike: {AT_1X}",)
    )


def _on_diagonal(speed: Array, frequency: Array, values: Array, points: Array) -> Array:
    if len(speed) == 1 or len(frequency) == 1:
        along = frequency if len(speed) == 1 else speed
        return np.interp(points, along, values.ravel())
    return np.asarray(RegularGridInterpolator((speed, frequency), values)(np.stack([points, points], axis=1)))


def _gap(section: Section, major: int, speed: Array, columns: dict[str, Array]) -> tuple[float, str, str]:
    """How far PCHIP is from ROSS's own curve at the points and half-way between them.

    Versions before 3 smooth: their cubic spline may miss the points by Σ r² ≤ number of points, in N/m, N s/m and kg.
    """
    how = str(section.values.get("interpolation", "pchip")) if major >= 3 else "a smoothing cubic spline"
    if how == "pchip" or len(speed) < 3 or np.any(np.diff(speed) <= 0):
        return 0.0, "", ""
    points = np.sort(np.concatenate([speed, (speed[1:] + speed[:-1]) / 2]))
    found = [(0.0, "", "")]
    for name, values in columns.items():
        if np.any(values):
            of_ross = _smoothed(speed, values, points) if major < 3 else np.interp(points, speed, values)
            distance = np.abs(PchipInterpolator(speed, values)(points) - of_ross).max()
            found.append((float(distance / np.abs(values).max()), "straight lines" if major >= 3 else how, name))
    return max(found)


def _smoothed(speed: Array, values: Array, points: Array) -> Array:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a spline that stops before it is smooth enough, which ROSS takes as it is
        return np.asarray(UnivariateSpline(speed, values, k=3 if len(speed) > 3 else 2)(points))

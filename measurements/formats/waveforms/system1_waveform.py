"""Waveform exports of Bently Nevada System 1.

Samples of whole turns that begin at the keyphasor, which is not in the file.

    Point Name,1XD TURBINE DE
    X-Axis Unit,ms
    Y-Axis Unit,µm
    Sample Speed, 14049 rpm
    Variable,Disp Wf(128X/16revs).KPH TURBINE
    X-Axis Value,Y-Axis Value
    0.000,19.477

`128X/16revs` is 128 samples a turn, 16 turns: sample n is at the angle 2π n/128 from the mark, whatever the times say. The vector of
each turn is the discrete Fourier transform, q_h = 2/N Σ x e^{-ihθ}, zero to peak, a lead; an export gives the mean of its
turns. Points that were sampled at the same time have one speed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError, shortened
from ksmea.units import TURN
from measurements.formats.curve import Curve
from measurements.formats.timestamps import seconds
from measurements.formats.unit_texts import amplitude_unit
from measurements.formats.waveforms.steady import mean_of_windows

SYNCHRONOUS = re.compile(r"\(\s*([0-9]+)\s*X\s*/\s*([0-9]+)\s*revs?\s*\)", re.IGNORECASE | re.ASCII)
WAVEFORM = re.compile(r"\bWf\b|waveform", re.IGNORECASE)
SAMPLE_SPEED = re.compile(r"([0-9]+(?:[.,][0-9]+)?)\s*(\S*)", re.ASCII)
SAME_SPEED = 0.005  # relative, of points that were sampled together
IMPLICIT = "phases count from the first sample, at which the keyphasor triggered; the export does not say at which edge"


@dataclass(frozen=True)
class Export:
    """One waveform of a file: the first lines by name, and its samples."""

    named: Mapping[str, str]
    line: int
    samples: Array


@dataclass(frozen=True)
class _Vector:
    """Record of one point: vectors at each harmonic, standard errors and speed.

    The speed is in the file's unit.
    """

    export: Export
    values: ComplexArray
    sigma: Array | None
    speed: float
    speed_unit: str


def is_waveform(variable: str) -> bool:
    return WAVEFORM.search(variable) is not None


def waveform_curves(exports: Sequence[Export], harmonics: Sequence[float], path: str) -> list[Curve]:
    """The vectors of each point, a row for each of its exports."""
    vectors = _at_common_speeds([_vector(each, harmonics, path) for each in exports])
    by_point: dict[str, list[_Vector]] = {}
    for each in vectors:
        by_point.setdefault(each.export.named.get("point name", ""), []).append(each)
    has_sigma = all(each.sigma is not None for each in vectors)
    return [
        _curve(name, of_point, number, harmonic, has_sigma=has_sigma)
        for name, of_point in by_point.items()
        for number, harmonic in enumerate(harmonics)
    ]


def _curve(name: str, rows: Sequence[_Vector], number: int, harmonic: float, *, has_sigma: bool) -> Curve:
    named = rows[0].export.named
    unit = amplitude_unit(named.get("y-axis unit", ""))
    values = np.array([each.values[number] for each in rows])
    return Curve(
        name,
        "",
        [each.export.line for each in rows],
        np.array([each.speed for each in rows]),
        np.abs(values),
        phase=np.angle(values, deg=True),
        sigma=np.array([each.sigma[number] for each in rows if each.sigma is not None]) if has_sigma else None,
        time=seconds([each.export.named.get("timestamp", "") for each in rows]) if len(rows) > 1 else None,
        speed_unit=rows[0].speed_unit or "rpm",
        unit=f"{named.get('y-axis unit', '') if unit is None else unit.unit} 0pk",  # of samples, whatever detector it has
        sense="lead",
        angle=named.get("probe angle", ""),
        harmonic=harmonic,
        notes=(IMPLICIT,),
    )


def _vector(export: Export, harmonics: Sequence[float], path: str) -> _Vector:
    where = f"{path} line {export.line}"
    variable = export.named.get("variable", "")
    found = SYNCHRONOUS.search(variable)
    if found is None:
        raise SettingError(
            f"{where}: expected a synchronous waveform such as Disp Wf(128X/16revs), got {shortened(repr(variable))}, which says nothing"
            " of the keyphasor; export synchronous waveforms or a Bode plot"
        )
    a_turn, turns = int(found[1]), int(found[2])
    if a_turn < 4 or turns < 1 or len(export.samples) < a_turn * turns or len(export.samples) > a_turn * turns + 1:
        raise SettingError(
            f"{where}: expected {a_turn} × {turns} samples, which Variable says, got {len(export.samples)}; export it again"
        )
    for harmonic in harmonics:
        if abs(harmonic * turns - round(harmonic * turns)) > 1e-9 or 2 * harmonic >= a_turn:
            raise SettingError(
                f"{where}: expected harmonics of whole periods in {turns} turns and below {a_turn / 2:g}X, got {harmonic:g}X;"
                " leave it out"
            )
    # as few turns as hold whole periods of all harmonics
    window = next(n for n in range(1, turns + 1) if all(abs(h * n - round(h * n)) < 1e-9 for h in harmonics))
    samples = export.samples[: turns // window * window * a_turn].reshape(-1, window * a_turn)
    angle = TURN * np.arange(window * a_turn) / a_turn
    values = 2 / samples.shape[1] * samples @ np.exp(-1j * np.outer(angle, harmonics))
    mean, sigma = mean_of_windows(values)
    speed, unit = _speed(export.named, where)
    return _Vector(export, mean, sigma, speed, unit)


def _speed(named: Mapping[str, str], where: str) -> tuple[float, str]:
    text = next((named[key] for key in ("sample speed", "speed") if key in named), "")
    found = SAMPLE_SPEED.fullmatch(text.strip())
    if found is None:
        raise SettingError(
            f"{where}: expected Sample Speed above the waveform, such as 1500 rpm, got {shortened(repr(text))}"
        )
    return float(found[1].replace(",", ".")), found[2]


def _at_common_speeds(vectors: Sequence[_Vector]) -> list[_Vector]:
    """Vectors at common speeds.

    Points that were sampled together get the mean of their speeds, which differ in their last digits.
    """
    together: dict[str, list[float]] = {}
    for each in vectors:
        together.setdefault(each.export.named.get("timestamp", ""), []).append(each.speed)
    found = []
    for each in vectors:
        speeds = together[each.export.named.get("timestamp", "")]
        is_one = max(speeds) - min(speeds) <= SAME_SPEED * max(speeds)
        speed = float(np.mean(speeds)) if is_one else each.speed
        found.append(_Vector(each.export, each.values, each.sigma, speed, each.speed_unit))
    return found

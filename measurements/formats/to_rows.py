"""Curves of a file as rows of a measurement: µm zero to peak, degrees of lead, rpm.

Every decision in words.

Velocity and acceleration become displacement by q = v / (i h Ω) and q = a / (i h Ω)² at the harmonic h.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, shortened, unknown, visible
from ksmea.measurement.channel import Channel
from ksmea.measurement.notation import LAG, LEAD, Notation
from ksmea.units import MICROMETRE, RPM
from measurements.formats.curve import Curve
from measurements.formats.probe_positions import Place, model_direction, places
from measurements.formats.questions import OpenQuestion
from measurements.formats.unit_texts import (
    SCALED,
    SPEED_UNITS,
    UNITS,
    ZERO_TO_PEAK,
    AmplitudeUnit,
    amplitude_unit,
    detector_of,
    speed_unit,
)
from measurements.formats.user_answers import Answers
from measurements.run_up_rows import LARGEST, MAX_ROWS, Rows

ZERO_PEAK = "0pk"
RIGHT_ANGLE = 90.0  # degrees: i leads by as much
LONGEST_LIST = 300  # characters of the names that an error lists


@dataclass(frozen=True)
class Decided:
    """One channel in the units of a measurement, and how it came to be them, in words."""

    channel: Channel
    curve: Curve
    speed: Array  # rpm
    amplitude: Array  # µm zero to peak
    phase: Array | None  # degrees of lead
    sigma: Array | None  # µm
    remark: str
    notation: Notation  # without its name


def decided(curves: Sequence[Curve], answers: Answers) -> tuple[Rows, tuple[str, ...], Notation]:
    """Rows of a file in the order of time, remarks on them, and units and names of the file.

    Raises `SettingError` if a question is left open.
    """
    chosen, others = _chosen(curves, answers)
    channels = [_decided(curve, place, answers) for curve, place in chosen]
    _require_all_or_none(channels, answers)
    for number, one in enumerate(channels):
        for other in channels[:number]:
            if one.channel == other.channel:
                raise SettingError(
                    f"{answers.path}: expected each channel once, got {one.channel} from {shortened(other.curve.name)} and"
                    f" {shortened(one.curve.name)}; leave one out of probes"
                )
    remarks = [each.remark for each in channels]
    if others:
        remarks.append(f"not used, as probes does not name them: {_listed(others)}")
    return _rows(channels, answers.path), tuple(remarks), _notation(channels)


def _chosen(curves: Sequence[Curve], answers: Answers) -> tuple[list[tuple[Curve, Place | None]], list[str]]:
    """The curves that are read with where they look (None: the file says it), and the names of the others."""
    named = places(answers.probes)
    names = list(dict.fromkeys(curve.name for curve in curves))
    if "" in named and len(names) == 1:  # the only probe needs no name
        named = {names[0]: named[""]}
    for name in named:
        if name not in names:
            raise SettingError(f"{answers.path}: {unknown('probe in probes:', name, names)}")
    at_harmonics = [curve for curve in curves if curve.harmonic in answers.harmonics]
    for harmonic in answers.harmonics:
        if all(curve.harmonic != harmonic for curve in curves):
            raise SettingError(
                f"{answers.path}: expected {harmonic:g}X, which harmonics names, got {_harmonics(curves)}; leave it out"
            )
    if named:
        return [(each, named[each.name]) for each in at_harmonics if each.name in named], [
            name for name in names if name not in named
        ]
    if any(curve.position is None for curve in at_harmonics):
        looks = {curve.name: curve.direction or curve.angle for curve in at_harmonics}
        raise OpenQuestion(
            f"{answers.path}: expected where each probe looks, got nothing; give probes=[name@m@direction,…] for"
            f" {_listed(names) if any(names) else 'the only one, without its name'}",
            "probes",
            tuple(f"{name}@M" + ("" if looks.get(name) else "@DIRECTION") for name in names),
            [f"{name}@{number}" + ("" if looks.get(name) else "@x") for number, name in enumerate(names)],
        )
    return [(curve, None) for curve in at_harmonics], []


def _decided(curve: Curve, place: Place | None, answers: Answers) -> Decided:
    where = f"{answers.path} {curve.where}".strip()
    stated = place.direction if place and place.direction else curve.direction or curve.angle
    if not stated:
        _ask_directions(answers, curve, where)
    direction = model_direction(stated, answers.rotation, f"{where} {shortened(curve.name)}".strip())
    position = place.position if place else curve.position
    assert position is not None  # `_chosen` refuses others
    channel = Channel(position, direction, curve.harmonic)
    name, unit, detector = _unit(curve, answers, where)
    of_speed = _speed_unit(curve, answers, where)
    sense = _sense(curve, answers, where)
    curve = curve.rows(np.isfinite(curve.speed) & (curve.speed != 0), "without a speed")
    curve = curve.rows(np.isfinite(curve.amplitude) & (curve.amplitude != 0), "without an amplitude")
    if curve.phase is not None and sense != "none":
        curve = curve.rows(np.isfinite(curve.phase), "without a phase")
    if not curve.line:
        raise SettingError(f"{where}: expected valid rows of {shortened(curve.name)}, got none{_reasons(curve)}")
    _require_in_time(curve, where)
    speed = curve.speed * (SPEED_UNITS[of_speed] / RPM)
    size, order = UNITS[unit]
    rate = (curve.harmonic * speed * RPM) ** order
    with np.errstate(over="ignore", divide="ignore"):
        factor = (answers.scale or 1.0) * size * ZERO_TO_PEAK[detector] / rate / MICROMETRE
    phase = None
    if curve.phase is not None and sense != "none":
        phase = (-1.0 if sense == "lag" else 1.0) * curve.phase - order * RIGHT_ANGLE
    _require_plausible(curve, where, "speed_rpm", speed, above_zero=True)
    _require_plausible(curve, where, "amplitude_um_0pk", curve.amplitude * factor, above_zero=True)
    if phase is not None:
        _require_plausible(curve, where, "phase_lead_deg", phase)
    sigma = None if curve.sigma is None else curve.sigma * factor
    if sigma is not None:
        _require_plausible(curve, where, "sigma_um", sigma, above_zero=True)
    shown = f"phase {sense}" if phase is not None else "no phase"
    remark = (
        f"{shortened(curve.name or 'probe')}: {channel}, from {name}, {shown}, speed in {of_speed}{_reasons(curve)}"
    )
    return Decided(
        channel,
        curve,
        speed,
        curve.amplitude * factor,
        phase,
        sigma,
        visible(remark),
        _units(unit, detector, sense, of_speed),
    )


def _units(unit: str, detector: str, sense: str, of_speed: str) -> Notation:
    """Units of a file; velocities, accelerations and volts take the units of their displacement."""
    words = f"{unit}_{detector}" if UNITS[unit][1] == 0 else f"um_{ZERO_PEAK}"
    return Notation().with_words(",".join([words, LAG if sense == LAG else LEAD, of_speed]))


def _notation(channels: Sequence[Decided]) -> Notation:
    """The units of the first channel, with the names of all that have one of their own."""
    names = {str(each.channel): visible(each.curve.name) for each in channels if each.curve.name}
    is_unique = len(set(names.values())) == len(names)
    return replace(channels[0].notation, names=names if is_unique else {})


def _ask_directions(answers: Answers, curve: Curve, where: str) -> NoReturn:
    """Ask for the directions of all probes named without one, if the file does not state them."""
    named = places(answers.probes)
    lacking = {text: not each.direction for text, each in zip(answers.probes, named.values())}
    raise OpenQuestion(
        f"{where} {shortened(curve.name)}: expected the direction in which it looks, x, y, H, V, degrees from x towards y, or 45R or 45L"
        " from the vertical, got none; give it in probes=[name@m@direction]",
        "probes",
        tuple(text + "@DIRECTION" * is_lacking for text, is_lacking in lacking.items()),
        [f"{text}@{number}" if is_lacking else text for number, (text, is_lacking) in enumerate(lacking.items())],
    )


def _unit(curve: Curve, answers: Answers, where: str) -> tuple[str, str, str]:
    """Name, unit and detector of an amplitude, by the file or else by the settings."""
    said = amplitude_unit(curve.unit)
    if answers.scale is not None:  # what the file measures in is what the scale begins at; its detector stays
        said = AmplitudeUnit("", detector_of(curve.unit))
    if said is None:
        raise SettingError(
            f"{where}: expected a displacement, velocity or acceleration in {', '.join(UNITS)}, got {shortened(repr(curve.unit))};"
            f" leave this probe out of probes, or {SCALED}"
        )
    unit = _either("unit", said.unit, answers.unit, where, "mil or another of its choices", "UNIT", "um")
    detector = _either(
        "amplitude", said.detector, answers.amplitude, where, "pp, 0pk or rms", "PP_0PK_OR_RMS", ZERO_PEAK
    )
    scaled = f"{answers.scale:g} " if answers.scale is not None else ""
    return f"{scaled}{unit} {detector}", unit, detector


def _speed_unit(curve: Curve, answers: Answers, where: str) -> str:
    said = speed_unit(curve.speed_unit)
    if curve.speed_unit and not said:
        raise SettingError(f"{where}: expected a speed in rpm, Hz or rad/s, got {shortened(repr(curve.speed_unit))}")
    return _either("speed_unit", said, answers.speed_unit, where, "rpm, Hz or rad/s", "RPM_HZ_OR_RAD/S", "rpm")


def _sense(curve: Curve, answers: Answers, where: str) -> str:
    """lag, lead or none. What an instrument shows is a convention, so that the setting comes first."""
    if curve.phase is None:
        if answers.phase not in (None, "none"):
            raise SettingError(
                f"{where}: expected phases, which phase={answers.phase} speaks of, got none; leave it out"
            )
        return "none"
    if curve.stated_sense:
        if answers.phase not in (None, "none", curve.stated_sense):
            raise SettingError(
                f"{where}: expected phase={curve.stated_sense}, which the heading of {shortened(curve.name or 'the phase')} says, got"
                f" {answers.phase}; leave it out, or correct the heading"
            )
        return answers.phase or curve.stated_sense
    if not answers.phase and not curve.sense:
        raise OpenQuestion(
            f"{where}: expected lags or leads as phases, got phases without a sign; give phase=lag, lead or none",
            "phase",
            ("LAG_LEAD_OR_NONE",),
            "lead",
        )
    return answers.phase or curve.sense


def _either(setting: str, said: str, given: str | None, where: str, choices: str, shown: str, meanwhile: str) -> str:
    if said and given and said != given:
        raise SettingError(f"{where}: expected {setting}={said}, which the file says, got {given}; leave it out")
    if not said and not given:
        message = f"{where}: the file does not say what {setting} it has; give {setting}={choices}"
        raise OpenQuestion(message, setting, (shown,), meanwhile)
    return said or given or ""


def _require_plausible(curve: Curve, where: str, name: str, values: Array, *, above_zero: bool = False) -> None:
    bad = ~np.isfinite(values) | (np.abs(values) > LARGEST[name]) | (above_zero & (values <= 0))
    if np.any(bad):
        first = int(np.flatnonzero(bad)[0])
        raise SettingError(
            f"{where} line {curve.line[first]}: expected {name}{' above 0 and' * above_zero} of at most {LARGEST[name]:g}, got"
            f" {values[first]:g}; check its unit, or remove the row"
        )


def _require_in_time(curve: Curve, where: str) -> None:
    if curve.time is not None and np.any(back := np.diff(curve.time) < 0):
        first = int(np.flatnonzero(back)[0]) + 1
        raise SettingError(
            f"{where} line {curve.line[first]}: expected rows in the order of time, got one that is"
            f" {curve.time[first - 1] - curve.time[first]:g} s before the last; sort them, or leave the times out"
        )


def _require_all_or_none(channels: Sequence[Decided], answers: Answers) -> None:
    for what, name in (("phases", "phase"), ("standard deviations", "sigma")):
        having = [each for each in channels if getattr(each, name) is not None]
        if having and len(having) < len(channels):
            lacking = next(each for each in channels if getattr(each, name) is None)
            cure = "give phase=none to use amplitudes alone" if name == "phase" else "leave them out"
            raise SettingError(
                f"{answers.path}: expected {what} of all probes or of none, got none of {shortened(lacking.curve.name)}; {cure}"
            )
    if any(not each.channel.is_1x for each in channels) and not any(each.channel.is_1x for each in channels):
        raise SettingError(f"{answers.path}: expected 1X with the other harmonics, got none; add it")


def _rows(channels: Sequence[Decided], path: str) -> Rows:
    """Rows of all channels, in the order of time if it is known.

    Otherwise the n-th rows of all channels stand together.
    """
    n_row = sum(len(each.curve.line) for each in channels)
    if n_row > MAX_ROWS:
        raise SettingError(f"{path}: expected at most {MAX_ROWS} rows (speeds × channels), got {n_row}; thin them out")
    has_time = all(each.curve.time is not None for each in channels)
    keys = [
        (float(each.curve.time[index]) if has_time and each.curve.time is not None else 0.0, index, number)
        for number, each in enumerate(channels)
        for index in range(len(each.curve.line))
    ]
    order = sorted(keys)

    def column(values: Sequence[Array | None]) -> list[float] | None:
        if any(part is None for part in values):
            return None
        return [float(part[index]) for _, index, number in order if (part := values[number]) is not None]

    return Rows(
        [channels[number].curve.line[index] for _, index, number in order],
        column([each.speed for each in channels]) or [],
        [_cells(channels[number].channel) for _, _, number in order],
        column([each.amplitude for each in channels]) or [],
        column([each.phase for each in channels]),
        column([each.sigma for each in channels]),
        column([each.curve.time for each in channels]),
        None,
    )


def _cells(channel: Channel) -> tuple[float, str, float]:
    return channel.position, channel.direction, channel.harmonic


def _reasons(curve: Curve) -> str:
    parts: Mapping[str, int] = curve.left_out
    reasons = ", ".join(f"{count} {reason}" for reason, count in parts.items() if count)
    return f"; rows left out: {reasons}" if reasons else ""


def _harmonics(curves: Iterable[Curve]) -> str:
    return ", ".join(f"{each:g}X" for each in sorted({curve.harmonic for curve in curves})) or "nothing"


def _listed(names: Iterable[str]) -> str:
    return shortened(", ".join(repr(name) for name in names), LONGEST_LIST)

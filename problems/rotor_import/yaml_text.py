"""The text of a rotor file, in SI but for GPa and rpm, of an imported rotor.

It draws at once, and says what it takes to compare it with data.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ksmea.errors import visible
from ksmea.units import GIGAPASCAL, GRAM_MILLIMETRE, RPM
from problems.rotor_import.model import NAME, Entry, ImportedRotor, mass_of

UNITS = (
    "{length: m, modulus: GPa, density: kg/m3, mass: kg, inertia: kg m2, stiffness: N/m, damping: N s/m, force: N,\n"
    "        angular_stiffness: N m/rad, angular_damping: N m s/rad, unbalance: g mm, angle: deg, speed: rpm}"
)
WIDTH = 120
DIGITS = 15  # which a float keeps
FACTOR = (0.2, 5.0)  # limits of a factor on a table, or of a coefficient over that of the model
G40 = 0.040  # m/s, ISO 21940-11: e Ω of coarse balance; limits of an unbalance are ten times that at the highest speed
SPEEDS, N_SPEED = (100.0, 10_000.0), 100  # rpm, where the model has no range of its own


@dataclass(frozen=True)
class Wanted:
    """Additions that no model has.

    Positions (m) of unbalance, probes (position, direction) and speeds (from, to in rpm, number).
    """

    unbalance: Sequence[float] = ()
    probes: Sequence[tuple[float, str]] = ()
    speeds: tuple[float, float, int] | None = None


def rotor_yaml(rotor: ImportedRotor, wanted: Wanted) -> str:
    """The file as text."""
    return "\n".join(_lines(rotor, wanted)) + "\n"


def _lines(rotor: ImportedRotor, wanted: Wanted) -> Iterator[str]:
    yield f"# Imported from {visible(rotor.source)}. Keys: docs/own_rotor.md"
    yield from (f"# {visible(remark)}" for remark in rotor.remarks)
    yield from (f"# left out: {visible(each)}" for each in rotor.left_out)
    low, high, number = _speeds(rotor, wanted)
    yield f"units: {UNITS}"
    yield "materials:"
    yield from (f"  {_text(name)}: {_flow(_in_units(values))}" for name, values in rotor.materials.items())
    if rotor.rotation:
        yield f"rotation: {rotor.rotation}"
    for key in ("shaft", "disks", "masses", "bearings", "seals", "couplings"):
        entries = getattr(rotor, key)
        if entries or key == "bearings":
            yield f"{key}:" if entries else f"{key}: []"
        for entry in entries:
            yield from _entry(_in_units(_with_unknowns_left_out(entry, key, wanted)))
    yield f"speeds: {{from: {_number(low)}, to: {_number(high)}, number: {number}}}"
    yield from _asked(rotor, wanted, high * RPM)


def _speeds(rotor: ImportedRotor, wanted: Wanted) -> tuple[float, float, int]:
    if wanted.speeds is not None:
        return wanted.speeds
    low, high = SPEEDS if rotor.speeds is None else [in_unit(each, RPM) for each in rotor.speeds]
    return low, high, N_SPEED


def _with_unknowns_left_out(entry: Entry, key: str, wanted: Wanted) -> Entry:
    """Numbers that an unknown sets stand there, as its reference."""
    if key != "bearings" or not wanted.unbalance or "table" in entry:
        return entry
    return {name: value for name, value in entry.items() if name not in _unknown_coefficients(entry)}


def _unknown_coefficients(entry: Entry) -> list[str]:
    return [name for name in ("kxx", "kyy", "cxx", "cyy") if entry.get(name, 0.0) > 0]


def _asked(rotor: ImportedRotor, wanted: Wanted, highest: float) -> Iterator[str]:
    """Unbalance, probes and unknowns: as requested, or as lines to be changed and uncommented."""
    length = sum(entry["length"] for entry in rotor.shaft)
    yield ""
    mark = "" if wanted.unbalance else "# "
    if not wanted.unbalance:
        yield "# To compare it with data, uncomment and change:"
    planes = wanted.unbalance or [_heaviest(rotor, length)]
    yield f"{mark}unbalance:"
    for number, position in enumerate(planes):
        yield f"{mark}  - {{position: {_number(position)}{', phase: 0' if number == 0 else ''}}}"
    if not wanted.probes:
        yield "# A measurement brings its probes; for synthetic data and plans:"
    mark_of_probes = "" if wanted.probes else "# "
    probes = wanted.probes or [(each["position"], axis) for each in rotor.bearings[:2] for axis in "xy"]
    yield f"{mark_of_probes}probes:"
    yield from (f"{mark_of_probes}  - {{position: {_number(place)}, direction: {axis}}}" for place, axis in probes)
    if not wanted.unbalance and any("table" not in entry for entry in rotor.bearings):
        yield "# An unknown takes the place of the number in the bearing: remove that, or give --unbalance to the import."
    yield f"{mark}unknowns:"
    yield from (f"{mark}  - {_flow(each)}" for each in _unknowns(rotor, planes, highest))


def _heaviest(rotor: ImportedRotor, length: float) -> float:
    heaviest = max(rotor.disks, key=lambda each: each["mass"], default=None)
    return length / 2 if heaviest is None else float(heaviest["position"])


def _unknowns(rotor: ImportedRotor, planes: Sequence[float], highest: float) -> Iterator[Entry]:
    """The unbalance, and of each bearing its direct coefficients or factors on its table.

    The model's own values are references.
    """
    for number in range(1, len(planes) + 1):
        most = 10 * G40 / highest * mass_of(rotor) / GRAM_MILLIMETRE
        yield {"name": f"u{number}", "lower": 0, "upper": _rounded(most), "sets": [f"unbalance {number} magnitude"]}
        if number > 1:
            yield {"name": f"phase{number}", "lower": -270, "upper": 270, "sets": [f"unbalance {number} phase"]}
    for number, entry in enumerate(rotor.bearings, start=1):
        if "table" in entry:
            for part in ("stiffness", "damping"):
                sets = [f"bearing {number} {part} factor"]
                yield {"name": f"{part}{number}", "lower": FACTOR[0], "upper": FACTOR[1], "reference": 1, "sets": sets}
            continue
        for name in _unknown_coefficients(entry):
            limits = {"lower": entry[name] * FACTOR[0], "upper": entry[name] * FACTOR[1], "reference": entry[name]}
            yield {"name": f"{name}{number}", **limits, "sets": [f"bearing {number} {name}"]}


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")


def _in_units(entry: Entry) -> Entry:
    """With moduli in GPa, and speeds of tables in rpm."""
    found = dict(entry)
    for key, value in entry.items():
        if isinstance(value, dict):
            found[key] = _in_units(value)
        elif key in ("speed", "frequency"):
            found[key] = [in_unit(each, RPM) for each in value]
        elif key == "young_modulus":
            found[key] = in_unit(value, GIGAPASCAL)
    return found


def _entry(entry: Entry) -> Iterator[str]:
    """A mapping in one line, or key by key where it is long, with the model's name of it as a remark."""
    own = {key: value for key, value in entry.items() if key != NAME}
    remark = f"  # {visible(str(entry[NAME]))}" if entry.get(NAME) else ""
    line = f"  - {_flow(own)}"
    if len(line) <= WIDTH:
        yield line + remark
        return
    start = "  - "
    for key, value in own.items():
        if isinstance(value, dict) and len(_flow(value)) > WIDTH:
            yield f"{start}{key}:"
            yield from (f"      {name}: {_flow(inner)}" for name, inner in value.items())
        else:
            yield f"{start}{key}: {_flow(value)}{remark}"
        start, remark = "    ", ""


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return _number(value) if isinstance(value, (int, float)) else _text(value)


def in_unit(value: float, si: float) -> float:
    """A number in SI in a unit of the file, without the rounding of the division."""
    return float(f"{value / si:.{DIGITS}g}")


def _number(value: float) -> str:
    """The shortest text that is read as the same number."""
    is_plain = value == 0 or 1e-4 <= abs(value) < 1e15
    return np.format_float_positional(value, trim="-") if is_plain else repr(float(value))


def _text(value: str) -> str:
    plain = value.replace("_", "").replace(" ", "").replace("-", "")
    if plain.isalnum() and value[:1].isalpha() and value.lower() not in ("true", "false", "null"):
        return value
    return '"' + visible(value).replace("\\", "\\\\").replace('"', '\\"') + '"'

"""Turn coefficients of another program once into the axes of a rotor file.

x and y lateral, y up where gravity matters.

`load` is the frame of journal bearing theory, with x along the load (down) and y a quarter turn from it in the sense in which x turns to y
(Lund). There q = R q' with R a quarter turn, and K = Rᵀ K' R = [[k'yy, −k'yx], [−k'xy, k'xx]]; C, M and dynamic stiffnesses likewise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from problems.rotor.finite_elements.bearing import COEFFICIENTS
from problems.rotor_import.model import Entry, ImportedRotor

XY, LOAD = "xy", "load"
AXES = (XY, LOAD)
OWN = {
    "xx": ("yy", 1),
    "xy": ("yx", -1),
    "yx": ("xy", -1),
    "yy": ("xx", 1),
}  # own entry by the other frame's, with its sign
RANK = {name: place for place, name in enumerate((*COEFFICIENTS, "table", "support"))}  # of keys in an entry
PAIRS = ("stiffness", "angular_stiffness", "damping", "angular_damping")  # of a coupling, [x, y]


def in_own_axes(rotor: ImportedRotor, axes: str) -> ImportedRotor:
    """The rotor in the axes of a rotor file; its coefficients are given in `axes`."""
    if axes == XY:
        return rotor
    parts: dict[str, Any] = {key: [_turned(each) for each in getattr(rotor, key)] for key in ("bearings", "seals")}
    parts["shaft"] = [_with_turned_coupling(each) for each in rotor.shaft]
    said = "coefficients were given with x along the load (down); they are turned a quarter turn"
    return replace(rotor, **parts, remarks=[said, *rotor.remarks])


def _turned(entry: Entry) -> Entry:
    """Entries of matrices, whose keys end in xx, xy, yx or yy; mappings inside too."""
    found: Entry = {}
    for key, value in entry.items():
        if isinstance(value, dict):
            found[key] = _turned(value)
        elif key[-2:] in OWN:
            other, sign = OWN[key[-2:]]
            found[key[:-2] + other] = value if sign > 0 else _negative(value)
        else:
            found[key] = value
    return dict(sorted(found.items(), key=lambda item: RANK.get(item[0], -1)))


def _negative(value: float | list[float]) -> float | list[float]:
    return [-each for each in value] if isinstance(value, list) else -value


def _with_turned_coupling(entry: Entry) -> Entry:
    if "coupling" not in entry:
        return entry
    own = {key: value[::-1] if key in PAIRS else value for key, value in entry["coupling"].items()}
    return {**entry, "coupling": own}

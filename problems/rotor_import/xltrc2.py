"""Sheets of XLTRC2, as far as other programs read them, made into the plain layout.

One row of headings with units, then numbers.

In such a sheet names stand in a row somewhere below titles, units in the row above them or below, and numbers under that as long as the column by
which the sheet is known has any. Shaft and materials share a sheet. Stations and elements are counted from 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ksmea.errors import SettingError, described
from ksmea.units import SI_PER_UNIT
from problems.rotor.finite_elements.bearing import COEFFICIENTS

BEARING = "kxx"
NAMES = {  # the project's own by XLTRC2's, for each sheet by a column that it is known by; a plain table has a unit beside kxx
    "od_left": {
        "elemnum": "element", "elem": "element", "elemlayer": "layer", "layer": "layer", "length": "length",
        "od_left": "outer_diameter_left", "od_right": "outer_diameter_right",
        "id_left": "inner_diameter_left", "id_right": "inner_diameter_right", "matnum": "material",
        "shear": "shear", "shear_effects": "shear", "axial": "axial_force", "axial_force": "axial_force",
    },
    "matno": {"matno": "material", "rhoa": "density", "ea": "young_modulus", "ga": "shear_modulus"},
    "it": {
        "station": "station", "n": "station", "m": "mass", "mass": "mass", "ip": "polar_inertia", "it": "diametral_inertia",
    },
    BEARING: {name: name for name in ("speed", *COEFFICIENTS)},
}  # fmt: skip
UNITS = {  # as sheets spell them, by quantity; others are those of a rotor file
    "length": {"inches": "in", "inch": "in", "meters": "m", "metres": "m"},
    "mass": {"lbm": "lb", "lbs": "lb"},
    "density": {"lbm/in3": "lb/in3", "lbm/in**3": "lb/in3", "lbm/cu.in": "lb/in3", "kg/m**3": "kg/m3"},
    "modulus": {"n/m2": "Pa", "n/m**2": "Pa", "pascals": "Pa", "lb/in2": "psi", "lbf/in2": "psi"},
    "inertia": {"lbm in2": "lb in2", "lbm in**2": "lb in2", "kg m**2": "kg m2"},
    "force": {"lb": "lbf", "lbs": "lbf", "newtons": "N"},
    "stiffness": {"lb/in": "lbf/in"},
    "damping": {"lb s/in": "lbf s/in"},
}


@dataclass(frozen=True)
class PlainTable:
    """Rows of a plain table, and the columns of the sheet that it does not have."""

    rows: list[list[str]]
    others: tuple[str, ...] = ()


def is_xltrc2(rows: Sequence[Sequence[str]], key: str) -> bool:
    """Whether a row has the column by which such a sheet is known."""
    return _header(rows, key) is not None


def plain(rows: Sequence[Sequence[str]], key: str, quantities: Mapping[str, str], path: str) -> PlainTable:
    """The table under the row that has the column `key`; `quantities` of the project's own columns."""
    at = _header(rows, key)
    assert at is not None, "no such sheet"
    names = [_spelt(cell) for cell in rows[at]]
    place = names.index(key)
    body = _numbers_below(rows[at + 1 :], place)
    if not body:
        raise SettingError(f"{path}: expected numbers below {key}, got {described(_cell(rows, at + 1, place) or None)}")
    own = NAMES[key]
    columns = [(index, own[name]) for index, name in enumerate(names) if name in own]
    if len({name for _, name in columns}) < len(columns):
        raise SettingError(f"{path}: expected each column once, got {', '.join(name for _, name in columns)}")
    headings = [_heading(rows, at, index, name, quantities[name], path) for index, name in columns]
    cells = [[_whole(row[index]) if index < len(row) else "" for index, _ in columns] for row in body]
    known = {name for of_sheet in NAMES.values() for name in of_sheet}
    others = tuple(name for name in names if name and name not in known)
    return PlainTable([headings, *cells], others)


def _header(rows: Sequence[Sequence[str]], key: str) -> int | None:
    return next((number for number, row in enumerate(rows) if key in map(_spelt, row)), None)


def _numbers_below(rows: Sequence[Sequence[str]], place: int) -> list[Sequence[str]]:
    """The first run of rows with a number at a place; a row of units may stand before it."""
    found: list[Sequence[str]] = []
    for row in rows:
        if place < len(row) and _is_number(row[place]):
            found.append(row)
        elif found:
            break
    return found


def _heading(rows: Sequence[Sequence[str]], at: int, index: int, name: str, quantity: str, path: str) -> str:
    """A name with its unit, which stands above the sheet's own name or below it."""
    if quantity not in SI_PER_UNIT:
        return name
    for cell in (_cell(rows, at - 1, index), _cell(rows, at + 1, index)):
        unit = _unit(cell, quantity)
        if unit:
            return f"{name} [{unit}]"
    seen = _cell(rows, at - 1, index)
    raise SettingError(
        f"{path}: {rows[at][index].strip()}: expected its unit in the row above, got {described(seen or None)}"
    )


def _unit(cell: str, quantity: str) -> str:
    """The unit of a rotor file that a cell means; '' if it is not a unit."""
    text = " ".join(cell.strip("[]() ").replace("^", "").replace("-", " ").replace("*", " ").split())
    spellings = {" ".join(key.replace("*", " ").split()): unit for key, unit in UNITS.get(quantity, {}).items()}
    known = {unit.lower(): unit for unit in SI_PER_UNIT[quantity]}
    return spellings.get(text.lower()) or known.get(text.lower(), "")


def _cell(rows: Sequence[Sequence[str]], row: int, index: int) -> str:
    return rows[row][index].strip() if 0 <= row < len(rows) and index < len(rows[row]) else ""


def _spelt(cell: str) -> str:
    return cell.strip().lower().replace(" ", "_")


def _whole(cell: str) -> str:
    """Excel has whole numbers as 3.0: materials are named by them."""
    return cell.strip().removesuffix(".0")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True

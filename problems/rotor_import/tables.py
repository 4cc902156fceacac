"""Rotor from tables of shaft elements, disks, and coefficients of each bearing or seal over speed.

Shaft elements may have layers; tables are CSV or Excel.

Columns are read by their names, units from the headings or from a row below them. Sheets of XLTRC2 are made into such tables before. Elements and
stations are counted from 1, the first one at 0 m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ksmea.errors import SettingError, shortened, unknown
from ksmea.settings.regular_files import read_input
from problems.rotor_document.bearings import DIRECT
from problems.rotor_document.tables import LARGEST, QUANTITY_OF, RotorSheets, columns_of, sheet_rows
from problems.rotor_import.bearing_texts import ansys_columns, is_ansys, require_no_dyrobes
from problems.rotor_import.model import DIGITS, NAME, Entry, ImportedRotor, ShaftElement, with_shaft
from problems.rotor_import.xltrc2 import BEARING, is_xltrc2, plain

SHAFT = {
    "element": "number",
    "layer": "number",
    "length": "length",
    "outer_diameter": "length",
    "outer_diameter_left": "length",
    "outer_diameter_right": "length",
    "inner_diameter": "length",
    "inner_diameter_left": "length",
    "inner_diameter_right": "length",
    "stiffness_outer_diameter": "length",
    "young_modulus": "modulus",
    "shear_modulus": "modulus",
    "density": "density",
    "poisson_ratio": "number",
    "axial_force": "force",
    "material": "text",
    "shear": "number",
    "carries": "text",
}
MATERIALS = {
    "material": "text",
    "young_modulus": "modulus",
    "shear_modulus": "modulus",
    "density": "density",
    "poisson_ratio": "number",
}
DISKS = {
    "position": "length",
    "station": "number",
    "mass": "mass",
    "polar_inertia": "inertia",
    "diametral_inertia": "inertia",
}
EXCEL = (".xlsx", ".xlsm")
INERTIAS = ("polar_inertia", "diametral_inertia")
SAME_PLACE = 1e-4  # of the shaft's length: a place that is given in printed digits is the node that it means

Columns = Mapping[str, Sequence[float]]
Texts = Mapping[str, Sequence[str]]


@dataclass(frozen=True)
class Station:
    """The left end of an element, by its number from 1, or the right end of the last one."""

    number: int


Place = float | Station  # m, or the station that lies there


@dataclass(frozen=True)
class Sheets:
    """The tables of a rotor, `file.csv` or `book.xlsx#sheet` each.

    Tables of bearings and seals have places.
    """

    shaft: str
    disks: str = ""
    materials: str = ""
    bearings: Sequence[tuple[str, Place]] = ()
    seals: Sequence[tuple[str, Place]] = ()


def read_sheets(sheets: Sheets) -> ImportedRotor:
    """The rotor that tables describe; `SettingError` if one is not such a table."""
    rotor = ImportedRotor(Path(sheets.shaft.partition("#")[0]).name)
    columns, texts = _read(rotor, sheets.shaft, SHAFT, "od_left")
    materials = _materials(rotor, sheets)
    nodes = with_shaft(rotor, _elements(rotor, sheets, columns, texts, materials))
    if sheets.disks:
        _disks(rotor, sheets.disks, nodes)
    for parts, kept in ((sheets.bearings, rotor.bearings), (sheets.seals, rotor.seals)):
        kept.extend(_bearing(rotor, word, _place(place, nodes, word)) for word, place in parts)
    return rotor


def _read(rotor: ImportedRotor, word: str, quantities: Mapping[str, str], key: str) -> tuple[Columns, Texts]:
    """Columns in SI, and columns of texts.

    `key` is the column by which a sheet of XLTRC2 of this kind is known.
    """
    path = word.partition("#")[0]
    rows = sheet_rows(word, RotorSheets(Path()))
    if is_xltrc2(rows, key):
        table = plain(rows, key, quantities, path)
        rows = table.rows
        if table.others and key == BEARING:
            raise unknown("column", shortened(table.others[0]), quantities).within(path)
        if table.others:
            rotor.left_out.append(f"columns {shortened(', '.join(table.others), 100)} of {path}")
    return columns_of(rows, path, quantities)


def _materials(rotor: ImportedRotor, sheets: Sheets) -> tuple[Columns, Texts] | None:
    """A table of materials: a file of its own, or in the sheet of the shaft, as XLTRC2 has it."""
    if sheets.materials:
        return _read(rotor, sheets.materials, MATERIALS, "matno")
    rows = sheet_rows(sheets.shaft, RotorSheets(Path()))
    return _read(rotor, sheets.shaft, MATERIALS, "matno") if is_xltrc2(rows, "matno") else None


def _disks(rotor: ImportedRotor, word: str, nodes: Mapping[int, float]) -> None:
    columns, _ = _read(rotor, word, DISKS, "it")
    _require(columns, ("mass",), word)
    if ("position" in columns) == ("station" in columns):
        raise SettingError(f"{word}: expected a column position or a column station, got {', '.join(columns)}")
    for index, mass in enumerate(columns["mass"]):
        place: Place = (
            columns["position"][index]
            if "position" in columns
            else Station(_count(columns["station"][index], "station", word))
        )
        entry: Entry = {"position": _place(place, nodes, word), "mass": mass}
        inertias = {key: columns[key][index] for key in INERTIAS if key in columns}
        if mass and any(inertias.values()):
            rotor.disks.append({**entry, **dict.fromkeys(INERTIAS, 0.0), **inertias})
        elif mass or any(inertias.values()):  # sheets by station have rows of zeros
            rotor.masses.append({**entry, **{key: value for key, value in inertias.items() if value}})


def _place(place: Place, nodes: Mapping[int, float], word: str) -> float:
    """A position, m, of the station or near it."""
    if isinstance(place, Station):
        if place.number - 1 not in nodes:
            raise SettingError(f"{word}: expected a station from 1 to {max(nodes) + 1}, got {place.number}")
        return nodes[place.number - 1]
    near = min(nodes.values(), key=lambda each: abs(each - place))
    return near if abs(near - place) <= SAME_PLACE * max(nodes.values()) else place


def _count(value: float, what: str, word: str) -> int:
    """A number that counts from 1."""
    if not (value >= 1 and value == int(value)):
        raise SettingError(f"{word}: {what}: expected a whole number from 1 on, got {value:g}")
    return int(value)


def _require(columns: Columns | Texts, names: Sequence[str], word: str) -> None:
    for name in names:
        if name not in columns:
            raise SettingError(f"{word}: expected a column {name}, got {', '.join(columns) or 'none'}")


def _elements(
    rotor: ImportedRotor, sheets: Sheets, columns: Columns, texts: Texts, materials: tuple[Columns, Texts] | None
) -> list[ShaftElement]:
    _require(columns, ("length",), sheets.shaft)
    outer = next((name for name in ("outer_diameter_left", "outer_diameter") if name in columns), None)
    if outer is None:
        raise SettingError(f"{sheets.shaft}: expected a column outer_diameter or outer_diameter_left, got none")
    if "layer" in columns and "element" not in columns:
        raise SettingError(f"{sheets.shaft}: expected a column element with the column layer, got none")
    inner = next((name for name in ("inner_diameter_left", "inner_diameter") if name in columns), None)
    found = []
    for index in range(len(columns["length"])):
        left = columns[outer][index]
        entry: Entry = {"outer_diameter": left}
        hollow = columns[inner][index] if inner else 0.0
        right, hollow_right = (
            columns[name][index] if name in columns else same
            for name, same in (("outer_diameter_right", left), ("inner_diameter_right", hollow))
        )
        entry |= {"inner_diameter": hollow} if hollow or hollow_right else {}
        entry |= {"outer_diameter_right": right} if right != left else {}
        entry |= {"inner_diameter_right": hollow_right} if hollow_right != hollow else {}
        if "stiffness_outer_diameter" in columns and columns["stiffness_outer_diameter"][index] != left:
            entry["stiffness_outer_diameter"] = columns["stiffness_outer_diameter"][index]
        entry["material"] = _material(rotor, sheets, index, columns, texts, materials)
        if "shear" in columns and not columns["shear"][index]:
            entry["theory"] = "euler_bernoulli"
        if "axial_force" in columns and columns["axial_force"][index]:
            entry["axial_force"] = columns["axial_force"][index]
        if (carried := texts["carries"][index] if "carries" in texts else "") not in ("", "both"):
            entry["carries"] = carried
        number = _count(columns["element"][index], "element", sheets.shaft) if "element" in columns else index + 1
        found.append(ShaftElement(number - 1, columns["length"][index], entry))
    return found


def _material(
    rotor: ImportedRotor,
    sheets: Sheets,
    index: int,
    columns: Columns,
    texts: Texts,
    materials: tuple[Columns, Texts] | None,
) -> str:
    """The material of a row: in its own columns, or by name in the table of materials."""
    if "young_modulus" in columns:
        _require(columns, ("density",), sheets.shaft)
        name = texts["material"][index] if "material" in texts else "material"
        return rotor.material(name, *_elastic(columns, index, sheets.shaft))
    if "material" not in texts or materials is None:
        raise SettingError(
            f"{sheets.shaft}: expected columns young_modulus, density and poisson_ratio, or a column material and a table of"
            " materials, got neither; give --materials FILE"
        )
    name, (numbers, names) = texts["material"][index], materials
    _require(numbers, ("young_modulus", "density"), sheets.materials or sheets.shaft)
    known = list(names.get("material", ()))
    if name not in known:
        raise SettingError(
            f"{sheets.materials or sheets.shaft}: expected a material '{shortened(name)}', got {', '.join(known) or 'none'}"
        )
    return rotor.material(name, *_elastic(numbers, known.index(name), sheets.materials or sheets.shaft))


def _elastic(columns: Columns, index: int, word: str) -> tuple[float, float, float]:
    """Young's modulus Pa, density kg/m³ and Poisson's ratio."""
    modulus, density = columns["young_modulus"][index], columns["density"][index]
    if "poisson_ratio" in columns:
        return modulus, density, columns["poisson_ratio"][index]
    _require(columns, ("shear_modulus",), word)
    shear = columns["shear_modulus"][index]
    if not shear > 0:
        raise SettingError(f"{word}: shear_modulus: expected a number above 0, got {shear:g}")
    return modulus, density, round(modulus / (2 * shear) - 1, DIGITS)


def _bearing(rotor: ImportedRotor, word: str, position: float) -> Entry:
    """Coefficients over speed; a table of one row is a bearing with constant ones."""
    columns = _bearing_columns(rotor, word)
    _require(columns, ("speed",), word)
    own = {name: values for name, values in columns.items() if name in ("speed", *DIRECT) or any(values)}
    if len(own["speed"]) == 1:
        direct = dict.fromkeys(DIRECT, 0.0)
        return {
            "position": position,
            **direct,
            **{name: values[0] for name, values in own.items() if name != "speed"},
            NAME: word,
        }
    return {"position": position, "table": {name: list(values) for name, values in own.items()}, NAME: word}


def _bearing_columns(rotor: ImportedRotor, word: str) -> Columns:
    """Columns in SI of a sheet with headings, or of a text of another program."""
    if not word.partition("#")[0].lower().endswith(EXCEL):
        text = read_input(word, "CSV or Excel", LARGEST, f"expected at most {LARGEST} bytes, got {{}}".format).decode(
            "latin-1"
        )
        require_no_dyrobes(text, word)
        if is_ansys(text):
            rotor.remark(
                f"{word}: a table of ANSYS COMBI214; numbers without its key of units are taken as N/m, N s/m and rad/s"
            )
            return ansys_columns(text, word)
    return _read(rotor, word, QUANTITY_OF, BEARING)[0]

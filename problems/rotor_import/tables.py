"""A rotor from tables: shaft elements with layers, disks, and a table over speed of each bearing or seal, in CSV or Excel.

Columns are read by their names, units from the headings or from a row below them. The names of an XLTRC2 sheet are understood as well
(`od_left`, `id_left`, `matnum`, …), with its stations counted from 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ksmea.errors import SettingError, shortened
from problems.rotor_document.bearings import DIRECT
from problems.rotor_document.tables import QUANTITY_OF, RotorSheets, columns_of, sheet_rows
from problems.rotor_import.model import Entry, ImportedRotor, ShaftElement, with_shaft

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
}
ALIASES = {  # of XLTRC2's sheets, as they are exported
    "elemnum": "element",
    "elem": "element",
    "elemlayer": "layer",
    "od_left": "outer_diameter_left",
    "od_right": "outer_diameter_right",
    "id_left": "inner_diameter_left",
    "id_right": "inner_diameter_right",
    "matnum": "material",
    "matno": "material",
    "rhoa": "density",
    "ea": "young_modulus",
    "ga": "shear_modulus",
    "axial": "axial_force",
    "ip": "polar_inertia",
    "it": "diametral_inertia",
    "station": "element",
}
MATERIALS = {
    "material": "text",
    "young_modulus": "modulus",
    "shear_modulus": "modulus",
    "density": "density",
    "poisson_ratio": "number",
}
DISKS = {"position": "length", "mass": "mass", "polar_inertia": "inertia", "diametral_inertia": "inertia"}
STEEL = 0.3  # Poisson's ratio where a table has neither that nor a shear modulus

Columns = Mapping[str, Sequence[float]]
Texts = Mapping[str, Sequence[str]]


@dataclass(frozen=True)
class Sheets:
    """The tables of a rotor, `file.csv` or `book.xlsx#sheet` each; of bearings and seals with their positions, m."""

    shaft: str
    disks: str = ""
    materials: str = ""
    bearings: Sequence[tuple[str, float]] = ()
    seals: Sequence[tuple[str, float]] = ()


def read_sheets(sheets: Sheets) -> ImportedRotor:
    """The rotor that tables describe; `SettingError` where one is no such table."""
    rotor = ImportedRotor(Path(sheets.shaft.partition("#")[0]).name)
    materials = _read(sheets.materials, MATERIALS) if sheets.materials else None
    columns, texts = _read(sheets.shaft, SHAFT)
    with_shaft(rotor, _elements(rotor, sheets, columns, texts, materials))
    if sheets.disks:
        disks, _ = _read(sheets.disks, DISKS)
        _require(disks, ("position", "mass"), sheets.disks)
        for index in range(len(disks["position"])):
            entry = {name: values[index] for name, values in disks.items()}
            has_inertia = entry.get("polar_inertia") or entry.get("diametral_inertia")
            own = entry if has_inertia else {key: entry[key] for key in ("position", "mass")}
            (rotor.disks if has_inertia else rotor.masses).append(own)
    for parts, kept in ((sheets.bearings, rotor.bearings), (sheets.seals, rotor.seals)):
        kept.extend(_bearing(word, position) for word, position in parts)
    return rotor


def _read(word: str, quantities: Mapping[str, str]) -> tuple[Columns, Texts]:
    """Columns in SI, and those of texts."""
    path = word.partition("#")[0]
    rows = [list(row) for row in sheet_rows(word, RotorSheets(Path()))]
    for row in rows[:1]:
        row[:] = [_renamed(cell) for cell in row]
    return columns_of(rows, path, quantities)


def _renamed(cell: str) -> str:
    name = cell.strip().lower().replace(" ", "_")
    return ALIASES.get(name, cell)


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
        number = int(columns["element"][index]) if "element" in columns else index + 1
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
        return rotor.material(name, *_elastic(columns, index))
    if "material" not in texts or materials is None:
        raise SettingError(
            f"{sheets.shaft}: expected columns young_modulus, density and poisson_ratio, or a column material and a table of"
            " materials, got neither; give --materials FILE"
        )
    name, (numbers, names) = texts["material"][index], materials
    _require(numbers, ("young_modulus", "density"), sheets.materials)
    known = list(names.get("material", ()))
    if name not in known:
        raise SettingError(
            f"{sheets.materials}: expected a material '{shortened(name)}', got {', '.join(known) or 'none'}"
        )
    return rotor.material(name, *_elastic(numbers, known.index(name)))


def _elastic(columns: Columns, index: int) -> tuple[float, float, float]:
    """Young's modulus Pa, density kg/m³ and Poisson's ratio."""
    modulus, density = columns["young_modulus"][index], columns["density"][index]
    if "poisson_ratio" in columns:
        return modulus, density, columns["poisson_ratio"][index]
    if "shear_modulus" in columns:
        return modulus, density, modulus / (2 * columns["shear_modulus"][index]) - 1
    return modulus, density, STEEL


def _bearing(word: str, position: float) -> Entry:
    """Coefficients over speed; a table of one row is a bearing with constant ones."""
    columns, _ = _read(word, QUANTITY_OF)
    _require(columns, ("speed",), word)
    own = {name: values for name, values in columns.items() if name in ("speed", *DIRECT) or any(values)}
    if len(own["speed"]) == 1:
        direct = dict.fromkeys(DIRECT, 0.0)
        return {"position": position, **direct, **{name: values[0] for name, values in own.items() if name != "speed"}}
    return {"position": position, "table": {name: list(values) for name, values in own.items()}}

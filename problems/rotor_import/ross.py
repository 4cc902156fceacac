"""Rotor models of ROSS, as `Rotor.save` writes them.

Versions 1, 2 and 3, TOML or JSON, SI throughout, nodes counted from 0.

Conventions are the project's own: x and y lateral, the shaft turns from x to y, the force on the shaft is −(kxx x + kxy y).
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ksmea.errors import SettingError, described, shortened
from ksmea.settings.document import Block
from ksmea.settings.regular_files import read_input
from problems.rotor_import.model import NAME, Entry, ImportedRotor, with_shaft
from problems.rotor_import.ross_bearings import read_bearings
from problems.rotor_import.ross_sections import Section, optional, tag_of, whole
from problems.rotor_import.ross_shaft import coupling_element, shaft_element, tell_torque

LARGEST = 20 * 10**6  # bytes
REFUSED = {
    "Gear": "gears: several shafts and torsion",
    "Mesh": "gears: several shafts and torsion",
    "Multi": "several rotors",
    "CoAxial": "several rotors",
}
SUPPORTING = ("BearingElement", "SealElement", "Damper", "DamperElement", "MagneticBearingElement")


def read_ross(path: str) -> ImportedRotor:
    """The rotor of a file; `SettingError` if it is another file, or holds what a rotor file cannot say."""
    model = _document(path)
    version = str(model.pop("ross_version", "") or "1")
    parameters = model.pop("parameters", None) or {}
    if not isinstance(parameters, dict):
        raise SettingError(f"{path}: parameters: expected a section, got {described(parameters)}")
    rotor = ImportedRotor(f"{Path(path).name} (ROSS {shortened(version)})")
    by_class = _sections(path, model)
    positions = _with_shaft(rotor, by_class)
    for section in by_class.pop("DiskElement", []):
        _disk(rotor, section, positions)
    supporting = [each for kind in list(by_class) if kind.endswith(SUPPORTING) for each in by_class.pop(kind)]
    read_bearings(rotor, supporting, by_class.pop("PointMass", []), positions, _major(version))
    for kind, others in by_class.items():
        tags = ", ".join(shortened(tag_of(each)) for each in others[:5])
        rotor.left_out.append(f"{len(others)} × {shortened(kind)} ({tags}): a rotor file has no such part")
    _parameters(rotor, Block(path, "parameters", parameters))
    return rotor


def _document(path: str) -> dict[str, Any]:
    content = read_input(
        path, "ROSS", LARGEST, f"expected at most {LARGEST} bytes, got {{}}; this is not a model".format
    )
    try:
        text = content.decode("utf-8-sig")
        found = json.loads(text) if text.lstrip().startswith("{") else tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # of UTF-8, TOML and JSON
        reason = shortened(str(error), 100)
        raise SettingError(f"{path}: expected a model that ROSS has saved (TOML or JSON), got {reason}") from error
    if not isinstance(found, dict) or not any(str(name).startswith("ShaftElement") for name in found):
        raise SettingError(f"{path}: expected a model that ROSS has saved, got one without ShaftElement sections")
    return found


def _sections(path: str, model: Mapping[str, Any]) -> dict[str, list[Section]]:
    """Sections by class, which is what stands before the first underscore of their names."""
    by_class: dict[str, list[Section]] = {}
    for name, values in model.items():
        kind = name.partition("_")[0]
        refused = next((words for start, words in REFUSED.items() if kind.startswith(start)), None)
        if refused:
            raise SettingError(
                f"{path}: expected a rotor of one shaft in lateral motion, got {shortened(name)} ({refused}); save it without"
            )
        if isinstance(values, dict):
            by_class.setdefault(kind, []).append(Section(path, shortened(name), values))
    return by_class


def _major(version: str) -> int:
    first = version.partition(".")[0]
    return int(first) if first.isascii() and first.isdigit() and len(first) < 4 else 1


def _with_shaft(rotor: ImportedRotor, by_class: dict[str, list[Section]]) -> dict[int, float]:
    """The shaft into the file; positions (m) by node."""
    sections = by_class.pop("ShaftElement", [])
    elements = [shaft_element(rotor, section) for section in sections]
    couplings = [coupling_element(rotor, section) for section in by_class.pop("CouplingElement", [])]
    positions = with_shaft(rotor, [*elements, *couplings])
    rotor.couplings.extend({"position": positions[each.node] + each.length / 2} for each in couplings)
    tell_torque(rotor, sections, max(positions.values()))
    return positions


def _disk(rotor: ImportedRotor, section: Section, positions: Mapping[int, float]) -> None:
    mass, polar, diametral = (section.number(key, at_least=0) for key in ("m", "Ip", "Id"))
    node = whole(section, "n")
    if node not in positions:
        raise section.error("n", f"expected a node of the shaft, up to {max(positions)}, got {node}")
    entry: Entry = {"position": positions[node], "mass": mass, NAME: tag_of(section)}
    if mass and (polar or diametral):
        rotor.disks.append({**entry, "polar_inertia": polar, "diametral_inertia": diametral})
    else:
        inertias = {"polar_inertia": polar, "diametral_inertia": diametral} if polar or diametral else {}
        rotor.masses.append({**entry, **inertias})


def _parameters(rotor: ImportedRotor, parameters: Block) -> None:
    """Range of speeds, and damping of the whole rotor, which stands still: αM + βK of all that turns."""
    low, high = (optional(parameters, key) for key in ("min_w", "max_w"))
    if 0 < low < high:
        rotor.speeds = (low, high)
    of_mass, of_stiffness = (optional(parameters, key, at_least=0) for key in ("alpha", "beta"))
    if of_mass or of_stiffness:
        _damp(rotor.shaft, of_mass, of_stiffness)
        heavy = [mass for mass in rotor.masses if mass["mass"]]  # only a disk has damping of its own, and needs a mass
        rotor.disks.extend({"polar_inertia": 0.0, "diametral_inertia": 0.0, **mass} for mass in heavy)
        rotor.masses[:] = [mass for mass in rotor.masses if not mass["mass"]]
        for disk in rotor.disks:
            disk["standing_damping"] = of_mass
        if rotor.couplings:
            rotor.left_out.append("alpha and beta of the whole rotor at its couplings")
    for key in ("default_damping_ratio", "modal_damping_ratio"):
        if value := parameters.values.get(key):
            rotor.left_out.append(f"{key} {described(value)}: a rotor file has no modal damping")


def _damp(shaft: Sequence[Entry], of_mass: float, of_stiffness: float) -> None:
    for entry in shaft:
        if "coupling" not in entry:
            own = entry.get("standing_damping", {"mass": 0.0, "stiffness": 0.0})
            entry["standing_damping"] = {
                "mass": own["mass"] + of_mass,
                "stiffness": own["stiffness"] + of_stiffness,
            }

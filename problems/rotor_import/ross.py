"""Rotor models of ROSS, as `Rotor.save` writes them: versions 1, 2 and 3, TOML or JSON, SI throughout, nodes counted from 0.

Conventions are the project's own: x and y lateral, the shaft turns from x to y, the force on the shaft is −(kxx x + kxy y). Lists of
coefficients are tables: over the speed of rotation in versions 1 and 2 (`frequency`), also over the frequency of whirl in version 3 (`speed`,
`frequency`); at 1X both are the speed of rotation.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from ksmea.arrays import Array
from ksmea.errors import SettingError, described, shortened
from ksmea.settings.regular_files import read_input
from problems.rotor.finite_elements.bearing import COEFFICIENTS
from problems.rotor_document.bearings import DIRECT
from problems.rotor_document.tables import REQUIRED_MEASURED
from problems.rotor_import.model import Entry, ImportedRotor, ShaftElement, with_shaft

ROUNDING = 1e-12  # of the largest number of its kind: smaller ones are 0
LARGEST = 20 * 10**6  # bytes
BEARINGS = ("Bearing", "Ball", "Roller", "Cylindrical", "Plain", "Tilting", "Thrust", "Squeeze", "Magnetic")
REFUSED = {"Gear": "gears: several shafts and torsion", "Brush": "brush seals", "Multi": "several rotors"}
SWITCHES = ("rotary_inertia", "gyroscopic")


def read_ross(path: str) -> ImportedRotor:
    """The rotor of a file; `SettingError` where it is none, or holds what a rotor file cannot say."""
    model = _document(path)
    rotor = ImportedRotor(Path(path).name)
    version = str(model.pop("ross_version", "1"))
    parameters = model.pop("parameters", None) or {}
    sections = {name: value for name, value in model.items() if isinstance(value, dict)}
    by_class: dict[str, list[tuple[str, Entry]]] = {}
    for name, section in sections.items():
        kind, _, tag = name.partition("_")
        by_class.setdefault(kind, []).append((str(section.get("tag") or tag), section))
    for kind in by_class:
        refused = next((words for start, words in REFUSED.items() if kind.startswith(start)), None)
        if refused:
            raise SettingError(
                f"{path}: expected a rotor of one shaft in lateral motion, got {kind} ({refused}); leave it out"
            )
    elements = [_shaft(rotor, *each) for each in by_class.pop("ShaftElement", [])]
    elements += [_coupling(rotor, *each) for each in by_class.pop("CouplingElement", [])]
    positions = with_shaft(rotor, elements)
    for tag, section in by_class.pop("DiskElement", []):
        _disk(rotor, tag, section, positions)
    links = {
        kind: by_class.pop(kind)
        for kind in list(by_class)
        if kind.endswith(("BearingElement", "SealElement", "SealElem"))
    }
    points = by_class.pop("PointMass", [])
    _supports_and_bearings(rotor, links, points, positions, _major(version))
    for kind, others in by_class.items():
        rotor.left_out += [f"{kind} '{shortened(tag)}': no such part in a rotor file" for tag, _ in others]
    _parameters(rotor, parameters)
    return rotor


def _major(version: str) -> int:
    first = version.partition(".")[0]
    return int(first) if first.isdigit() else 1


def _document(path: str) -> dict[str, Any]:
    content = read_input(path, "ROSS file", LARGEST, f"expected at most {LARGEST} bytes, got {{}}".format)
    try:
        text = content.decode("utf-8-sig")
        found = json.loads(text) if text.lstrip().startswith("{") else tomllib.loads(text)
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise SettingError(
            f"{path}: expected a file that ROSS has saved (TOML or JSON), got {shortened(str(error), 100)}"
        ) from error
    if not isinstance(found, dict) or not any(str(name).startswith("ShaftElement") for name in found):
        raise SettingError(f"{path}: expected a file that ROSS has saved, got one without ShaftElement sections")
    return found


def _number(section: Mapping[str, Any], key: str, tag: str, default: float | None = None) -> float:
    value = section.get(key)
    if value is None and default is not None:
        return default
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(float(value)):
        raise SettingError(f"{shortened(tag)}: {key}: expected a number, got {described(value)}")
    return float(value)


def _whole(section: Mapping[str, Any], key: str, tag: str) -> int:
    value = section.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise SettingError(f"{shortened(tag)}: {key}: expected a node from 0 on, got {described(value)}")
    return value


def _shaft(rotor: ImportedRotor, tag: str, section: Entry) -> ShaftElement:
    left, right = (_number(section, f"od{side}", tag) for side in "lr")
    inner_left, inner_right = (_number(section, f"id{side}", tag) for side in "lr")
    inner_left, inner_right = (0.0 if abs(each) < ROUNDING * left else each for each in (inner_left, inner_right))
    material = section.get("material")
    if not isinstance(material, dict):
        raise SettingError(f"{shortened(tag)}: material: expected its section, got {described(material)}")
    modulus, shear = (_number(material, key, tag) for key in ("E", "G_s"))
    if shear <= 0:
        raise SettingError(f"{shortened(tag)}: G_s: expected a number above 0, got {shear}")
    ratio = modulus / (2 * shear) - 1
    entry: Entry = {"outer_diameter": left}
    entry |= {"inner_diameter": inner_left} if inner_left or inner_right else {}
    entry |= {"outer_diameter_right": right} if right != left else {}
    entry |= {"inner_diameter_right": inner_right} if inner_right != inner_left else {}
    name = str(material.get("name") or "material")
    entry["material"] = rotor.material(name, modulus, _number(material, "rho", tag), ratio)
    if section.get("shear_effects", True) is False:
        entry["theory"] = "euler_bernoulli"
    elif section.get("shear_method_calc", "cowper") == "hutchinson":
        entry["shear_coefficient"] = _hutchinson(ratio, (inner_left + inner_right) / (left + right))
        _once(rotor, "Hutchinson's shear coefficient is the one that ROSS computes (its formula lacks a factor 1 + ν).")
    entry |= {key: False for key in SWITCHES if section.get(key, True) is False}
    if force := _number(section, "axial_force", tag, 0.0):
        entry["axial_force"] = force
    if torque := _number(section, "torque", tag, 0.0):
        rotor.left_out.append(f"torque of {torque:g} N m on {shortened(tag)}: a rotor file has none")
    damping = {"mass": _number(section, "alpha", tag, 0.0), "stiffness": _number(section, "beta", tag, 0.0)}
    if any(damping.values()):
        entry["standing_damping"] = damping
    return ShaftElement(_whole(section, "n", tag), _number(section, "L", tag), entry)


def _hutchinson(nu: float, ratio: float) -> float:
    """As ROSS has it."""
    squared = ratio**2
    whole = (1 + squared) ** 2
    return 6 * whole * (1 + nu) / (whole * (7 + 12 * nu + 4 * nu**2) + 4 * squared * (5 + 6 * nu + 2 * nu**2))


def _coupling(rotor: ImportedRotor, tag: str, section: Entry) -> ShaftElement:
    def pair(first: str, second: str) -> list[float]:
        return [_number(section, key, tag, 0.0) for key in (first, second)]

    coupling = {
        "stiffness": pair("kt_x", "kt_y"),
        "angular_stiffness": pair("kr_x", "kr_y"),
        "damping": pair("ct_x", "ct_y"),
        "angular_damping": pair("cr_x", "cr_y"),
        "masses": pair("m_l", "m_r"),
        "polar_inertias": pair("Ip_l", "Ip_r"),
        "diametral_inertias": pair("Id_l", "Id_r"),
    }
    kept = {key: value for key, value in coupling.items() if any(value) or key in ("stiffness", "angular_stiffness")}
    entry: Entry = {"coupling": kept}
    if diameter := _number(section, "o_d", tag, 0.0):
        entry["outer_diameter"] = diameter
    return ShaftElement(_whole(section, "n", tag), _number(section, "L", tag), entry)


def _disk(rotor: ImportedRotor, tag: str, section: Entry, positions: Mapping[int, float]) -> None:
    mass, polar, diametral = (_number(section, key, tag) for key in ("m", "Ip", "Id"))
    node = _whole(section, "n", tag)
    if node not in positions:
        raise SettingError(f"{shortened(tag)}: n: expected a node of the shaft, up to {max(positions)}, got {node}")
    entry = {"position": positions[node], "mass": mass, "polar_inertia": polar, "diametral_inertia": diametral}
    if polar or diametral:
        rotor.disks.append(entry)
    else:
        rotor.masses.append({"position": positions[node], "mass": mass})


def _supports_and_bearings(
    rotor: ImportedRotor,
    links: Mapping[str, list[tuple[str, Entry]]],
    points: list[tuple[str, Entry]],
    positions: Mapping[int, float],
    major: int,
) -> None:
    """Bearings and seals on the shaft; those on nodes beyond it are supports, of the bearing that is linked to the node."""
    supports: dict[int, Entry] = {}
    on_shaft: list[tuple[str, str, Entry, int]] = []
    for kind, found in links.items():
        if "Seal" not in kind and not kind.startswith(BEARINGS):
            rotor.remarks.append(f"{kind}: read as a bearing.")
        for tag, section in found:
            node = _whole(section, "n", tag)
            if node in positions:
                on_shaft.append((kind, tag, section, node))
            elif node in supports:
                raise SettingError(f"{shortened(tag)}: expected one support at node {node}, got another one")
            elif section.get("n_link") is not None:
                raise SettingError(
                    f"{shortened(tag)}: expected a support on the ground, got one on node {section['n_link']}"
                )
            else:
                supports[node] = _support(rotor, tag, section, major)
    for tag, point in points:
        _point_mass(rotor, tag, point, positions, supports)
    linked: set[int] = set()
    for kind, tag, section, node in on_shaft:
        entry = {"position": positions[node], **_coefficients(rotor, tag, section, major)}
        if (link := section.get("n_link")) is not None:
            if link in linked or link not in supports:
                what = "its own support" if link in linked else "a support at that node"
                raise SettingError(f"{shortened(tag)}: n_link: expected {what}, got node {described(link)}")
            linked.add(link)
            entry["support"] = supports[link]
        (rotor.seals if "Seal" in kind else rotor.bearings).append(entry)
    rotor.left_out += [f"support at node {node}: no bearing stands on it" for node in supports if node not in linked]


def _point_mass(
    rotor: ImportedRotor, tag: str, section: Entry, positions: Mapping[int, float], supports: dict[int, Entry]
) -> None:
    whole = _number(section, "m", tag, 0.0)
    along_x, along_y = (_number(section, key, tag, whole) for key in ("mx", "my"))
    node = _whole(section, "n", tag)
    if node in positions and along_x == along_y:
        rotor.masses.append({"position": positions[node], "mass": along_x})
    elif node in positions:  # what turns with the shaft has one mass: this one does not turn
        rotor.seals.append({"position": positions[node], "mxx": along_x, "myy": along_y})
    elif node in supports:
        for key, value in (("mxx", along_x), ("myy", along_y)):
            supports[node][key] = supports[node].get(key, 0.0) + value
    else:
        rotor.left_out.append(f"PointMass '{shortened(tag)}': nothing is at node {node}")


def _coefficients(rotor: ImportedRotor, tag: str, section: Entry, major: int) -> Entry:
    """kxx … myy, as numbers or as a table."""
    speed, columns = _columns(rotor, tag, section, major)
    kept = {name: values for name, values in columns.items() if name in DIRECT or np.any(values)}
    if speed is None:
        return {name: float(values[0]) for name, values in kept.items()}
    return {"table": {"speed": speed.tolist(), **{name: values.tolist() for name, values in kept.items()}}}


def _support(rotor: ImportedRotor, tag: str, section: Entry, major: int) -> Entry:
    """Of a bearing element on the ground; a table is its dynamic stiffness at the frequency of rotation."""
    speed, columns = _columns(rotor, tag, section, major)
    if speed is None:
        return {"kxx": 0.0, "kyy": 0.0} | {name: float(values[0]) for name, values in columns.items() if values[0]}
    table: Entry = {"frequency": speed.tolist()}
    for name in ("xx", "xy", "yx", "yy"):
        table[f"re_z{name}"] = (columns[f"k{name}"] - speed**2 * columns[f"m{name}"]).tolist()
        table[f"im_z{name}"] = (speed * columns[f"c{name}"]).tolist()
    rotor.remarks.append(
        f"{shortened(tag)}: a support as a table, taken as its dynamic stiffness at the frequency of rotation."
    )
    return {"table": {name: values for name, values in table.items() if name in REQUIRED_MEASURED or np.any(values)}}


def _columns(rotor: ImportedRotor, tag: str, section: Entry, major: int) -> tuple[Array | None, dict[str, Array]]:
    """Speeds (rad/s) of a table, None of constant coefficients, and each coefficient over them."""
    axes = {key: section.get(key) for key in ("speed", "frequency", "w")}
    given = {key: np.asarray(value, dtype=float).ravel() for key, value in axes.items() if _is_list(value)}
    columns = {}
    for name in COEFFICIENTS:
        value = section.get(name)
        columns[name] = np.zeros(1) if value is None else _array(value, name, tag)
    for start in "kcm":
        largest = max(np.abs(values).max() for name, values in columns.items() if name[0] == start)
        for name, values in columns.items():
            if name[0] == start:
                columns[name] = np.where(np.abs(values) < ROUNDING * largest, 0.0, values)
    sizes = {values.size for values in columns.values()}
    if max(sizes) == 1:
        return None, {name: values.ravel() for name, values in columns.items()}
    if not given:
        raise SettingError(f"{shortened(tag)}: expected the speeds of its table, got none")
    if any(values.ndim == 2 for values in columns.values()):
        return _along_rotation(rotor, tag, given, columns)
    [*_, axis] = sorted(given, key=lambda key: key == "speed")
    if major >= 3 and "speed" not in given:
        rotor.remarks.append(f"{shortened(tag)}: a table over the frequency of whirl, taken at that of rotation.")
    elif major < 3 and "g0" in section:
        rotor.remarks.append(
            f"{shortened(tag)}: a magnetic bearing; its table over frequency is taken at that of rotation."
        )
    speed = given[axis]
    full = {}
    for name, values in columns.items():
        full[name] = np.full(len(speed), values.ravel()[0]) if values.size == 1 else values.ravel()
        if len(full[name]) != len(speed):
            raise SettingError(
                f"{shortened(tag)}: {name}: expected {len(speed)} numbers, one for each speed, got {len(full[name])}"
            )
    order = np.argsort(speed)
    return speed[order], {name: values[order] for name, values in full.items()}


def _along_rotation(
    rotor: ImportedRotor, tag: str, given: Mapping[str, Array], columns: Mapping[str, Array]
) -> tuple[Array, dict[str, Array]]:
    """Tables [speed][frequency] where the frequency of whirl is that of rotation, linear between the points."""
    if {"speed", "frequency"} - set(given):
        raise SettingError(
            f"{shortened(tag)}: expected speed and frequency of a table over both, got {', '.join(given)}"
        )
    speed, frequency = given["speed"], given["frequency"]
    found = {}
    for name, values in columns.items():
        if values.ndim < 2:
            found[name] = np.full(len(speed), values.ravel()[0])
            continue
        if values.shape != (len(speed), len(frequency)):
            raise SettingError(
                f"{shortened(tag)}: {name}: expected {len(speed)} × {len(frequency)} numbers, got {' × '.join(map(str, values.shape))}"
            )
        at = np.stack([speed, np.clip(speed, frequency[0], frequency[-1])], axis=1)
        found[name] = RegularGridInterpolator((speed, frequency), values)(at) if len(speed) > 1 else values[:, 0]
    rotor.remarks.append(
        f"{shortened(tag)}: a table over speed and frequency of whirl, taken where whirl is rotation (1X)."
    )
    return speed, found


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and len(value) > 0


def _array(value: Any, name: str, tag: str) -> Array:
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        found = np.full(1, np.nan)
    if not found.size or not np.all(np.isfinite(found)) or found.ndim > 2:
        raise SettingError(f"{shortened(tag)}: {name}: expected numbers, got {described(value)}")
    return np.atleast_1d(found)


def _parameters(rotor: ImportedRotor, parameters: Mapping[str, Any]) -> None:
    low, high = (parameters.get(key) for key in ("min_w", "max_w"))
    if isinstance(low, (int, float)) and isinstance(high, (int, float)) and 0 < low < high:
        rotor.speeds = (float(low), float(high))
    damping = [_number(parameters, key, "parameters", 0.0) for key in ("alpha", "beta")]
    if any(damping):
        for entry in rotor.shaft:
            if "coupling" not in entry:
                own = entry.setdefault("standing_damping", {"mass": 0.0, "stiffness": 0.0})
                own["mass"], own["stiffness"] = own["mass"] + damping[0], own["stiffness"] + damping[1]
        for disk in rotor.disks:
            disk["standing_damping"] = damping[0]
    for key in ("default_damping_ratio", "modal_damping_ratio"):
        if parameters.get(key):
            rotor.left_out.append(f"{key} {described(parameters[key])}: a rotor file has no modal damping")


def _once(rotor: ImportedRotor, remark: str) -> None:
    if remark not in rotor.remarks:
        rotor.remarks.append(remark)

"""Bearings, seals, supports and point masses of ROSS.

Nodes beyond the shaft's last belong to supports: a bearing is linked to such a node (`n_link`), another bearing element stands between the node
and the ground, and a point mass sits there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from problems.rotor_document.bearings import DIRECT
from problems.rotor_document.tables import REQUIRED_MEASURED
from problems.rotor_import.model import NAME, Entry, ImportedRotor
from problems.rotor_import.ross_sections import Section, optional, tag_of, whole
from problems.rotor_import.ross_tables import Coefficients, coefficients

AXIAL = ("kzz", "czz", "mzz")
LEAST_GAP = 1e-4  # between two interpolations, that is said


def read_bearings(
    rotor: ImportedRotor,
    sections: Sequence[Section],
    points: Sequence[Section],
    positions: Mapping[int, float],
    major: int,
) -> None:
    """Put bearings, seals and their supports into the rotor; `positions` (m) belong to the shaft's nodes."""
    found = [(section, coefficients(section, major)) for section in sections]
    supports = _supports(rotor, [each for each in found if whole(each[0], "n") not in positions], max(positions))
    for point in points:
        _point_mass(rotor, point, positions, supports)
    linked: dict[int, str] = {}
    for section, own in found:
        node = whole(section, "n")
        if node not in positions:
            continue
        entry = {"position": positions[node], **_entry(own), NAME: tag_of(section)}
        if section.values.get("n_link") is not None:
            link = whole(section, "n_link")
            _require_own_support(section, link, positions, supports, linked)
            linked[link] = tag_of(section)
            entry["support"] = supports[link]
        is_seal = "Seal" in section.path.partition("_")[0]
        if is_seal and "support" in entry:
            raise section.error("n_link", "expected a seal on the ground, got one on a support; model it as a bearing")
        (rotor.seals if is_seal else rotor.bearings).append(entry)
    for parts in (rotor.bearings, rotor.seals):  # as they lie along the shaft
        parts.sort(key=lambda entry: float(entry["position"]))
    rotor.left_out += [f"support at node {node}: no bearing stands on it" for node in supports if node not in linked]
    _tell(rotor, found)


def _require_own_support(
    section: Section,
    link: int,
    positions: Mapping[int, float],
    supports: Mapping[int, Entry],
    linked: Mapping[int, str],
) -> None:
    if link in positions:
        raise section.error("n_link", f"expected a support beyond the shaft, got node {link} of the shaft itself")
    if link in linked:
        raise section.error("n_link", f"expected a support of its own, got node {link}, which carries {linked[link]}")
    if link not in supports:
        raise section.error("n_link", f"expected a bearing element from node {link} to the ground, got none")


def _supports(rotor: ImportedRotor, found: Sequence[tuple[Section, Coefficients]], last: int) -> dict[int, Entry]:
    """Supports by node; several elements of one node add."""
    supports: dict[int, Entry] = {}
    for section, own in found:
        node = whole(section, "n")
        if section.values.get("n_link") is not None:
            raise section.error(
                "n_link", f"expected a support on the ground, got one on node {section.values['n_link']}"
            )
        entry = _support(rotor, section, own)
        if node in supports and ("table" in entry or "table" in supports[node]):
            raise section.error("n", f"expected one support at node {node}, got another one with a table")
        before = supports.get(node, {})
        supports[node] = (
            entry
            if "table" in entry
            else {key: before.get(key, 0.0) + entry.get(key, 0.0) for key in {**before, **entry}}
        )
    return supports


def _support(rotor: ImportedRotor, section: Section, own: Coefficients) -> Entry:
    """Support from a bearing element on the ground.

    A table becomes a dynamic stiffness at the frequency of rotation.
    """
    if own.speed is None:
        return {"kxx": 0.0, "kyy": 0.0} | {name: float(values[0]) for name, values in own.columns.items() if values[0]}
    table: Entry = {"frequency": own.speed.tolist()}
    for name in ("xx", "xy", "yx", "yy"):
        table[f"re_z{name}"] = (own.columns[f"k{name}"] - own.speed**2 * own.columns[f"m{name}"]).tolist()
        table[f"im_z{name}"] = (own.speed * own.columns[f"c{name}"]).tolist()
    rotor.remark(f"{tag_of(section)}: a table of a support, taken as its dynamic stiffness: equal at 1X alone")
    return {"table": {name: values for name, values in table.items() if name in REQUIRED_MEASURED or np.any(values)}}


def _point_mass(
    rotor: ImportedRotor, section: Section, positions: Mapping[int, float], supports: dict[int, Entry]
) -> None:
    whole_mass = optional(section, "m", at_least=0)
    along_x, along_y = (
        optional(section, key, at_least=0) if section.values.get(key) is not None else whole_mass
        for key in ("mx", "my")
    )
    node = whole(section, "n")
    if node in positions and along_x == along_y:
        rotor.masses.append({"position": positions[node], "mass": along_x})
    elif node in positions:
        rotor.seals.append({"position": positions[node], "mxx": along_x, "myy": along_y, NAME: tag_of(section)})
        rotor.remark(f"{tag_of(section)}: a mass that differs in x and y, written as a seal with mxx and myy alone")
    elif node in supports:
        for key, value in (("mxx", along_x), ("myy", along_y)):
            supports[node][key] = supports[node].get(key, 0.0) + value
    else:
        raise section.error("n", f"expected a node of the shaft or of a support, got {node}; nothing else is there")


def _entry(own: Coefficients) -> Entry:
    """kxx … myy, as numbers or as a table."""
    kept = {name: values for name, values in own.columns.items() if name in DIRECT or np.any(values)}
    if own.speed is None:
        return {name: float(values[0]) for name, values in kept.items()}
    return {"table": {"speed": own.speed.tolist(), **{name: values.tolist() for name, values in kept.items()}}}


def _tell(rotor: ImportedRotor, found: Sequence[tuple[Section, Coefficients]]) -> None:
    """Remark on approximations, and list axial coefficients as left out."""
    for section, own in found:
        for remark in own.remarks:
            rotor.remark(f"{tag_of(section)}: {remark}")
    gap, how, name, tag = max(((*own.gap, tag_of(section)) for section, own in found), default=(0.0, "", "", ""))
    if gap > LEAST_GAP:
        rotor.remark(
            f"tables are interpolated by PCHIP, where ROSS takes {how}: they differ by up to {100 * gap:.2g} % of the largest"
            f" {name} ({tag})"
        )
    axial = [tag_of(section) for section, _ in found if any(_is_any(section.values.get(key)) for key in AXIAL)]
    if axial:
        rotor.left_out.append(f"axial coefficients (kzz, czz, mzz) of {', '.join(axial[:5])}: the motion is lateral")


def _is_any(value: object) -> bool:
    try:
        return bool(np.any(np.asarray(value if value is not None else 0.0, dtype=float)))
    except (TypeError, ValueError, OverflowError):
        return True

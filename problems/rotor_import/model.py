"""A rotor model of another program on its way to a rotor file.

The file's own keys in SI, remarks, and a count to compare with the drawing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from ksmea.errors import SettingError, described
from ksmea.units import RPM

DIGITS = 12  # of positions in m: rounding of summed lengths
SLOWEST, FASTEST = 100 * RPM, 30_000 * RPM  # tables over frequency may reach further
NAME = "name"  # key of an entry that no rotor file has: what the model calls it, a remark there
Entry = dict[str, Any]  # a mapping of the rotor file
OF_A_LAYER = (
    "outer_diameter",
    "inner_diameter",
    "outer_diameter_right",
    "inner_diameter_right",
    "material",
    "carries",
)
OF_THE_WHOLE = ("theory", "rotary_inertia", "gyroscopic", "standing_damping", "stiffness_outer_diameter")


@dataclass
class ImportedRotor:
    """Parts of a rotor file, as it spells them, in SI units.

    Elements hold the length of each shaft entry in file order.
    """

    source: str
    materials: dict[str, Entry] = field(default_factory=dict)
    shaft: list[Entry] = field(default_factory=list)
    disks: list[Entry] = field(default_factory=list)
    masses: list[Entry] = field(default_factory=list)
    bearings: list[Entry] = field(default_factory=list)
    seals: list[Entry] = field(default_factory=list)
    couplings: list[Entry] = field(default_factory=list)
    speeds: tuple[float, float] | None = None  # rad/s, of the model's own range
    rotation: str = ""  # as the rotor file says it; none: x to y
    remarks: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)

    def remark(self, text: str) -> None:
        """Say something once."""
        if text not in self.remarks:
            self.remarks.append(text)

    def material(self, name: str, young_modulus: float, density: float, poisson_ratio: float) -> str:
        """The name under which a material stands in the file; another one of the same name gets a number."""
        own = {"young_modulus": young_modulus, "density": density, "poisson_ratio": poisson_ratio}
        base, number = name or "material", 1
        name = base
        while name in self.materials and self.materials[name] != own:
            number += 1
            name = f"{base}_{number}"
        self.materials[name] = own
        return name


def tables_of(rotor: ImportedRotor) -> list[Mapping[str, list[float]]]:
    """All tables over speed or frequency that stand in it."""
    parts = [*rotor.bearings, *rotor.seals]
    found = (part.get("table") for part in (*parts, *(each["support"] for each in parts if "support" in each)))
    return [table for table in found if isinstance(table, dict)]


def speeds_of_tables(rotor: ImportedRotor) -> tuple[float, float] | None:
    """Speed range (rad/s) common to all tables, within speeds that machines turn at.

    None without a table or a common range.
    """
    ranges = [next(iter(table.values())) for table in tables_of(rotor)]
    if not ranges:
        return None
    low, high = max(min(each) for each in ranges), min(max(each) for each in ranges)
    low, high = max(low, SLOWEST), min(high, FASTEST)
    return (low, high) if low < high else None


def mass_of(rotor: ImportedRotor) -> float:
    """About the mass of all that turns, kg: cones by their left ends."""
    rings = [
        (entry["length"], ring)
        for entry in rotor.shaft
        for ring in (entry, *entry.get("layers", ()))
        if "material" in ring
    ]
    of_shaft = sum(
        length
        * rotor.materials[ring["material"]]["density"]
        * math.pi
        / 4
        * (ring["outer_diameter"] ** 2 - ring.get("inner_diameter", 0.0) ** 2)
        for length, ring in rings
    )
    return float(of_shaft + sum(each["mass"] for each in (*rotor.disks, *rotor.masses)))


@dataclass(frozen=True)
class ShaftElement:
    """One element of another program.

    Between which nodes it lies, and its entry in `shaft`, or in `layers` of one.
    """

    node: int
    length: float  # m
    entry: Entry


def with_shaft(rotor: ImportedRotor, elements: Sequence[ShaftElement]) -> dict[int, float]:
    """Put shaft elements into the file, elements of one node as layers of the innermost.

    Positions (m) by node, the first one at 0.
    """
    by_node: dict[int, list[ShaftElement]] = {}
    for element in elements:
        by_node.setdefault(element.node, []).append(element)
    nodes = sorted(by_node)
    if not nodes:
        raise SettingError(f"{rotor.source}: expected shaft elements, got none")
    gaps = [node for node, after in pairwise(nodes) if after != node + 1]
    if gaps:
        raise SettingError(
            f"{rotor.source}: expected shaft elements one after the other, got none at node {gaps[0] + 1}"
        )
    positions, place = {nodes[0]: 0.0}, 0.0
    for node in nodes:
        layers = by_node[node]
        lengths = {element.length for element in layers}
        if len(lengths) > 1:
            raise SettingError(
                f"{rotor.source}: expected layers of one length at node {node}, got {min(lengths):g} and {max(lengths):g} m;"
                " split the longer one"
            )
        rotor.shaft.append(_layered(rotor, layers))
        place = round(place + layers[0].length, DIGITS)
        positions[node + 1] = place
    _merge_equal(rotor)
    return positions


def _layered(rotor: ImportedRotor, elements: Sequence[ShaftElement]) -> Entry:
    """The innermost element, with the others as its layers."""
    if len(elements) == 1:
        return {"length": elements[0].length, **elements[0].entry, "elements": 1}
    node = elements[0].node
    if any("coupling" in each.entry for each in elements):
        raise SettingError(f"{rotor.source}: expected a coupling by itself at node {node}, got a layer with it")
    own, *others = sorted(
        (each.entry for each in elements),
        key=lambda entry: (entry.get("inner_diameter", 0.0), entry["outer_diameter"]),
    )
    for key in OF_THE_WHOLE:
        for other in others:
            if other.get(key) != own.get(key):
                raise SettingError(
                    f"{rotor.source}: expected {key} to be alike in all layers at node {node}, got {_told(own, key)} and"
                    f" {_told(other, key)}; make them alike"
                )
    if any(entry.get("shear_coefficient") != own.get("shear_coefficient") for entry in others):
        rotor.remark(f"layers at node {node} have Cowper's shear coefficient")
    whole = {"length": elements[0].length, **own}
    if force := sum(entry.get("axial_force", 0.0) for entry in (own, *others)):
        whole["axial_force"] = force
    hollow: list[Entry] = [{"inner_diameter": 0.0, **entry} for entry in others]
    further = [{key: entry[key] for key in OF_A_LAYER if key in entry} for entry in hollow]
    return {**whole, "layers": further, "elements": 1}


def _told(entry: Entry, key: str) -> str:
    return described(entry[key]) if key in entry else "none given"


def _merge_equal(rotor: ImportedRotor) -> None:
    """Neighbours that are alike in one entry with several elements: the nodes between them stay."""
    merged: list[Entry] = []
    for entry in rotor.shaft:
        alone = {key: value for key, value in entry.items() if key != "elements"}
        before = merged[-1] if merged else None
        if before is not None and _may_be_cut(entry) and _one_of(before) == alone:
            before["elements"] += 1
            before["length"] = round(before["elements"] * entry["length"], DIGITS)
        else:
            merged.append(dict(entry))
    rotor.shaft[:] = merged


def _may_be_cut(entry: Entry) -> bool:
    """Whether equal elements of an entry are each as the entry is: cones would become one long cone."""
    return "coupling" not in entry and not any(
        key.endswith("_right") for part in (entry, *entry.get("layers", ())) for key in part
    )


def _one_of(entry: Mapping[str, Any]) -> Entry:
    """One of the equal elements of an entry."""
    alone = {key: value for key, value in entry.items() if key != "elements"}
    return alone | {"length": round(entry["length"] / entry["elements"], DIGITS)} if entry["elements"] > 1 else alone

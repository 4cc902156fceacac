"""Bearings, seals, supports and unbalance of a rotor file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ksmea.settings.document import Block, Units, inside
from problems.rotor.finite_elements.bearing import COEFFICIENTS, DAMPINGS, MASSES, STIFFNESSES, Bearing, Pedestal
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.response.unknowns import (
    UNBALANCE_PARTS,
    BearingTarget,
    PedestalTarget,
    Target,
    UnbalanceTarget,
)
from problems.rotor_document.shaft import position_of
from problems.rotor_document.tables import RotorSheets, read_table

DIRECT = ("kxx", "kyy", "cxx", "cyy")  # what a bearing has to have; all others are none unless given
QUANTITY_OF_PART = {
    **dict.fromkeys(STIFFNESSES, "stiffness"),
    **dict.fromkeys(DAMPINGS, "damping"),
    **dict.fromkeys(MASSES, "mass"),
    "magnitude": "unbalance",
    "phase": "angle",
}


def read_bearing(
    block: Block, units: Units, shaft: Rotor, index: int, owners: Mapping[Target, str], sheets: RotorSheets
) -> Bearing:
    """One of `bearings`: kxx kyy cxx cyy are required unless an unknown sets them or a table has them."""
    return _bearing(block, units, shaft, index, owners, sheets, "bearing")


def read_seal(
    block: Block, units: Units, shaft: Rotor, index: int, owners: Mapping[Target, str], sheets: RotorSheets
) -> Bearing:
    """One of `seals`, with its index among bearings and seals: any coefficients."""
    return _bearing(block, units, shaft, index, owners, sheets, "seal")


def _bearing(
    block: Block,
    units: Units,
    shaft: Rotor,
    index: int,
    owners: Mapping[Target, str],
    sheets: RotorSheets,
    what: str,
) -> Bearing:
    targets: dict[str, Target] = {name: BearingTarget(index, name) for name in COEFFICIENTS}
    estimated = estimated_keys(block, targets, owners)
    table, columns = read_table(block, "table", units, sheets) if "table" in block.values else (None, ())
    for name in columns:
        if name in block.values:
            raise block.error(name, "expected no value, since the table has it; remove one of them")
        if name in estimated:
            raise block.error(
                "table",
                f"expected no {name} in it, since unknown {owners[targets[name]]} sets it; remove the column, or set '{name} factor'",
            )
    required = [name for name in DIRECT if what == "bearing" and name not in (*estimated, *columns)]
    block.check_keys(["position", *required], [*COEFFICIENTS, "table", *(["support"] if what == "bearing" else [])])
    position = position_of(block, units, shaft, what, needs_node=True)
    numbers: dict[str, Any] = coefficients_of(block, units)
    if "support" in block.values:
        support = block.block("support", may_be_empty=True)
        numbers["pedestal"] = _support(support, units, index, owners, sheets)
    return Bearing(position, table=table, **numbers)


def _support(block: Block, units: Units, index: int, owners: Mapping[Target, str], sheets: RotorSheets) -> Pedestal:
    parts = {name: PedestalTarget(index, name) for name in (*COEFFICIENTS, "mass")}
    estimated = estimated_keys(block, parts, owners)
    for name in ("mxx", "myy"):
        if name in block.values and ("mass" in block.values or "mass" in estimated):
            raise block.error(name, "expected either mass or mxx and myy, got both; remove one of them")
    required = [name for name in ("kxx", "kyy") if name not in estimated and "table" not in block.values]
    block.check_keys(required, [*COEFFICIENTS, "mass", "loss_factor", "table"])
    numbers: dict[str, Any] = coefficients_of(block, units)
    if "mass" in block.values:
        numbers |= dict.fromkeys(("mxx", "myy"), units.quantity(block, "mass", "mass", at_least=0))
    if "loss_factor" in block.values:
        numbers["loss_factor"] = block.number("loss_factor", at_least=0, at_most=1)
    if "table" in block.values:
        numbers["dynamic_stiffness"], _ = read_table(block, "table", units, sheets, measured=True)
    return inside(block, "", lambda: Pedestal(**numbers))


def coefficients_of(block: Block, units: Units) -> dict[str, float]:
    """Coefficients that a block gives, SI."""
    given = [name for name in COEFFICIENTS if name in block.values]
    return {name: units.quantity(block, name, QUANTITY_OF_PART[name]) for name in given}


def read_plane(block: Block, units: Units, shaft: Rotor, index: int, owners: Mapping[Target, str]) -> UnbalancePlane:
    """One of `unbalance`."""
    estimated = estimated_keys(block, {part: UnbalanceTarget(index, part) for part in UNBALANCE_PARTS}, owners)
    block.check_keys(["position", *(part for part in UNBALANCE_PARTS if part not in estimated)])
    position = position_of(block, units, shaft, "unbalance", needs_node=False)
    limits = {"magnitude": {"at_least": 0}, "phase": {}}
    given = [part for part in UNBALANCE_PARTS if part in block.values]
    return UnbalancePlane(
        position, **{part: units.quantity(block, part, QUANTITY_OF_PART[part], **limits[part]) for part in given}
    )


def estimated_keys(block: Block, targets: Mapping[str, Target], owners: Mapping[Target, str]) -> list[str]:
    """The keys of a block that an unknown sets, none of which may have a value of its own."""
    estimated = [key for key, target in targets.items() if target in owners]
    for key in estimated:
        if key in block.values:
            raise block.error(
                key, f"expected no value, since unknown {owners[targets[key]]} sets it; remove one of them"
            )
    return estimated

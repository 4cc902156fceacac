"""Materials, shaft, disks and lumped masses of a rotor file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ksmea.errors import described
from ksmea.settings.document import Block, Units, inside
from ksmea.settings.types import TRUTHS
from ksmea.units import GIGAPASCAL
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import share_elements
from problems.rotor.finite_elements.segments import (
    CARRIES,
    CouplingSegment,
    Disk,
    Layer,
    Material,
    Segment,
    ShaftSegment,
)
from problems.rotor_settings import MAX_ELEMENTS

THINNEST_WALL = 1e-6  # of the outer diameter; differences of squares lose thinner ones
LONGEST_SHAFT = 50.0  # m; more, and moduli beyond those of soft plastics and of diamond, are slips in a unit
LEAST_MODULUS, LARGEST_MODULUS = 1 * GIGAPASCAL, 1500 * GIGAPASCAL
RING = ("position", "outer_diameter", "inner_diameter", "thickness", "material")
WEIGHED = ("position", "mass", "polar_inertia", "diametral_inertia")
THEORIES = {"timoshenko": 1.0, "euler_bernoulli": 0.0}  # flexibility in shear, of Timoshenko's
PAIRS = {  # of a coupling in line, with their quantities: a number for both, or [x, y] or [left, right]
    "stiffness": "stiffness",
    "angular_stiffness": "angular_stiffness",
    "damping": "damping",
    "angular_damping": "angular_damping",
    "masses": "mass",
    "polar_inertias": "inertia",
    "diametral_inertias": "inertia",
}


def read_materials(block: Block, units: Units) -> dict[str, Material]:
    for name in block.values:
        if not isinstance(name, str):
            raise block.error("", f"expected names of materials that are texts, got {described(name)}")
    return {name: _material(block.block(name), units) for name in block.values}


def _material(block: Block, units: Units) -> Material:
    block.check_keys(("young_modulus", "density", "poisson_ratio"))
    modulus = units.quantity(block, "young_modulus", "modulus", above=0)
    if modulus > LARGEST_MODULUS:
        raise _implausible(block, modulus)
    density = units.quantity(block, "density", "density", above=0)
    return Material(modulus, density, block.number("poisson_ratio", above=-1, at_most=0.5))


def _implausible(block: Block, modulus: float) -> Exception:
    return block.error(
        "young_modulus",
        f"expected {LEAST_MODULUS / GIGAPASCAL:g} to {LARGEST_MODULUS / GIGAPASCAL:g} GPa, got {modulus / GIGAPASCAL:g}"
        " GPa, which is implausible (steel has 210); check units.modulus",
    )


def read_shaft(
    blocks: Sequence[Block], units: Units, materials: Mapping[str, Material], named: Block, mesh: int | None
) -> tuple[Segment, ...]:
    """Segments from left to right.

    `mesh` elements replace the number in the file, `named` holds the materials.
    """
    lengths = [units.quantity(block, "length", "length", above=0) for block in blocks]
    segments = [
        _coupling(block, units, length) if "coupling" in block.values else _segment(block, units, materials, length)
        for block, length in zip(blocks, lengths, strict=True)
    ]
    if sum(lengths) > LONGEST_SHAFT:
        raise blocks[0].error(
            "length",
            f"expected segments of at most {LONGEST_SHAFT:g} m together, got {sum(lengths):g} m, which is implausible; check"
            " units.length",
        )
    shafts = [segment for segment in segments if isinstance(segment, ShaftSegment)]
    if not shafts:
        raise blocks[0].error("coupling", "expected a segment of shaft next to it, got couplings only")
    _refuse_soft(shafts, materials, named)
    if mesh is None:
        return tuple(segments)
    counts = iter(share_elements(mesh - (len(segments) - len(shafts)), [segment.length for segment in shafts]))
    return tuple(
        replace(segment, n_element=next(counts)) if isinstance(segment, ShaftSegment) else segment
        for segment in segments
    )


def _refuse_soft(shafts: Sequence[ShaftSegment], materials: Mapping[str, Material], named: Block) -> None:
    """Raise `SettingError` if a material is too soft, but for sleeves.

    Sleeves are in segments that another material makes stiff.
    """
    for name, material in materials.items():
        if material.young_modulus >= LEAST_MODULUS:
            continue
        using = [each for each in shafts if material in (each.material, *(layer.material for layer in each.layers))]
        if not using or not all(map(_is_stiff, using)):
            raise _implausible(named.block(name), material.young_modulus)


def _is_stiff(segment: ShaftSegment) -> bool:
    bending = [segment.material, *(layer.material for layer in segment.layers if layer.carries != "mass")]
    return any(material.young_modulus >= LEAST_MODULUS for material in bending)


def _segment(block: Block, units: Units, materials: Mapping[str, Material], length: float) -> ShaftSegment:
    optional = (
        "inner_diameter", "outer_diameter_right", "inner_diameter_right", "stiffness_outer_diameter", "layers", "axial_force",
        "theory", "rotary_inertia", "gyroscopic", "shear_coefficient", "internal_damping", "loss_factor", "standing_damping",
    )  # fmt: skip
    block.check_keys(("length", "outer_diameter", "material", "elements"), optional)
    outer, inner = _radii(block, units)
    shear = THEORIES[block.choice("theory", "beam theory", THEORIES)] if "theory" in block.values else 1.0
    layers = block.blocks("layers") if "layers" in block.values else []
    stiffness = _optional(block, units, "stiffness_outer_diameter", "length", above=0)
    numbers: dict[str, Any] = {
        "material": _material_of(block, materials),
        "n_element": block.whole("elements", MAX_ELEMENTS),
        "inner_radius": inner,
        "shear_flexibility": shear,
        **_right_radii(block, units),
        "stiffness_outer_radius": None if stiffness is None else stiffness / 2,
        "layers": tuple(_layer(each, units, materials, shear) for each in layers),
        "shear_coefficient": _number(block, "shear_coefficient", above=0),
        "rotary_inertia": _truth(block, "rotary_inertia"),
        "gyroscopic": _truth(block, "gyroscopic"),
        "axial_force": _optional(block, units, "axial_force", "force") or 0.0,
        "internal_damping": _number(block, "internal_damping", "s", at_least=0) or 0.0,
        "loss_factor": _number(block, "loss_factor", at_least=0, at_most=1) or 0.0,
        "standing_damping": _standing(block),
    }
    return inside(block, "", lambda: ShaftSegment(length, outer, **numbers))


def _layer(block: Block, units: Units, materials: Mapping[str, Material], shear: float) -> Layer:
    optional = ("outer_diameter_right", "inner_diameter_right", "carries")
    block.check_keys(("outer_diameter", "inner_diameter", "material"), optional)
    outer, inner = _radii(block, units)
    carries = block.choice("carries", "part", CARRIES) if "carries" in block.values else "both"
    right, material = _right_radii(block, units), _material_of(block, materials)
    return inside(block, "", lambda: Layer(outer, material, inner, carries=carries, shear_flexibility=shear, **right))


def _right_radii(block: Block, units: Units) -> dict[str, Any]:
    """Radii (m) at the right end of a cone, None if they are as at the left one."""
    found = {}
    for side in ("outer", "inner"):
        diameter = _optional(block, units, f"{side}_diameter_right", "length", at_least=0)
        found[f"{side}_radius_right"] = None if diameter is None else diameter / 2
    return found


def _standing(block: Block) -> tuple[float, float]:
    """Damping on the ground in proportion to mass (1/s) and stiffness (s)."""
    if "standing_damping" not in block.values:
        return (0.0, 0.0)
    parts = block.block("standing_damping")
    parts.check_keys((), ("mass", "stiffness"))
    of_mass, of_stiffness = (
        _number(parts, key, unit, at_least=0) or 0.0 for key, unit in (("mass", "1/s"), ("stiffness", "s"))
    )
    return of_mass, of_stiffness


def _coupling(block: Block, units: Units, length: float) -> CouplingSegment:
    block.check_keys(("length", "coupling"), ["outer_diameter", "elements"])
    if "elements" in block.values and block.whole("elements", MAX_ELEMENTS) != 1:
        raise block.error("elements", f"expected 1 of a coupling, got {block.values['elements']}")
    parts = block.block("coupling")
    parts.check_keys(("stiffness", "angular_stiffness"), PAIRS)
    outer = _optional(block, units, "outer_diameter", "length", above=0) or 0.0
    given: dict[str, Any] = {key: _pair(parts, key, units, PAIRS[key]) for key in PAIRS if key in parts.values}
    return inside(block, "coupling", lambda: CouplingSegment(length, outer_radius=outer / 2, **given))


def _pair(block: Block, key: str, units: Units, quantity: str) -> tuple[float, float]:
    """One number for both, or two of them, SI."""
    value = block.values[key]
    both = value if isinstance(value, list) else [value, value]
    if len(both) != 2:
        raise block.error(key, f"expected a number or two of them, got {described(value)}")
    pair = Block(block.file, block.path, {f"{key}[{number}]": each for number, each in enumerate(both, start=1)})
    first, second = (units.quantity(pair, each, quantity, at_least=0) for each in pair.values)
    return first, second


def _optional(block: Block, units: Units, key: str, quantity: str, **limits: float) -> float | None:
    """A quantity of the file, SI; None if it is not given."""
    return units.quantity(block, key, quantity, **limits) if key in block.values else None


def _number(block: Block, key: str, unit: str = "", **limits: float) -> float | None:
    return block.number(key, unit, **limits) if key in block.values else None


def _truth(block: Block, key: str) -> bool:
    return TRUTHS[block.choice(key, "value", TRUTHS)] if key in block.values else True


def _radii(block: Block, units: Units) -> tuple[float, float]:
    """Outer and inner radius, m."""
    outer = units.quantity(block, "outer_diameter", "length", above=0)
    inner = units.quantity(block, "inner_diameter", "length", at_least=0) if "inner_diameter" in block.values else 0.0
    if inner > outer * (1 - THINNEST_WALL):
        sizes = [described(block.values[key]) for key in ("outer_diameter", "inner_diameter")]
        raise block.error("inner_diameter", f"expected less than the outer_diameter, {sizes[0]}, got {sizes[1]}")
    return outer / 2, inner / 2


def _material_of(block: Block, materials: Mapping[str, Material]) -> Material:
    return materials[block.choice("material", "material", materials)]


def read_disk(block: Block, units: Units, materials: Mapping[str, Material], shaft: Rotor) -> Disk:
    """A ring of a material, or a mass with its inertias."""
    has_mass = any(key in block.values for key in WEIGHED[1:])
    if has_mass and any(key in block.values for key in RING[1:]):
        raise block.error("", f"expected either {', '.join(RING[1:])} or {', '.join(WEIGHED[1:])}, got some of both")
    block.check_keys(WEIGHED if has_mass else RING, ["standing_damping"])
    damping = _number(block, "standing_damping", "1/s", at_least=0) or 0.0
    position = position_of(block, units, shaft, "disk", needs_node=True)
    if has_mass:
        return Disk(
            position,
            mass=units.quantity(block, "mass", "mass", above=0),
            polar_inertia=units.quantity(block, "polar_inertia", "inertia", at_least=0),
            diametral_inertia=units.quantity(block, "diametral_inertia", "inertia", at_least=0),
            standing_damping=damping,
        )
    outer, inner = _radii(block, units)
    ring = Disk.from_geometry(
        position,
        outer_radius=outer,
        inner_radius=inner,
        thickness=units.quantity(block, "thickness", "length", above=0),
        density=_material_of(block, materials).density,
    )
    return replace(ring, standing_damping=damping)


def read_mass(block: Block, units: Units, shaft: Rotor) -> Disk:
    """A lumped mass, whose inertias may be left out, or inertias alone."""
    block.check_keys(("position", "mass"), WEIGHED[2:])
    position = position_of(block, units, shaft, "lumped mass", needs_node=True)
    mass = units.quantity(block, "mass", "mass", at_least=0)
    polar, diametral = (_optional(block, units, key, "inertia", at_least=0) or 0.0 for key in WEIGHED[2:])
    return Disk(position, mass, polar, diametral, is_lumped=True)


def position_of(block: Block, units: Units, shaft: Rotor, what: str, *, needs_node: bool) -> float:
    position = units.quantity(block, "position", "length")
    check = shaft.node_at if needs_node else shaft.require_on_shaft
    inside(block, "position", lambda: check(position, what))
    return position

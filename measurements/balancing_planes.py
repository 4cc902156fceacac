"""Sizes of weights in the units of their file, and the planes that they are put on.

Radius, unit of results and holes.

    planes:
      - {position: 0.2, radius: 120 mm, holes: 12, first_angle_deg: 15, occupied: [3], most: 20 g, step: 0.5 g}

A size is a mass times a length (`2.5 oz in`), a mass at a radius (`5 g @ 120 mm`), or a mass alone. A mass alone is at the `radius` of the
plane; without one, all weights of the plane are masses at the same radius, and results are masses. With `unit: washers` or any other
word, sizes are numbers of it. Results in masses or in a unit of one's own need no radius; a rotor model does.
Holes are equally spaced from the first one in the direction of rotation, or a list of angles; they count from 1.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ksmea.errors import SettingError, shortened
from ksmea.measurement.campaign import Holes, Plane, Weight, WeightUnit
from ksmea.settings.document import Block
from ksmea.units import DEGREE, INCH, OUNCE, POUND, TURN

MASSES = {"g": 1e-3, "kg": 1.0, "mg": 1e-6, "oz": OUNCE, "lb": POUND}
LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": INCH}
NUMBER = r"(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)"
SIZE = re.compile(rf"{NUMBER} *([a-z]+)(?:[ ·*-]([a-z]+))?(?: *@ *{NUMBER} *([a-z]+))?", re.ASCII)
EXAMPLES = "2.5 oz in, 5 g @ 120 mm, or 5 g"
ANY_RADIUS = 1.0  # m, of masses at a radius that is not stated
MASS = "mass"
OWN = WeightUnit()  # whose size stands for 1 of a unit of one's own
MAX_HOLES = 360
MAX_ANGLE = 360.0  # degrees
IN_PLANE = ("position", "radius", "unit", "holes", "first_angle_deg", "occupied", "most", "step", "sizes")


@dataclass(frozen=True)
class Radius:
    """Radius of the weights in a plane, as its file writes it."""

    text: str
    metres: float


@dataclass(frozen=True)
class Stated:
    """Statements of a plane on the sizes of its weights: their radius, and a unit of the user's own."""

    radius: Radius | None = None
    own: str = ""


def read_size(block: Block, key: str, plane: Stated | None, value: object = None) -> tuple[float, WeightUnit]:
    """A size of a weight, kg m, and the unit that it is written in.

    `value`: an entry of a list instead of the key's.
    """
    given = block.values[key] if value is None else value
    plane = plane or Stated()
    text = str(given).strip() if plane.own or isinstance(given, str) else ""
    if plane.own and (in_own := re.fullmatch(rf"{NUMBER} *({re.escape(plane.own)})?", text)) and float(in_own[1]):
        return float(in_own[1]) * OWN.si, WeightUnit(plane.own, OWN.si, scale=plane.own)
    found = SIZE.fullmatch(text)
    if not found or found[2] not in MASSES or float(found[1]) == 0:
        raise block.error(
            key,
            f"expected a size above 0 such as {EXAMPLES}, got {shortened(str(given))!r}; a unit of your own needs the plane's unit",
        )
    number, mass, length, at, unit_at = found.groups()
    radius = plane.radius if at is None else _radius(block, key, f"{at} {unit_at}")
    if length is not None:
        if length not in LENGTHS or at is not None:
            raise block.error(key, f"expected a size such as {EXAMPLES}, got {shortened(str(given))!r}")
        unit = WeightUnit(f"{mass} {length}", MASSES[mass] * LENGTHS[length])
    elif radius is None:
        unit = WeightUnit(mass, MASSES[mass] * ANY_RADIUS, scale=MASS)
    else:
        unit = WeightUnit(mass, MASSES[mass] * radius.metres, radius.text)
    return float(number) * unit.si, unit


def stated(blocks: Sequence[Block]) -> dict[float, Stated]:
    """Statements of planes on the sizes of their weights, by the position of the plane, m."""
    found = {}
    for block in blocks:
        block.check_keys(["position"], IN_PLANE[1:])
        radius = _radius(block, "radius", block.text("radius")) if "radius" in block.values else None
        own = block.text("unit") if "unit" in block.values and not _is_known(block.text("unit")) else ""
        if own and not re.fullmatch(r"[^\W\d_][\w -]{0,19}", own):
            raise block.error("unit", f"expected a unit such as g, oz in or washers, got {shortened(own)!r}")
        found[block.number("position", "m")] = Stated(radius, own)
    return found


def _is_known(unit: str) -> bool:
    """Whether a unit is one of mass, mass times length, or mass at a radius."""
    found = SIZE.fullmatch(f"1 {unit.strip()}")
    return found is not None and found[2] in MASSES and (found[3] is None or found[3] in LENGTHS)


def read_planes(
    blocks: Sequence[Block], weights: Sequence[tuple[Weight, WeightUnit]], planes: Mapping[float, Stated]
) -> tuple[Plane, ...]:
    """The planes of a campaign, in the units of its weights.

    The unit of the first one in each plane, else of the first of all.
    """
    by_position = {block.number("position", "m"): block for block in blocks}
    own: dict[float, WeightUnit] = {}
    for weight, unit in weights:
        first = own.setdefault(weight.position, unit)
        if unit.scale != first.scale:
            raise _mixed(f"plane at {weight.position:g} m", first, unit)
    usual = weights[0][1] if weights else WeightUnit()
    found = []
    for position in {**own, **by_position}:
        block, unit = by_position.get(position), own.get(position, usual)
        if block is not None and "unit" in block.values:
            in_plane = read_size(block, "unit", planes.get(position), f"1 {block.text('unit')}")[1]
            if position in own and in_plane.scale != unit.scale:
                raise _mixed(block.location("unit"), unit, in_plane)
            unit = in_plane
        found.append(Plane(position, unit, None if block is None else _holes(block, planes.get(position), unit)))
    return tuple(sorted(found, key=lambda plane: plane.position))


def _mixed(where: str, one: WeightUnit, other: WeightUnit) -> SettingError:
    return SettingError(
        f"{where}: expected weights that can be compared, got some in {one} and some in {other}; give the radius of masses, or use one"
        " unit"
    )


def _radius(block: Block, key: str, text: str) -> Radius:
    found = re.fullmatch(rf"{NUMBER} *([a-z]+)", text.strip())
    if not found or found[2] not in LENGTHS or float(found[1]) == 0:
        raise block.error(key, f"expected a radius such as 120 mm or 4.5 in, got {shortened(text)!r}")
    return Radius(f"{float(found[1]):g} {found[2]}", float(found[1]) * LENGTHS[found[2]])


def _holes(block: Block, plane: Stated | None, unit: WeightUnit) -> Holes | None:
    if "holes" not in block.values:
        for key in IN_PLANE[4:]:
            if key in block.values:
                raise block.error(key, "expected holes with it, got none; give their number or their angles")
        return None
    if isinstance(block.values["holes"], list):
        if "first_angle_deg" in block.values:
            raise block.error("first_angle_deg", "expected the number of holes with it, got their angles; leave it out")
        numbers = [Block(block.file, block.path, {"holes": each}) for each in block.entries("holes")]
        angles = [each.number("holes", "deg", at_least=-MAX_ANGLE, at_most=MAX_ANGLE) * DEGREE for each in numbers]
    else:
        n, first = block.whole("holes", MAX_HOLES), 0.0
        if "first_angle_deg" in block.values:
            first = block.number("first_angle_deg", "deg", at_least=-MAX_ANGLE, at_most=MAX_ANGLE) * DEGREE
        angles = [first + TURN * number / n for number in range(n)]
    if "step" in block.values and "sizes" in block.values:
        raise block.error("step", "expected a step or the sizes that there are, got both; leave one out")
    sizes = block.entries("sizes") if "sizes" in block.values else []

    def size(key: str, value: object = None) -> float:
        found, its = read_size(block, key, plane, value)
        if its.scale != unit.scale:
            raise _mixed(block.location(key), unit, its)
        return found

    return Holes(
        tuple(angles),
        _occupied(block, len(angles)),
        size("most") if "most" in block.values else None,
        size("step") if "step" in block.values else None,
        tuple(size("sizes", each) for each in sizes),
    )


def _occupied(block: Block, n: int) -> tuple[int, ...]:
    numbers = block.values.get("occupied", [])
    if not isinstance(numbers, list) or any(type(each) is not int or not 1 <= each <= n for each in numbers):
        raise block.error("occupied", f"expected a list of holes from 1 to {n}, got {shortened(str(numbers))}")
    if len(set(numbers)) == n:
        raise block.error("occupied", f"expected a free hole, got all {n} occupied; leave one out")
    return tuple(numbers)

"""Positions of probes: `name@m@direction`, and the directions that people and instruments name.

x is to the right and y up, as the probes are looked at. An angle in degrees goes from x towards y; 45R and 45L, or '45° Right',
are angles from the vertical, as instruments give them, and say nothing without the sense of rotation. In the model the shaft turns
from x to y: of a shaft that turns clockwise the model's y is up and its x to the left, so that an angle φ becomes 180° − φ.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ksmea.errors import SettingError, shortened
from ksmea.measurement.channel import direction_at
from measurements.formats.questions import OpenQuestion

NAMED = {"x": 0.0, "h": 0.0, "hor": 0.0, "horizontal": 0.0, "y": 90.0, "v": 90.0, "ver": 90.0, "vertical": 90.0}
DEGREES = re.compile(r"([-+]?[0-9]+\.?[0-9]*)\s*(?:°|deg)?", re.ASCII)
FROM_VERTICAL = re.compile(r"([0-9]+\.?[0-9]*)\s*(?:°|deg)?\s*(r|l|right|left)", re.ASCII | re.IGNORECASE)
DECIMAL_COMMA = re.compile(r"^(\s*[-+]?[0-9]*),([0-9]+)(\s*(?:[rl]|°|deg)?\s*)$", re.ASCII | re.IGNORECASE)
LARGEST = 360.0  # degrees
FARTHEST = 1e3  # m: no shaft is as long
CLOCKWISE = "cw"


@dataclass(frozen=True)
class Place:
    """Position and direction of the probe of a name; an empty direction is taken from the file."""

    name: str
    position: float  # m
    direction: str


def places(texts: Sequence[str]) -> dict[str, Place]:
    """Probes of the setting `probes`, by name; `SettingError` for other texts or a name that stands twice.

    >>> places(["1X (VERT)@0.1@45R"])
    {'1X (VERT)': Place(name='1X (VERT)', position=0.1, direction='45R')}
    """
    found: dict[str, Place] = {}
    for text in texts:
        parts = text.rsplit("@", 2)
        if len(parts) == 3 and not _is_number(parts[1]):  # the name has an @
            parts = text.rsplit("@", 1)
        if (meant := _with_points(text)) != text:
            raise SettingError(
                f"probes: expected a decimal point, got a comma in {shortened(repr(text))}; write {shortened(meant)}"
            )
        if len(parts) < 2 or not _is_number(parts[1]) or not 0 <= float(parts[1]) <= FARTHEST:
            raise SettingError(
                f"probes: expected name@m@direction, such as 1X@0.1@x, got {shortened(repr(text))}; m is from the left end"
            )
        name = parts[0].strip()
        if name in found:
            raise SettingError(f"probes: expected each name once, got {shortened(repr(name))} twice; remove one")
        found[name] = Place(name, float(parts[1]), parts[2].strip() if len(parts) > 2 else "")
    return found


def model_direction(text: str, rotation: str | None, what: str) -> str:
    """The model's direction (`ksmea.measurement.channel`) of a probe that a text describes.

    `what` names it in errors.
    """
    vertical = FROM_VERTICAL.fullmatch(text.strip())
    if vertical and rotation is None:
        raise OpenQuestion(
            f"{what}: expected the sense of rotation with the angle {text} from the vertical, got none; give rotation=ccw or cw",
            "rotation",
            ("CCW_OR_CW",),
            "ccw",
        )
    angle = _angle(text)
    if angle is None or abs(angle) > LARGEST:
        raise SettingError(
            f"{what}: expected a direction x, y, H, V, degrees from x towards y, or 45R or 45L from the vertical, got"
            f" {shortened(repr(text)) if text else 'none'}; give it in probes=[name@m@direction]"
        )
    return direction_at(180.0 - angle if rotation == CLOCKWISE else angle)


def _angle(text: str) -> float | None:
    """Degrees from x to the right towards y up."""
    text = text.strip()
    if text.lower() in NAMED:
        return NAMED[text.lower()]
    if found := FROM_VERTICAL.fullmatch(text):
        degrees = float(found[1])
        return 90.0 - degrees if found[2].lower().startswith("r") else 90.0 + degrees
    if found := DEGREES.fullmatch(text):
        return float(found[1])
    return None


def _with_points(text: str) -> str:
    """A probe with decimal points where its place, or its direction in degrees, has a comma.

    >>> _with_points("1,5X@0,1@-22,5"), _with_points("X@0.1@45R")
    ('1,5X@0.1@-22.5', 'X@0.1@45R')
    """
    name, *numbers = text.rsplit("@", 2)
    return "@".join([name, *(DECIMAL_COMMA.sub(r"\1.\2\3", each) for each in numbers)])


def _is_number(text: str) -> bool:
    return re.fullmatch(r"[0-9]+\.?[0-9]*|\.[0-9]+", text.strip(), re.ASCII) is not None

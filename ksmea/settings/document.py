"""Checked reading of a document of mappings and lists; every error names the location in the file.

Entries of a list are counted from 1, as the disks on a shaft are. By hand, not by msgspec: an error there is one sentence without the
value that came, its unit or the nearest key, and does not know units that the file itself chooses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from ksmea.errors import SettingError, described, shortened, unknown
from ksmea.settings.settings import expected_range
from ksmea.units import SI_PER_UNIT, Unit

# Range of each quantity, SI: no rotor comes near these sizes, and formulas neither overflow nor lose them.
# Smaller than the first is 0 or a slip, larger than the second a slip or another unit.
PLAUSIBLE = {
    "length": (1e-9, 1e4),  # m
    "modulus": (1e3, 1e15),  # Pa
    "density": (1e-3, 1e6),  # kg/m³
    "mass": (1e-12, 1e9),  # kg
    "inertia": (1e-18, 1e12),  # kg m²
    "stiffness": (1e-9, 1e18),  # N/m
    "damping": (1e-12, 1e15),  # N s/m
    "force": (1e-9, 1e12),  # N
    "angular_stiffness": (1e-9, 1e18),  # N m/rad
    "angular_damping": (1e-12, 1e15),  # N m s/rad
    "unbalance": (1e-18, 1e6),  # kg m
    "angle": (1e-15, 1e6),  # rad
    "speed": (1e-6, 1e6),  # rad/s
}


@dataclass(frozen=True)
class Block:
    """A mapping in a file, its location in it, and the units of the file."""

    file: str
    path: str  # "disks[2]"; empty for the document itself
    values: dict[Any, Any]

    @classmethod
    def of_document(cls, file: str, document: Any, what: str = "the rotor's description") -> Block:
        if not isinstance(document, dict) or not document:
            raise SettingError(f"{file}: expected a mapping with {what}, got {described(document)}")
        return cls(file, "", document)

    def location(self, key: str = "") -> str:
        return f"{self.file}: {self._path(key)}" if self._path(key) else self.file

    def error(self, key: str, message: object) -> SettingError:
        return SettingError(f"{self.location(key)}: {message}")

    def check_keys(self, required: Iterable[str], optional: Iterable[str] = ()) -> None:
        """Unknown keys first: a misspelt key is also a missing one."""
        required = list(required)
        known = list(dict.fromkeys([*required, *optional]))
        for key in self.values:
            if key not in known:
                raise self.error("", unknown("key", shortened(str(key)), known))
        for key in required:
            if key not in self.values:
                raise self.error(key, "expected a value, got nothing; add it")

    def number(
        self,
        key: str,
        unit: str = "",
        *,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
    ) -> float:
        value: Any = self.values.get(key)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if (
            not is_number
            or not math.isfinite(_as_float(value))
            or (above is not None and value <= above)
            or (at_least is not None and value < at_least)
            or (at_most is not None and value > at_most)
        ):
            limits = expected_range({"above": above, "at_least": at_least, "at_most": at_most})
            expected = " ".join(word for word in ("a number", limits, f"({unit})" if unit else "") if word)
            raise self.error(key, f"expected {expected}, got {described(value)}")
        return float(value)

    def whole(self, key: str, at_most: int) -> int:
        value = self.values.get(key)
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= at_most:
            raise self.error(key, f"expected a whole number from 1 to {at_most}, got {described(value)}")
        return value

    def text(self, key: str) -> str:
        value = self.values.get(key)
        if not isinstance(value, str) or not value:
            raise self.error(key, f"expected a text, got {described(value)}")
        return value

    def choice(self, key: str, noun: str, known: Iterable[str]) -> str:
        text = self.text(key)
        known = list(known)
        if text not in known:
            raise self.error(key, unknown(noun, shortened(text), known))
        return text

    def block(self, key: str, *, may_be_empty: bool = False) -> Block:
        value = self.values.get(key)
        return Block(self.file, self._path(key), {}) if may_be_empty and value == {} else self._block(key, value)

    def blocks(self, key: str) -> list[Block]:
        """The mappings of a list, at least one."""
        return [self._block(f"{key}[{number}]", value) for number, value in enumerate(self.entries(key), start=1)]

    def entries(self, key: str) -> list[Any]:
        value = self.values.get(key)
        if not isinstance(value, list) or not value:
            raise self.error(key, f"expected a list with at least one entry, got {described(value)}")
        return value

    def _block(self, key: str, value: Any) -> Block:
        if not isinstance(value, dict) or not value:
            raise self.error(key, f"expected a mapping (key: value), got {described(value)}")
        return Block(self.file, self._path(key), value)

    def _path(self, key: str) -> str:
        return ".".join(part for part in (self.path, shortened(key)) if part)


@dataclass(frozen=True)
class Units:
    """The header of a file that says once which unit each quantity has; requested only where it is needed."""

    header: Block

    @classmethod
    def of(cls, header: Block) -> Units:
        header.check_keys((), SI_PER_UNIT)
        for quantity in header.values:
            header.choice(quantity, f"unit of {quantity}", SI_PER_UNIT[quantity])
        return cls(header)

    def unit(self, quantity: str) -> Unit:
        if quantity not in self.header.values:
            known = ", ".join(SI_PER_UNIT[quantity])
            raise self.header.error(
                quantity, f"expected the unit of every {quantity} in the file, got nothing; known: {known}"
            )
        name = self.header.values[quantity]
        return Unit(name, SI_PER_UNIT[quantity][name])

    def value(self, block: Block, key: str, quantity: str, **limits: float) -> float:
        """A number in the file's unit, as the limits are; `SettingError` also where no rotor has such a size."""
        unit = self.unit(quantity)
        value = block.number(key, unit.name, **limits)
        smallest, largest = (limit / unit.si for limit in PLAUSIBLE[quantity])
        if value and not smallest <= abs(value) <= largest:
            raise block.error(
                key,
                f"expected a {quantity} between {smallest:.3g} and {largest:.3g} {unit.name} in size, got {value:g};"
                " check it and its unit",
            )
        return value

    def quantity(self, block: Block, key: str, quantity: str, **limits: float) -> float:
        """A number of the file in SI; the limits are in the file's unit."""
        return self.value(block, key, quantity, **limits) * self.unit(quantity).si


def inside(block: Block, key: str, make: Callable[[], Any]) -> Any:
    """Result of `make`; its `SettingError` is preceded by the location in the file."""
    try:
        return make()
    except SettingError as error:
        raise block.error(key, error) from error


def _as_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # a whole number beyond 1e308
        return math.inf

"""Numbers of a rotor file that are not exact.

`{value: 206, sd: 4}`, `{value: 9, sd: 1 %}`, `{value: 1, lower: 0.5, upper: 2}`.

They are taken out of the document before it is read, which then has plain numbers in their places.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from ksmea.errors import described
from ksmea.settings.document import Block

KEYS = ("value", "sd", "lower", "upper")
NOT_HERE = ("units", "unknowns", "speeds", "tolerances")  # keys of the document whose mappings are something else
PERCENT = re.compile(r"\s*([0-9.eE+-]+)\s*%\s*")

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class StatedNumber:
    """A number that is not exact, in the unit of the file.

    `sd` None without a tolerance, `limits` None if it is not searched.
    """

    block: Block  # the map itself
    path: Path  # ("disks", 1, "mass")
    value: Any  # a number, or x and y of a direction
    sd: float | None
    limits: tuple[float, float] | None

    @property
    def key(self) -> str:
        return str(self.path[-1])


def split(document: Block) -> tuple[Block, list[StatedNumber]]:
    """A document with plain numbers, and its numbers that are not exact."""
    found: list[StatedNumber] = []
    values = {
        key: value if key in NOT_HERE else _plain(document, (key,), value, found)
        for key, value in document.values.items()
    }
    return replace(document, values=values), found


def _plain(document: Block, path: Path, value: Any, found: list[StatedNumber]) -> Any:
    if isinstance(value, list):
        return [_plain(document, (*path, index), each, found) for index, each in enumerate(value)]
    if not isinstance(value, dict):
        return value
    if "value" in value and len(path) > 1:
        stated = _stated(Block(document.file, _shown(path), value), path)
        found.append(stated)
        return stated.value
    return {key: _plain(document, (*path, key), each, found) for key, each in value.items()}


def _stated(block: Block, path: Path) -> StatedNumber:
    block.check_keys(("value",), KEYS[1:])
    value = block.values["value"]
    if path[-1] != "direction" or not isinstance(value, str):
        value = block.number("value")
    has_limits = [key for key in ("lower", "upper") if key in block.values]
    limits = None
    if has_limits:
        lower = block.number("lower")
        limits = (lower, block.number("upper", above=lower))
        block.number("value", at_least=limits[0], at_most=limits[1])
    if "sd" not in block.values and limits is None:
        raise block.error(
            "sd",
            "expected a standard deviation, or lower and upper limits, got nothing; give a plain number if it is exact",
        )
    return StatedNumber(block, path, value, deviation(block, "sd", value) if "sd" in block.values else None, limits)


def deviation(block: Block, key: str, value: Any) -> float:
    """A standard deviation in the unit of its number: given so, or in per cent of it."""
    given = block.values[key]
    if isinstance(given, str):
        part = PERCENT.fullmatch(given)
        if part is None or isinstance(value, str) or not value:
            raise block.error(
                key, f"expected a number, or per cent such as '2 %' of a value that is not 0, got {described(given)}"
            )
        try:
            of_value = float(part[1])
        except ValueError:
            raise block.error(key, f"expected a number before %, got {described(given)}") from None
        if not 0 <= of_value <= 100:
            raise block.error(key, f"expected 0 to 100 %, got {described(given)}")
        return of_value / 100 * abs(float(value))
    return block.number(key, at_least=0)


def _shown(path: Path) -> str:
    """Path of a number in errors, such as disks[2].mass."""
    return "".join(_steps(path)).removeprefix(".")


def _steps(path: Path) -> Iterator[str]:
    for step in path:
        yield f"[{step + 1}]" if isinstance(step, int) else f".{step}"

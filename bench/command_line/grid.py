"""An experiment's grid: which lines it has, and the points that they stand for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any

from bench.command_line.plugin_settings import short
from ksmea.errors import SettingError, unknown

LABEL = "label"
MOST_LINES = 100_000

Block = dict[str, Any]  # {setting or group: value or values}


def grid_blocks(grid: Sequence[Block], add: Sequence[Block], cross: Sequence[Block]) -> list[Block]:
    """Cross every line of a grid, and every added line, with every block of `cross`.

    A line's own values take precedence.

    >>> grid_blocks([{"label": "DE"}], [{"label": "Mine"}], [{"seed": [1, 2]}])
    [{'label': 'DE', 'seed': [1, 2]}, {'label': 'Mine', 'seed': [1, 2]}]
    """
    lines = [*grid, *add] or [{}]
    if (n := len(lines) * len(cross or [{}])) > MOST_LINES:
        raise SettingError(
            f"expected at most {MOST_LINES} lines of a grid with cross, got {n}; give lists of values", setting="grid"
        )
    return [
        line | {key: value for key, value in block.items() if key not in line}
        for line in lines
        for block in cross or [{}]
    ]


def labelled(blocks: Sequence[Block], chosen: Sequence[Any]) -> list[Block]:
    """The blocks of these labels alone, in the grid's order.

    Raises `SettingError` if it has no line of that label.
    """
    known = list(dict.fromkeys(str(label) for block in blocks for label in listed(block.get(LABEL, ()))))
    for label in chosen:
        if not known:
            raise SettingError(
                f"{LABEL}: expected an experiment whose grid has labels, got {LABEL}={label}; leave it out"
            )
        if str(label) not in known:
            raise unknown(LABEL, str(label), known)
    names = {str(label) for label in chosen}
    kept = [block | {LABEL: [each for each in listed(block.get(LABEL, ())) if str(each) in names]} for block in blocks]
    return [block for block in kept if block[LABEL]]


def grid_points(grid: Sequence[Block], swept: Mapping[str, tuple[Any, ...]], fixed: set[str]) -> list[dict[str, Any]]:
    """The points of an experiment.

    The product inside each block, the union of the blocks, each point once.

    A key that the command line fixes leaves the grid, also where the grid names the plugin; one that it sweeps replaces that
    axis in every block.

    >>> grid_points([{"samples": [40, 70]}], {"optimizer": ("de", "pso")}, {"samples"})
    [{'optimizer': 'de'}, {'optimizer': 'pso'}]
    """
    every = (dict(zip(axes, values)) for axes in grid_axes(grid, swept, fixed) for values in product(*axes.values()))
    return each_once(every)


def n_point(grid: Sequence[Block], swept: Mapping[str, tuple[Any, ...]], fixed: set[str]) -> int:
    """Number of points of a grid, with repeated ones.

    >>> n_point([{"samples": [40, 70]}], {"optimizer": ("de", "pso")}, set())
    4
    """
    return sum(prod(map(len, axes.values())) for axes in grid_axes(grid, swept, fixed))


def each_once(points: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Unique points, in the order of their first occurrence."""
    known: dict[Any, dict[str, Any]] = {}
    for point in points:
        known.setdefault(_hashable(point), point)
    return list(known.values())


def _hashable(value: Any) -> Any:
    """A value of a grid as what is equal where the value is."""
    if isinstance(value, Mapping):
        return frozenset((key, _hashable(each)) for key, each in value.items())
    return tuple(map(_hashable, value)) if isinstance(value, (list, tuple)) else value


def grid_axes(
    grid: Sequence[Block], swept: Mapping[str, tuple[Any, ...]], fixed: set[str]
) -> Iterator[dict[str, tuple[Any, ...]]]:
    """The axes of each block with their values."""
    for block in grid or [{}]:
        left = {key: listed(value) for key, value in block.items() if fixed.isdisjoint((key, short(key)))}
        yield {key: values for key, values in left.items() if key in swept or short(key) not in swept} | dict(swept)


def listed(value: Any) -> tuple[Any, ...]:
    """One value or several, as several."""
    return tuple(value) if isinstance(value, (list, tuple)) else (value,)

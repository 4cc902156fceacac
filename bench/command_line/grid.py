"""An experiment's grid: which lines it has, and the points that they stand for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

from bench.command_line.plugin_settings import short
from ksmea.errors import SettingError, unknown

LABEL = "label"

Block = dict[str, Any]  # {setting or group: value or values}


def grid_blocks(grid: Sequence[Block], add: Sequence[Block], cross: Sequence[Block]) -> list[Block]:
    """The lines of a grid and those that are added to it, each crossed with every block of `cross`; what a line says itself
    counts.

    >>> grid_blocks([{"label": "DE"}], [{"label": "Mine"}], [{"seed": [1, 2]}])
    [{'label': 'DE', 'seed': [1, 2]}, {'label': 'Mine', 'seed': [1, 2]}]
    """
    lines = [*grid, *add] or [{}]
    return [
        line | {key: value for key, value in block.items() if key not in line}
        for line in lines
        for block in cross or [{}]
    ]


def labelled(blocks: Sequence[Block], chosen: Sequence[Any]) -> list[Block]:
    """The blocks of these labels alone, in the grid's order; `SettingError` where it has no line of that label."""
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
    """The points of an experiment: the product inside each block, the union of the blocks, each point once.

    A key that the command line fixes leaves the grid, also where the grid names the plugin; one that it sweeps replaces that
    axis in every block.

    >>> grid_points([{"samples": [40, 70]}], {"optimizer": ("de", "pso")}, {"samples"})
    [{'optimizer': 'de'}, {'optimizer': 'pso'}]
    """
    points: list[dict[str, Any]] = []
    for block in grid or [{}]:
        left = {key: listed(value) for key, value in block.items() if fixed.isdisjoint((key, short(key)))}
        axes = {key: values for key, values in left.items() if key in swept or short(key) not in swept} | dict(swept)
        for values in product(*axes.values()):
            point = dict(zip(axes, values))
            if point not in points:
                points.append(point)
    return points


def listed(value: Any) -> tuple[Any, ...]:
    """One value or several, as several."""
    return tuple(value) if isinstance(value, (list, tuple)) else (value,)

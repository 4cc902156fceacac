"""Places of numbers in a rotor, by fields and indices, and the rotor with other numbers there.

>>> Place(("disks", 0, "mass"))  # of the first disk
Place(path=('disks', 0, 'mass'), scale=1.0)
>>> Place(("segments", 2, "outer_radius"), scale=0.5)  # of a number that is a diameter
Place(path=('segments', 2, 'outer_radius'), scale=0.5)
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material, RingSize, ShaftSegment

Step = str | int
MAX_KEPT = 512  # parts with changes: of one number after the other, all others are as they were


@dataclass(frozen=True)
class Place:
    """One number of a rotor; `scale` is how much it changes per unit of the number that changes it."""

    path: tuple[Step, ...]
    scale: float = 1.0


def with_changes(rotor: Rotor, changes: Iterable[tuple[Place, float]]) -> Rotor:
    """The rotor with changes (SI) added to its numbers at these places.

    A ring that changes brings along mass and inertias of its disk, before these are changed themselves. Parts without a
    change stay the same objects.
    """
    of_parts: dict[tuple[Step, ...], dict[tuple[Step, ...], float]] = {}
    for place, change in changes:
        if change:
            own = of_parts.setdefault(place.path[:2], {})
            own[place.path[2:]] = own.get(place.path[2:], 0.0) + place.scale * change
    new: dict[str, Any] = {}
    for (field, *index), own in of_parts.items():
        name = str(field)
        value = new.get(name, getattr(rotor, name))
        if index:
            [part] = index
            value = (*value[:part], _changed(value[part], tuple(own.items())), *value[int(part) + 1 :])
        else:
            value = value + own[()]
        new[name] = value
    return dataclasses.replace(rotor, **new) if new else rotor


def material_paths(rotor: Rotor) -> Iterator[tuple[tuple[Step, ...], Material]]:
    """The materials of a rotor's segments and of their layers, with their paths."""
    for index, segment in enumerate(rotor.segments):
        if isinstance(segment, ShaftSegment):
            yield ("segments", index, "material"), segment.material
            for layer, each in enumerate(segment.layers):
                yield ("segments", index, "layers", layer, "material"), each.material


@lru_cache(maxsize=MAX_KEPT)
def _changed(part: Any, changes: tuple[tuple[tuple[Step, ...], float], ...]) -> Any:
    """A part of a rotor with changes added to its numbers.

    They are named by fields and indices within it.
    """
    tree: dict[Step, Any] = {}
    for path, change in changes:
        branch = tree
        for step in path[:-1]:
            branch = branch.setdefault(step, {})
        branch[path[-1]] = change
    return _grown(part, tree)


def _grown(part: Any, tree: dict[Step, Any]) -> Any:
    """A part with the changes of a tree of fields and indices added."""
    if not isinstance(tree, dict):
        return part + tree
    if isinstance(part, tuple):
        return tuple(_grown(each, tree[index]) if index in tree else each for index, each in enumerate(part))
    if isinstance(part, Disk) and isinstance(part.ring, RingSize) and "ring" in tree:
        part = part.resized(_grown(part.ring, tree["ring"]))
        tree = {step: branch for step, branch in tree.items() if step != "ring"}
    new: dict[Any, Any] = {step: _grown(getattr(part, str(step)), branch) for step, branch in tree.items()}
    return dataclasses.replace(part, **new) if new else part

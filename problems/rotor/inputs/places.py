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
from typing import Any

from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material, RingSize, ShaftSegment

Step = str | int


@dataclass(frozen=True)
class Place:
    """One number of a rotor; `scale` is how much it changes per unit of the number that changes it."""

    path: tuple[Step, ...]
    scale: float = 1.0


def with_changes(rotor: Rotor, changes: Iterable[tuple[Place, float]]) -> Rotor:
    """The rotor with changes (SI) added to its numbers at these places.

    A ring that changes brings along mass and inertias of its disk, before these are changed themselves.
    """
    tree: dict[Step, Any] = {}
    for place, change in changes:
        if change:
            branch = tree
            for step in place.path[:-1]:
                branch = branch.setdefault(step, {})
            branch[place.path[-1]] = branch.get(place.path[-1], 0.0) + place.scale * change
    changed: Rotor = _changed(rotor, tree)
    return changed


def material_paths(rotor: Rotor) -> Iterator[tuple[tuple[Step, ...], Material]]:
    """The materials of a rotor's segments and of their layers, with their paths."""
    for index, segment in enumerate(rotor.segments):
        if isinstance(segment, ShaftSegment):
            yield ("segments", index, "material"), segment.material
            for layer, each in enumerate(segment.layers):
                yield ("segments", index, "layers", layer, "material"), each.material


def _changed(part: Any, tree: dict[Step, Any]) -> Any:
    """A part with the changes of a tree of fields and indices added."""
    if not isinstance(tree, dict):
        return part + tree
    if isinstance(part, tuple):
        return tuple(_changed(each, tree[index]) if index in tree else each for index, each in enumerate(part))
    if isinstance(part, Disk) and isinstance(part.ring, RingSize) and "ring" in tree:
        part = part.resized(_changed(part.ring, tree["ring"]))
        tree = {step: branch for step, branch in tree.items() if step != "ring"}
    new: dict[Any, Any] = {step: _changed(getattr(part, str(step)), branch) for step, branch in tree.items()}
    return dataclasses.replace(part, **new) if new else part

"""The impedances that the unknowns of a rotor set, for surrogates that use how a response depends on them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence

from ksmea.response_structure import UnknownImpedance
from problems.rotor.data import DAMPINGS, STIFFNESSES
from problems.rotor.unknowns import BearingTarget, Unknown


def unknown_impedances(unknowns: Sequence[Unknown]) -> tuple[UnknownImpedance, ...]:
    """Each pair of an unknown stiffness and damping that entries of bearings are set by, or the one of them that is unknown, with
    the number of these entries."""
    setters: dict[tuple[int, int], list[str]] = defaultdict(
        lambda: ["", ""]
    )  # by bearing and place in its 2 × 2 matrix
    for item in unknowns:
        for target in item.targets:
            if isinstance(target, BearingTarget):
                for part, names in enumerate((STIFFNESSES, DAMPINGS)):
                    if target.coefficient in names:
                        setters[target.bearing, names.index(target.coefficient)][part] = item.parameter.name
    pairs = Counter((stiffness, damping) for stiffness, damping in setters.values())
    return tuple(UnknownImpedance(*pair, n_port) for pair, n_port in pairs.items())

"""Checks of unknowns: each points at a number that the rotor has, and no two at one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.errors import SettingError
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.unknowns import (
    BearingTarget,
    OriginTarget,
    PedestalTarget,
    Target,
    UnbalanceTarget,
    Unknown,
)


def check_unknowns(rotor: Rotor, unknowns: Sequence[Unknown]) -> None:
    """Raise `SettingError` if an unknown points at nothing, or two point at the same number."""
    owner: dict[object, str] = {}
    for item in unknowns:
        name = item.parameter.name
        if not item.targets:
            raise SettingError(f"unknown {name}: expected at least one target, got none")
        for target in item.targets:
            _check_target(rotor, name, target)
            for number in numbers_set_by(target):
                if number in owner:
                    raise SettingError(
                        f"unknown {name}: {target} is already set by {owner[number]}; tie them in one unknown"
                    )
                owner[number] = name


def numbers_set_by(target: Target) -> list[object]:
    """Which numbers of a rotor it sets: a factor on all of K sets those on its four columns."""
    if isinstance(target, BearingTarget):
        return [(target.bearing, target.is_factor, column) for column in target.columns]
    if isinstance(target, PedestalTarget):
        return [(target.bearing, "pedestal", column) for column in target.columns]
    return [target]


def _check_target(rotor: Rotor, name: str, target: Target) -> None:
    if isinstance(target, OriginTarget):
        return
    if isinstance(target, UnbalanceTarget):
        thing, index, count = "unbalance plane", target.plane, len(rotor.unbalance)
    else:
        thing, index, count = "bearing", target.bearing, len(rotor.supported)
    if not 0 <= index < count:
        raise SettingError(f"unknown {name}: expected a {thing} from 0 to {count - 1}, got {index}")
    if isinstance(target, BearingTarget) and target.is_factor and rotor.supported[index].table is None:
        raise SettingError(
            f"unknown {name}: expected a bearing with a table for a {target.coefficient.replace('_', ' ')}, got"
            f" bearing {index + 1} without one; set a coefficient, or give it a table"
        )
    if isinstance(target, BearingTarget) and target.is_factor and not _has_column(rotor.supported[index], target):
        raise SettingError(
            f"unknown {name}: expected a table with more than zeros for a {target.coefficient.replace('_', ' ')}, got none; name"
            " a column that it has"
        )
    if isinstance(target, PedestalTarget) and rotor.supported[index].pedestal is None:
        raise SettingError(f"unknown {name}: expected a bearing with a support, got bearing {index + 1} without one")


def _has_column(bearing: Bearing, target: BearingTarget) -> bool:
    """Whether the table of a bearing has anything that a factor would change."""
    return bearing.table is not None and bool(np.any(np.array(bearing.table.rows)[:, list(target.columns)]))

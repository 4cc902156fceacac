"""Probes, given as positions and directions, made into channels."""

from __future__ import annotations

from collections.abc import Sequence

from ksmea.channel import Channel, require_direction
from ksmea.errors import SettingError


def check_probes(sensors: Sequence[float], directions: Sequence[str]) -> None:
    """Raise `SettingError` where a list is empty, holds an entry twice or a direction that is none."""
    for name, entries in (("sensors", sensors), ("directions", directions)):
        if not entries or len(set(entries)) < len(entries):
            raise SettingError(f"{name}: expected at least one entry and none twice, got {list(entries)}")
    for direction in directions:
        try:
            require_direction(direction)
        except SettingError as error:
            raise SettingError(str(error).replace("direction", "directions", 1)) from error


def channels_of(sensors: Sequence[float], directions: Sequence[str]) -> tuple[Channel, ...]:
    """Every probe (m) in every direction, probe by probe."""
    return tuple(Channel(position, direction) for position in sensors for direction in directions)

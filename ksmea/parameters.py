"""Unknown parameters with their units and limits: the one door between SI, engineering units and the unit cube."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.units import SI_PER_UNIT, TURN

PHASE_ORIGIN = "phase_origin"  # name of the unknown that measured phases bring along: it turns all data alike


@dataclass(frozen=True)
class Parameter:
    """One unknown: `unit` is what people read, `si_per_unit` its size in SI; the limits are in SI."""

    name: str
    unit: str
    si_per_unit: float
    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.lower) and np.isfinite(self.upper) and self.lower < self.upper):
            raise SettingError(
                f"limits of {self.name}: expected lower < upper, got"
                f" [{self.lower / self.si_per_unit:g}, {self.upper / self.si_per_unit:g}] {self.unit}; swap or widen them"
            )

    @property
    def is_full_turn(self) -> bool:
        """Whether it is an angle whose limits hold a turn or more: values a turn apart are the same."""
        return self.unit in SI_PER_UNIT["angle"] and self.upper - self.lower >= TURN * (1 - 1e-9)

    def turned(self, value: float) -> float:
        """The value; of an angle that may be any, the one of its turns that lies between −180° and 180°."""
        return float(value - TURN * np.ceil(value / TURN - 0.5)) if self.is_full_turn else value

    @property
    def is_unbalance(self) -> bool:
        """Whether it is the magnitude of an unbalance."""
        return self.unit in SI_PER_UNIT["unbalance"] and self.lower >= 0


@dataclass(frozen=True)
class Parameters:
    """The unknowns of a problem, in the order of every parameter vector."""

    items: tuple[Parameter, ...]

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self.items)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(parameter.name for parameter in self.items)

    @property
    def lower(self) -> Array:  # (d,) SI
        return np.array([parameter.lower for parameter in self.items])

    @property
    def upper(self) -> Array:  # (d,) SI
        return np.array([parameter.upper for parameter in self.items])

    @property
    def width(self) -> Array:  # (d,) SI
        return self.upper - self.lower

    @property
    def si_per_unit(self) -> Array:  # (d,)
        return np.array([parameter.si_per_unit for parameter in self.items])

    def to_si(self, u: Array) -> Array:
        """Unit cube (…, d) to SI."""
        return self.lower + np.asarray(u) * self.width

    def to_cube(self, x: Array) -> Array:
        """SI (…, d) to the unit cube."""
        return (np.asarray(x) - self.lower) / self.width

    def in_units(self, x: Array) -> Array:
        """SI (…, d) to the units people read."""
        return np.asarray(x) / self.si_per_unit

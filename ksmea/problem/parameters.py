"""Unknown parameters with units and limits: the one conversion between SI, engineering units and the unit cube."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.errors import SettingError
from ksmea.units import SI_PER_UNIT, TURN

PHASE_ORIGIN = "phase_origin"  # name of the unknown that measured phases bring along: it turns all data alike


def name_at(name: str, place: str) -> str:
    """The name of an unknown that is apart from others of its name by its place, as one word: settings are given by it.

    >>> name_at("runout_x", "at 0.5 m")
    'runout_x_at_0_5_m'
    """
    return "_".join([name, *re.findall(r"\w+", place)])


SEEN = 0.98  # of a prior's standard deviation: numbers that are known less well afterwards are not seen by the data


@dataclass(frozen=True)
class Prior:
    """The Gaussian distribution of a number before any measurement, SI: as drawings, catalogues and calibrations state it."""

    value: float
    sd: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.value) and 0 < self.sd < np.inf):
            raise SettingError(
                f"prior: expected a finite value and a standard deviation above 0, got {self.value:g} ± {self.sd:g}"
            )


@dataclass(frozen=True)
class Parameter:
    """One unknown: `unit` is what people read, `si_per_unit` its size in SI; the limits are in SI. `makes_jumps` says whether the
    response may jump as it changes, as where a resonance curve folds over. `words` name it for people; '': its name does."""

    name: str
    unit: str
    si_per_unit: float
    lower: float
    upper: float
    makes_jumps: bool = False
    prior: Prior | None = None
    words: str = ""
    is_input: bool = False  # a number of the model that is known to a tolerance, which searches take as stated

    def __post_init__(self) -> None:
        if not (np.isfinite(self.lower) and np.isfinite(self.upper) and self.lower < self.upper):
            raise SettingError(
                f"limits of {self.name}: expected lower < upper, got"
                f" [{self.lower / self.si_per_unit:g}, {self.upper / self.si_per_unit:g}] {self.unit}; swap or widen them"
            )

    @property
    def stated(self) -> float:
        """The value of its prior, SI; without one the middle of its limits."""
        return (self.lower + self.upper) / 2 if self.prior is None else self.prior.value

    @property
    def is_angle(self) -> bool:
        """Whether its unit is one of angles."""
        return self.unit in SI_PER_UNIT["angle"]

    @property
    def is_full_turn(self) -> bool:
        """Whether it is an angle whose limits hold a turn or more: values a turn apart are the same."""
        return self.is_angle and self.upper - self.lower >= TURN * (1 - 1e-9)

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

    @cached_property
    def own(self) -> Indices:
        """Indices of the unknowns but for numbers known to a tolerance."""
        return np.flatnonzero([not parameter.is_input for parameter in self.items])

    @cached_property
    def with_prior(self) -> Indices:
        """Indices of the unknowns that have a prior."""
        return np.flatnonzero([parameter.prior is not None for parameter in self.items])

    @cached_property
    def priors(self) -> tuple[Array, Array]:
        """Value and standard deviation (n_prior,) of these, in the unit cube."""
        found = [(item, item.prior) for item in self.items if item.prior is not None]
        value = [(prior.value - item.lower) / (item.upper - item.lower) for item, prior in found]
        return np.array(value), np.array([prior.sd / (item.upper - item.lower) for item, prior in found])

    def off_priors(self, u: Array) -> Array:
        """Deviations of points (…, ≥ d) of the unit cube from the priors, in standard deviations, (…, n_prior)."""
        value, sd = self.priors
        return (u[..., self.with_prior] - value) / sd

    @property
    def period(self) -> Array:
        """How far apart in the unit cube values of an unknown are the same (d,): a turn where it is free to turn, else infinite."""
        return np.array([TURN / (item.upper - item.lower) if item.is_full_turn else np.inf for item in self.items])

    @property
    def makes_jumps(self) -> bool:
        """Whether one of them does: a response then takes ten to a hundred times as long as another."""
        return any(item.makes_jumps for item in self.items)

    def to_si(self, u: Array) -> Array:
        """Unit cube (…, d) to SI."""
        return self.lower + np.asarray(u) * self.width

    def to_cube(self, x: Array) -> Array:
        """SI (…, d) to the unit cube."""
        return (np.asarray(x) - self.lower) / self.width

    def from_decades(self, z: Array) -> Array:
        """Unit cube (…, d) in which unknowns whose limits lie a decade or more apart grow by factors, to the unit cube."""
        span = self._decades
        return np.where(span > 0, (10 ** (np.asarray(z) * span) - 1) / np.where(span > 0, 10**span - 1, 1), z)

    def to_decades(self, u: Array) -> Array:
        """The inverse of `from_decades`."""
        span = self._decades
        return np.where(span > 0, np.log10(1 + np.asarray(u) * (10**span - 1)) / np.where(span > 0, span, 1), u)

    @property
    def _decades(self) -> Array:  # (d,), 0 where less than one
        ratio = [item.upper / item.lower if item.lower > 0 else 1.0 for item in self.items]
        return np.where(np.array(ratio) >= 10, np.log10(ratio), 0.0)

    def in_units(self, x: Array) -> Array:
        """SI (…, d) to the units people read."""
        return np.asarray(x) / self.si_per_unit


def middles(parameters: Parameters, names: Iterable[str]) -> dict[str, float]:
    """The middle of the limits of each named unknown, in its unit; the geometric one where they lie a decade or more apart."""
    middle = parameters.to_si(parameters.from_decades(np.full(len(parameters), 0.5)))
    values = dict(zip(parameters.names, parameters.in_units(middle).tolist()))
    return {name: values[name] for name in names}

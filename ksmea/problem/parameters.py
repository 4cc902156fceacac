"""Unknown parameters with units and limits.

The one conversion between SI, engineering units and the unit cube.
"""

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
    """Name of an unknown with its place, as one word: settings are given by it.

    The place distinguishes it from others of its name.

    >>> name_at("runout_x", "at 0.5 m")
    'runout_x_at_0_5_m'
    """
    return "_".join([name, *re.findall(r"\w+", place)])


SEEN = 0.98  # of a prior's standard deviation: numbers that are known less well afterwards are not seen by the data


@dataclass(frozen=True)
class Prior:
    """Gaussian distribution of a number before any measurement, SI.

    Drawings, catalogues and calibrations state it.
    """

    value: float
    sd: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.value) and 0 < self.sd < np.inf):
            raise SettingError(
                f"prior: expected a finite value and a standard deviation above 0, got {self.value:g} ± {self.sd:g}"
            )


@dataclass(frozen=True)
class Parameter:
    """Unknown with its unit and search limits.

    Args:
        name: name in settings, tables and files.
        unit: unit in which people read it.
        si_per_unit: one such unit in SI.
        lower: lower limit, SI.
        upper: upper limit, SI.
        makes_jumps: whether the response may jump as it changes, as if a resonance curve folds over.
        prior: distribution before any measurement. Default: None.
        words: its name for people. Default: empty, its name.
        is_input: whether it is a number of the model that is known to a tolerance, which searches take as stated.

    Raises:
        SettingError: the limits are not finite, or not in rising order.

    >>> stiffness = Parameter("kxx", "MN/m", 1e6, 10e6, 100e6)
    >>> stiffness.stated
    55000000.0
    """

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
        """Value of its prior, SI; without one the middle of its limits."""
        return (self.lower + self.upper) / 2 if self.prior is None else self.prior.value

    @property
    def is_angle(self) -> bool:
        """Whether its unit is one of angles."""
        return self.unit in SI_PER_UNIT["angle"]

    @property
    def is_full_turn(self) -> bool:
        """Whether it is an angle whose limits hold a turn or more: values a turn apart are equal."""
        return self.is_angle and self.upper - self.lower >= TURN * (1 - 1e-9)

    def turned(self, value: float) -> float:
        """Value of an angle that may be any, turned to between −180° and 180°; any other value unchanged.

        Args:
            value: value, SI.
        """
        return float(value - TURN * np.ceil(value / TURN - 0.5)) if self.is_full_turn else value

    @property
    def is_unbalance(self) -> bool:
        """Whether it is the magnitude of an unbalance."""
        return self.unit in SI_PER_UNIT["unbalance"] and self.lower >= 0


@dataclass(frozen=True)
class Parameters:
    """Unknowns of a problem, in the order of every parameter vector.

    Args:
        items: the unknowns.

    >>> known = Parameters((Parameter("k", "MN/m", 1e6, 10e6, 100e6), Parameter("c", "kN s/m", 1e3, 10.0, 1e3)))
    >>> known.to_si(np.array([0.5, 1.0])).tolist(), known.to_cube(np.array([10e6, 1e3])).tolist()
    ([55000000.0, 1000.0], [0.0, 1.0])
    """

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
        """Deviations from the priors, in standard deviations.

        Args:
            u: points (…, ≥ d) of the unit cube.

        Returns:
            Deviations (…, n_prior).
        """
        value, sd = self.priors
        return (u[..., self.with_prior] - value) / sd

    @property
    def period(self) -> Array:
        """Distance in the unit cube between equal values of each unknown, (d,).

        It is a turn for an unknown that is free to turn, otherwise infinite.
        """
        return np.array([TURN / (item.upper - item.lower) if item.is_full_turn else np.inf for item in self.items])

    @property
    def makes_jumps(self) -> bool:
        """Whether one of them does: a response then takes ten to a hundred times as long as another."""
        return any(item.makes_jumps for item in self.items)

    def to_si(self, u: Array) -> Array:
        """Convert from the unit cube to SI.

        Args:
            u: points (…, d) in the unit cube.

        Returns:
            Values (…, d), SI.
        """
        return self.lower + np.asarray(u) * self.width

    def to_cube(self, x: Array) -> Array:
        """Convert from SI to the unit cube.

        Args:
            x: values (…, d), SI.

        Returns:
            Points (…, d).
        """
        return (np.asarray(x) - self.lower) / self.width

    def from_decades(self, z: Array) -> Array:
        """Convert to the unit cube from one in which unknowns over a decade or more grow by factors.

        Args:
            z: points (…, d) in the latter.

        Returns:
            Points (…, d) in the unit cube.
        """
        span = self._decades
        return np.where(span > 0, (10 ** (np.asarray(z) * span) - 1) / np.where(span > 0, 10**span - 1, 1), z)

    def to_decades(self, u: Array) -> Array:
        """Inverse of `from_decades`.

        Args:
            u: points (…, d) in the unit cube.
        """
        span = self._decades
        return np.where(span > 0, np.log10(1 + np.asarray(u) * (10**span - 1)) / np.where(span > 0, span, 1), u)

    @property
    def _decades(self) -> Array:  # (d,), 0 where less than one
        ratio = [item.upper / item.lower if item.lower > 0 else 1.0 for item in self.items]
        return np.where(np.array(ratio) >= 10, np.log10(ratio), 0.0)

    def in_units(self, x: Array) -> Array:
        """Convert from SI to the units people read.

        Args:
            x: values (…, d), SI.

        Returns:
            Values (…, d), each in the unit of its unknown.
        """
        return np.asarray(x) / self.si_per_unit


def middles(parameters: Parameters, names: Iterable[str]) -> dict[str, float]:
    """Midpoint of the limits of each named unknown, in its unit.

    It is the geometric one if the limits lie a decade or more apart.

    Args:
        parameters: unknowns of a problem.
        names: names of some of them.
    """
    middle = parameters.to_si(parameters.from_decades(np.full(len(parameters), 0.5)))
    values = dict(zip(parameters.names, parameters.in_units(middle).tolist()))
    return {name: values[name] for name in names}

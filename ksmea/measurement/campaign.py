"""Campaign: several runs of one machine, measured by the same probes.

An example is one without and one with a trial weight.

A measurement of a campaign has the speeds of its runs one after the other. A run is named in one word: `bare`, or the known weights
on the shaft, `150@0.2@30`: size (g mm), position from the left end (m) and angle (degrees, 0 if it is left out), with @ between;
several weights are joined by +.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Indices
from ksmea.errors import SettingError
from ksmea.measurement.speeds import SpeedHistory
from ksmea.units import DEGREE, GRAM_MILLIMETRE

RUN_DIRECTIONS = ("up", "down", "steady")  # which way the speed goes in a run
OF_RUN = "@"  # between the name of an unknown and that of the run whose own it is


def own_name(name: str, run: str) -> str:
    """The unknown of one run: u@trial."""
    return f"{name}{OF_RUN}{run}"


def shared_name(name: str) -> str:
    """The unknown of the machine that an unknown is, or is one run's own of.

    >>> shared_name("u@trial"), shared_name("kxx")
    ('u', 'kxx')
    """
    return name.partition(OF_RUN)[0]


@dataclass(frozen=True)
class Weight:
    """A known unbalance (kg m) on the shaft at a position (m).

    Its angle (rad) counts from the same mark as the angles of the model's unbalance, towards the direction of rotation.
    """

    position: float
    magnitude: float
    angle: float = 0.0

    def __str__(self) -> str:
        """For example '150 g mm at 0.2 m, 30°'."""
        return f"{self.magnitude / GRAM_MILLIMETRE:g} g mm at {self.position:g} m, {self.angle / DEGREE:g}°"


@dataclass(frozen=True)
class WeightUnit:
    """Unit of weights in a file: a mass times a length (oz in), or a mass at a `radius` (g at 120 mm).

    Weights may also be masses at one radius that is not stated, or in a unit of the user's own (washers): then `scale` names what
    all weights of the plane share, and `si` is any size, which balancing without a rotor model does not need.
    """

    name: str = "g mm"
    si: float = GRAM_MILLIMETRE  # kg m
    radius: str = ""
    scale: str = ""

    def __str__(self) -> str:
        return f"{self.name} @ {self.radius}" if self.radius else self.name


@dataclass(frozen=True)
class Holes:
    """Holes of a plane for weights.

    Angles (rad), numbers from 1 of the occupied ones, the `most` that one takes, and the available sizes: multiples of
    a `step`, or some `sizes` (kg m); neither: any size.
    """

    angles: tuple[float, ...]
    occupied: tuple[int, ...] = ()
    most: float | None = None
    step: float | None = None
    sizes: tuple[float, ...] = ()


@dataclass(frozen=True)
class Plane:
    """Balancing plane: position (m), unit of its weights, and holes (None: weights go anywhere)."""

    position: float
    unit: WeightUnit = WeightUnit()
    holes: Holes | None = None


@dataclass(frozen=True)
class UnknownWeight:
    """An unbalance of unknown size and angle at a position (m).

    Its components lie within ± `at_most` (kg m; None: the largest unbalance that the model may have).
    """

    position: float
    at_most: float | None = None

    def __str__(self) -> str:
        return f"an unknown weight at {self.position:g} m"


@dataclass(frozen=True)
class Run:
    """One run: how many speeds it has, and the weights that the shaft carried.

    `direction`: one of `RUN_DIRECTIONS`, or nothing. `history`: the course of its speed; None if not known, or in
    steady states.
    """

    name: str
    n_speed: int
    weights: tuple[Weight, ...] = ()
    direction: str = ""
    unknown_weights: tuple[UnknownWeight, ...] = ()
    history: SpeedHistory | None = None

    @property
    def all_weights(self) -> tuple[Weight | UnknownWeight, ...]:
        return (*self.weights, *self.unknown_weights)

    def __str__(self) -> str:
        """For example 'trial (45 speeds, up, 150 g mm at 0.2 m, 30°)'."""
        parts = [f"{self.n_speed} speeds", self.direction, *map(str, self.all_weights)]
        return f"{self.name} ({', '.join(part for part in parts if part)})"


def weight_names(run: str, number: int) -> tuple[str, str]:
    """The two components of an unknown weight of a run, counted from 1.

    Weight_x@trial, the second is weight2_x@trial.
    """
    which = "" if number == 1 else str(number)
    return own_name(f"weight{which}_x", run), own_name(f"weight{which}_y", run)


def is_weight(name: str) -> bool:
    """Whether an unknown is a component of an unknown weight.

    >>> is_weight("weight_x@trial"), is_weight("u@trial")
    (True, False)
    """
    return re.fullmatch(rf"weight\d*_[xy]{OF_RUN}.*", name) is not None


@dataclass(frozen=True)
class Campaign:
    """The runs in the order of their speeds, and the unknowns of which each run has its own.

    All others are shared. With `own_noise` each run has noise of its own level, if that is estimated. With a
    `reference`, the name of a run, only how the others differ from it counts. `planes` says more of planes than their
    weights do.
    """

    runs: tuple[Run, ...]
    own: tuple[str, ...] = ()
    own_noise: bool = False
    reference: str = ""
    planes: tuple[Plane, ...] = ()

    def plane(self, position: float) -> Plane:
        """The plane at a position, m; one with weights in g mm where nothing else is said."""
        return next((plane for plane in self.planes if plane.position == position), Plane(position))

    def __str__(self) -> str:
        return f"{len(self.runs)} runs of one machine: {', '.join(map(str, self.runs))}"

    @property
    def rows(self) -> tuple[slice, ...]:
        """Rows of the speeds of each run."""
        ends = np.cumsum([0, *(run.n_speed for run in self.runs)]).tolist()
        return tuple(slice(start, stop) for start, stop in itertools.pairwise(ends))

    @property
    def weight_names(self) -> tuple[str, ...]:
        """The unknowns that the unknown weights of all runs are."""
        return tuple(
            name
            for run in self.runs
            for number in range(1, len(run.unknown_weights) + 1)
            for name in weight_names(run.name, number)
        )

    def with_counts(self, counts: Sequence[int]) -> Campaign:
        """This campaign with other numbers of speeds in its runs, which may be 0."""
        runs = (dataclasses.replace(run, n_speed=int(count)) for run, count in zip(self.runs, counts, strict=True))
        return dataclasses.replace(self, runs=tuple(runs))

    def part(self, indices: Indices) -> Campaign:
        """The campaign at some of its speeds, by rising index."""
        return self.with_counts([np.sum((indices >= rows.start) & (indices < rows.stop)) for rows in self.rows])


BARE = "bare"  # a run without a weight


def weights_of(run: str) -> tuple[Weight, ...]:
    """The weights of a run; `SettingError` if the word says none.

    >>> [str(weight) for weight in weights_of("150@0.2+80@1@-90")]
    ['150 g mm at 0.2 m, 0°', '80 g mm at 1 m, -90°']
    """
    return () if run == BARE else tuple(_weight(word, run) for word in run.split("+"))


def notation(weights: Sequence[Weight]) -> str:
    """The word of a run with these weights.

    >>> notation(weights_of("150@0.2+80@1@-90")), notation(())
    ('150@0.2+80@1@-90', 'bare')
    """
    return "+".join(map(_word, weights)) or BARE


def _weight(word: str, run: str) -> Weight:
    try:
        size, position, *angle = map(float, word.split("@"))
    except ValueError:
        raise _no_run(run) from None
    if len(angle) > 1 or size <= 0 or not all(map(math.isfinite, (size, position, *angle))):
        raise _no_run(run)
    return Weight(position, size * GRAM_MILLIMETRE, sum(angle) * DEGREE)


def _word(weight: Weight) -> str:
    parts = [weight.magnitude / GRAM_MILLIMETRE, weight.position, weight.angle / DEGREE]
    return "@".join(f"{part:.12g}" for part in (parts if weight.angle else parts[:2]))


def _no_run(run: str) -> SettingError:
    return SettingError(
        f"runs: expected {BARE}, or weights such as 150@0.2@30 (g mm, m, degrees) joined by +, got '{run}'; write it so"
    )

"""Parts of real machines that drawn rotors may have.

Bearings as tables over speed, seals, supports, layers.

Each part turns a drawn rotor with its unknowns and their true values into another one. Nobody published such a machine with its truth:
the ranges are chosen about what is usual, in parts of the bearings and the rotor that were drawn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ksmea.problem.parameters import Parameter
from problems.drawn_numbers import limited_about, log_uniform, rounded
from problems.rotor.finite_elements.bearing import COEFFICIENTS, Bearing, Pedestal, SpeedTable
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Layer, ShaftSegment
from problems.rotor.response.unknowns import BearingTarget, PedestalTarget, Unknown

TABLE_SPEEDS = (
    0.005,
    3.0,
)  # ends of all tables in parts of the highest speed at which critical speeds are sought: beyond any band
N_TABLE = 12  # speeds of a table, evenly in the logarithm
AT_SPEED = 0.2  # where a table has the drawn coefficients, in the same parts: in the midst of the bands
# Powers of the speed, evenly: with speed the film of a bearing loses damping, and its stiffness falls or rises.
STIFFNESS_POWER, DAMPING_POWER = (-0.3, 0.3), (-0.7, 0.0)
FACTOR = 0.5, 2.0  # true coefficients in parts of those that were calculated; clearances and loads are known no better
TABLED = ("kxx", "kyy", "cxx", "cyy")  # cross-coupling is left constant beside the table

SEAL_STIFFNESS, SEAL_DAMPING = (0.01, 0.1), (0.05, 0.5)  # in parts of those of a bearing
SWIRL = (
    0.2,
    0.5,
)  # cross-coupled stiffness = this × c Ω, evenly: half the speed at most, as of a seal without a swirl brake

SUPPORT_STIFFNESS = 1.5, 10.0  # in parts of a bearing's; API 617 lets supports be left out from 3.5 on
SUPPORT_MASS = 0.05, 0.3  # of each bearing's in parts of the rotor's mass
SUPPORT_LOSS = 0.01, 0.06  # of bolted steel
SUPPORT_ANISOTROPY = 0.5, 1.5  # y in parts of x, of a known one; an unknown one is alike in both

LAYER_RADIUS = 1.1, 1.6  # in parts of the shaft's radius


@dataclass(frozen=True)
class Draw:
    """A drawn rotor, its unknowns and their true values, SI."""

    rotor: Rotor
    unknowns: tuple[Unknown, ...]
    true: Mapping[str, float]
    fastest: float  # rad/s, up to which critical speeds are sought

    def typical(self, letter: str) -> float:
        """The drawn stiffness (k, N/m) or damping (c, N s/m) of a bearing, over both directions."""
        own = self.true.get(letter)
        return own if own is not None else math.sqrt(self.true[f"{letter}xx"] * self.true[f"{letter}yy"])

    @property
    def table_speeds(self) -> tuple[float, ...]:  # rad/s
        speeds = np.geomspace(*TABLE_SPEEDS, N_TABLE) * self.fastest
        return tuple(map(rounded, speeds))


def with_seals(draw: Draw, rng: np.random.Generator) -> Draw:
    """A known seal at one of the disks, with cross-coupling in proportion to the speed."""
    position = draw.rotor.disks[int(rng.integers(len(draw.rotor.disks)))].position
    stiffness = rounded(draw.typical("k") * log_uniform(SEAL_STIFFNESS, rng))
    damping = rounded(draw.typical("c") * log_uniform(SEAL_DAMPING, rng))
    crossed = damping * rng.uniform(*SWIRL)
    rows = []
    for speed in draw.table_speeds:
        numbers = {"kxx": stiffness, "kyy": stiffness, "cxx": damping, "cyy": damping}
        numbers |= {"kxy": rounded(crossed * speed), "kyx": -rounded(crossed * speed)}
        rows.append(_row(numbers))
    seal = Bearing(position, table=SpeedTable(draw.table_speeds, tuple(rows)))
    return replace(draw, rotor=replace(draw.rotor, seals=(*draw.rotor.seals, seal)))


def with_supports(draw: Draw, rng: np.random.Generator) -> Draw:
    """Each bearing on a support of known mass and loss factor.

    Its stiffness is known or, as likely, one more unknown.
    """
    stiffness = rounded(draw.typical("k") * log_uniform(SUPPORT_STIFFNESS, rng))
    in_y = rounded(stiffness * rng.uniform(*SUPPORT_ANISOTROPY))
    mass = rounded(draw.rotor.mass * log_uniform(SUPPORT_MASS, rng))
    pedestal = Pedestal(mxx=mass, myy=mass, loss_factor=log_uniform(SUPPORT_LOSS, rng))
    is_known = bool(rng.integers(2))
    parameter = limited_about("support", "stiffness", stiffness, rng)
    if is_known:
        pedestal = replace(pedestal, kxx=stiffness, kyy=in_y)
    else:
        indices = range(len(draw.rotor.bearings))
        targets = tuple(PedestalTarget(index, name) for index in indices for name in ("kxx", "kyy"))
        unknowns = (*draw.unknowns, Unknown(parameter, targets))
        draw = replace(draw, unknowns=unknowns, true={**draw.true, "support": stiffness})
    bearings = tuple(replace(bearing, pedestal=pedestal) for bearing in draw.rotor.bearings)
    return replace(draw, rotor=replace(draw.rotor, bearings=bearings))


def with_layers(draw: Draw, rng: np.random.Generator) -> Draw:
    """A sleeve around a piece of the shaft between the bearings.

    Its mass alone or, as likely, its stiffness too.
    """
    rotor = draw.rotor
    inner = range(1, len(rotor.segments) - 1)  # without both overhangs
    place = inner[int(rng.integers(len(inner)))]
    segment = rotor.segments[place]
    assert isinstance(segment, ShaftSegment), "a drawn shaft has cylinders alone"
    radius = rounded(segment.outer_radius * log_uniform(LAYER_RADIUS, rng))
    carries = ("mass", "both")[int(rng.integers(2))]
    layer = Layer(radius, segment.material, inner_radius=segment.outer_radius, carries=carries)
    segments = (*rotor.segments[:place], replace(segment, layers=(layer,)), *rotor.segments[place + 1 :])
    return replace(draw, rotor=replace(rotor, segments=segments))


def with_tables(draw: Draw, rng: np.random.Generator) -> Draw:
    """Direct coefficients of both bearings as tables over speed that were calculated.

    The truth is a factor times each, and unknown.
    """
    ratio = np.array(draw.table_speeds) / (AT_SPEED * draw.fastest)
    columns: dict[str, list[float]] = {}
    unknowns: list[Unknown] = []
    true: dict[str, float] = {}
    for item in draw.unknowns:
        name, value = item.parameter.name, draw.true[item.parameter.name]
        tabled = [each.coefficient for each in item.targets if isinstance(each, BearingTarget)]
        if not tabled or not set(tabled) <= set(TABLED):
            unknowns.append(item)
            true[name] = value
            continue
        factor = log_uniform(FACTOR, rng)
        power = rng.uniform(*(STIFFNESS_POWER if name.startswith("k") else DAMPING_POWER))
        calculated = value / factor
        column = [rounded(calculated * each**power) for each in ratio]
        columns |= dict.fromkeys(tabled, column)
        lower, upper = (rounded(end / calculated) for end in (item.parameter.lower, item.parameter.upper))
        targets = tuple(
            BearingTarget(each.bearing, f"{each.coefficient}_factor")
            for each in item.targets
            if isinstance(each, BearingTarget)
        )
        unknowns.append(Unknown(Parameter(f"{name}_factor", "times table", 1.0, lower, upper), targets))
        true[f"{name}_factor"] = factor
    rows = [_row({name: column[place] for name, column in columns.items()}) for place in range(len(ratio))]
    table = SpeedTable(draw.table_speeds, tuple(rows))
    bearings = tuple(replace(bearing, table=table) for bearing in draw.rotor.bearings)
    return replace(draw, rotor=replace(draw.rotor, bearings=bearings), unknowns=tuple(unknowns), true=true)


# In this order: the last one turns coefficients, by which the others are sized, into factors.
PARTS = {"seals": with_seals, "supports": with_supports, "layers": with_layers, "tables": with_tables}


def in_order(parts: Sequence[str]) -> tuple[str, ...]:
    """Parts each once, in one order: their order in a setting changes nothing."""
    return tuple(name for name in PARTS if name in parts)


def with_parts(draw: Draw, parts: Sequence[str], rng: np.random.Generator) -> Draw:
    """The draw with these parts."""
    for name in in_order(parts):
        draw = PARTS[name](draw, rng)
    return draw


def _row(numbers: Mapping[str, float]) -> tuple[float, ...]:
    """A row of a table, zeros where nothing is given."""
    return tuple(numbers.get(name, 0.0) for name in COEFFICIENTS)

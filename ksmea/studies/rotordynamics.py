"""Rotordynamics of a rotor at values of its unknowns.

Campbell diagram, critical speeds, stability, mode shapes.

Critical speeds are crossings of the diagram: natural frequencies that equal a multiple of the spin speed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import brentq

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.layout import RotorLayout
from ksmea.rotordynamics.margins import Peak, peaks, separation_margins
from ksmea.rotordynamics.stability import SLOWEST
from ksmea.rotordynamics.tracking import continued, tracked
from ksmea.rotordynamics.whirl import (
    NO_PEAK,
    CriticalSpeed,
    CriticalSpeedMap,
    FreeRotor,
    ModeShapes,
    Rotordynamic,
    Rotordynamics,
    direction_of_whirl,
)
from ksmea.settings.settings import Settings, setting
from ksmea.units import MEGANEWTON_PER_METRE, RPM

SEARCHED = 1.5  # times a problem's highest speed, up to which critical speeds are looked for unless said otherwise
MORE_MODES = 4  # are followed than are shown: modes change places
N_STIFFNESS = 61  # of a critical speed map
N_PLACE = 201  # of a mode shape
MAP_DECADES = 1.5  # either side of the stiffnesses of the model
WIDTHS, N_ABOUT = 6.0, 121  # half-power half-widths either side of a critical speed, and speeds there
N_CURVE = 600  # speeds of a response beside these
NOMINAL = 10 * MEGANEWTON_PER_METRE  # in the middle of the map of a rotor whose bearings have no stiffness


@dataclass(frozen=True)
class RotordynamicsOptions(Settings):
    """Options of the drawings of a rotor."""

    highest_rpm: float | None = setting(
        None,
        "speed up to which critical speeds are looked for; null: 1.5 times the problem's highest",
        unit="rpm",
        above=0,
    )
    speed_rpm: float | None = setting(
        None, "speed of the drawn modes and listed bearing coefficients; null: the first critical speed", unit="rpm",
        above=0,
    )  # fmt: skip
    modes: int = setting(6, "number of modes that are followed over speed and drawn", at_least=1, at_most=20)
    harmonics: list[float] = setting(
        [1.0, 2.0], "multiples of the speed that are crossed with the natural frequencies", above=0, at_most=20
    )
    operating_rpm: list[float] = setting(
        [],
        "operating range, least and largest continuous speed: separation margins by API 617 are given",
        unit="rpm",
        above=0,
    )
    speeds: int = setting(101, "number of speeds of the Campbell diagram", at_least=16, at_most=2000)
    stiffness_from: float | None = setting(
        None, "smallest stiffness of the critical speed map; null: below that of the bearings", unit="MN/m", above=0
    )
    stiffness_to: float | None = setting(None, "largest stiffness of the map", unit="MN/m", above=0)

    def check(self) -> None:
        if not self.harmonics:
            raise SettingError("harmonics: expected at least one, got none; 1 is the speed itself")
        if self.operating_rpm and (len(self.operating_rpm) != 2 or self.operating_rpm[0] > self.operating_rpm[1]):
            raise SettingError(
                f"operating_rpm: expected the least and the largest continuous speed, such as [9000, 11000], got {self.operating_rpm}"
            )
        if self.stiffness_from and self.stiffness_to and self.stiffness_from >= self.stiffness_to:
            raise SettingError(
                f"stiffness_to: expected more than {self.stiffness_from:g} MN/m, the beginning of the map, got {self.stiffness_to:g}"
            )


def rotordynamics(
    problem: Problem, x: Array, options: RotordynamicsOptions, *, title: str, remarks: tuple[str, ...] = ()
) -> Rotordynamics:
    """All that is drawn of a problem at values x (d,) SI. `SettingError` where it is not made of a rotor."""
    if not isinstance(problem, Rotordynamic):
        raise SettingError(
            f"expected a problem that knows its rotor, got {type(problem).__name__}; take one that is made of a rotor"
        )
    highest = SEARCHED * float(np.max(problem.speed)) if options.highest_rpm is None else options.highest_rpm * RPM
    rotor = problem.free_rotor(x, max(highest * max(1.0, *options.harmonics), _speed(options, 0.0)))
    speed = np.linspace(0.0, highest, options.speeds).clip(SLOWEST * highest)
    branches = tracked([each.first(options.modes + MORE_MODES) for each in rotor.motions(speed)], options.modes)
    found = critical_speeds(rotor, speed, options.harmonics)
    at_1x = [each.speed for each in found if each.harmonic == 1.0]
    shown_at = _speed(options, at_1x[0] if at_1x else highest)
    layout = rotor.layout(shown_at)
    low_high = [each * RPM for each in options.operating_rpm]
    operating = (low_high[0], low_high[1]) if low_high else None
    values = tuple(
        (each.name, each.unit, value / each.si_per_unit) for each, value in zip(problem.parameters, x.tolist())
    )
    return Rotordynamics(
        title=title,
        values=values,
        layout=layout,
        highest=highest,
        branches=branches,
        harmonics=tuple(options.harmonics),
        critical_speeds=found,
        threshold=problem.stability_threshold(x, highest),
        speed_map=_speed_map(rotor, layout, options, highest),
        shapes=_mode_shapes(rotor, layout, shown_at, options.modes),
        remarks=(*remarks, *problem.remarks_at(speed[1:]), *rotor.remarks),
        operating=operating,
        margins=() if operating is None else separation_margins(_peaks(problem, x, speed, found), *operating),
    )


def _peaks(problem: Problem, x: Array, speed: Array, found: Sequence[CriticalSpeed]) -> tuple[Peak, ...]:
    """Peaks of the response to the model's unbalance at its probes.

    The speeds are dense about critical speeds.
    """
    channels = [channel for channel in problem.channels if channel.is_1x]
    lacking = ", ".join([*({"unbalance"} & set(problem.missing)), *([] if channels else ["probes"])])
    if lacking:
        raise SettingError(
            f"operating_rpm: expected a rotor that answers unbalance, got one without {lacking}; add them"
        )
    about = [
        each.speed * (1 + max(each.damping_ratio, 1e-4) * np.linspace(-WIDTHS, WIDTHS, N_ABOUT))
        for each in found
        if each.harmonic == 1.0
    ]
    at = np.unique(np.concatenate([np.linspace(speed[-1] / N_CURVE, speed[-1], N_CURVE), *about]))
    at = at[(at > 0) & (at <= speed[-1])]
    return peaks(at, np.abs(problem.at(at, channels).response(x[None])[0]), channels)


def _speed(options: RotordynamicsOptions, otherwise: float) -> float:
    """The speed (rad/s) at which modes are drawn."""
    return otherwise if options.speed_rpm is None else options.speed_rpm * RPM


def _mode_shapes(rotor: FreeRotor, layout: RotorLayout, speed: float, n_mode: int) -> ModeShapes:
    places = np.union1d(np.linspace(0.0, layout.length, N_PLACE), layout.node_positions)
    motions = rotor.shapes(speed, places.tolist()).first(n_mode)
    # of the places that critical speeds and the Campbell diagram look at: an orbit next to a line has one name everywhere
    [at_nodes] = rotor.motions(np.array([speed]))
    return ModeShapes(places, motions, tuple(direction_of_whirl(*shape.T) for shape in at_nodes.first(n_mode).shape))


def _speed_map(
    rotor: FreeRotor, layout: RotorLayout, options: RotordynamicsOptions, highest: float
) -> CriticalSpeedMap | None:
    of_model = _own_stiffnesses(layout)
    sizes = [size for _, size in of_model] or [NOMINAL]
    ends = (min(sizes) / 10**MAP_DECADES, max(sizes) * 10**MAP_DECADES)
    given = (options.stiffness_from, options.stiffness_to)
    least, largest = (end if one is None else one * MEGANEWTON_PER_METRE for one, end in zip(given, ends))
    if least >= largest:
        raise SettingError(
            f"stiffness_from, stiffness_to: expected a rising pair, got {least / MEGANEWTON_PER_METRE:g} and"
            f" {largest / MEGANEWTON_PER_METRE:g} MN/m; give both"
        )
    stiffness = np.geomspace(least, largest, N_STIFFNESS)
    try:
        found = [rotor.undamped_critical_speeds(each) for each in stiffness.tolist()]
    except np.linalg.LinAlgError:  # no stiffness there holds the rotor, as with one bearing
        return None
    forward, backward = (_padded([pair[side][: options.modes] for pair in found], options.modes) for side in (0, 1))
    return CriticalSpeedMap(stiffness, forward, backward, of_model)


def _own_stiffnesses(layout: RotorLayout) -> tuple[tuple[str, float], ...]:
    """Direct stiffnesses of the bearings above 0 by name; one name where all bearings have the same."""
    named: dict[str, float] = {}
    if not layout.bearings:
        return ()
    for axis, name in enumerate(("kxx", "kyy")):
        sizes = [float(bearing.stiffness[axis, axis]) for bearing in layout.bearings]
        if np.allclose(sizes, sizes[0], rtol=1e-9):
            named[name] = sizes[0]
        else:
            named |= {f"{name} of bearing {number}": size for number, size in enumerate(sizes, start=1)}
    return tuple((name, size) for name, size in named.items() if size > 0)


def _padded(rows: list[Array], n: int) -> Array:
    """Rows of up to n numbers as (len(rows), n), not a number where there are fewer."""
    return np.array([np.append(row, np.full(n - len(row), np.nan)) for row in rows])


TOLERANCE = 1e-9  # of the highest speed
N_DAMPING = 9  # parts of the damping, from all to none, over which a motion is followed


def critical_speeds(rotor: FreeRotor, speed: Array, harmonics: Sequence[float]) -> tuple[CriticalSpeed, ...]:
    """Speeds (rad/s) at which a damped natural frequency is a harmonic of the speed.

    They lie within rising scanned speeds (n_speed,), each with the undamped critical speed next to it; None if damping
    is so large that the response has no peak. A frequency that crosses twice between two scanned speeds is missed.
    """
    damped, undamped = rotor.frequencies, partial(rotor.frequencies, damped=False)
    tables = damped(speed), undamped(speed)
    found: list[CriticalSpeed] = []
    for harmonic in harmonics:
        at_harmonic = [
            _critical_speed(rotor, each, harmonic) for each, _ in _crossings(damped, tables[0], speed, harmonic)
        ]
        resonant = [each for each in at_harmonic if each.damping_ratio < NO_PEAK]
        of_columns = _crossings(undamped, tables[1], speed, harmonic)
        found += [_with_undamped(rotor, each, of_columns, tables[1].shape[1]) for each in resonant]
    return tuple(found)


def _critical_speed(rotor: FreeRotor, speed: float, harmonic: float) -> CriticalSpeed:
    [motions] = rotor.motions(np.array([speed]))
    nearest = int(np.argmin(np.abs(motions.eigenvalue.imag - harmonic * speed)))
    direction = direction_of_whirl(*motions.shape[nearest].T)
    return CriticalSpeed(speed, harmonic, complex(motions.eigenvalue[nearest]), direction)


def _crossings(
    frequencies: Callable[[Array], Array], table: Array, speed: Array, harmonic: float
) -> list[tuple[float, int]]:
    """Rising speeds at which a column of frequencies equals a multiple of the speed, with the column.

    The `table` of frequencies at the scanned speeds is (n_speed, n).
    """
    is_above = table >= harmonic * speed[:, None]
    found = []
    for interval, column in zip(*np.nonzero(is_above[:-1] != is_above[1:])):

        def excess_at(at: float, column: int = int(column)) -> float:
            return float(frequencies(np.array([at]))[0, column] - harmonic * at)

        at = brentq(excess_at, speed[interval], speed[interval + 1], xtol=TOLERANCE * speed[-1])
        found.append((at, int(column)))
    return sorted(found)


def _with_undamped(
    rotor: FreeRotor, critical: CriticalSpeed, undamped: Sequence[tuple[float, int]], n_column: int
) -> CriticalSpeed:
    """Critical speed with the undamped one that it becomes as all damping is taken away.

    Its motion is followed to the undamped one at its own speed, which belongs to one column of frequencies; the answer
    is the crossing of this column with the harmonic.
    """
    at = np.array([critical.speed])
    [before] = rotor.motions(at)
    index = int(np.argmin(np.abs(before.eigenvalue - critical.eigenvalue)))
    for part in np.linspace(1.0, 0.0, N_DAMPING)[1:]:
        [now] = rotor.motions(at, damping=float(part))
        following = continued(before, index, now)
        if following is None:
            return critical
        before, index = now, following
    column = n_column - len(before.eigenvalue) + index  # motions that oscillate are the last columns
    crossings = [speed for speed, own in undamped if own == column]
    if not crossings:
        return critical
    nearest = min(crossings, key=lambda speed: abs(speed - critical.speed))
    return dataclasses.replace(critical, undamped=nearest)

"""Campbell diagram, stability map and critical speed map.

How the followed modes go with speed and with the bearings' stiffness.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.rotordynamics.whirl import Branches, CriticalSpeed, CriticalSpeedMap, Rotordynamics
from ksmea.show.charts.chart import Axis, Chart, Choice, Element, Level, Line, Points, Span, Words, one_panel
from ksmea.show.charts.colours import CATEGORIES, INK, REFERENCE
from ksmea.units import HERTZ, MEGANEWTON_PER_METRE, RPM

DIRECTIONS = {1.0: "forward", -1.0: "backward", 0.0: "mixed"}  # of whirl
WHIRL = dict(zip(DIRECTIONS.values(), (CATEGORIES[0], CATEGORIES[1], CATEGORIES[3])))  # colours
MAX_LABELS = 10  # critical speeds at 1X with their amplification factor beside them
OFFSETS = ((10.0, -15.0), (-6.0, 14.0), (34.0, -30.0), (-30.0, 30.0))  # of these words from their point, in points
AT_EDGE = 0.8  # of the highest speed: behind it words stand on the left of their point
NEAR = 0.09  # of the highest speed: closer ones have their words on different sides
CLOSE = 0.002  # relative: a frequency between two scanned speeds is not quite on the straight line
DEEPEST, HIGHEST_DECREMENT = -0.5, 3.0  # log decrements that are shown: beyond, nothing is seen of a motion
NEAR_STIFFNESS = 0.09  # of the axis of stiffness: names of lines that are closer stand in one text


def campbell_chart(found: Rotordynamics) -> Chart:
    """Damped natural frequencies by direction of whirl, lines of the harmonics, and where they meet.

    The critical speeds, with their amplification factors at 1X.
    """
    branches, right = found.branches, found.highest / RPM
    frequency = branches.frequency / HERTZ
    top = 1.08 * float(frequency[np.isfinite(frequency)].max(initial=0.0)) or 1.0
    elements = list(_by_whirl(branches, frequency, "{y:.2f} Hz"))
    for harmonic in found.harmonics:
        slope = harmonic * RPM / HERTZ
        end = min(right, top / slope)
        elements.append(Line([0, right], [0, slope * right], colour=REFERENCE, dash="dash", width=0.9))
        elements.append(
            Words(x=end, y=end * slope, text=f"{harmonic:g}X", size=9, offset=(-8, -4), side="right", edge="top")
        )
    marked = [each for each in found.critical_speeds if _is_on_a_branch(each, branches)]
    for name, symbol, mine in (
        ("critical speed", "circle", [each for each in marked if each.harmonic == 1.0]),
        ("at a harmonic", "square", [each for each in marked if each.harmonic != 1.0]),
    ):
        x, y = [each.speed / RPM for each in mine], [each.harmonic * each.speed / HERTZ for each in mine]
        if mine:
            elements.append(
                Points(x, y, symbol, 6.5, True, name=name, colour=INK, said=[_critical_speed(each) for each in mine])
            )
    elements += _amplifications([each for each in marked if each.harmonic == 1.0][:MAX_LABELS], found.highest)
    return one_panel(
        elements, Axis("speed (rpm)", low=0, high=right), Axis("natural frequency (Hz)", low=0, high=top), f"Campbell diagram, {found.title}",
        "Damped natural frequencies over speed, by direction of whirl; dashed: the harmonics. Circles are critical speeds, with their"
        " amplification factors (AF).", height=4.8, choices=_choices(branches),
    )  # fmt: skip


def _critical_speed(each: CriticalSpeed) -> str:
    return f"{each.harmonic:g}X: {each.speed / RPM:.1f} rpm, {each.direction}<br>damping ratio {100 * each.damping_ratio:.3g} %"


def _amplifications(critical: Sequence[CriticalSpeed], highest: float) -> Iterator[Words]:
    """Words next to critical speeds, rising; words of neighbours alternate sides, ever further away."""
    place = 0
    for index, each in enumerate(critical):
        place = place + 1 if index and each.speed - critical[index - 1].speed < NEAR * highest else 0
        right, up = OFFSETS[place % len(OFFSETS)]
        factor = each.amplification_factor
        said = "unstable" if factor is None else f"AF {factor:.3g}" if factor < 100 else f"AF {factor:.0f}"
        is_at_edge = each.speed > AT_EDGE * highest
        yield Words(
            x=each.speed / RPM, y=each.speed / HERTZ, text=f"{each.speed / RPM:.0f} rpm, {said}", colour=INK, has_leader=True, has_ground=True,
            offset=(-12.0, abs(up)) if is_at_edge else (right, up), side="right" if is_at_edge else "left",
        )  # fmt: skip


def stability_chart(found: Rotordynamics) -> Chart:
    """Logarithmic decrement of the modes over speed: below 0 a free motion grows.

    The first such speed is marked.
    """
    decrement = found.branches.log_decrement
    shown = decrement[np.isfinite(decrement)]
    lowest, highest = (float(shown.min()), float(shown.max())) if shown.size else (DEEPEST, HIGHEST_DECREMENT)
    low, high = min(max(lowest, DEEPEST), 0.0), max(min(highest, HIGHEST_DECREMENT), 0.0)
    room = 0.08 * (high - low or 1.0)
    elements: list[Element] = [Span(low=low - room, high=0.0, colour=CATEGORIES[1])]
    elements += _by_whirl(found.branches, decrement, "{y:.4g}")
    elements.append(Level(at=0.0, dash="solid"))
    elements.append(Words(x=0.0, y=low - room, text="unstable", size=9, offset=(5, 3), side="left", edge="bottom"))
    if np.isfinite(found.threshold):
        label = f"threshold {found.threshold / RPM:.0f} rpm" if found.threshold else "unstable from rest"
        elements.append(Level(at=found.threshold / RPM, along="x", colour=INK, width=1.4, label=label))
    beyond = " Decrements beyond are not shown." if highest > high or lowest < low else ""
    return one_panel(
        elements, Axis("speed (rpm)", low=0, high=found.highest / RPM), Axis("logarithmic decrement", low=low - room, high=high + room, better="high"),
        f"Stability, {found.title}", f"Logarithmic decrement of each mode over speed. Below zero the motion grows.{beyond}", choices=_choices(found.branches),
    )  # fmt: skip


def _choices(branches: Branches) -> tuple[Choice, ...]:
    there = [whirl for direction, whirl in DIRECTIONS.items() if np.any(branches.direction == direction)]
    return (Choice("whirl", "whirl", tuple(there)),) if len(there) > 1 else ()


def _by_whirl(branches: Branches, values: Array, said: str) -> Iterator[Element]:
    """A line for each mode (n_speed, n_branch) and direction that it whirls in.

    It goes on where the direction changes.
    """
    for number, (column, direction) in enumerate(zip(values.T, branches.direction.T), start=1):
        for of_direction, whirl in DIRECTIONS.items():
            own = direction == of_direction
            joined = own | np.append(False, own[:-1])  # on to the first point of what follows
            if np.any(own & np.isfinite(column)):
                where = f"mode {number}, {whirl}: {said} at {{x:.0f}} rpm"
                shown = np.where(joined, column, np.nan)
                yield Line(
                    branches.speed / RPM, shown, name=whirl, colour=WHIRL[whirl], said=where, tags={"whirl": whirl}
                )


def _is_on_a_branch(critical: CriticalSpeed, branches: Branches) -> bool:
    """Whether a critical speed lies on one of the modes that are drawn."""
    at = np.searchsorted(branches.speed, critical.speed).clip(1, len(branches.speed) - 1)
    ends = branches.frequency[at - 1 : at + 1]
    low, high = np.nanmin(ends, axis=0, initial=np.inf), np.nanmax(ends, axis=0, initial=-np.inf)
    frequency = critical.harmonic * critical.speed
    return bool(np.any((low <= (1 + CLOSE) * frequency) & (high >= (1 - CLOSE) * frequency)))


def speed_map_chart(found: Rotordynamics) -> Chart:
    """Forward and backward critical speeds over bearing stiffness; dotted: stiffnesses of the model."""
    drawn = found.speed_map
    if drawn is None:
        raise SettingError(
            "critical speed map: expected bearings at two places, got a rotor that they do not hold; add one"
        )
    stiffness, highest = drawn.stiffness / MEGANEWTON_PER_METRE, found.highest / RPM
    elements: list[Element] = []
    for whirl, dash, curves in (("forward", "solid", drawn.forward), ("backward", "dash", drawn.backward)):
        for number, curve in enumerate(curves.T, start=1):
            said = f"{whirl} {number}: {{y:.0f}} rpm at {{x:.4g}} MN/m"
            elements.append(Line(stiffness, curve / RPM, name=whirl, colour=WHIRL[whirl], dash=dash, said=said))
    for lines, said in stiffnesses_of_model(drawn):
        elements += [Level(at=at, along="x", label=said if at == lines[0] else "") for at in lines]
    elements.append(Level(at=highest, colour=INK, dash="solid", width=0.8, label="highest speed"))
    return one_panel(
        elements, Axis("stiffness of each bearing, x and y (MN/m)", "log", float(stiffness[0]), float(stiffness[-1])),
        Axis("undamped critical speed (rpm)", "log"), f"Undamped critical speed map, {found.title}",
        "Critical speeds on bearings of one stiffness in x and y. Dotted lines are the stiffnesses of the model.", height=4.4,
    )  # fmt: skip


def stiffnesses_of_model(drawn: CriticalSpeedMap, near: float = NEAR_STIFFNESS) -> list[tuple[list[float], str]]:
    """The model's own stiffnesses within the axis, rising, MN/m, with their names.

    Stiffnesses closer than `near`, of the axis, share one text.
    """
    first, last = drawn.stiffness[0], drawn.stiffness[-1]
    groups: list[list[tuple[float, str]]] = []
    for size, name in sorted((size, name) for name, size in drawn.of_model if first <= size <= last):
        if groups and size < groups[-1][-1][0] * (last / first) ** near:
            groups[-1].append((size, name))
        else:
            groups.append([(size, name)])
    scale = MEGANEWTON_PER_METRE
    return [
        ([size / scale for size, _ in group], ", ".join(f"{name} {size / scale:.4g}" for size, name in group))
        for group in groups
    ]

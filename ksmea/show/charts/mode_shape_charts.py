"""Mode shapes at one speed: orbits along the shaft in space, and deflection lines.

The latter are in the planes x–z and y–z.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.rotordynamics.layout import RotorLayout
from ksmea.rotordynamics.whirl import Rotordynamics, damping_ratio, roundness
from ksmea.show.charts.chart import Axis, Chart, Element, Level, Line, Panel, Points, Space
from ksmea.show.charts.colours import CATEGORIES, INK, REFERENCE
from ksmea.units import HERTZ, RPM

FORWARD, BACKWARD, STRAIGHT = (
    ("forward", CATEGORIES[0]),
    ("backward", CATEGORIES[1]),
    ("along a line", CATEGORIES[3]),
)  # orbits
HARDLY_ROUND = 0.02  # of a circle: flatter orbits are drawn as lines
COLUMNS = 3
N_ORBIT = 13  # orbits along the shaft, besides those at bearings and disks
TURN = np.exp(1j * np.linspace(0.0, 2 * np.pi, 49))


def orbits_chart(found: Rotordynamics) -> Chart:
    """Panel for each mode: orbits in the colour of their direction, and the deflected shaft.

    The shaft is shown at one moment.
    """
    shapes = found.shapes
    stacks = []
    for index, shape in enumerate(shapes.motions.shape):
        size = float(np.sqrt(np.max(np.sum(np.abs(shape) ** 2, axis=1))))
        elements = tuple(_orbits(shapes.places, shape, stations(found.layout)))
        y, z = (Axis(name, low=-1.05 * size, high=1.05 * size) for name in "xy")
        stacks.append((Panel(elements, Axis("position (m)"), y, mode_title(found, index), 2.7, z=z),))
    return Chart(
        f"Mode shapes at {shapes.motions.speed / RPM:.0f} rpm, {found.title}",
        "Orbits at places along the shaft, at disks and at bearings, and the deflected shaft at one moment (black). The largest deflection is 1.",
        tuple(stacks), min(COLUMNS, max(len(stacks), 1)), of_stacks="mode", most=len(stacks),
    )  # fmt: skip


def _orbits(places: Array, shape: ComplexArray, stations: Array) -> Iterator[Element]:
    x, y = shape.T
    yield Space(places, 0 * places, 0 * places, width=0.7, colour=REFERENCE)
    shown = np.unique([np.argmin(np.abs(places - station)) for station in stations])
    round_by = np.nan_to_num(roundness(x, y))[shown]
    ways = (
        (FORWARD, round_by > HARDLY_ROUND),
        (BACKWARD, round_by < -HARDLY_ROUND),
        (STRAIGHT, np.abs(round_by) <= HARDLY_ROUND),
    )
    for (name, colour), mine in ways:
        rings = np.real(shape[shown[mine], :, None] * TURN)  # (n, 2, n_turn)
        if len(rings):
            gaps = np.full((len(rings), 1), np.nan)
            along = np.repeat(places[shown[mine]][:, None], len(TURN) + 1, axis=1)
            first, second = (np.concatenate([rings[:, axis], gaps], axis=1).ravel() for axis in (0, 1))
            yield Space(along.ravel(), first, second, width=1.0, name=name, colour=colour)
    yield Space(places, x.real, y.real, width=1.3, colour=INK)


def deflections_chart(found: Rotordynamics) -> Chart:
    """Panel for each mode: deflection in x and in y at the moment at which each is largest.

    The largest of both is 1. Circles are nodes; dotted lines stand at the bearings.
    """
    shapes = found.shapes
    x, y = (
        Axis("position along the shaft (m)", group="position"),
        Axis("deflection", low=-1.1, high=1.1, group="deflection"),
    )
    stacks = tuple(
        (Panel(tuple(_deflections(shapes.places, shape, found.layout)), x, y, mode_title(found, index), 1.7),)
        for index, shape in enumerate(shapes.motions.shape)
    )
    return Chart(
        f"Deflection of the modes at {shapes.motions.speed / RPM:.0f} rpm, {found.title}",
        "Deflection in x and in y at the moment at which each is largest. Circles are nodes, dotted lines bearings.",
        stacks, min(COLUMNS, max(len(stacks), 1)), most=len(stacks),
    )  # fmt: skip


def _deflections(places: Array, shape: ComplexArray, layout: RotorLayout) -> Iterator[Element]:
    yield Level(at=0.0, dash="solid", width=0.7)
    yield from (Level(at=bearing.position, along="x", width=0.8) for bearing in layout.bearings)
    largest = np.max(np.abs(shape))
    for values, name, colour, dash in zip(shape.T, "xy", CATEGORIES, ("solid", "dash")):
        deflection = in_plane(values) / largest
        yield Line(places, deflection, dash, name=name, colour=colour)
        at = nodes(places, deflection)
        if len(at) and np.max(np.abs(deflection)) > HARDLY_ROUND:
            yield Points(at, 0 * at, is_open=True, name=f"node of {name}", colour=colour)


def mode_title(found: Rotordynamics, index: int) -> str:
    """Number, frequency, damping ratio and direction of a mode."""
    eigenvalue = found.shapes.motions.eigenvalue[index]
    ratio = float(damping_ratio(eigenvalue))
    return f"{index + 1}: {eigenvalue.imag / HERTZ:.4g} Hz, ζ {100 * ratio:.3g} %, {found.shapes.directions[index]}"


def in_plane(shape: ComplexArray) -> Array:
    """A deflection (n_place,) at the moment at which it is largest.

    Real, with the sign of its largest value.
    """
    turned: Array = (shape * np.exp(-0.5j * np.angle(np.sum(shape**2)))).real
    return turned * (np.sign(turned[np.argmax(np.abs(turned))]) or 1.0)


def nodes(places: Array, deflection: Array) -> Array:
    """Places (n,) at which a deflection (n_place,) goes through zero."""
    before, after = deflection[:-1], deflection[1:]
    crosses = before * after < 0
    part = before[crosses] / (before[crosses] - after[crosses])
    return np.asarray(places[:-1][crosses] + part * np.diff(places)[crosses])


def stations(layout: RotorLayout) -> Array:
    """Where orbits are drawn, m."""
    own = [disk.position for disk in layout.disks] + [bearing.position for bearing in layout.bearings]
    return np.union1d(np.linspace(0.0, layout.length, N_ORBIT), own)

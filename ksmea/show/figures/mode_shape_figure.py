"""Mode shapes at one speed: orbits along the shaft in space, and deflection lines in the planes x–z and y–z."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.axes3d import Axes3D

from ksmea.arrays import Array, ComplexArray
from ksmea.rotordynamics.layout import RotorLayout
from ksmea.rotordynamics.whirl import Rotordynamics, damping_ratio, roundness
from ksmea.show.figures.style import COLOURS, REFERENCE, ShownFigure
from ksmea.units import HERTZ, RPM

FORWARD, BACKWARD, STRAIGHT = COLOURS[0], COLOURS[1], COLOURS[3]  # of an orbit
HARDLY_ROUND = 0.02  # of a circle: flatter orbits are drawn as lines
COLUMNS = 3
N_ORBIT = 13  # orbits along the shaft, besides those at bearings and disks
ANGLE = np.linspace(0.0, 2 * np.pi, 49)


def orbits_figure(found: Rotordynamics) -> Figure:
    """A panel for each mode: orbits in the colour of their direction, the deflected shaft at one moment, dots where it is then."""
    shapes = found.shapes
    n_mode = len(shapes.motions.eigenvalue)
    columns, rows = min(COLUMNS, n_mode), -(-n_mode // COLUMNS)
    figure = ShownFigure(figsize=(8.0, 2.9 * rows + 0.9))
    for index in range(n_mode):
        panel: Axes3D = figure.add_subplot(rows, columns, index + 1, projection="3d")
        _draw_orbits(panel, shapes.places, shapes.motions.shape[index], stations(found.layout))
        panel.set_title(mode_title(found, index), fontsize=9, y=0.98)
    names = ((FORWARD, "forward"), (BACKWARD, "backward"), (STRAIGHT, "along a line"))
    handles = [Line2D([], [], color=colour, label=name) for colour, name in names]
    figure.legend(handles=handles, loc="lower center", ncols=3, fontsize=9, frameon=False)
    figure.suptitle(f"Mode shapes at {shapes.motions.speed / RPM:.0f} rpm, {found.title}", fontsize=11)
    figure.subplots_adjust(left=0.02, right=0.97, bottom=0.06, top=0.9, wspace=0.06, hspace=0.14)
    return figure


def deflections_figure(found: Rotordynamics) -> Figure:
    """A panel for each mode: deflection in x and in y at the moment at which each is largest, the largest of both 1. Circles are
    nodes; dotted lines stand at the bearings."""
    shapes = found.shapes
    n_mode = len(shapes.motions.eigenvalue)
    columns, rows = min(COLUMNS, n_mode), -(-n_mode // COLUMNS)
    figure = ShownFigure(figsize=(8.0, 1.9 * rows + 1.0), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for index, panel in enumerate(panels.flat):
        if index >= n_mode:
            panel.set_axis_off()
            continue
        _draw_deflections(panel, shapes.places, shapes.motions.shape[index], found.layout)
        panel.set_title(mode_title(found, index), fontsize=9)
    for panel in panels[:, 0]:
        panel.set_ylabel("deflection", fontsize=9)
    for index in range(max(0, n_mode - columns), n_mode):  # the lowest panel of each column
        panels.flat[index].set_xlabel("position along the shaft (m)", fontsize=9)
        panels.flat[index].tick_params(labelbottom=True)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    figure.suptitle(f"Deflection of the modes at {shapes.motions.speed / RPM:.0f} rpm, {found.title}", fontsize=11)
    return figure


def mode_title(found: Rotordynamics, index: int) -> str:
    """Number, frequency, damping ratio and direction of a mode."""
    eigenvalue = found.shapes.motions.eigenvalue[index]
    ratio = float(damping_ratio(eigenvalue))
    return f"{index + 1}: {eigenvalue.imag / HERTZ:.4g} Hz, ζ {100 * ratio:.3g} %\n{found.shapes.directions[index]}"


def in_plane(shape: ComplexArray) -> Array:
    """A deflection (n_place,) at the moment at which it is largest: real, with the sign of its largest value."""
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


def _draw_orbits(panel: Axes3D, places: Array, shape: ComplexArray, stations: Array) -> None:
    x, y = shape.T
    size = float(np.sqrt(np.max(np.abs(x) ** 2 + np.abs(y) ** 2)))
    round_by = np.nan_to_num(roundness(x, y))
    panel.plot(places, 0 * places, 0 * places, color=REFERENCE, linewidth=0.7, dashes=(8, 3))
    for station in stations:
        at = int(np.argmin(np.abs(places - station)))
        colour = FORWARD if round_by[at] > HARDLY_ROUND else BACKWARD if round_by[at] < -HARDLY_ROUND else STRAIGHT
        turning = np.exp(1j * ANGLE)
        panel.plot(0 * ANGLE + places[at], (x[at] * turning).real, (y[at] * turning).real, color=colour, linewidth=1.0)
        panel.plot([places[at]], [x[at].real], [y[at].real], "o", color=colour, markersize=2.5)
    panel.plot(places, x.real, y.real, color="black", linewidth=1.3)
    panel.set(ylim=(-size, size), zlim=(-size, size), yticks=[], zticks=[])
    panel.set_xlabel("z (m)", fontsize=8, labelpad=-6)
    panel.set_ylabel("x", fontsize=8, labelpad=-14)
    panel.set_zlabel("y", fontsize=8, labelpad=-14)
    panel.tick_params(axis="x", labelsize=7, pad=-3)
    panel.set_box_aspect((2.2, 1, 1), zoom=1.08)
    panel.view_init(elev=18, azim=-62)


def _draw_deflections(panel: Axes, places: Array, shape: ComplexArray, layout: RotorLayout) -> None:
    largest = np.max(np.abs(shape))
    for values, name, colour, line in zip(shape.T, "xy", (COLOURS[0], COLOURS[1]), ("-", "--")):
        deflection = in_plane(values) / largest
        panel.plot(places, deflection, line, color=colour, linewidth=1.6, label=name)
        if np.max(np.abs(deflection)) > HARDLY_ROUND:
            at = nodes(places, deflection)
            panel.plot(at, 0 * at, "o", color=colour, markerfacecolor="white", markersize=5, label=f"node of {name}")
    panel.axhline(0.0, color=REFERENCE, linewidth=0.7)
    for bearing in layout.bearings:
        panel.axvline(bearing.position, color=REFERENCE, linewidth=0.8, linestyle=":")
    panel.set_ylim(-1.1, 1.1)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)

"""Undamped critical speed map: critical speeds over the stiffness of the bearings, both axes logarithmic."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.errors import SettingError
from ksmea.rotordynamics.whirl import CriticalSpeedMap, Rotordynamics
from ksmea.show.figures.style import COLOURS, REFERENCE, ShownFigure, figure_of
from ksmea.show.figures.ticks import plain_ticks
from ksmea.units import MEGANEWTON_PER_METRE, RPM

NEAR = 0.03  # of the axis of stiffness: names of lines that are closer stand in one text
LINES = (("forward", "-", COLOURS[0]), ("backward", "--", COLOURS[1]))


def speed_map_figure(found: Rotordynamics, axes: Axes | None = None) -> Figure:
    """Forward and backward critical speeds of the shaft on bearings of one stiffness; dotted: those of the model."""
    drawn = found.speed_map
    if drawn is None:
        raise SettingError(
            "critical speed map: expected bearings at two places, got a rotor that they do not hold; add one"
        )
    if axes is None:
        axes = ShownFigure(figsize=(8.0, 5.6), layout="constrained").subplots()
        axes.set_title(f"Undamped critical speed map, {found.title}", fontsize=11)
    stiffness = drawn.stiffness / MEGANEWTON_PER_METRE
    for (name, line, colour), curves in zip(LINES, (drawn.forward, drawn.backward)):
        for index, curve in enumerate(curves.T):
            label = name if index == 0 else None
            axes.loglog(stiffness, curve / RPM, line, color=colour, linewidth=1.6, label=label)
    for lines, said in stiffnesses_of_model(drawn):
        for at in lines:
            axes.axvline(at, color=REFERENCE, linestyle=":", linewidth=1.3)
        axes.annotate(said, (lines[0], 0.02), (-2, 0), xycoords=("data", "axes fraction"), rotation=90,
                      textcoords="offset points", ha="right", fontsize=8, color=REFERENCE)  # fmt: skip
    axes.axhline(found.highest / RPM, color="black", linewidth=0.8)
    axes.annotate("highest speed", (0.01, found.highest / RPM), (0, 3), xycoords=("axes fraction", "data"),
                  textcoords="offset points", fontsize=8, bbox={"facecolor": "white", "linewidth": 0, "pad": 0.5})  # fmt: skip
    axes.set_xlabel("stiffness of each bearing, x and y (MN/m)", fontsize=10)
    axes.set_ylabel("undamped critical speed (rpm)", fontsize=10)
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.set_xlim(stiffness[0], stiffness[-1])
    axes.grid(alpha=0.3)
    axes.grid(alpha=0.12, which="minor")
    axes.tick_params(labelsize=9)
    axes.legend(fontsize=9, loc="upper left")
    return figure_of(axes)


def stiffnesses_of_model(drawn: CriticalSpeedMap, near: float = NEAR) -> list[tuple[list[float], str]]:
    """The model's own stiffnesses within the axis, rising, MN/m, with their names; those closer than `near`, of the axis, share one text."""
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

"""Undamped critical speed map: critical speeds over the stiffness of the bearings, both axes logarithmic."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.errors import SettingError
from ksmea.show.style import COLOURS, REFERENCE, ShownFigure, figure_of
from ksmea.units import MEGANEWTON_PER_METRE, RPM
from ksmea.whirl import Rotordynamics

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
    for name, size in drawn.of_model:
        at = size / MEGANEWTON_PER_METRE
        if not stiffness[0] <= at <= stiffness[-1]:
            continue
        axes.axvline(at, color=REFERENCE, linestyle=":", linewidth=1.3)
        axes.annotate(f"{name} {at:.4g}", (at, 0.02), (-2, 0), xycoords=("data", "axes fraction"), rotation=90,
                      textcoords="offset points", ha="right", fontsize=8, color=REFERENCE)  # fmt: skip
    axes.axhline(found.highest / RPM, color="black", linewidth=0.8)
    axes.annotate("highest speed", (0.01, found.highest / RPM), (0, 3), xycoords=("axes fraction", "data"),
                  textcoords="offset points", fontsize=8, bbox={"facecolor": "white", "linewidth": 0, "pad": 0.5})  # fmt: skip
    axes.set_xlabel("stiffness of each bearing, x and y (MN/m)", fontsize=10)
    axes.set_ylabel("undamped critical speed (rpm)", fontsize=10)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xlim(stiffness[0], stiffness[-1])
    axes.grid(alpha=0.3)
    axes.grid(alpha=0.12, which="minor")
    axes.tick_params(labelsize=9)
    axes.legend(fontsize=9, loc="upper left")
    return figure_of(axes)

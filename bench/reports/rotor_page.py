"""What the page of a drawn rotor tells: its drawings, those with a speed axis as plots, and their numbers as tables."""

from __future__ import annotations

import numpy as np

from bench.plan.page import Block, Control, Drawn, Picture, Plot, Prose, Section, Table
from bench.reports.plots.traces import (
    BLUE,
    COLOURS,
    GREY,
    ORANGE,
    PALE,
    PURPLE,
    Trace,
    layout,
)
from ksmea.rotordynamics.whirl import Rotordynamics
from ksmea.show.charts.whirl_charts import campbell_chart, speed_map_chart, stability_chart
from ksmea.show.figures.mode_shape_figure import stations
from ksmea.show.rotordynamics_text import (
    DIRECTIONS,
    bearing_table,
    critical_speed_table,
    mode_table,
    sentences,
)
from ksmea.units import HERTZ

WHIRLS = dict(zip(DIRECTIONS.values(), (BLUE, ORANGE, PURPLE)))
SPEED_RPM = "speed (rpm)"
DEEPEST, HIGHEST_DECREMENT = -0.5, 3.0  # log decrements that are shown at first: beyond, nothing is seen of a motion
NO_MARGIN = {"l": 0, "r": 0, "t": 0, "b": 0}
EYE = {"x": 1.5, "y": -2.3, "z": 1.0}  # from where orbits are seen
NARROW_EYE = 1.8  # times as far on a narrow page
ROOM = 0.5  # decades below the lowest curve of the critical speed map: for the names of lines
NEAR = 0.09  # of the axis of stiffness: names of lines that are closer stand in one text, also on a narrow page
HEIGHT_3D = 520  # px


def rotor_sections(found: Rotordynamics) -> tuple[Section, ...]:
    """The chapters of the page. Figures are named as the files beside it."""
    rotor: tuple[Block, ...] = (
        Prose("\n".join(sentences(found))),
        Picture(
            "rotor.png", "Shaft sections, disks, bearings, unbalance planes and probes, with lengths between them."
        ),
        Table(bearing_table(found), "Bearings"),
    )
    whirl: tuple[Block, ...] = (
        Drawn(campbell_chart(found), "campbell.png"),
        Table(critical_speed_table(found), "Critical speeds", "critical_speeds.csv"),
    )
    modes: list[Block] = [Table(mode_table(found), "Modes"), *_orbits(found)]
    modes.append(
        Picture(
            "deflections.png",
            "Deflection in x and in y at the moment at which each is largest. Circles are nodes, dotted lines bearings.",
            "Deflection lines",
        )
    )
    sections = [
        Section("Rotor", rotor),
        Section("Critical speeds", whirl),
        Section("Stability", (Drawn(stability_chart(found), "stability.png"),)),
    ]
    if found.speed_map is not None:
        sections.append(Section("Stiffness of the bearings", (Drawn(speed_map_chart(found), "speed_map.png"),)))
    return (*sections, Section("Mode shapes", tuple(modes)))


def _orbits(found: Rotordynamics) -> list[Block]:
    """Each mode's orbits at places along the shaft, to be turned; the first mode is chosen at first."""
    shapes, turn = found.shapes, np.linspace(0.0, 2 * np.pi, 49)
    shown = np.unique([np.argmin(np.abs(shapes.places - station)) for station in stations(found.layout)])
    names, traces = [], list[Trace]()
    for number, (value, shape) in enumerate(zip(shapes.motions.eigenvalue, shapes.motions.shape), start=1):
        whirl = shapes.directions[number - 1]
        name = f"mode {number}: {value.imag / HERTZ:.1f} Hz, {whirl}"
        names.append(name)
        rings = np.real(shape[shown, :, None] * np.exp(1j * turn))  # (n_shown, 2, n)
        gap = np.full(1, np.nan)
        z = np.concatenate([np.concatenate([np.full(turn.size, place), gap]) for place in shapes.places[shown]])
        x, y = (np.concatenate([np.concatenate([ring[axis_], gap]) for ring in rings]) for axis_ in (0, 1))
        moment = shape.real
        common = {"type": "scatter3d", "mode": "lines", "meta": {"mode": name}, "hoverinfo": "skip"}
        colour = WHIRLS.get(whirl, COLOURS[0])
        traces.append({**common, "x": z, "y": x, "z": y, "name": "orbits", "line": {"color": colour, "width": 3}})
        shaft = {"x": shapes.places, "y": moment[:, 0], "z": moment[:, 1]}
        traces.append({**common, **shaft, "name": "shaft at one moment", "line": {"color": GREY, "width": 5}})
    if not names:
        return []
    style = {"color": GREY, "gridcolor": PALE, "zerolinecolor": PALE}  # styles of the page do not reach into it
    sides = {"range": [-1.05, 1.05], "title": {"text": "x"}, **style}
    scene = {
        "xaxis": {"title": {"text": "position (m)"}, **style},
        "yaxis": sides,
        "zaxis": {**sides, "title": {"text": "y"}},
        "aspectmode": "manual",
        "aspectratio": {"x": 2.2, "y": 1, "z": 1},
        "camera": {"eye": EYE},
    }
    farther = {**scene, "camera": {"eye": {side: NARROW_EYE * at for side, at in EYE.items()}}}
    return [
        Plot(
            "Orbits",
            "Orbits at places along the shaft, at disks and at bearings, and the deflected shaft at one moment. The largest deflection is 1.",
            {
                "data": traces,
                "layout": layout(scene=scene, margin=NO_MARGIN, narrow={"margin": NO_MARGIN, "scene": farther}),
            },
            "orbits.png",
            (Control("mode", "mode", tuple(names), with_all=False),),
            HEIGHT_3D,
        )
    ]

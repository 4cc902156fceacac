"""What the page of a drawn rotor tells: its drawings, those with a speed axis as plots, and their numbers as tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bench.plan.page import Block, Control, Picture, Plot, Prose, Section, Table
from bench.reports.plots.traces import (
    BLUE,
    COLOURS,
    GREY,
    ORANGE,
    PALE,
    PURPLE,
    Trace,
    axis,
    layout,
    level,
    line,
    points,
)
from ksmea.arrays import Array
from ksmea.rotordynamics.whirl import Rotordynamics
from ksmea.show.figures.mode_shape_figure import stations
from ksmea.show.figures.speed_map_figure import stiffnesses_of_model
from ksmea.show.rotordynamics_text import (
    DIRECTIONS,
    bearing_table,
    critical_speed_table,
    mode_table,
    sentences,
    speed_map_frame,
)
from ksmea.units import HERTZ, RPM

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
        _campbell(found),
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
    sections = [Section("Rotor", rotor), Section("Critical speeds", whirl), Section("Stability", (_stability(found),))]
    if found.speed_map is not None:
        sections.append(Section("Stiffness of the bearings", (_speed_map(found),)))
    return (*sections, Section("Mode shapes", tuple(modes)))


def _campbell(found: Rotordynamics) -> Plot:
    """Natural frequencies over speed, lines of the harmonics, and where both meet."""
    branches = found.branches
    lines = list(_by_whirl(found, branches.frequency / HERTZ, "%{y:.2f} Hz"))
    ends = np.array([0.0, float(branches.speed[-1])])
    for harmonic in found.harmonics:
        style = {"color": GREY, "width": 1.2, "dash": "dash"}
        lines.append(line(ends / RPM, harmonic * ends / HERTZ, f"{harmonic:g}X", GREY, line=style, hoverinfo="skip"))
    critical = found.critical_speeds
    labels = [
        f"{each.harmonic:g}X: {each.speed / RPM:.1f} rpm, {each.direction}<br>damping ratio {100 * each.damping_ratio:.3g} %"
        for each in critical
    ]
    marked = points(
        [each.speed / RPM for each in critical],
        [each.eigenvalue.imag / HERTZ for each in critical],
        "critical speed",
        GREY,
        marker={"size": 10, "symbol": "circle-open", "line": {"width": 2}},
        text=labels,
        hovertemplate="%{text}<extra></extra>",
    )
    return Plot(
        "Campbell diagram",
        "Damped natural frequencies over speed, by direction of whirl. Circles are critical speeds.",
        {"data": [*lines, marked], "layout": layout(SPEED_RPM, "frequency (Hz)")},
        "campbell.png",
        (Control("whirl", "whirl", tuple(WHIRLS)),),
    )


def _stability(found: Rotordynamics) -> Plot:
    shapes = [level(0.0)]
    if np.isfinite(found.threshold):
        shapes.append(level(found.threshold / RPM, along="x"))
    values = found.branches.log_decrement
    shown = values[np.isfinite(values)]
    ends = (DEEPEST, HIGHEST_DECREMENT) if not shown.size else (float(shown.min()), float(shown.max()))
    low, high = max(ends[0], DEEPEST), min(ends[1], HIGHEST_DECREMENT)
    room = 0.05 * (high - low or 1.0)
    of_decrement = axis("log decrement", range=[min(low, 0.0) - room, high + room])
    return Plot(
        "Stability",
        "Logarithmic decrement of each mode over speed. Below zero the motion grows.",
        {
            "data": list(_by_whirl(found, values, "%{y:.4g}")),
            "layout": layout(SPEED_RPM, "", yaxis=of_decrement, shapes=shapes),
        },
        "stability.png",
        (Control("whirl", "whirl", tuple(WHIRLS)),),
    )


def _by_whirl(found: Rotordynamics, values: Array, value_template: str) -> Iterator[Trace]:
    """A line for each mode (n_speed, n_branch) and direction that it whirls in; it goes on where the direction changes."""
    named: set[str] = set()
    for number, (column, direction) in enumerate(zip(values.T, found.branches.direction.T), start=1):
        for of_direction, whirl in DIRECTIONS.items():
            own = direction == of_direction
            joined = own | np.append(False, own[:-1])  # on to the first point of what follows
            if not np.any(own & np.isfinite(column)):
                continue
            yield line(
                found.branches.speed / RPM,
                np.where(joined, column, np.nan),
                whirl,
                WHIRLS[whirl],
                legendgroup=whirl,
                showlegend=whirl not in named,
                meta={"whirl": whirl},
                hovertemplate=f"mode {number}, {whirl}: {value_template} at %{{x:.0f}} rpm<extra></extra>",
            )
            named.add(whirl)


def _speed_map(found: Rotordynamics) -> Plot:
    assert found.speed_map is not None
    traces, named = [], set[str]()
    curves = speed_map_frame(found)
    for (whirl, number), curve in curves.groupby(["whirl", "number"], sort=False):
        traces.append(
            line(
                curve["stiffness_MN_m"],
                curve["critical_speed_rpm"],
                str(whirl),
                WHIRLS[str(whirl)],
                legendgroup=whirl,
                showlegend=whirl not in named,
                hovertemplate=f"{whirl} {number}: %{{y:.0f}} rpm at %{{x:.4g}} MN/m<extra></extra>",
            )
        )
        named.add(str(whirl))
    shapes, notes = [], []
    for stiffnesses, said in stiffnesses_of_model(found.speed_map, NEAR):
        shapes += [level(at, along="x") for at in stiffnesses]
        notes.append(
            {"x": float(np.log10(stiffnesses[0])), "y": 0.02, "yref": "paper", "text": said, "textangle": -90, "showarrow": False, "font": {"size": 10},
             "xanchor": "right", "yanchor": "bottom"}
        )  # fmt: skip
    made = layout(
        "stiffness of each bearing (MN/m)",
        "critical speed (rpm)",
        x_log=True,
        y_log=True,
        shapes=shapes,
        annotations=notes,
    )
    rpm = np.log10(curves["critical_speed_rpm"][curves["critical_speed_rpm"] > 0])
    if len(rpm):
        made["yaxis"]["range"] = [float(rpm.min()) - ROOM, float(rpm.max()) + 0.1]
    return Plot(
        "Undamped critical speed map",
        "Critical speeds on bearings of one stiffness in x and y. Dotted lines are the stiffnesses of the model.",
        {"data": traces, "layout": made},
        "speed_map.png",
    )


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

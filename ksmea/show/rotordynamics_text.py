"""Rotordynamics as tables of numbers, as tables of texts, and in sentences.

The numbers are the files behind the figures.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import named
from ksmea.rotordynamics.margins import CLAUSE
from ksmea.rotordynamics.whirl import CriticalSpeed, Rotordynamics, log_decrement, roundness
from ksmea.rotordynamics.whirl import damping_ratio as ratio_of
from ksmea.show.charts.mode_shape_charts import in_plane, nodes
from ksmea.show.margins_text import margin_frame, margin_table, sag_frame
from ksmea.show.text import capital
from ksmea.units import GRAM_MILLIMETRE, HERTZ, KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE, MICROMETRE, RPM

DIRECTIONS = {1.0: "forward", -1.0: "backward", 0.0: "mixed"}
ENTRIES = ("xx", "xy", "yx", "yy")


def layout_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each drawn thing of the rotor: its position, in m, and its known properties."""
    layout = found.layout
    rows: list[dict[str, object]] = [
        {"thing": f"section {number}", "from_m": each.start, "to_m": each.end, "outer_diameter_m": 2 * each.outer_radius,
         "inner_diameter_m": 2 * each.inner_radius}
        for number, each in enumerate(layout.sections, start=1)
    ]  # fmt: skip
    for number, disk in enumerate(layout.disks, start=1):
        ring = {"outer_diameter_m": disk.outer_radius and 2 * disk.outer_radius, "thickness_m": disk.thickness}
        inertias = {"polar_inertia_kg_m2": disk.polar_inertia, "diametral_inertia_kg_m2": disk.diametral_inertia}
        rows.append({"thing": f"disk {number}", "from_m": disk.position, "mass_kg": disk.mass, **inertias, **ring})
    for number, bearing in enumerate(layout.bearings, start=1):
        k = dict(zip((f"k{each}_MN_m" for each in ENTRIES), (bearing.stiffness / MEGANEWTON_PER_METRE).ravel()))
        c = dict(zip((f"c{each}_kN_s_m" for each in ENTRIES), (bearing.damping / KILONEWTON_SECOND_PER_METRE).ravel()))
        load = {} if bearing.load is None else {"static_load_N": bearing.load}
        rows.append({"thing": f"bearing {number}", "from_m": bearing.position, **k, **c, **load})
    for plane in layout.unbalance:
        size = {"unbalance_g_mm": plane.magnitude / GRAM_MILLIMETRE, "phase_deg": np.degrees(plane.phase)}
        rows.append({"thing": "unbalance", "from_m": plane.position, **size})
    rows += [{"thing": f"probe {named(each.direction)}", "from_m": each.position} for each in layout.probes]
    for effect in layout.effects:
        rows += [{"thing": effect.name, "from_m": place} for place in effect.positions or (None,)]
    return pd.DataFrame(rows)


def campbell_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each speed and mode that was followed: frequency, damping and direction of whirl."""
    branches = found.branches
    n_speed, n_branch = branches.eigenvalue.shape
    table = pd.DataFrame(
        {
            "speed_rpm": np.repeat(branches.speed / RPM, n_branch),
            "mode": np.tile(np.arange(1, n_branch + 1), n_speed),
            "frequency_hz": branches.frequency.ravel() / HERTZ,
            "damping_ratio": branches.damping_ratio.ravel(),
            "log_decrement": branches.log_decrement.ravel(),
            "whirl": [DIRECTIONS.get(each, "") for each in branches.direction.ravel().tolist()],
        }
    )
    return table.dropna(subset=["frequency_hz"])


def critical_speed_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each critical speed."""
    return pd.DataFrame(
        [
            {
                "harmonic": each.harmonic,
                "critical_speed_rpm": each.speed / RPM,
                "undamped_rpm": None if each.undamped is None else each.undamped / RPM,
                "frequency_hz": each.eigenvalue.imag / HERTZ,
                "whirl": each.direction,
                "damping_ratio": each.damping_ratio,
                "log_decrement": each.log_decrement,
                "amplification_factor": each.amplification_factor,
            }
            for each in found.critical_speeds
        ],
        columns=["harmonic", "critical_speed_rpm", "undamped_rpm", "frequency_hz", "whirl", "damping_ratio",
                 "log_decrement", "amplification_factor"],
    )  # fmt: skip


def speed_map_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each stiffness, direction and curve of the critical speed map."""
    drawn = found.speed_map
    columns = ["stiffness_MN_m", "whirl", "number", "critical_speed_rpm"]
    if drawn is None:
        return pd.DataFrame(columns=columns)
    stiffness = drawn.stiffness / MEGANEWTON_PER_METRE
    parts = [
        pd.DataFrame(
            zip(stiffness, np.full(len(curve), name), np.full(len(curve), number), curve / RPM), columns=columns
        )
        for name, curves in (("forward", drawn.forward), ("backward", drawn.backward))
        for number, curve in enumerate(curves.T, start=1)
    ]
    return pd.concat(parts).dropna(subset=["critical_speed_rpm"])


def mode_shape_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each mode and place.

    Complex deflections of x and y, the largest 1, and how round the orbit is.
    """
    shapes = found.shapes
    parts = []
    for number, (value, shape) in enumerate(zip(shapes.motions.eigenvalue, shapes.motions.shape), start=1):
        x, y = shape.T
        columns = {"x_re": x.real, "x_im": x.imag, "y_re": y.real, "y_im": y.imag, "roundness": roundness(x, y)}
        parts.append(
            pd.DataFrame({"mode": number, "frequency_hz": value.imag / HERTZ, "position_m": shapes.places, **columns})
        )
    return pd.concat(parts) if parts else pd.DataFrame(columns=["mode", "frequency_hz", "position_m"])


FRAMES = {
    "rotor": layout_frame,
    "campbell": campbell_frame,
    "critical_speeds": critical_speed_frame,
    "speed_map": speed_map_frame,
    "mode_shapes": mode_shape_frame,
    "margins": margin_frame,
    "sag": sag_frame,
}


def critical_speed_table(found: Rotordynamics) -> pd.DataFrame:
    """Critical speeds as texts."""
    return pd.DataFrame([_row(each) for each in found.critical_speeds], columns=list(HEAD))


HEAD = (
    "order",
    "critical speed (rpm)",
    "undamped (rpm)",
    "whirl",
    "damping ratio (%)",
    "log decrement",
    "amplification factor",
)


def _row(each: CriticalSpeed) -> tuple[str, ...]:
    return (
        f"{each.harmonic:g}X",
        f"{each.speed / RPM:.1f}",
        "–" if each.undamped is None else f"{each.undamped / RPM:.1f}",
        each.direction,
        f"{100 * each.damping_ratio:.3g}",
        f"{each.log_decrement:.3g}",
        _factor_in_words(each),
    )


def _factor_in_words(each: CriticalSpeed) -> str:
    factor = each.amplification_factor
    if factor is None:
        return "grows" if each.damping_ratio < 0 else "undamped"
    return f"{factor:.3g}" if factor < 1000 else f"{factor:.0f}"


def mode_table(found: Rotordynamics) -> pd.DataFrame:
    """Modes at the speed that they are drawn for, as texts."""
    motions, places = found.shapes.motions, found.shapes.places
    rows = []
    for number, (value, shape) in enumerate(zip(motions.eigenvalue, motions.shape), start=1):
        rows.append(
            {
                "mode": str(number),
                "frequency (Hz)": f"{value.imag / HERTZ:.2f}",
                "whirl": found.shapes.directions[number - 1],
                "damping ratio (%)": f"{100 * float(ratio_of(value)):.3g}",
                "log decrement": f"{float(log_decrement(value)):.3g}",
                "nodes (m)": _places(nodes(places, in_plane(_larger(shape)))),
            }
        )
    return pd.DataFrame(rows)


def bearing_table(found: Rotordynamics) -> pd.DataFrame:
    """Bearings with their coefficients, as texts."""
    rows = []
    for number, bearing in enumerate(found.layout.bearings, start=1):
        k, c = bearing.stiffness / MEGANEWTON_PER_METRE, bearing.damping / KILONEWTON_SECOND_PER_METRE
        coefficients = {f"k{each} (MN/m)": f"{value:.4g}" for each, value in zip(ENTRIES, k.ravel())}
        coefficients |= {f"c{each} (kN s/m)": f"{value:.4g}" for each, value in zip(ENTRIES, c.ravel())}
        load = {} if bearing.load is None else {"static load (N)": f"{bearing.load:.4g}"}
        rows.append({"bearing": str(number), "position (m)": f"{bearing.position:g}", **coefficients, **load})
    table = pd.DataFrame(rows)
    crossed = [name for name in table.columns if name[1:3] in ("xy", "yx") and set(table[name]) == {"0"}]
    return table.drop(columns=crossed)


def sentences(found: Rotordynamics) -> list[str]:
    """Summary of the drawings in sentences."""
    layout, at = found.layout, found.shapes.motions.speed / RPM
    said = [
        f"{layout.length:g} m long, {layout.mass:.4g} kg; {_count(layout.disks, 'disk')}, {_count(layout.bearings, 'bearing')}."
    ]
    if found.values:
        said.append(f"Values: {', '.join(f'{name} {value:.4g} {unit}' for name, unit, value in found.values)}.")
    if layout.sag is not None:
        loads = ", ".join(f"{bearing.load:.4g}" for bearing in layout.bearings if bearing.load is not None)
        lowest = int(np.argmax(layout.sag))
        said.append(
            f"Lying level, the bearings carry {loads} N, and the shaft hangs {layout.sag[lowest] / MICROMETRE:.3g} µm below their"
            f" line at {layout.node_positions[lowest]:.3g} m."
        )
    if layout.support:
        said.append(f"{capital(layout.support)}.")
    said += [f"Effect: {each.name} ({each.where})." for each in layout.effects]
    count = sum(each.harmonic == 1.0 for each in found.critical_speeds)
    said.append(f"{count} critical speed{'s' * (count != 1)} up to {found.highest / RPM:.0f} rpm.")
    if np.isfinite(found.threshold):
        where = "from rest" if found.threshold == 0 else f"from {found.threshold / RPM:.0f} rpm on"
        said.append(f"Unstable {where}.")
    else:
        said.append(f"Stable up to {found.highest / RPM:.0f} rpm.")
    if found.speed_map is None:
        said.append("No critical speed map: bearings at one place alone do not hold the rotor.")
    return [*said, *found.remarks, f"Modes and coefficients of the bearings are those at {at:.0f} rpm."]


def text(found: Rotordynamics) -> str:
    """The table of critical speeds and what it does not say, for a terminal."""
    table = critical_speed_table(found)
    shown = table.to_string(index=False) if len(table) else "no critical speed"
    first, *others = sentences(found)
    lines = [f"{found.title}: {first}", *others, "", shown]
    if found.operating is not None:
        low, high = (each / RPM for each in found.operating)
        margins = margin_table(found)
        rows = margins.to_string(index=False) if len(margins) else "no peak of the response"
        lines += ["", f"separation margins for {low:.0f} to {high:.0f} rpm ({CLAUSE})", rows]
    return "\n".join(lines)


def _larger(shape: ComplexArray) -> ComplexArray:
    """The deflection in x or in y, whichever is larger."""
    return shape[:, int(np.argmax(np.max(np.abs(shape), axis=0)))]


def _places(places: Array) -> str:
    return ", ".join(f"{place:.3g}" for place in places) or "none"


def _count(things: Sequence[object], name: str) -> str:
    return f"{len(things)} {name}{'s' * (len(things) != 1)}"

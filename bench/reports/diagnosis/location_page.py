"""Sections on a location: the shaft with all sites that were tried, what acts at the best one, and the unknowns beside it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from bench.plan.page import Block, Folded, Page, Plot, Prose, Section, Table
from bench.reports.plots.interval_plot import Shown, interval_plot
from bench.reports.plots.traces import (  # fmt: skip
    BLUE,
    COLOURS,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    TEAL,
    SymlogAxis,
    axis,
    band,
    broken,
    layout,
    level,
    line,
    points,
)
from ksmea.arrays import Array
from ksmea.records.estimate import EstimateRecord
from ksmea.records.location import PAIR, ForceRecord, LocationRecord, SeriesRecord
from ksmea.show.figures.location_figure import LINEAR
from ksmea.show.location_text import sites_table, text
from ksmea.show.location_words import headline
from ksmea.show.text import LEAST_OF_A_DOUBLE, chance, number
from ksmea.units import MICROMETRE, RPM

COLOUR_OF_QUANTITY = {"force": BLUE, "moment": ORANGE, "reading": GREEN, "force and moment": PURPLE, PAIR: GREY}
MEGA = 1e6
LEAST_P = 1e-300  # of a site, drawn on a logarithmic axis
MOST_TICKS = 5  # of that axis
SPEED = "speed (rpm)"


def location_page(record: LocationRecord, following: Sequence[Block]) -> Page:
    """The page of a location alone."""
    sections = [Section("What was found", (Prose(text(record)),))]
    sections += [Section("What to do next", tuple(following))] if following else []
    return Page(headline(record), (*sections, Section("Sites", tuple(location_blocks(record, "location.png")))))


def location_blocks(record: LocationRecord, still: str = "", about_others: Sequence[str] = ()) -> Iterator[Block]:
    """Shaft, force over speed, sites and unknowns; `about_others` says why values of the same model elsewhere on the page are
    others."""
    if record.candidates:
        yield shaft_plot(record, still)
        accepted = ["yes" if site.accepted else "no" for site in record.candidates]
        table = Table(sites_table(record, record.candidates).assign(accepted=accepted), file="sites.csv")
        yield Folded(f"All {len(record.candidates)} sites that were tried", (table,))
    if record.force is not None:
        yield from _force_plots(record, record.force)
    unknowns = {
        each.name: {
            name: _shown(estimate)
            for name, estimate in (
                ("without", each.plain),
                ("beside it", each.best),
                ("over all sites", each.over_sites),
            )
            if estimate is not None
        }
        for each in record.coefficients
    }
    if record.force is not None and unknowns:
        said = "Unknowns without what acts there, beside it at the best site, and over all accepted sites."
        yield interval_plot(unknowns, {}, " ".join([said, *about_others]))


def _shown(estimate: EstimateRecord) -> Shown:
    low, high = (np.nan if end is None else end for end in (estimate.low, estimate.high))
    return Shown(estimate.value, low, high, estimate.unit)


def shaft_plot(record: LocationRecord, still: str = "") -> Plot:
    """p of each site over its position, above the shaft with what sits on it."""
    traces = [trace for quantity in COLOUR_OF_QUANTITY for trace in _sites(record, quantity)]
    probes = [*dict.fromkeys(record.planes)]
    landmarks = list(record.landmarks.items())
    shaft: dict[str, Any] = {"yaxis": "y2", "showlegend": False}
    traces += [
        {**line(list(record.shaft), [0, 0], "shaft", GREY, hoverinfo="skip", **shaft), "line": {"color": GREY, "width": 8}},
        points(
            [at for _, at in landmarks], [0] * len(landmarks), "on the shaft", TEAL, **shaft,
            text=[name for name, _ in landmarks], hovertemplate="%{text}: %{x:g} m<extra></extra>",
            marker={"size": 14, "symbol": [_symbol(name) for name, _ in landmarks]},
        ),
        points(
            probes, [0.75] * len(probes), "probe", ORANGE, **shaft, hovertemplate="probe: %{x:g} m<extra></extra>",
            marker={"size": 10, "symbol": "triangle-down"},
        ),
    ]  # fmt: skip
    made = layout()
    made["xaxis"] = axis("position (m)", anchor="y2")
    decades = -math.log10(max(min(site.p for site in record.candidates), LEAST_P))
    made["yaxis"] = axis("p of the site", log=True, domain=[0.34, 1.0], dtick=max(math.ceil(decades / MOST_TICKS), 1))
    made["yaxis2"] = axis(
        domain=[0.0, 0.24], range=[-1.5, 1.2], showticklabels=False, ticks="", showgrid=False, fixedrange=True
    )
    made["shapes"] = [level(record.level, dash="dash")]
    made["annotations"] = [
        {"x": at, "y": -0.75, "xref": "x", "yref": "y2", "text": _short(name), "showarrow": False, "yanchor": "top", "yshift": 6,
         "font": {"size": 10}}
        for name, at in landmarks
    ]  # fmt: skip
    return Plot(
        "Sites on the shaft",
        "p of the test of each site over its position; filled: accepted, hollow: rejected, dashed: the level of the test. Below"
        " it the shaft with its disks, bearings and probes (triangles above it).",
        {"data": traces, "layout": made},
        still,
        height=430,
    )


def _symbol(name: str) -> str:
    return "triangle-up" if name.startswith("bearing") else "line-ns-open"


def _short(name: str) -> str:
    """'disk 2' as 'd 2', to stand below a shaft on a telephone."""
    word, _, number = name.partition(" ")
    return f"{word[:1]}{number}" if number.isdigit() else name


def _sites(record: LocationRecord, quantity: str) -> Iterator[dict[str, Any]]:
    sites = sorted((site for site in record.candidates if site.kind == quantity), key=lambda site: site.position)
    for is_accepted in (False, True):
        places = [(at, site) for site in sites if site.accepted == is_accepted for at in site.positions]
        if not places:
            continue
        yield points(
            [at for at, _ in places], [max(site.p, LEAST_P) for _, site in places],
            f"{quantity}, {'accepted' if is_accepted else 'rejected'}", COLOUR_OF_QUANTITY[quantity],
            marker={"symbol": "circle" if is_accepted else "circle-open", "size": 10 if is_accepted else 7},
            text=[f"{site}: {chance(site.p, LEAST_OF_A_DOUBLE)}, χ² = {number(site.chi2)}" for _, site in places],
            hovertemplate="%{text}<extra></extra>",
        )  # fmt: skip


def _force_plots(record: LocationRecord, force: ForceRecord) -> Iterator[Block]:
    in_micrometre = force.parts[0].unit == "m"
    unit, scale = ("µm", MICROMETRE) if in_micrometre else (force.parts[0].unit, 1.0)
    traces = [
        trace
        for part, colour in zip(force.parts, COLOURS)
        for trace in _series(record, part.amplitude, part.part, colour, scale)
    ]
    if record.law is not None and (record.law.position, record.law.kind) == (force.position, force.kind):
        for direction, amplitude in zip("xy", record.law.amplitude):
            traces.append(
                line(
                    _rpm(record),
                    _lines(record, amplitude),
                    f"{record.law.law} ({direction})",
                    GREY,
                    line={"dash": "dash", "color": GREY},
                )
            )
    dashed = "; dashed: the law that it follows" if record.law is not None else ""
    said = f"Amplitude of the unknown {force.kind} at the best site over speed, with its {_level(record)} interval{dashed}."
    yield Plot(
        f"The {force.kind} over speed",
        said,
        {"data": traces, "layout": layout(SPEED, f"{force.kind} ({unit})", y_log=True)},
    )
    if force.work is not None:
        on_axis = SymlogAxis(LINEAR * (float(np.max(np.abs(force.work.value))) or 1.0))
        made = layout(SPEED, "work (J per turn)", shapes=[level(0, dash="solid")])
        made["yaxis"] |= on_axis.ticks(min(force.work.low), max(force.work.high))
        said = f"Work of the force on the motion per turn, with its {_level(record)} interval: above 0 it feeds the motion."
        traces = _series(record, force.work, "work", BLUE, on_axis=on_axis.positions)
        yield Plot("Work", said, {"data": traces, "layout": made}, height=300)
    directions = [each for each in force.stiffness if each.part in ("x", "y")]
    if directions:
        traces = [
            trace
            for each, (first, second) in zip(directions, ((BLUE, TEAL), (ORANGE, PURPLE)))
            for part, of, colour in (("in phase", each.real, first), ("in quadrature", each.imaginary, second))
            for trace in _series(record, of, f"{each.part}, {part}", colour, MEGA)
        ]
        coherence = ", ".join(f"{each.part} {each.coherence:.2f}" for each in directions)
        said = (
            "Force over motion of its site, −f/q: what it amounts to where it follows the motion"
            f" (coherence: {coherence}), with {_level(record)} intervals."
        )
        middle = np.concatenate([each.real.value for each in directions]) / MEGA
        low, high = np.quantile(middle, [0.05, 0.95])
        made = layout(SPEED, "dynamic stiffness (MN/m)")
        low, high = low - max(high - low, 1e-3), high + max(high - low, 1e-3)
        made["yaxis"]["range"] = [low, high]
        if middle.min() < low or middle.max() > high:
            said += " Where the site hardly moves it is larger than the axis shows."
        yield Plot("Dynamic stiffness", said, {"data": traces, "layout": made}, height=340)


def _level(record: LocationRecord) -> str:
    return f"{100 * record.interval_level:g} %"


def _series(
    record: LocationRecord,
    series: SeriesRecord,
    name: str,
    colour: str,
    scale: float = 1.0,
    on_axis: Callable[[Array], Array] = np.asarray,
) -> list[dict[str, Any]]:
    """A quantity over speed with the band of its interval; `on_axis` says where values stand on an axis of a kind that plotly lacks."""
    value, low, high = (_lines(record, values) / scale for values in (series.value, series.low, series.high))
    drawn = line(_rpm(record), on_axis(value), name, colour, legendgroup=name, customdata=value,
                 hovertemplate="%{x:.0f} rpm: %{customdata:.4g}")  # fmt: skip
    return [*band(_rpm(record), on_axis(low), on_axis(high), name, colour, showlegend=False, legendgroup=name), drawn]


def _rpm(record: LocationRecord) -> Array:
    return _lines(record, record.speed) / RPM


def _lines(record: LocationRecord, values: Sequence[float]) -> Array:
    return broken(np.array(values), record.breaks)

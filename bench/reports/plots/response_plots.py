"""Plots of measured and modelled response: over speed (Bode), in the complex plane (Nyquist), as orbits of the shaft."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from bench.plan.page import Block, Control, Orbits, Plot
from bench.reports.plots.responses import Response
from bench.reports.plots.traces import COLOURS, FADED, axis, broken, layout, level, line, points
from ksmea.arrays import Array, ComplexArray
from ksmea.show.figures.response_lines import AMPLITUDE

MOST_ERROR_BARS = 400  # points; more are drawn without
MOST_AT_ONCE = 2  # channels that are shown at first
DASHES = {"model before": "dash"}  # of lines; all others are solid
IN_WORDS = {"dash": "dashed", "solid": "solid"}
SYMBOLS = {"model before": ("circle-open", "x-thin-open")}  # of the parts of residuals
OWN_SYMBOLS = ("circle", "cross-thin-open")  # of those of any other model
MARKS = {"circle-open": "○", "x-thin-open": "×", "circle": "●", "cross-thin-open": "+"}  # as a caption shows them
SPEED = "speed (rpm)"


def response_blocks(response: Response, still: str = "") -> Iterator[Block]:
    """All plots that a response has."""
    yield bode_plot(response, still)
    if response.has_phase:
        yield nyquist_plot(response)
        if response.planes():
            yield orbits(response)


def bode_plot(response: Response, still: str = "") -> Plot:
    """Amplitude, phase where there is one, and residuals in units of the noise, one below the other."""
    rows = ["amplitude", *(["phase"] if response.has_phase else []), *(["residuals"] if response.residuals else [])]
    heights = {"amplitude": 3.0, "phase": 1.6, "residuals": 1.6}
    axes = {row: "y" if index == 0 else f"y{index + 1}" for index, row in enumerate(rows)}
    traces = [trace for column in range(len(response.channels)) for trace in _of_channel(response, column, axes)]
    made = layout()
    for row, (low, high) in zip(rows, _domains([heights[row] for row in rows])):
        made[f"yaxis{axes[row][1:]}"] = AXES[row] | {"domain": [low, high]}
    made["xaxis"] = axis(SPEED, anchor=axes[rows[-1]])
    if "residuals" in rows:
        own = axes["residuals"]
        made["shapes"] = [
            {"type": "rect", "xref": "x domain", "x0": 0, "x1": 1, "yref": own, "y0": -2, "y1": 2, "line": {"width": 0},
             "fillcolor": FADED, "layer": "below"},
            level(0, dash="solid", yref=own),
        ]  # fmt: skip
    bars = "dots: measured, with ± 1 σ" if _has_bars(response) else "dots: measured"
    of_both = ", of one law for both, each at its own response" if len(response.residuals) > 1 else ""
    below = (
        f"; below: residuals in units of the noise{of_both}{_marks(response)}, ± 2 shaded" if response.residuals else ""
    )
    return Plot(
        "Response over speed",
        f"Amplitude{' and phase lead' if response.has_phase else ''} over speed; {bars}, lines: {_models(response)}{below}.",
        {"data": traces, "layout": made},
        still,
        (*_channel_control(response), *_model_control(response)),
        height=300 + 130 * (len(rows) - 1),
    )


AXES = {
    "amplitude": axis(AMPLITUDE, log=True),
    "phase": axis("phase (°)", range=[-190, 190], tickvals=[-180, -90, 0, 90, 180]),
    "residuals": axis("residual / σ"),
}


def nyquist_plot(response: Response) -> Plot:
    """The response in the complex plane."""
    traces = []
    for column, channel in enumerate(response.channels):
        colour = COLOURS[column % len(COLOURS)]
        for name, curve in response.curves.items():
            values, rpm = curve.values[:, column], broken(curve.speed, curve.breaks)
            re, im = (broken(part, curve.breaks) for part in (values.real, values.imag))
            traces.append(
                line(
                    re, im, f"{name}, {channel}", colour, meta={"channel": channel, "model": name},
                    customdata=rpm, hovertemplate=HOVER_PLANE, line=_style(name, colour),
                )
            )  # fmt: skip
        measured = response.measured[:, column]
        traces.append(
            points(
                measured.real, measured.imag, f"measured, {channel}", colour, meta={"channel": channel},
                customdata=response.speed, hovertemplate=HOVER_PLANE, marker={"size": 5},
            )
        )  # fmt: skip
    made = layout("real part (µm)", "imaginary part (µm)")
    made["yaxis"] |= {"scaleanchor": "x", "zeroline": True, "constrain": "domain"}
    made["xaxis"] |= {"zeroline": True, "constrain": "domain"}
    return Plot(
        "Response in the complex plane",
        f"Nyquist plot of each channel; dots: measured, lines: {_models(response)}; a point's speed shows on touch or hover.",
        {"data": traces, "layout": made},
        controls=(*_channel_control(response), *_model_control(response)),
        height=440,
    )


HOVER_PLANE = "%{customdata:.0f} rpm: %{x:.3g} %{y:+.3g}i µm"


def orbits(response: Response) -> Orbits:
    """The orbits of all planes with probes in two directions, measured and by the last model."""
    curves = {"measured": response.measured, "model": list(response.at_speeds.values())[-1]}
    return Orbits(
        "Orbits",
        "The path of the shaft in each plane at a speed, measured (dotted) and by the model; dots: where it is at phase 0.",
        tuple(response.speed.tolist()),
        {
            place: {curve: _phasors(values[:, columns] @ to_xy.T) for curve, values in curves.items()}
            for place, (columns, to_xy) in response.planes().items()
        },
    )


def _phasors(values: ComplexArray) -> tuple[tuple[float, float, float, float], ...]:
    """(n_speed, 2) of x and y as (re x, im x, re y, im y)."""
    return tuple((x.real, x.imag, y.real, y.imag) for x, y in values.tolist())


def _of_channel(response: Response, column: int, axes: dict[str, str]) -> Iterator[dict[str, Any]]:
    channel, colour = response.channels[column], COLOURS[column % len(COLOURS)]
    of_channel: dict[str, Any] = {"legendgroup": channel, "meta": {"channel": channel}}
    measured = response.measured[:, column]
    bars = _bars(response, column)
    more: dict[str, Any] = {"error_y": bars} if bars else {}
    yield points(
        response.speed,
        np.abs(measured),
        f"measured, {channel}",
        colour,
        marker={"size": 5},
        opacity=0.85,
        **more,
        **of_channel,
    )
    if "phase" in axes:
        yield points(
            response.speed, np.degrees(np.angle(measured)), channel, colour, marker={"size": 4}, yaxis=axes["phase"],
            showlegend=False, hovertemplate="%{x:.0f} rpm: %{y:.1f}°", **of_channel,
        )  # fmt: skip
    for name, curve in response.curves.items():
        values, rpm = curve.values[:, column], broken(curve.speed, curve.breaks)
        own = {**of_channel, "meta": {"channel": channel, "model": name}, "line": _style(name, colour)}
        yield line(rpm, broken(np.abs(values), curve.breaks), f"{name}, {channel}", colour, **own)
        if "phase" in axes:
            phase = broken(_unbroken(np.degrees(np.angle(values))), curve.breaks)
            yield line(rpm, phase, name, colour, yaxis=axes["phase"], showlegend=False, hoverinfo="skip", **own)
        for (part, left), symbol in zip(response.residuals.get(name, {}).items(), SYMBOLS.get(name, OWN_SYMBOLS)):
            yield points(
                response.speed, left[:, column], f"{name}, {part}", colour, yaxis=axes["residuals"], showlegend=False,
                hovertemplate=f"%{{x:.0f}} rpm: %{{y:.2f}} σ ({part})", marker={"size": 4, "symbol": symbol}, **own,
            )  # fmt: skip


def _marks(response: Response) -> str:
    """Which mark is which part of which model's residuals, where there are several."""
    several = len(response.residuals) > 1
    legend = [
        f"{MARKS[symbol]} {part}{f', {name}' if several else ''}"
        for name, parts in response.residuals.items()
        for part, symbol in zip(parts, SYMBOLS.get(name, OWN_SYMBOLS))
    ]
    return f" ({'; '.join(legend)})" if len(legend) > 1 else ""


def _unbroken(phase: Array) -> Array:
    """A wrapped phase with a gap where it jumps."""
    jumps = np.abs(np.diff(phase, append=phase[-1:])) > 340
    return np.where(jumps, np.nan, phase)


def _has_bars(response: Response) -> bool:
    return response.sd is not None and len(response.speed) <= MOST_ERROR_BARS


def _bars(response: Response, column: int) -> dict[str, Any] | None:
    """± 1 σ; downwards no further than a logarithmic axis shows."""
    if response.sd is None or not _has_bars(response):
        return None
    sd = response.sd[:, column]
    down = np.minimum(sd, 0.95 * np.abs(response.measured[:, column]))
    return {"type": "data", "array": sd, "arrayminus": down, "symmetric": False, "thickness": 1, "width": 0}


def _domains(heights: list[float]) -> Iterator[tuple[float, float]]:
    """Parts of the height of a figure from the top, with gaps between them."""
    gap, total = 0.05, sum(heights)
    scale, top = (1 - gap * (len(heights) - 1)) / total, 1.0
    for height in heights:
        bottom = top - scale * height
        yield max(bottom, 0.0), top
        top = bottom - gap


def _style(name: str, colour: str) -> dict[str, Any]:
    return {"color": colour, "width": 1.8, "dash": DASHES.get(name, "solid")}


def _models(response: Response) -> str:
    """The models in words, and where there are several how their lines look."""
    if len(response.curves) == 1:
        return next(iter(response.curves))
    return " and ".join(f"{name} ({IN_WORDS[DASHES.get(name, 'solid')]})" for name in response.curves)


def _channel_control(response: Response) -> Iterator[Control]:
    channels = response.channels
    if len(channels) > 1:
        yield Control("channel", "channel", channels, chosen=channels[0] if len(channels) > MOST_AT_ONCE else "")


def _model_control(response: Response) -> Iterator[Control]:
    if len(response.curves) > 1:
        yield Control("model", "model", tuple(response.curves))

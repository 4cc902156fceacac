"""Measured and modelled response over speed (Bode) and in the complex plane (Nyquist).

A stack for each channel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.show.charts.chart import Axis, Band, Chart, Choice, Element, Level, Line, Panel, Points, Span, broken
from ksmea.show.charts.colours import AFTER, BEFORE, CONTEXT, MEASURED, MODEL
from ksmea.show.charts.responses import Response

AMPLITUDE, PHASE, SPEED = "amplitude (µm 0-peak)", "phase lead (°)", "speed (rpm)"
MOST_ERROR_BARS = 400  # points; more are drawn without
ACROSS, MAX_CHANNELS = 3, 9  # of a picture; pages and records have all
COLOURS = {"model before": BEFORE, "model after": AFTER}  # of models; of any other: MODEL
DASHES = {"model before": "dash"}  # of lines; all others are solid
JUMP = 340.0  # degrees between neighbours of a wrapped phase, where its line is broken
SYMBOLS, MARKS = ("circle", "x"), ("●", "×")  # of the parts of residuals, and as a caption shows them
N_SD = 2.0  # of the noise: the band of residuals


def bode_chart(response: Response, title: str) -> Chart:
    """Amplitude, phase where there is one, and residuals in units of the noise, one below the other.

    A stack per channel.
    """
    stacks = tuple(tuple(_panels(response, column)) for column in range(len(response.channels)))
    bars = "dots: measured, with ± 1 σ" if _has_bars(response) else "dots: measured"
    of_both = ", of one law for both, each at its own response" if len(response.residuals) > 1 else ""
    below = (
        f"; below: residuals in units of the noise{of_both}{_marks(response)}, ± {N_SD:g} shaded"
        if response.residuals
        else ""
    )
    averaged = (
        "; shaded: what the average of the models that explain the data predicts"
        if response.averaged is not None
        else ""
    )
    caption = f"Amplitude{' and phase lead' if response.has_phase else ''} over speed; {bars}, lines: {_models(response)}{averaged}{below}."
    across = len(stacks) if len(stacks) == ACROSS + 1 else min(ACROSS, len(stacks))
    return Chart(
        title, caption, stacks, across, max(7.0, 2.8 * across + 0.6), _choices(response), "channel", MAX_CHANNELS
    )


def _across(stacks: Sequence[object]) -> int:
    return len(stacks) if len(stacks) == ACROSS + 1 else min(ACROSS, len(stacks))


def _panels(response: Response, column: int) -> Iterator[Panel]:
    x = Axis(SPEED, group="speed")
    yield Panel(
        tuple(_amplitude(response, column)),
        x,
        Axis(AMPLITUDE, "log", group="amplitude"),
        response.channels[column],
        2.6,
    )
    if response.has_phase:
        ticks = {float(each): str(each).replace("-", "−") for each in (-180, -90, 0, 90, 180)}
        y = Axis(PHASE, low=-190, high=190, ticks=ticks, group="phase")
        yield Panel(tuple(_phase(response, column)), x, y, height=1.4)
    for name, parts in response.residuals.items():
        elements: list[Element] = [Span(low=-N_SD, high=N_SD), Level(at=0.0, dash="solid", width=0.6)]
        elements += [
            Points(
                response.speed, left[:, column], symbol, 3.0, name=f"residual {part}" if len(parts) > 1 else "residual", colour=COLOURS.get(name, MODEL),
                said=f"{{x:.0f}} rpm: {{y:.2f}} σ ({part})", tags={"model": name},
            )
            for (part, left), symbol in zip(parts.items(), SYMBOLS)
        ]  # fmt: skip
        of_model = f"\n{name.removeprefix('model ')}" if len(response.residuals) > 1 else ""
        yield Panel(tuple(elements), x, Axis(f"residual / σ{of_model}", group=name), height=1.4)


def _amplitude(response: Response, column: int) -> Iterator[Element]:
    size = np.abs(response.measured[:, column])
    low = high = None
    if response.sd is not None and _has_bars(response):
        sd = response.sd[:, column]
        low, high = size - np.minimum(sd, 0.95 * size), size + sd  # the axis is logarithmic
    if response.averaged is not None:
        low_end, high_end = (broken(end[:, column], response.breaks) for end in response.averaged)
        yield Band(
            broken(response.speed, response.breaks), low_end, high_end, name="averaged, its interval", colour=AFTER
        )
    name = "measured ± 1 σ" if low is not None else "measured"
    yield Points(response.speed, size, size=3.5, low=low, high=high, name=name, colour=MEASURED, opacity=0.85)
    for model, curve in response.curves.items():
        values = broken(np.abs(curve.values[:, column]), curve.breaks)
        yield _line(model, broken(curve.speed, curve.breaks), values)


def _phase(response: Response, column: int) -> Iterator[Element]:
    measured = np.degrees(np.angle(response.measured[:, column]))
    yield Points(response.speed, measured, size=3.5, colour=MEASURED, opacity=0.85, said="{x:.0f} rpm: {y:.1f}°")
    for model, curve in response.curves.items():
        phase = broken(_unbroken(np.degrees(np.angle(curve.values[:, column]))), curve.breaks)
        yield _line(model, broken(curve.speed, curve.breaks), phase)


def _line(model: str, x: Array, y: Array, said: str | list[str] = "") -> Line:
    return Line(
        x,
        y,
        DASHES.get(model, "solid"),
        1.3,
        name=model,
        colour=COLOURS.get(model, MODEL),
        said=said,
        tags={"model": model},
    )


def nyquist_chart(response: Response) -> Chart:
    """The response in the complex plane."""
    stacks = []
    x, y = Axis("real part (µm)"), Axis("imaginary part (µm)")
    for column, channel in enumerate(response.channels):
        elements: list[Element] = [
            Level(at=0.0, dash="solid", width=0.6, colour=CONTEXT),
            Level(at=0.0, along="x", dash="solid", width=0.6, colour=CONTEXT),
        ]
        for model, curve in response.curves.items():
            values, rpm = curve.values[:, column], broken(curve.speed, curve.breaks)
            re, im = (broken(part, curve.breaks) for part in (values.real, values.imag))
            elements.append(_line(model, re, im, _speeds(rpm)))
        measured = response.measured[:, column]
        elements.append(
            Points(
                measured.real, measured.imag, size=3.5, name="measured", colour=MEASURED, said=_speeds(response.speed)
            )
        )
        stacks.append((Panel(tuple(elements), x, y, channel, 3.4, is_to_scale=True),))
    return Chart(
        "Response in the complex plane",
        f"Nyquist plot of each channel; dots: measured, lines: {_models(response)}; a point's speed shows on touch or hover.",
        tuple(stacks), _across(stacks), choices=_choices(response), of_stacks="channel",
    )  # fmt: skip


def _speeds(rpm: Array) -> list[str]:
    return [f"{each:.0f} rpm" if np.isfinite(each) else "" for each in rpm]


def _marks(response: Response) -> str:
    """Legend of the marks of the parts of residuals; empty for a single part."""
    parts = next(iter(response.residuals.values()), {})
    legend = [f"{mark} {part}" for part, mark in zip(parts, MARKS)]
    return f" ({'; '.join(legend)})" if len(legend) > 1 else ""


def _unbroken(phase: Array) -> Array:
    """A wrapped phase with a gap where it jumps."""
    return np.where(np.abs(np.diff(phase, append=phase[-1:])) > JUMP, np.nan, phase)


def _has_bars(response: Response) -> bool:
    return response.sd is not None and len(response.speed) <= MOST_ERROR_BARS


def _models(response: Response) -> str:
    """The models in words, and where there are several how their lines look."""
    if len(response.curves) == 1:
        return next(iter(response.curves))
    return " and ".join(f"{name} ({'dashed' if name in DASHES else 'solid'})" for name in response.curves)


def _choices(response: Response) -> tuple[Choice, ...]:
    return (Choice("model", "model", tuple(response.curves)),) if len(response.curves) > 1 else ()

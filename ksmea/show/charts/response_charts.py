"""Measured and modelled response over speed (Bode) and in the complex plane (Nyquist).

A stack for each channel. Units and names of channels follow the response's notation. A Bode plot has phase lag in
any notation, as is usual for rotors (API 684), and its label says so; a polar plot counts phases as the notation does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.show.charts.chart import Axis, Band, Chart, Choice, Element, Line, Panel, Points, broken
from ksmea.show.charts.colours import AFTER, BEFORE, MEASURED, MODEL
from ksmea.show.charts.parts.bode import (
    MOST_NAMED,
    N_SD,
    TURN,
    around,
    close_pairs,
    lags_along,
    marks,
    nearest_lag,
    phase_ticks,
    residual_ground,
    residual_reach,
    resonances,
)
from ksmea.show.charts.parts.polar import BEYOND, REACH, phase_in_words, rings, speeds_at, speeds_said, within
from ksmea.show.charts.responses import AS_GIVEN, WITH_CAUSE, ModelCurve, Response
from ksmea.show.readings import PLAIN, amplitude_label, speed_at_pointer, speed_digits, speed_form, speed_label

AMPLITUDE, PHASE, SPEED = amplitude_label(PLAIN), "phase lag (°)", speed_label(PLAIN)
MOST_ERROR_BARS = 400  # points; more are drawn without
ACROSS, MAX_CHANNELS = 3, 9  # of a picture; pages and records have all
SQUARES_ACROSS = 2  # of more than `ACROSS` polar plots
COLOURS = {AS_GIVEN: BEFORE, WITH_CAUSE: AFTER}  # of models; of any other: MODEL
DASHES = {AS_GIVEN: "dash"}  # of lines; all others are solid
SYMBOLS, MARKS = ("circle", "x"), ("●", "×")  # of the parts of residuals, and as a caption shows them
MOST_ZOOMED = 3  # channels that have a column for a close pair
PHASE_ROOM = 0.5  # of the range of phases, above them


def bode_chart(response: Response, title: str) -> Chart:
    """Phase lag unwrapped along the model, amplitude, and residuals in units of the noise.

    They are one below the other in a stack per channel, followed by one of a pair of resonances closer than 5 %, if channels are few."""
    stacks: list[tuple[Panel, ...]] = []
    peaks = resonances(_model(response)) if response.curves else []
    pairs = close_pairs(peaks)[:1] if len(response.channels) <= MOST_ZOOMED else []
    for column in range(len(response.channels)):
        stacks.append(tuple(_panels(response, column, peaks)))
        stacks += [tuple(_panels(response, column, peaks, pair)) for pair in pairs]
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
    named = f"; vertical: peaks of the model, {response.notation.speed}" if 0 < len(peaks) <= MOST_NAMED else ""
    zoomed = "; on the right: two peaks closer than 5 %" if pairs else ""
    caption = (
        f"{'Phase lag and amplitude' if response.has_phase else 'Amplitude'} over speed; {bars}, lines: {_models(response)}"
        f"{averaged}{below}{named}{zoomed}."
    )
    across = 2 if pairs else _across(stacks)
    return Chart(
        title, caption, tuple(stacks), across, max(7.0, (3.8 if pairs else 2.8) * across + 0.6), _choices(response), "channel", MAX_CHANNELS,
        int(response.has_phase),
    )  # fmt: skip


def _model(response: Response) -> ModelCurve:
    """The curve of the last model, along which phases are unwrapped."""
    return list(response.curves.values())[-1]


def _across(stacks: Sequence[object]) -> int:
    return len(stacks) if len(stacks) == ACROSS + 1 else min(ACROSS, len(stacks))


def _panels(
    response: Response, column: int, peaks: Sequence[float], pair: tuple[float, float] | None = None
) -> Iterator[Panel]:
    """Panels of a channel; `pair` are two resonances that a column of their own shows."""
    low, high = (None, None) if pair is None else around(pair)
    notation = response.notation
    x = Axis(speed_label(notation), low=low, high=high, group="speed" if pair is None else "pair")
    shown = [each for each in peaks if low is None or high is None or low <= each <= high]
    title = response.shown_channels[column]
    if pair is not None:
        title += f", {' and '.join(speed_digits(each, notation) for each in pair)} {notation.speed}"

    def marked(*, is_top: bool = False) -> Iterator[Element]:
        yield from marks(shown, with_names=is_top, are_apart=pair is not None, form=speed_form(notation))

    if response.has_phase:
        yield Panel((*marked(is_top=True), *_phase(response, column)), x, _phase_axis(response), title, 1.5)
    elements = (*marked(is_top=not response.has_phase), *_amplitude(response, column))
    yield Panel(
        elements, x, Axis(amplitude_label(notation), "log", group="amplitude"), "" if response.has_phase else title, 2.6
    )
    for name, parts in response.residuals.items():
        most = residual_reach(parts)
        own = {part: left[:, column] for part, left in parts.items()}
        ground = list(residual_ground(own, most, float(np.max(response.speed))))
        points = [
            Points(
                response.speed, left, symbol, 3.0, name=f"residual {part}" if len(parts) > 1 else "residual", colour=COLOURS.get(name, MODEL),
                said=f"{speed_at_pointer(notation)}: {{y:.2f}} σ ({part})", tags={"model": name},
            )
            for (part, left), symbol in zip(own.items(), SYMBOLS)
        ]  # fmt: skip
        of_model = f"\n{name}" if len(response.residuals) > 1 else ""
        y = Axis(f"residual / σ{of_model}", low=-most, high=most, group=name)
        yield Panel((*(ground if pair is None else ground[:-1]), *points), x, y, height=1.4)


def _phase_axis(response: Response) -> Axis:
    """From the least to the largest lag of all channels, with room for names of resonances."""
    lags = [_lags(response, column) for column in range(len(response.channels))]
    every = np.concatenate([each for of in lags for each in of])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    room = PHASE_ROOM * max(high - low, 90.0)
    return Axis(
        PHASE,
        low=low - 0.3 * room,
        high=high + room,
        ticks=phase_ticks(low - 0.3 * room, high + 0.2 * room),
        group="phase",
    )


def _lags(response: Response, column: int) -> list[Array]:
    """Measured lag, and the lag of each model."""
    models = list(response.curves.values())
    measured = response.measured[:, column]
    if not models:
        return [np.degrees(-np.angle(measured)) % TURN]
    own = nearest_lag(measured, response.speed, response.breaks, models[-1], column)
    return [own, *lags_along(models, column)]


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
    measured, *of_models = _lags(response, column)
    said = f"{speed_at_pointer(response.notation)}: {{y:.1f}}°"
    yield Points(response.speed, measured, size=3.5, colour=MEASURED, opacity=0.85, said=said)
    for (model, curve), lag in zip(response.curves.items(), of_models):
        yield _line(model, broken(curve.speed, curve.breaks), broken(lag, curve.breaks))


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
    """The response in the complex plane, with rings of equal amplitude and speeds at some points."""
    stacks = []
    for column, channel in enumerate(response.shown_channels):
        measured = response.measured[:, column]
        reach = float(np.max(np.abs(measured)))
        said = speeds_said(response.speed, response.notation)
        speeds = list(speeds_at(measured, said))
        elements = list(rings(reach, response.notation, speeds))
        for model, curve in response.curves.items():
            values, speed = within(curve.values[:, column], reach), broken(curve.speed, curve.breaks)
            re, im = (broken(part, curve.breaks) for part in (values.real, values.imag))
            elements.append(_line(model, re, im, speeds_said(speed, response.notation)))
        elements.append(Points(measured.real, measured.imag, size=3.5, name="measured", colour=MEASURED, said=said))
        elements += speeds
        axis = Axis(low=-REACH * reach, high=REACH * reach, ticks={})
        stacks.append((Panel(tuple(elements), axis, axis, channel, 3.4, is_to_scale=True),))
    return Chart(
        "Response in the complex plane",
        f"Polar plot of each channel, {response.notation.unit}; {phase_in_words(response.notation)}; dots: measured, lines: {_models(response)}, up to"
        f" {BEYOND:g} times the largest measured amplitude; numbers: speed in {response.notation.speed}.",
        tuple(stacks), SQUARES_ACROSS if len(stacks) > ACROSS else len(stacks), choices=_choices(response), of_stacks="channel",
    )  # fmt: skip


def _marks(response: Response) -> str:
    """Legend of the marks of the parts of residuals; empty for a single part."""
    return legend_of(next(iter(response.residuals.values()), {}))


def legend_of(parts: Iterable[str]) -> str:
    """Parts of residuals with their marks, ' (● in phase; × in quadrature)'; empty for a single part."""
    legend = [f"{mark} {part}" for part, mark in zip(parts, MARKS)]
    return f" ({'; '.join(legend)})" if len(legend) > 1 else ""


def _has_bars(response: Response) -> bool:
    return response.sd is not None and len(response.speed) <= MOST_ERROR_BARS


def _models(response: Response) -> str:
    """The models in words, and where there are several how their lines look."""
    names = [f"{name} ({'dashed' if name in DASHES else 'solid'})" for name in response.curves]
    said = " and ".join(names if len(names) > 1 else response.curves)
    return f"model {said}" if any(name in COLOURS for name in response.curves) else said


def _choices(response: Response) -> tuple[Choice, ...]:
    return (Choice("model", "model", tuple(response.curves)),) if len(response.curves) > 1 else ()
